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
    constexpr bake::BakeRanges k_ranges;
    bake::BakeOptions out;
    if (o.projection != 0 && o.projection != 1)
        throw Failure{SQMAP_E_ARGUMENT, "options.projection", "is " + std::to_string(o.projection), "take 0 or 1"};
    if (o.threads > 1024)
        throw Failure{SQMAP_E_ARGUMENT, "options.threads", "is " + std::to_string(o.threads), "give at most 1024"};
    if (o.target_error != 0)
        out.target_error =
            checked(o.target_error, k_ranges.target_error.least, k_ranges.target_error.max, "options.target_error");
    if (o.band != 0) out.band = checked(o.band, k_ranges.band.least, k_ranges.band.max, "options.band");
    if (o.max_parts != 0)
        out.max_parts = static_cast<std::uint32_t>(
            checked(o.max_parts, k_ranges.max_parts.least, k_ranges.max_parts.max, "options.max_parts"));
    out.exact = o.without_exact == 0;
    out.keep_input = o.without_input == 0;
    out.threads = o.threads;
    if (o.progress != nullptr)
        out.progress = [&o](const char* stage, double done) {
            if (o.progress(o.progress_context, stage, done) != 0) throw Cancelled{};
        };
    return out;
}

using Decompose = decompose::DecomposeOptions;

/// A threshold of section 3: the caller's, the library's, its range. A range that begins at zero is one of shares.
struct Threshold {
    const char* name;
    double sqmap_paper_options::*given;
    double Decompose::*value;
    double least, max;
};
constexpr Threshold k_thresholds[] = {
    {"salient_window", &sqmap_paper_options::salient_window, &Decompose::salient_window, 1e-3, 1e6},
    {"salient_prominence", &sqmap_paper_options::salient_prominence, &Decompose::salient_prominence, 1e-3, 1e6},
    {"locale_width", &sqmap_paper_options::locale_width, &Decompose::locale_width, 1e-3, 1e6},
    {"boundary_strength", &sqmap_paper_options::boundary_strength, &Decompose::boundary_strength, 1e-3, 1e6},
    {"protrusion_ratio", &sqmap_paper_options::protrusion_ratio, &Decompose::protrusion_ratio, 1e-3, 1e6},
    {"curvature_window", &sqmap_paper_options::curvature_window, &Decompose::curvature_window, 1e-3, 1e6},
    {"hyperbolic_curvature", &sqmap_paper_options::hyperbolic_curvature, &Decompose::hyperbolic_curvature, 1e-3, 1e6},
    {"boundary_concavity", &sqmap_paper_options::boundary_concavity, &Decompose::boundary_concavity, 0, 1},
    {"curvature_floor", &sqmap_paper_options::curvature_floor, &Decompose::curvature_floor, 0, 1},
    {"hyperbolic_share", &sqmap_paper_options::hyperbolic_share, &Decompose::hyperbolic_share, 0, 1},
    {"minimum_part", &sqmap_paper_options::minimum_part, &Decompose::minimum_part_area, 0, 1},
    {"fragment_roundness", &sqmap_paper_options::fragment_roundness, &Decompose::fragment_roundness, 0, 1},
    {"printed_strength", &sqmap_paper_options::printed_strength, &Decompose::printed_strength, 1e-3, 1e6},
    {"printed_curvature", &sqmap_paper_options::printed_curvature, &Decompose::printed_curvature, 1e-3, 1e6}};

std::string of_paper(const char* name) { return std::string("options.paper.") + name; }

/// Zero leaves the default; below zero stands for zero, where the range begins there.
template <class Number>
void take(double given, double least, double max, const char* name, Number& value)
{
    if (given == 0) return;
    const double meant = given < 0 && least == 0 ? 0 : given;
    value = static_cast<Number>(checked(meant, least, max, of_paper(name).c_str()));
}

/// One of so many kinds, from zero on.
int kind(std::int32_t given, int count, const char* name)
{
    if (given < 0 || given >= count)
        throw Failure{SQMAP_E_ARGUMENT, of_paper(name), "is " + std::to_string(given),
                      "give a number from 0 to " + std::to_string(count - 1)};
    return given;
}

