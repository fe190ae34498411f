// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, sections 2 to 4.1: the whole of preprocessing.
#include "pipeline.h"

#include "assemble.h"
#include "bake/distance/distance.h"
#include "bake/locator/made_up.h"
#include "budget.h"
#include "model/flags.h"
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
// Small cells do not help where sheets cross and hide each other: none are made smaller once they have gained less than this
// share, a logarithm's, of what they should, or the maps take so many times their budget.
constexpr double k_least_gain = 0.5;
constexpr double k_max_refined = 3;
// A model that misses its targets by so many times is not measured with more points.
constexpr double k_clear_miss = 3;
// No resolution of the maps shows a surface that is mostly hidden from its parts' projections, as in cups and cheese, and the
// locator answers there: the maps' cells are so much larger, and not refined.
constexpr double k_mostly_hidden = 50, k_hidden_coarser = 4;
constexpr std::uint32_t k_hidden_base = 4;

model::Measured figures_of(const Evaluation& e)
{
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

double map_bytes(const std::vector<CentralMapData>& maps)
{
    double sum = 0;
    for (const CentralMapData& map : maps) sum += static_cast<double>(map.map_bytes());
    return sum;
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

/// The target is met by measuring: finer cells where the first guess falls short. Sets fineness.
Draft meet_target(const Subject& subject, MapSteps& steps, double& fineness)
{
    const BakeOptions& options = subject.options;
    const auto progress = [&](const char* stage, double done) {
        if (options.progress) options.progress(stage, done);
    };
    progress("map", 0);
    CentralOptions central = central_options(options.target_error, mesh::largest_vertex_distance(subject.solid.mesh()));
    const double hidden = hidden_percent(subject.fitted.parts);
    const bool is_hidden = subject.header.solid != 0 && hidden > steps.max_hidden();
    if (is_hidden) {
        scale(central, fineness = k_hidden_coarser);
        central.least_base = k_hidden_base;
    }
    const auto made = [&](const Draft* coarser) {
        Draft out = steps.draft(subject, central, coarser);
        out.measured.q2_share = hidden;
        return out;
    };
    Draft draft = made(nullptr);
    steps.accept();
    progress("measure", 0);
    if (is_hidden) return draft;
    const double max_bytes = k_max_refined * byte_budget(subject.solid.mesh().triangles.size(), options.target_error);
    double factor = 1;
    for (int attempt = 0; attempt < k_refinements && steps.shortfall(draft.measured, options) > 1; ++attempt) {
        if (map_bytes(draft.maps) > max_bytes) break;
        progress("refine", static_cast<double>(attempt) / k_refinements);
        const double finer_by = std::clamp(1 / steps.shortfall(draft.measured, options), 0.5, 0.7);
        scale(central, finer_by);
        factor *= finer_by;
        Draft finer = made(&draft);
        const double gain = steps.shortfall(finer.measured, options) / steps.shortfall(draft.measured, options);
        if (gain >= 1) break;  // keep the better model
        draft = std::move(finer);
        steps.accept();
        fineness = factor;
        if (gain > std::pow(finer_by, k_least_gain)) break;
    }
    return draft;
}

model::Cure stored(const Cured& cured)
{
    const mesh::Distances &from = cured.deviation.input_to_result, &to = cured.deviation.result_to_input;
    return {cured.rung, from.mean, from.p99, from.max, to.mean, to.p99, to.max, cured.deviation.made_up_share};
}

/// Origin and unit of model space, and what the mesh is.
model::Header header_of(const mesh::Mesh& input, bool solid)
{
    const mesh::Normalization normalization = mesh::normalization_of(input);
    model::Header header{};
    for (int k = 0; k < 3; ++k) header.origin[k] = normalization.origin[k];
    header.unit = normalization.unit;
    header.solid = solid ? 1 : 0;
    return header;
}

std::vector<PartReport> report_of(const FittedPartition& fitted, const std::vector<CentralMapData>& maps)
{
    std::vector<PartReport> parts;
    for (std::size_t i = 0; i < fitted.parts.size(); ++i) {
        const auto& [part, quality] = fitted.parts[i];
        parts.push_back({part.fit.certificate, part.fit.volume, quality.solid_volume, quality.area, quality.q2_share,
                         part.fit.fallback, maps[i].base, maps[i].map_bytes()});
    }
    return parts;
}

}  // namespace

model::Measured measured(const std::function<Evaluation(const EvaluateOptions&)>& evaluate,
                         const std::function<double(const model::Measured&)>& shortfall)
{
    EvaluateOptions options;
    options.points = 4000;
    const model::Measured quick = figures_of(evaluate(options));
    const double miss = shortfall(quick);
    if (miss <= 1 || miss >= k_clear_miss) return quick;
    options.points = 20000;
    return figures_of(evaluate(options));
}

void measure_layers(const model::ModelView& view, const mesh::Solid& solid, model::Measured& m)
{
    EvaluateOptions options;
    options.points = m.q2_share > k_mostly_hidden ? 20000 : 4000;
    const LayerErrors errors = layer_errors(view, solid, options);
    m.layer1_depth_p99 = errors.depth[0].p99;
    m.layer2_depth_p99 = errors.depth[1].p99;
    if (!model::has_locator(view)) return;
    m.points = errors.points;
    m.missed = errors.missed;
    m.false_contacts = errors.false_contacts;
    m.depth_median = errors.depth[2].median;
    m.depth_p95 = errors.depth[2].p95;
    m.depth_p99 = errors.depth[2].p99;
    m.depth_max = errors.depth[2].max;
    m.normal_median = errors.normal.median;
}

void check_range(const char* name, double value, double least, double max)
{
    if (value >= least && value <= max) return;
    throw mesh::InvalidInput(std::string(name) + " must be from " + std::to_string(static_cast<long>(least)) + " to " +
                             std::to_string(static_cast<long>(max)));
}

std::vector<CentralMapData> bake_central_maps(const Subject& subject, const CentralOptions& central,
                                              std::span<const CentralMapData> coarser)
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

mesh::Mesh model_space(const mesh::Mesh& mesh)
{
    mesh::Mesh out = mesh::normalized(mesh, mesh::normalization_of(mesh));
    for (Vec3d& v : out.vertices) v = cast<double>(cast<float>(v));
    return out;
}

BakeResult run_pipeline(const mesh::Mesh& input, bool solid_mesh, const BakeOptions& options, MapSteps& steps)
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

    const Subject subject{solid, parts, header_of(input, solid_mesh), options};
    Draft draft = meet_target(subject, steps, result.report.fineness);
    lap("map");
    steps.locate(subject, draft);
    lap("locate");
    mark_made_up(mesh, options.cured.made_up, draft.model);
    // Distances are the triangles', or those of central maps.
    if (options.exact || model::has_central_maps(draft.model.view()))
        bake_distance(solid, {options.band, options.threads, steps.bytes_beside()}, draft.model);
    lap("distance");

    draft.model.measured = draft.measured;
    draft.model.cure = stored(options.cured);
    draft.model.mesh_hash = mesh::content_hash(input);
    result.report.target_met = draft.measured.depth_p99 <= options.target_error && !model::has_wrong_verdicts(draft.measured);
    progress("measure", 1);
    result.report.parts = report_of(parts, draft.maps);
    result.model = std::move(draft.model);
    result.report.partition = std::move(parts.partition);
    lap("measure");
    return result;
}

}  // namespace sqmap::bake
