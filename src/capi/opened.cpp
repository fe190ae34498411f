// Models that libsqmap opens: central ones and paper models.
#include "objects.h"
#include "sqmap/paper/model_file.h"

namespace sqmap::capi {

Opened open_model(std::span<const std::byte> bytes, const std::string& element)
{
    auto model = std::make_shared<paper::AnyModel>();
    if (const model::ParseStatus status = model->parse(bytes); status != model::ParseStatus::Ok) refuse_bytes(status, element);
    return {model->view(), model->paper() != nullptr, model};
}

std::string json_of(const model::ModelView& view, std::size_t bytes) { return paper::model_json(view, bytes); }

}  // namespace sqmap::capi
