// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, sections 2 to 4.1: the whole of preprocessing.
#include "sqmap/bake/bake.h"

#include "assemble.h"
#include "bake/central/central_map.h"
#include "bake/central/central_options.h"
#include "bake/distance/distance.h"
#include "bake/exact/candidate_lists.h"
#include "bake/locator/locator.h"
#include "bake/locator/made_up.h"
#include "bake/normal/cells.h"
#include "bake/normal/pack.h"
#include "bake/parts/refinement.h"
#include "budget.h"
#include "model/flags.h"
#include "sqmap/bake/evaluate.h"
#include "sqmap/mesh/error.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/model/reliability.h"
#include "sqmap/parallel/for_each.h"
#include "stage_clock.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace sqmap::bake {

namespace {

constexpr int k_refinements = 6;
// Where sheets cross and hide each other small cells do not help: no further ones once they have gained less than this share, a
// logarithm's, of what they should, or the maps take so many times their budget.
constexpr double k_least_gain = 0.5;
constexpr double k_max_refined = 3;
// A model that misses its targets by so many times is not measured with more points.
constexpr double k_clear_miss = 3;
// Where more than this share of a solid's surface is hidden from its parts' projections, as in cups and cheese, no resolution of
// the maps shows it and the locator answers: their cells are so much larger, and not refined.
constexpr double k_mostly_hidden = 0.5, k_hidden_coarser = 4;
constexpr std::uint32_t k_hidden_base = 4;
// Where verdicts are wrong, the locator may take so many times its bytes.
constexpr double k_max_locator = 8;
// Eq. 35's mean and 99th percentile are held to these shares of the target too, where that is not less than what is promised at
// the default; the percentile, told from few points, with room to spare.
constexpr double k_eq35_share = 0.1, k_eq35_least = 0.05;
constexpr double k_eq35_p99_share = 0.9, k_eq35_p99_least = 0.45;

/// By which factor a model misses its targets; up to 1 it meets them.
double shortfall(const model::Measured& m, const BakeOptions& options)
{
    const double depth = m.depth_p99 / options.target_error;
    if (options.projection == model::Projection::Normal) return depth;  // what a first hit hides, no resolution shows
    return std::max({depth, m.eq35_mean / std::max(k_eq35_share * options.target_error, k_eq35_least),
                     m.eq35_p99 / std::max(k_eq35_p99_share * options.target_error, k_eq35_p99_least)});
}

model::Measured measure(const model::ModelData& data, const mesh::Solid& solid, std::uint32_t points)
{
    EvaluateOptions options;
    options.points = points;
    const Evaluation e = evaluate(data.view(), solid, options);
    model::Measured m;
    m.points = e.points;
    m.missed = e.missed;
    m.false_contacts = e.false_contacts;
    m.eq35_mean = e.eq35.mean;
    m.eq35_p99 = e.eq35.p99;
    m.eq35_max = e.eq35.max;
    m.depth_median = e.depth.median;
    m.depth_p95 = e.depth.p95;
    m.depth_p99 = e.depth.p99;
    m.depth_max = e.depth.max;
    m.normal_median = e.normal.median;
    return m;
}

/// The figures stored in the model: a quick evaluation of layer 3, a longer one where it misses by little enough that a few
/// rays with large errors may have made the mean of eq. 35.
model::Measured measure(const model::ModelData& data, const mesh::Solid& solid, const BakeOptions& options)
{
    const model::Measured quick = measure(data, solid, 4000);
    const double miss = shortfall(quick, options);
    return miss > 1 && miss < k_clear_miss ? measure(data, solid, 20000) : quick;
}

/// The same as probes compute: with the locator, which answers where its planes are the surface. Wrong verdicts are rare but
/// where most of the surface is hidden: there they are looked for at more points.
void measure_layers(const model::ModelData& data, const mesh::Solid& solid, model::Measured& m)
{
    EvaluateOptions options;
    options.points = m.q2_share > 100 * k_mostly_hidden ? 20000 : 4000;
    const LayerErrors errors = layer_errors(data.view(), solid, options);
    m.layer1_depth_p99 = errors.depth[0].p99;
    m.layer2_depth_p99 = errors.depth[1].p99;
    if (!model::has_locator(data.view())) return;
    m.points = errors.points;
    m.missed = errors.missed;
    m.false_contacts = errors.false_contacts;
    m.depth_median = errors.depth[2].median;
    m.depth_p95 = errors.depth[2].p95;
    m.depth_p99 = errors.depth[2].p99;
    m.depth_max = errors.depth[2].max;
    m.normal_median = errors.normal.median;
}

void check_partition(const decompose::Partition& partition, const mesh::Mesh& mesh)
{
    if (partition.part_count < 1 || partition.part_count > 1000) throw mesh::InvalidInput("a partition has 1 to 1000 parts");
    if (partition.part_of_triangle.size() != mesh.triangles.size())
        throw mesh::InvalidInput("the partition is of another mesh: it has " + std::to_string(partition.part_of_triangle.size()) +
                                 " triangles, the mesh " + std::to_string(mesh.triangles.size()));
    std::vector<std::uint8_t> used(partition.part_count);
    for (const std::uint32_t part : partition.part_of_triangle) {
        if (part >= partition.part_count) throw mesh::InvalidInput("the partition has a label beyond its parts");
        used[part] = 1;
    }
    if (std::find(used.begin(), used.end(), 0) != used.end()) throw mesh::InvalidInput("the partition has an empty part");
}

/// @throw mesh::InvalidInput
void check_range(const char* name, double value, double least, double max)
{
    if (value >= least && value <= max) return;
    throw mesh::InvalidInput(std::string(name) + " must be from " + std::to_string(static_cast<long>(least)) + " to " +
                             std::to_string(static_cast<long>(max)));
}

void check(const NormalMapOptions& map)
{
    check_range("subdivisions", map.subdivisions, 0, 5);
    check_range("the offset constant", map.offset_constant, 0, 100);
    check_range("the offset radius", map.offset_radius, 0, 8);
    check_range("the smoothing radius", map.smoothing_radius, 0, 8);
    if (map.grid.rows == 0 && map.grid.columns == 0) return;
    check_range("rows of the grid", map.grid.rows, 5, model::k_max_map_rows);
    check_range("columns of the grid", map.grid.columns, 8, model::k_max_map_columns);
    if (!is_storable(map))
        throw mesh::InvalidInput("the grid, subdivided, must have at most " + std::to_string(model::k_max_map_rows) +
                                 " rows and " + std::to_string(model::k_max_map_columns) + " columns");
}

void check(const decompose::DecomposeOptions& d)
{
    for (const double threshold :
         {d.salient_window, d.salient_prominence, d.locale_width, d.boundary_strength, d.protrusion_ratio, d.boundary_concavity,
          d.curvature_window, d.hyperbolic_share, d.hyperbolic_curvature, d.minimum_part_area, d.fragment_roundness,
          d.printed_strength, d.printed_curvature})
        if (!(threshold >= 0 && std::isfinite(threshold)))
            throw mesh::InvalidInput("a threshold of the decomposition is negative or not finite");
}

void check(const mesh::Mesh& mesh, const BakeOptions& options)
{
    if (!(options.target_error > 0)) throw mesh::InvalidInput("target error must be above zero");
    if (options.max_parts < 1 || options.max_parts > 1000) throw mesh::InvalidInput("max parts must be from 1 to 1000");
    check(options.normal);
    check(options.decompose);
    if (!options.locator && options.exact) throw mesh::InvalidInput("the exact layer needs the locator");
    if (!(options.max_looseness >= 1))
        throw mesh::InvalidInput("max looseness must be at least 1: no superquadric is smaller than what it holds");
    if (!(options.max_q2_share >= 0)) throw mesh::InvalidInput("max Q2 share must not be negative");
    if (!(options.band >= 0 && options.band <= 100)) throw mesh::InvalidInput("the band must be from 0 to 100 percent of R_max");
    if (!(options.split_gain >= 0 && options.split_gain < 1)) throw mesh::InvalidInput("split gain must be in [0, 1)");
    if (!options.cured.made_up.empty() && options.cured.made_up.size() != mesh.triangles.size())
        throw mesh::InvalidInput("what is made up is of another mesh");
    if (options.partition != nullptr) check_partition(*options.partition, mesh);
}

/// The caller's parts, or those that section 3 finds.
decompose::Partition first_partition(const mesh::Mesh& mesh, const BakeOptions& options)
{
    decompose::DecomposeOptions cuts = options.decompose;
    cuts.max_parts = std::min(cuts.max_parts, options.max_parts);
    decompose::Partition partition = options.partition != nullptr ? *options.partition : decompose::decompose(mesh, cuts);
    if (partition.part_count > model::k_max_parts)
        throw mesh::RefusedMesh(
            {mesh::Refusal::Limit, "mesh",
             std::to_string(partition.part_count) + " parts; a model holds " + std::to_string(model::k_max_parts),
             "leave out loose pieces"});
    return partition;
}

FittedPartition fitted(const mesh::Solid& solid, const decompose::Partition& partition, const BakeOptions& options)
{
    const CanonicalMesh canonical = canonical_mesh(solid.mesh());
    return options.partition != nullptr ? fit_partition(solid, canonical, partition, options)
                                        : refine_partition(solid, canonical, partition, options);
}

/// What maps are baked of.
struct Subject {
    const mesh::Solid& solid;
    const FittedPartition& fitted;
    model::Header header;  ///< as assemble takes it
    const BakeOptions& options;
};

/// A model without locator, and what it was made with.
struct Draft {
    std::vector<CentralMapData> maps;  ///< #parts
    model::ModelData model;
    model::Measured measured;
};

double map_bytes(const std::vector<CentralMapData>& maps)
{
    double sum = 0;
    for (const CentralMapData& map : maps) sum += static_cast<double>(map.map_bytes());
    return sum;
}

/// coarser: the maps of a draft with larger cells, or none. A base that was beaten there is not tried again.
std::vector<CentralMapData> bake_central_maps(const Subject& subject, const CentralOptions& central,
                                              const std::vector<CentralMapData>& coarser)
{
    const BakeOptions& options = subject.options;
    const mesh::Mesh& mesh = subject.solid.mesh();
    std::vector<CentralMapData> maps(subject.fitted.parts.size());
    parallel::for_each(maps.size(), options.threads, [&](std::size_t i) {
        const FittedPart& part = subject.fitted.parts[i].fitted;
        const shape::Superquadricd& sq = part.fit.superquadric;
        CentralOptions finer = central;
        if (!coarser.empty()) finer.least_base = coarser[i].base;
        const ChartDomain domain = chart_domain(sq, part.centre, corners_of(mesh, part.patch));
        maps[i] = bake_central_map(subject.solid, {sq, part.centre, domain, part.patch.triangles}, finer);
    });
    return maps;
}

model::ModelData assembled(const Subject& subject, const std::vector<CentralMapData>& maps)
{
    Assembly assembly{subject.solid, subject.fitted.partition.part_of_triangle, {}, nullptr, subject.options.exact};
    for (std::size_t i = 0; i < maps.size(); ++i) assembly.parts.push_back({&subject.fitted.parts[i].fitted, &maps[i]});
    return assemble(subject.header, assembly);
}

/// Percent of the surface that its part's projection does not see first.
double hidden_percent(const std::vector<MeasuredPart>& parts)
{
    double hidden = 0, area = 0;
    for (const MeasuredPart& part : parts) {
        hidden += 100 * part.quality.q2_share * part.quality.area;
        area += part.quality.area;
    }
    return hidden / area;
}

Draft make_draft(const Subject& subject, const CentralOptions& central, const std::vector<CentralMapData>& coarser)
{
    const BakeOptions& options = subject.options;
    const bool is_normal = options.projection == model::Projection::Normal;
    Draft draft;
    if (is_normal)
        draft.maps.resize(subject.fitted.parts.size());
    else
        draft.maps = bake_central_maps(subject, central, coarser);
    draft.model = assembled(subject, draft.maps);
    if (is_normal)
        append_normal_maps(subject.solid.mesh(), subject.fitted.parts,
                           {2.5 * central.tolerance * draft.model.header.r_max, options.normal, options.threads}, draft.model);
    draft.measured = measure(draft.model, subject.solid, options);
    draft.measured.q2_share = hidden_percent(subject.fitted.parts);
    return draft;
}

/// The target is met by measuring: finer cells where the first guess falls short. Sets fineness.
Draft meet_target(const Subject& subject, double& fineness)
{
    const BakeOptions& options = subject.options;
    const auto progress = [&](const char* stage, double done) {
        if (options.progress) options.progress(stage, done);
    };
    progress("map", 0);
    CentralOptions central = central_options(options.target_error, mesh::largest_vertex_distance(subject.solid.mesh()));
    const bool is_hidden = options.projection != model::Projection::Normal && subject.header.solid != 0 &&
                           hidden_percent(subject.fitted.parts) > 100 * k_mostly_hidden;
    if (is_hidden) {
        scale(central, fineness = k_hidden_coarser);
        central.least_base = k_hidden_base;
    }
    Draft draft = make_draft(subject, central, {});
    progress("measure", 0);
    if (is_hidden) return draft;
    const double max_bytes = k_max_refined * byte_budget(subject.solid.mesh().triangles.size(), options.target_error);
    double factor = 1;
    for (int attempt = 0; attempt < k_refinements && shortfall(draft.measured, options) > 1; ++attempt) {
        if (map_bytes(draft.maps) > max_bytes) break;
        progress("refine", static_cast<double>(attempt) / k_refinements);
        const double finer_by = std::clamp(1 / shortfall(draft.measured, options), 0.5, 0.7);
        scale(central, finer_by);
        factor *= finer_by;
        Draft finer = make_draft(subject, central, draft.maps);
        const double gain = shortfall(finer.measured, options) / shortfall(draft.measured, options);
        if (gain >= 1) break;  // keep the better model
        draft = std::move(finer);
        fineness = factor;
        if (gain > std::pow(finer_by, k_least_gain)) break;
    }
    return draft;
}

/// What finds the surface beside the maps: the locator and the exact layer's lists. A normal model has them for its triangles
/// alone: charts lead to its cells and are dropped, planes and seeds with them.
/// The locator, and what layers 1 to 3 err with it. Where verdicts are wrong it takes more bytes than its share.
void bake_measured_locator(const PartedSolid& surface, LocatorOptions locator, Draft& draft)
{
    for (;; locator.more *= 2) {
        bake_locator(surface, locator, draft.model);
        measure_layers(draft.model, surface.solid, draft.measured);
        if (!model::has_wrong_verdicts(draft.measured) || 2 * locator.more > k_max_locator) return;
    }
}

void bake_cells(const Subject& subject, Draft& draft)
{
    model::ModelData& data = draft.model;
    const BakeOptions& options = subject.options;
    const LocatorOptions locator{options.target_error, options.threads};
    const PartedSolid surface{subject.solid, subject.fitted.partition.part_of_triangle};
    if (options.projection != model::Projection::Normal) {
        if (data.header.solid != 0 && options.locator)
            bake_measured_locator(surface, locator, draft);
        else
            measure_layers(data, subject.solid, draft.measured);
        if (options.locator) bake_candidate_lists(subject.solid, locator, data);
        return;
    }
    if (options.exact && data.header.solid != 0) {
        const double r_max = mesh::largest_vertex_distance(subject.solid.mesh());
        model::ModelData led = assembled(subject, bake_central_maps(subject, central_options(options.target_error, r_max), {}));
        bake_locator(surface, locator, led);
        bake_candidate_lists(subject.solid, locator, led);
        take_cells(led, data);
    }
    measure_layers(data, subject.solid, draft.measured);
}

model::Cure stored(const Cured& cured)
{
    const mesh::Distances &from = cured.deviation.input_to_result, &to = cured.deviation.result_to_input;
    return {cured.rung, from.mean, from.p99, from.max, to.mean, to.p99, to.max, cured.deviation.made_up_share};
}

}  // namespace

