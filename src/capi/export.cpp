// Shapes that enclose a model's parts, from C.
#include "sqmap/collider/export.h"
#include "objects.h"
#include "sqmap/mesh/error.h"

#include <optional>

namespace sqmap::capi {
namespace {

constexpr std::uint32_t k_max_spheres = 4096;

collider::ShapeChoice shape_of(const sqmap_export_options& o)
{
    if (o.spheres > k_max_spheres)
        throw Failure{SQMAP_E_ARGUMENT, "options.spheres", "is " + std::to_string(o.spheres), "give a number from 1 to 4096"};
    if (o.shape < SQMAP_SHAPE_DEFAULT || o.shape > SQMAP_SHAPE_SUPERQUADRIC)
        throw Failure{SQMAP_E_ARGUMENT, "options.shape", "is " + std::to_string(o.shape), "take one of sqmap_shape"};
    if (o.shape == SQMAP_SHAPE_DEFAULT) return {.kind = collider::Kind::Hull, .spheres = o.spheres};
    return {.kind = static_cast<collider::Kind>(o.shape - 1), .spheres = o.spheres};
}

collider::Format format_of(const sqmap_export_options& o, const std::filesystem::path& path)
{
    if (o.format < SQMAP_FORMAT_DEFAULT || o.format > SQMAP_FORMAT_GLB)
        throw Failure{SQMAP_E_ARGUMENT, "options.format", "is " + std::to_string(o.format), "take one of sqmap_format"};
    if (o.format != SQMAP_FORMAT_DEFAULT) return static_cast<collider::Format>(o.format - 1);
    if (const std::optional<collider::Format> format = collider::format_by_ending(path)) return *format;
    throw Failure{SQMAP_E_ARGUMENT, "path", "has an ending that names no format",
                  "take .urdf, .mjcf, .sdf, .srdf, .json, .obj or .glb, or set options.format"};
}

unsigned checked_threads(const sqmap_export_options& o)
{
    if (o.threads > 1024)
        throw Failure{SQMAP_E_ARGUMENT, "options.threads", "is " + std::to_string(o.threads), "give at most 1024"};
    return o.threads;
}

}  // namespace
}  // namespace sqmap::capi

sqmap_code sqmap_export(sqmap_model model, const char* path, const sqmap_export_options* options, sqmap_text* report)
{
    using namespace sqmap;
    return capi::guarded([&] {
        const capi::Model& m = *capi::model_of(model);
        const std::filesystem::path file = &capi::needed(path, "path");
        const sqmap_export_options o = capi::taken(options, "options");
        if (report != nullptr) capi::give_text(report, "", "report");  // a wrong one is refused before anything is written
        const collider::ExportOptions wanted{
            .format = capi::format_of(o, file), .shape = capi::shape_of(o), .threads = capi::checked_threads(o)};
        if (!model::has_exact(m.view()))
            throw capi::Failure{SQMAP_E_MISSING,
                                "model",
                                "was baked without its triangles",
                                {"bake it with the exact layer: ", mesh::Setting::Exact}};
        try {
            const collider::Colliders made = collider::export_model(m.view(), file, wanted);
            if (report != nullptr) capi::give_text(report, collider::report_json(made), "report");
        } catch (const mesh::InvalidInput& e) {
            throw capi::Failure{SQMAP_E_ARGUMENT, "options.shape", e.what(), "take another shape or another format"};
        }
    });
}
