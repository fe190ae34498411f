// Baking behind the C interface, which libsqmap has and libsqmap_query leaves out.
#include "objects.h"
#include "sqmap/bake_mesh.h"
#include "structs.h"
#include "words.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>

namespace sqmap::capi {
namespace {

/// Thrown through bake by the progress of a caller that cancels.
struct Cancelled {};

/// A member of a struct of this interface with the name of the option that it sets.
template <class Struct>
struct Given {
    const char* name;
    NumberMember<Struct> member;
};
using Bake = sqmap_bake_options;
constexpr Given<Bake> k_bake_members[] = {{"target_error", &Bake::target_error},
                                          {"band", &Bake::band},
                                          {"max_parts", &Bake::max_parts},
                                          {"thickness", &Bake::thickness},
                                          {"gap", &Bake::gap},
                                          {"wrap_tolerance", &Bake::wrap_tolerance},
                                          {"unit", &Bake::unit}};
using Paper = sqmap_paper_options;
constexpr Given<Paper> k_paper_members[] = {{"protrusion_sources", &Paper::protrusion_sources},
                                            {"salient_window", &Paper::salient_window},
                                            {"salient_prominence", &Paper::salient_prominence},
                                            {"locale_width", &Paper::locale_width},
                                            {"boundary_strength", &Paper::boundary_strength},
                                            {"protrusion_ratio", &Paper::protrusion_ratio},
                                            {"curvature_window", &Paper::curvature_window},
                                            {"hyperbolic_curvature", &Paper::hyperbolic_curvature},
                                            {"boundary_concavity", &Paper::boundary_concavity},
                                            {"curvature_floor", &Paper::curvature_floor},
                                            {"hyperbolic_share", &Paper::hyperbolic_share},
                                            {"minimum_part", &Paper::minimum_part},
                                            {"fragment_roundness", &Paper::fragment_roundness},
                                            {"printed_strength", &Paper::printed_strength},
                                            {"printed_curvature", &Paper::printed_curvature},
                                            {"max_looseness", &Paper::max_looseness},
                                            {"max_q2", &Paper::max_q2},
                                            {"rows", &Paper::rows},
                                            {"columns", &Paper::columns},
                                            {"subdivisions", &Paper::subdivisions},
                                            {"offset_constant", &Paper::offset_constant},
                                            {"offset_radius", &Paper::offset_radius},
                                            {"smoothing_length", &Paper::smoothing_length},
                                            {"smoothing_radius", &Paper::smoothing_radius}};

/// True where a table has an option of this name, whose range is then given.
template <class Options, std::size_t n>
bool range_found(const NumberOption<Options> (&table)[n], std::string_view name, double& least, double& greatest)
{
    for (const NumberOption<Options>& option : table)
        if (option.name == name) {
            least = option.range.least;
            greatest = option.range.max;
            return true;
        }
    return false;
}

std::string of_paper(const char* name) { return std::string("options.paper.") + name; }

/// Sets an option to what a member gives. Zero leaves it, below zero stands for zero where that is in range and not the default.
template <class Struct, class Options>
void take(const Struct& from, const NumberMember<Struct>& member, const NumberOption<Options>& option, Options& to)
{
    const double given = value_of(from, member);
    if (given == 0) return;
    const bool means_zero = given < 0 && std::isfinite(given) && option.range.holds(0) && option.value(Options{}) != 0;
    const std::string element = std::is_same_v<Struct, Paper> ? of_paper(option.name) : std::string("options.") + option.name;
    option.set(to, checked(means_zero ? 0 : given, option.range.least, option.range.max, element.c_str()));
}

/// The same for all options of a table that this struct has.
template <class Struct, std::size_t given, class Options, std::size_t n>
void take_numbers(const Struct& from, const Given<Struct> (&members)[given], const NumberOption<Options> (&table)[n], Options& to)
{
    for (const NumberOption<Options>& option : table)
        for (const Given<Struct>& m : members)
            if (std::string_view(m.name) == option.name) take(from, m.member, option, to);
}

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
    if (o.solid != SQMAP_SOLID_AS_IS && o.solid != SQMAP_SOLID_OUTER)
        throw Failure{SQMAP_E_ARGUMENT, "options.solid", "is " + std::to_string(o.solid), "take one of sqmap_solid"};
    if (o.solid == SQMAP_SOLID_OUTER) out.solid = mesh::SolidKind::Outer;
    take_numbers(o, k_bake_members, mesh::k_admission_numbers, out);
    take_numbers(o, k_bake_members, mesh::k_wrap_numbers, out.wrap);
    return out;
}

bake::BakeOptions bake_options(const sqmap_bake_options& o)
{
    bake::BakeOptions out;
    if (o.projection != 0 && o.projection != 1)
        throw Failure{SQMAP_E_ARGUMENT, "options.projection", "is " + std::to_string(o.projection), "take 0 or 1"};
    if (o.threads > 1024)
        throw Failure{SQMAP_E_ARGUMENT, "options.threads", "is " + std::to_string(o.threads), "give at most 1024"};
    take_numbers(o, k_bake_members, bake::k_bake_numbers, out);
    if (o.without_locator != 0 && o.projection == 1)
        throw Failure{SQMAP_E_ARGUMENT, "options.without_locator", "is given, and a paper model has no locator", "leave it out"};
    out.locator = o.without_locator == 0;
    out.exact = o.without_exact == 0 && out.locator;
    out.keep_input = o.without_input == 0;
    out.threads = o.threads;
    if (o.progress != nullptr)
        out.progress = [&o](const char* stage, double done) {
            if (o.progress(o.progress_context, stage, done) != 0) throw Cancelled{};
        };
    return out;
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
    out.fit.allow_taper = o.without_taper == 0;
    out.fit.allow_bend = o.without_bend == 0;
    take_numbers(o, k_paper_members, bake::k_bake_numbers, out);
    const bool printed = kind(o.cuts, 2, "cuts") == 1;
    if (printed) out.decompose = decompose::printed_cuts();
    if (o.exact_geodesics != 0) out.decompose.protrusion = decompose::ProtrusionSum::Exact;
    take_numbers(o, k_paper_members, decompose::k_thresholds, out.decompose);
    if (kind(o.mean_curvature, 2, "mean_curvature") == 1) out.decompose.curvature_mean = decompose::CurvatureMean::Count;
    refuse_idle(decompose::idle_threshold(out.decompose));
}

/// True where an option of the paper's maps is not zero.
bool gives_maps(const sqmap_paper_options& o)
{
    const auto is_of = [](const char* name, const auto& table) {
        return std::any_of(std::begin(table), std::end(table),
                           [&](const auto& option) { return option.name == std::string_view(name); });
    };
    return o.smoothing != 0 || o.smoothing_kernel != 0 ||
           std::any_of(std::begin(k_paper_members), std::end(k_paper_members), [&](const Given<Paper>& m) {
               return (is_of(m.name, paper::k_map_numbers) || is_of(m.name, paper::k_grid_numbers)) && value_of(o, m.member) != 0;
           });
}

/// Section 4.1.
paper::MapOptions map_options(const sqmap_paper_options& o, bool is_paper)
{
    paper::MapOptions out;
    if (o.rows != 0 || o.columns != 0) {
        take_numbers(o, k_paper_members, paper::k_grid_numbers, out.grid);
        for (const NumberOption<paper::GridSize>& side : paper::k_grid_numbers)
            (void)checked(side.value(out.grid), side.range.least, side.range.max, of_paper(side.name).c_str());
    }
    take_numbers(o, k_paper_members, paper::k_map_numbers, out);
    out.smoothing = static_cast<paper::Smoothing>(kind(o.smoothing, 2, "smoothing"));
    out.smoothing_kernel = static_cast<paper::SmoothingKernel>(kind(o.smoothing_kernel, 3, "smoothing_kernel"));
    refuse_idle(paper::idle_smoothing(out));
    if (!paper::is_storable(out))
        throw Failure{SQMAP_E_ARGUMENT, of_paper("rows"), "and columns, subdivided, are more than a map can have",
                      "give fewer, or fewer subdivisions"};
    if (const int max = paper::greatest_smoothing_radius(out); out.smoothing_radius > max)
        throw Failure{SQMAP_E_ARGUMENT, of_paper("smoothing_radius"),
                      "is more than " + std::to_string(max) + ", the greatest for so few rows", "give less, or more rows"};
    if (gives_maps(o) && !is_paper)
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
        if (d.code == mesh::Refusal::File) throw Failure{SQMAP_E_FILE, d.element, d.message, d.cure};
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

sqmap_code sqmap_option_range(const char* name, double* least, double* greatest)
{
    return guarded([&] {
        const std::string_view wanted = &needed(name, "name");
        double &from = needed(least, "least"), &to = needed(greatest, "greatest");
        const auto find = [&](const auto&... tables) { return (capi::range_found(tables, wanted, from, to) || ...); };
        if (!find(bake::k_bake_numbers, mesh::k_admission_numbers, mesh::k_wrap_numbers, decompose::k_thresholds,
                  paper::k_map_numbers, paper::k_grid_numbers, paper::k_query_numbers))
            throw capi::Failure{SQMAP_E_ARGUMENT, "name", "is no number with a range", "give a member's name: \"band\""};
    });
}
