// Baking behind the C interface, which libsqmap has and libsqmap_query leaves out.
#include "objects.h"
#include "sqmap/bake_mesh.h"
#include "structs.h"
#include "words.h"

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <variant>

namespace sqmap::capi {
namespace {

/// Thrown through bake by the progress of a caller that cancels.
struct Cancelled {};

mesh::AdmitOptions admit_options(const sqmap_bake_options& o)
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
    if (o.solid != SQMAP_SOLID_AS_IS && o.solid != SQMAP_SOLID_OUTER)
        throw Failure{SQMAP_E_ARGUMENT, "options.solid", "is " + std::to_string(o.solid), "take one of sqmap_solid"};
    if (o.solid == SQMAP_SOLID_OUTER) out.solid = mesh::SolidKind::Outer;
    if (o.gap != 0) out.gap = checked(o.gap, 0, 0.2, "options.gap");
    if (o.wrap_tolerance != 0) out.wrap.tolerance = checked(o.wrap_tolerance, 1.6e-3, 0.1, "options.wrap_tolerance");
    if (o.unit != 0) out.unit = checked(o.unit, 1e-12, 1e12, "options.unit");
    return out;
}

bake::BakeOptions bake_options(const sqmap_bake_options& o)
{
    constexpr bake::BakeRanges ranges;
    bake::BakeOptions out;
    if (o.projection != 0 && o.projection != 1)
        throw Failure{SQMAP_E_ARGUMENT, "options.projection", "is " + std::to_string(o.projection), "take 0 or 1"};
    if (o.threads > 1024)
        throw Failure{SQMAP_E_ARGUMENT, "options.threads", "is " + std::to_string(o.threads), "give at most 1024"};
    if (o.target_error != 0)
        out.target_error = checked(o.target_error, ranges.target_error.least, ranges.target_error.max, "options.target_error");
    if (o.band != 0) out.band = checked(o.band, ranges.band.least, ranges.band.max, "options.band");
    if (o.max_parts != 0)
        out.max_parts =
            static_cast<std::uint32_t>(checked(o.max_parts, ranges.max_parts.least, ranges.max_parts.max, "options.max_parts"));
    out.exact = o.without_exact == 0;
    out.keep_input = o.without_input == 0;
    out.threads = o.threads;
    if (o.progress != nullptr)
        out.progress = [&o](const char* stage, double done) {
            if (o.progress(o.progress_context, stage, done) != 0) throw Cancelled{};
        };
    return out;
}

/// The element of a diagnosis, "face 12", as a caller of arrays counts: "mesh.triangles[11]"; without "mesh." but in C.
std::string in_arrays(const std::string& element, std::int32_t words)
{
    const std::string owner = words == SQMAP_WORDS_C ? "mesh." : "";
    const auto row = [&](const char* name, unsigned long long from_one) {
        return owner + name + "[" + std::to_string(from_one - 1) + "]";
    };
    unsigned long long first = 0, second = 0;
    if (std::sscanf(element.c_str(), "face %llu", &first) == 1) return row("triangles", first);
    if (std::sscanf(element.c_str(), "vertex %llu", &first) == 1) return row("vertices", first);
    if (std::sscanf(element.c_str(), "edge %llu-%llu", &first, &second) == 2)
        return "edge " + row("vertices", first) + "-" + row("vertices", second);
    return element;
}

std::shared_ptr<Model> baked(const MeshInput& input, const sqmap_bake_options& o)
{
    (void)names_of(o.words, "options.words");
    try {
        BakeMeshOptions options{.bake = bake_options(o), .provenance = {.made_by = "libsqmap " SQMAP_VERSION}};
        options.mesh.admit = admit_options(o);
        if (o.projection == 1) options.paper_maps.emplace();
        if (o.source != nullptr) options.provenance.source = o.source;
        return std::make_shared<Model>(bake_mesh(input, options).bytes(), o.words);
    } catch (const mesh::RefusedMesh& e) {
        const mesh::Diagnosis& d = e.diagnosis();
        const bool is_file = std::holds_alternative<std::filesystem::path>(input);
        throw Failure{SQMAP_E_MESH, is_file ? d.element : in_arrays(d.element, o.words), d.message, d.cure, mesh::name_of(d.code),
                      o.words};
    } catch (const Cancelled&) {
        throw Failure{SQMAP_E_CANCELLED, "progress", "the callback stopped the bake", "bake again"};
    }
}

}  // namespace

}  // namespace sqmap::capi

using namespace sqmap;
using capi::guarded;
using capi::needed;

sqmap_code sqmap_bake(const sqmap_mesh* mesh, const sqmap_bake_options* options, sqmap_model* model)
{
    return capi::opened(model, "model", capi::models(), [&] {
        const sqmap_mesh in = capi::taken(&needed(mesh, "mesh"), "mesh");
        const sqmap_points points{sizeof(sqmap_points), in.vertices, in.vertex_count, nullptr};
        if (in.triangle_count > 0xffffffffu / 3)
            throw capi::Failure{SQMAP_E_ARGUMENT, "mesh.triangle_count", "is too large", "give the number of triangles"};
        if (in.triangle_count > 0) (void)needed(in.triangles, "mesh.triangles");
        const mesh::PolygonView arrays{capi::rows(points, "mesh.vertices"), {}, std::span(in.triangles, 3 * in.triangle_count)};
        return capi::baked(arrays, capi::taken(options, "options"));
    });
}

sqmap_code sqmap_bake_file(const char* path, const sqmap_bake_options* options, sqmap_model* model)
{
    return capi::opened(model, "model", capi::models(), [&] {
        const std::filesystem::path file = &needed(path, "path");
        return capi::baked(file, capi::taken(options, "options"));
    });
}
