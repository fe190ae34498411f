// The kinds of models that a library opens. The kernels of paper models would be a third of libsqmap_query, so it refuses those.
#include "objects.h"
#include "sqmap/io/model_file.h"
#include "sqmap/paper/model.h"
#include "sqmap/query/options.h"
#ifdef SQMAP_OPENS_PAPER
#include "sqmap/paper/model_file.h"
#endif

#include <string_view>

namespace sqmap::capi {
namespace {

void refuse_idle(const Opened& opened, const paper::QueryOptions& how, query::QueryOptions query)
{
    query.layer = query::chosen_layer(opened.view, query);
    const std::optional<IdleOption> idle = paper::idle_option(how, opened.is_paper, query);
    if (!idle) return;
    const std::string_view name = idle->name;
    const std::string prefix = name == "gaps" || name == "pruning" ? "options.without_"
                               : name == "offset"                  ? "options.has_"
                                                                   : "options.";
    throw Failure{SQMAP_E_ARGUMENT, prefix + idle->name, idle->why, idle->cure};
}

}  // namespace

#ifdef SQMAP_OPENS_PAPER

Opened read_paper(const Opened& opened, const paper::QueryOptions& how, const query::QueryOptions& query)
{
    refuse_idle(opened, how, query);
    if (!opened.is_paper || how == paper::QueryOptions{}) return opened;
    auto reading = std::make_shared<paper::Reading>(paper::Reading::of(opened.view).model(), how);
    return {reading->view(), true, reading};
}

Opened open_model(std::span<const std::byte> bytes, const std::string& element)
{
    auto model = std::make_shared<paper::AnyModel>();
    if (const model::ParseStatus status = model->parse(bytes); status != model::ParseStatus::Ok) refuse_bytes(status, element);
    return {model->view(), model->paper() != nullptr, model};
}

std::string json_of(const model::ModelView& view, std::span<const std::byte> bytes)
{
    return paper::model_json(view, bytes.size(), notes_in(bytes));
}

std::span<const model::NoteRecord> notes_in(std::span<const std::byte> bytes) { return paper::notes_of(bytes); }

#else

Opened read_paper(const Opened& opened, const paper::QueryOptions& how, const query::QueryOptions& query)
{
    refuse_idle(opened, how, query);
    return opened;
}

Opened open_model(std::span<const std::byte> bytes, const std::string& element)
{
    Opened opened;
    const model::ParseStatus status = model::parse(bytes, opened.view);
    if (status == model::ParseStatus::PaperModel)
        throw Failure{SQMAP_E_MISSING, "model", "is a paper model, which libsqmap_query leaves out",
                      "link libsqmap, or bake it with the central projection"};
    if (status != model::ParseStatus::Ok) refuse_bytes(status, element);
    return opened;
}

std::string json_of(const model::ModelView& view, std::span<const std::byte> bytes)
{
    return io::model_json(view, bytes.size(), notes_in(bytes));
}

std::span<const model::NoteRecord> notes_in(std::span<const std::byte> bytes) { return model::notes_of(bytes); }

#endif

}  // namespace sqmap::capi
