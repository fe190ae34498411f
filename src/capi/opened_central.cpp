// Models that libsqmap_query opens: central ones. The kernels of paper models would be a third of it, so it refuses those.
#include "objects.h"
#include "sqmap/io/model_json.h"

namespace sqmap::capi {

Opened open_model(std::span<const std::byte> bytes, const std::string& element)
{
    Opened opened;
    const model::ParseStatus status = model::parse(bytes, opened.view);
    if (status == model::ParseStatus::PaperModel)
        throw Failure{SQMAP_E_MISSING, "model", "is of the normal projection, which libsqmap_query leaves out",
                      "link libsqmap, or bake it with the central projection"};
    if (status != model::ParseStatus::Ok) refuse_bytes(status, element);
    return opened;
}

std::string json_of(const model::ModelView& view, std::size_t bytes) { return io::model_json(view, bytes); }

}  // namespace sqmap::capi