mesh::Mesh model_space(const mesh::Mesh& mesh)
{
    mesh::Mesh out = mesh::normalized(mesh, mesh::normalization_of(mesh));
    for (Vec3d& v : out.vertices) v = cast<double>(cast<float>(v));
    return out;
}

BakeResult bake(const mesh::Mesh& input, bool solid_mesh, const BakeOptions& options)
{
    check(input, options);
    BakeResult result;
    StageClock clock;
    const auto lap = [&](const char* stage) { clock.lap(stage, result.report.seconds); };
    const auto progress = [&](const char* stage, double done) {
        if (options.progress) options.progress(stage, done);
    };

    const mesh::Mesh mesh = model_space(input);
    const mesh::Solid solid(mesh, mesh::find_self_intersections(mesh).crossed);
    lap("prepare");
    progress("decompose", 0);
    const decompose::Partition first = first_partition(mesh, options);
    lap("decompose");
    progress("fit", 0);
    FittedPartition parts = fitted(solid, first, options);
    lap("fit");

    const mesh::Normalization normalization = mesh::normalization_of(input);
    model::Header header{};
    for (int k = 0; k < 3; ++k) header.origin[k] = normalization.origin[k];
    header.unit = normalization.unit;
    header.solid = solid_mesh ? 1 : 0;
    header.projection = static_cast<std::uint32_t>(options.projection);
    const Subject subject{solid, parts, header, options};
    Draft draft = meet_target(subject, result.report.fineness);
    lap("map");
    bake_cells(subject, draft);
    lap("locate");
    mark_made_up(mesh, options.cured.made_up, draft.model);
    // Distances of a normal model are its triangles'.
    if (options.projection != model::Projection::Normal || options.exact)
        bake_distance(solid, options.band, options.threads, draft.model);
    lap("distance");

    draft.model.measured = draft.measured;
    draft.model.cure = stored(options.cured);
    draft.model.mesh_hash = mesh::content_hash(input);
    result.report.target_met = draft.measured.depth_p99 <= options.target_error && !model::has_wrong_verdicts(draft.measured);
    progress("measure", 1);
    for (std::size_t i = 0; i < parts.parts.size(); ++i) {
        const auto& [part, quality] = parts.parts[i];
        result.report.parts.push_back({part.fit.certificate, part.fit.volume, quality.solid_volume, quality.area,
                                       quality.q2_share, part.fit.fallback, draft.maps[i].base, draft.maps[i].map_bytes()});
    }
    result.model = std::move(draft.model);
    result.report.partition = std::move(parts.partition);
    lap("measure");
    return result;
}

}  // namespace sqmap::bake