void refuse_idle(const std::optional<IdleOption>& idle)
{
    if (idle) throw Failure{SQMAP_E_ARGUMENT, of_paper(idle->name), idle->why, idle->cure};
}

/// Sections 2 and 3.
void take_cuts(const sqmap_paper_options& o, bake::BakeOptions& out)
{
    constexpr bake::BakeRanges k_ranges;
    out.fit.allow_taper = o.without_taper == 0;
    out.fit.allow_bend = o.without_bend == 0;
    take(o.max_looseness, k_ranges.max_looseness.least, k_ranges.max_looseness.max, "max_looseness", out.max_looseness);
    take(o.max_q2, k_ranges.max_q2_share.least, k_ranges.max_q2_share.max, "max_q2", out.max_q2_share);
    const bool printed = kind(o.cuts, 2, "cuts") == 1;
    if (printed) out.decompose = decompose::printed_cuts();
    if (o.exact_geodesics != 0) out.decompose.protrusion = decompose::ProtrusionSum::Exact;
    take(o.protrusion_sources, 1, 1e5, "protrusion_sources", out.decompose.protrusion_sources);
    for (const Threshold& t : k_thresholds) take(o.*t.given, t.least, t.max, t.name, out.decompose.*t.value);
    if (kind(o.mean_curvature, 2, "mean_curvature") == 1) out.decompose.curvature_mean = decompose::CurvatureMean::Count;
    refuse_idle(decompose::idle_threshold(out.decompose));
}

/// Section 4.1.
paper::MapOptions map_options(const sqmap_paper_options& o, bool is_normal)
{
    paper::MapOptions out;
    if (o.rows != 0 || o.columns != 0) {
        take(o.rows == 0 ? 1 : o.rows, 5, paper::k_max_map_rows, "rows", out.grid.rows);
        take(o.columns == 0 ? 1 : o.columns, 8, paper::k_max_map_columns, "columns", out.grid.columns);
    }
    take(o.subdivisions, 0, 5, "subdivisions", out.subdivisions);
    take(o.offset_constant, 0, 100, "offset_constant", out.offset_constant);
    take(o.offset_radius, 0, 8, "offset_radius", out.offset_radius);
    take(o.smoothing_length, 1e-3, 0.1, "smoothing_length", out.smoothing_length);
    take(o.smoothing_radius, 0, 8, "smoothing_radius", out.smoothing_radius);
    out.smoothing = static_cast<paper::Smoothing>(kind(o.smoothing, 2, "smoothing"));
    out.smoothing_kernel = static_cast<paper::SmoothingKernel>(kind(o.smoothing_kernel, 3, "smoothing_kernel"));
    refuse_idle(paper::idle_smoothing(out));
    if (!paper::is_storable(out))
        throw Failure{SQMAP_E_ARGUMENT, of_paper("rows"), "and columns, subdivided, are more than a map can have",
                      "give fewer, or fewer subdivisions"};
    if (const int max = paper::greatest_smoothing_radius(out); out.smoothing_radius > max)
        throw Failure{SQMAP_E_ARGUMENT, of_paper("smoothing_radius"),
                      "is more than " + std::to_string(max) + ", the greatest for so few rows", "give less, or more rows"};
    const bool of_maps = o.rows != 0 || o.columns != 0 || o.subdivisions != 0 || o.offset_constant != 0 || o.offset_radius != 0 ||
                         o.smoothing != 0 || o.smoothing_length != 0 || o.smoothing_radius != 0 || o.smoothing_kernel != 0;
    if (of_maps && !is_normal)
        throw Failure{SQMAP_E_ARGUMENT, "options.projection", "is central, and options of the paper's maps are given",
                      "set it to 1, for a paper model"};
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
        const sqmap_paper_options paper = taken(o.paper, "options.paper");
        take_cuts(paper, options.bake);
        const paper::MapOptions maps = map_options(paper, o.projection == 1);
        if (o.projection == 1) options.paper_maps = maps;
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
