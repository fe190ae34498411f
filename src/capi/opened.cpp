// The kinds of models that a library opens. The kernels of paper models would be a third of libsqmap_query, so it refuses those.
#include "objects.h"
#include "sqmap/io/model_file.h"
#ifdef SQMAP_OPENS_PAPER
#include "sqmap/paper/model_file.h"
#endif

namespace sqmap::capi {
namespace {

/// A central model is read as it is. @throw Failure unless all are the defaults
void check_unread(const PaperReading& how)
{
    const PaperReading plain;
    const char* const element = how.projector != plain.projector           ? "options.projector"
                                : how.nearest_steps != plain.nearest_steps ? "options.nearest_steps"
                                : how.gaps != plain.gaps                   ? "options.without_gaps"
                                : how.pruning != plain.pruning             ? "options.without_pruning"
                                                                           : nullptr;
    if (element != nullptr)
        throw Failure{SQMAP_E_ARGUMENT, element, "counts for models of the normal projection, and this one has the central",
                      "leave the default, or bake with the normal projection"};
}

}  // namespace

#ifdef SQMAP_OPENS_PAPER

Opened read_paper(const Opened& opened, const PaperReading& how)
{
    if (!opened.is_paper) {
        check_unread(how);
        return opened;
    }
    paper::QueryOptions options;
    options.projector = static_cast<paper::Projector>(how.projector);
    options.nearest_steps = how.nearest_steps;
    options.gaps = how.gaps;
    options.pruning = how.pruning;
    auto reading = std::make_shared<paper::Reading>(paper::Reading::of(opened.view).model(), options);
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

Opened read_paper(const Opened& opened, const PaperReading& how)
{
    check_unread(how);
    return opened;
}

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

std::string json_of(const model::ModelView& view, std::span<const std::byte> bytes)
{
    return io::model_json(view, bytes.size(), notes_in(bytes));
}

std::span<const model::NoteRecord> notes_in(std::span<const std::byte> bytes) { return model::notes_of(bytes); }

#endif

}  // namespace sqmap::capi
