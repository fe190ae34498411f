// Baking behind the C interface: what libsqmap has and libsqmap_query leaves out.
#include "sqmap/bake/bake.h"
#include "objects.h"
#include "sqmap/io/read.h"
#include "sqmap/mesh/admit.h"
#include "structs.h"

#include <filesystem>
#include <string>

namespace sqmap::capi {
namespace {

/// Thrown through bake by the progress of a caller that cancels.
struct Cancelled {};

/// Polygons of either door: a caller's arrays or a file's.
struct Input {
    mesh::PolygonView polygons;
    std::string source;
};

mesh::AdmitOptions gate_options(const sqmap_bake_options& o)
{
    mesh::AdmitOptions out;
    switch (o.repair) {
        case SQMAP_REPAIR_DEFAULT:
        case SQMAP_REPAIR_WRAP:
            break;
        case SQMAP_REPAIR_NONE:
            out.repair = mesh::Repair::None;
            break;
        case SQMAP_REPAIR_SAFE:
            out.repair = mesh::Repair::Safe;
            break;
        case SQMAP_REPAIR_CLOSE:
            out.repair = mesh::Repair::Close;
            break;
        default:
            throw Failure{SQMAP_E_ARGUMENT, "options.repair", "is " + std::to_string(o.repair), "take one of sqmap_repair"};
    }
    out.accept_surface = o.accepts_surface != 0;
    out.thickness = checked(o.thickness, 0, 1e300, "options.thickness");
    return out;
}

bake::BakeOptions bake_options(const sqmap_bake_options& o)
{
    bake::BakeOptions out;
    if (o.projection != 0 && o.projection != 1)
        throw Failure{SQMAP_E_ARGUMENT, "options.projection", "is " + std::to_string(o.projection), "take 0 or 1"};
    if (o.threads > 1024)
        throw Failure{SQMAP_E_ARGUMENT, "options.threads", "is " + std::to_string(o.threads), "give at most 1024"};
    if (o.target_error != 0) out.target_error = checked(o.target_error, 1e-3, 100, "options.target_error");
    if (o.band != 0) out.band = checked(o.band, 0, 100, "options.band");
    if (o.max_parts != 0) out.max_parts = o.max_parts;
    out.projection = o.projection == 1 ? model::Projection::Normal : model::Projection::Central;
    out.exact = o.without_exact == 0;
    out.threads = o.threads;
    if (o.progress != nullptr)
        out.progress = [&o](const char* stage, double done) {
            if (o.progress(o.progress_context, stage, done) != 0) throw Cancelled{};
        };
    return out;
}

std::string notes_of(const mesh::AdmitResult& gate)
{
    std::string out;
    for (const mesh::RepairNote& r : gate.repairs)
        out += std::string("repaired: ") + mesh::name_of(r.kind) + " (" + std::to_string(r.count) + ")\n";
    for (const mesh::Warning& w : gate.warnings) out += std::string(mesh::name_of(w.kind)) + ": " + w.message + "\n";
    return out;
}

std::shared_ptr<Model> baked(const Input& input, const sqmap_bake_options& o)
{
    bake::BakeOptions options = bake_options(o);
    const mesh::AdmitResult gate = mesh::admit(input.polygons, gate_options(o));
    if (gate.admission == mesh::Admission::Refused) throw mesh::RefusedMesh(gate.diagnosis);
    options.cured = bake::cured(gate.admission, gate.made_up, gate.deviation);
    try {
        bake::BakeResult result = bake::bake(gate.mesh, gate.solid, options);
        result.model.made_by = "libsqmap " SQMAP_VERSION;
        result.model.source = o.source != nullptr ? o.source : input.source;
        return std::make_shared<Model>(io::serialize(result.model), notes_of(gate));
    } catch (const Cancelled&) {
        throw Failure{SQMAP_E_CANCELLED, "progress", "the callback stopped the bake", "bake again"};
    }
}

}  // namespace

void refuse_unanswered(const model::ModelView&) {}  // whatever is baked is answered

}  // namespace sqmap::capi

using namespace sqmap;
using capi::guarded;
using capi::needed;

sqmap_code sqmap_bake(const sqmap_mesh* mesh, const sqmap_bake_options* options, sqmap_model* model)
{
    return guarded([&] {
        sqmap_model& out = needed(model, "model");
        out = {};
        const sqmap_mesh in = capi::taken(&needed(mesh, "mesh"), "mesh");
        const sqmap_points points{sizeof(sqmap_points), in.vertices, in.vertex_count, nullptr};
        if (in.triangle_count > 0xffffffffu / 3)
            throw capi::Failure{SQMAP_E_ARGUMENT, "mesh.triangle_count", "is too large", "give the number of triangles"};
        if (in.triangle_count > 0) (void)needed(in.triangles, "mesh.triangles");
        std::vector<std::uint32_t> offsets(in.triangle_count + 1);
        for (std::size_t i = 0; i < offsets.size(); ++i) offsets[i] = static_cast<std::uint32_t>(3 * i);
        const capi::Input input{{capi::rows(points, "mesh.vertices"), offsets, std::span(in.triangles, 3 * in.triangle_count)},
                                "arrays"};
        out.id = capi::models().open(capi::baked(input, capi::taken(options, "options")));
    });
}

sqmap_code sqmap_bake_file(const char* path, const sqmap_bake_options* options, sqmap_model* model)
{
    return guarded([&] {
        sqmap_model& out = needed(model, "model");
        out = {};
        const io::ReadResult read = io::read_mesh_file(&needed(path, "path"));
        if (read.error)
            throw capi::Failure{SQMAP_E_MESH, read.error->element, read.error->message, read.error->cure, read.error->code};
        const capi::Input input{{read.soup.positions, read.soup.polygon_offsets, read.soup.indices},
                                std::filesystem::path(path).filename().string()};
        out.id = capi::models().open(capi::baked(input, capi::taken(options, "options")));
    });
}
