// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, sections 2 to 4.1: the whole of preprocessing.
#include "pipeline.h"

#include "assemble.h"
#include "bake/distance/distance.h"
#include "bake/locator/made_up.h"
#include "bake/parts/bound_figures.h"
#include "bake/parts/fit.h"
#include "budget.h"
#include "decompose/borders.h"
#include "decompose/mirror.h"
#include "decompose/named_parts.h"
#include "decompose/partition.h"
#include "mesh/simplified.h"
#include "model/flags.h"
#include "parallel/for_each.h"
#include "sqmap/mesh/error.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/model/model.h"
#include "sqmap/model/named_parts.h"

#include <algorithm>
#include <cmath>
#include <ctime>

namespace sqmap::bake {

namespace {

constexpr int k_refinements = 6;
// Small cells do not help where sheets cross and hide each other: none are made smaller once they have gained less than this
// share, a logarithm's, of what they should, or the maps take so many times their budget.
constexpr double k_least_gain = 0.5;
constexpr double k_max_refined = 3;
// A model that misses its targets by so many times is not measured with more points: it is refined by as much as it may be.
constexpr double k_clear_miss = 1.5;
// No resolution of the maps shows a surface that is mostly hidden from its parts' projections, as in cups and cheese, and the
// locator answers there: the maps' cells are so much larger, and not refined.
constexpr double k_mostly_hidden = 50, k_hidden_coarser = 4;
constexpr std::uint32_t k_hidden_base = 4;

// Meshes of so many triangles are cut, and their parts' fits compared, on a copy of so many.
constexpr std::size_t k_many_triangles = 100000;
constexpr std::uint32_t k_coarse_triangles = 10000;

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

void check(const mesh::Mesh& mesh, const BakeOptions& options)
{
    check_numbers(k_bake_numbers, options);
    check_numbers(decompose::k_thresholds, options.decompose);
    if (!options.locator && options.exact) throw mesh::InvalidInput("the exact layer needs the locator");
    if (!options.cured.made_up.empty() && options.cured.made_up.size() != mesh.triangles.size())
        throw mesh::InvalidInput("what is made up is of another mesh");
    const SourceNumbers& source = options.source;
    if ((!source.triangle.empty() && source.triangle.size() != mesh.triangles.size()) ||
        (!source.vertex.empty() && source.vertex.size() != mesh.vertices.size()))
        throw mesh::InvalidInput("the numbers of the input are of another mesh");
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

double map_bytes(const std::vector<CentralMapData>& maps)
{
    double sum = 0;
    for (const CentralMapData& map : maps) sum += static_cast<double>(map.map_bytes());
    return sum;
}

/// True where a part's map has no room for finer cells.
bool is_any_full(const std::vector<CentralMapData>& maps)
{
    return std::any_of(maps.begin(), maps.end(), [](const CentralMapData& map) { return map.is_full; });
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

model::Cure stored(const Cured& cured)
{
    const mesh::Distances &from = cured.deviation.input_to_result, &to = cured.deviation.result_to_input;
    return {cured.rung, from.mean, from.p99, from.max, to.mean, to.p99, to.max, cured.deviation.made_up_share};
}

/// The domain of the chart that a part had.
ChartDomain domain_of(const model::Part& part)
{
    ChartDomain domain{};
    std::copy(std::begin(part.chart_lo), std::end(part.chart_lo), domain.lo);
    std::copy(std::begin(part.chart_hi), std::end(part.chart_hi), domain.hi);
    return domain;
}

double cpu_seconds()
{
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace

model::ModelData Pipeline::run_steps()
{
    last_lap_ = cpu_seconds();
    validate();
    lap("prepare");
    parts();
    polytopes();
    lap("fit");
    maps();
    lap("map");
    locator();
    exact();
    measure();
    lap("locate");
    model_.bound_figures = measure_bounds(mesh_, patches(), model_, locator_.threads);
    lap("bounds");
    finish();
    lap("distance");
    return std::move(model_);
}

void Pipeline::exact() { bake_candidate_lists(*solid_, kept_lists_ ? &*kept_lists_ : nullptr, locator_, model_); }

void Pipeline::finish()
{
    mark_made_up(mesh_, made_up_, model_);
    // Distances are the triangles', or those of central maps.
    if (model::has_exact(model_.view()) || model::has_central_maps(model_.view()))
        bake_distance(*solid_, {band_, locator_.threads, bytes_beside()}, model_);
    if (model::has_exact(model_.view()) && !input_vertices_.empty()) store_input(input_vertices_, source_, model_);
    model_.mesh_hash = mesh_hash_;
}

void Pipeline::set_mesh(mesh::Mesh mesh, std::span<const std::uint8_t> crossed)
{
    mesh_ = std::move(mesh);
    solid_.emplace(mesh_, crossed);
}

void Pipeline::lap(const char* stage)
{
    const double now = cpu_seconds();
    seconds_.emplace_back(stage, now - last_lap_);
    last_lap_ = now;
}

Bake::Bake(const mesh::Mesh& input, bool is_solid, const BakeOptions& options)
    : Pipeline({options.target_error, options.threads}), options_(options), input_(input)
{
    header_.solid = is_solid ? 1 : 0;
}

BakeResult Bake::run()
{
    BakeResult result;
    result.model = run_steps();
    const model::Measured& m = result.model.measured;
    result.report.fineness = fineness_;
    result.report.target_met = m.depth_p99 <= options_.target_error && !model::has_wrong_verdicts(m);
    result.report.parts = part_reports();
    name_parts(result.model);
    result.report.partition = std::move(fitted_.partition);
    progress("measure", 1);
    lap("measure");
    result.report.seconds = std::move(seconds_);
    return result;
}

/// Parts that a person has cut have names of their own.
void Bake::name_parts(model::ModelData& model) const
{
    if (name_of_triangle_.empty()) return;
    const std::vector<std::uint32_t> groups = decompose::labels_of_parts(fitted_.partition, name_of_triangle_);
    for (std::size_t i = 0; i < groups.size(); ++i) model::set_group(model.parts[i], groups[i]);
}

void Bake::progress(const char* stage, double done) const
{
    if (options_.progress) options_.progress(stage, done);
}

void Bake::validate()
{
    check(input_, options_);
    mesh_hash_ = mesh::content_hash(input_);
    made_up_.assign(options_.cured.made_up.begin(), options_.cured.made_up.end());
    if (options_.keep_input) input_vertices_ = input_.vertices;
    source_ = options_.source;
    band_ = options_.band;
    const mesh::Normalization normalization = mesh::normalization_of(input_);
    for (int k = 0; k < 3; ++k) header_.origin[k] = normalization.origin[k];
    header_.unit = normalization.unit;
    mesh::Mesh mesh = model_space(input_);
    const std::vector<std::uint8_t> crossed = mesh::find_self_intersections(mesh).crossed;
    set_mesh(std::move(mesh), crossed);
}

void Bake::parts()
{
    progress("decompose", 0);
    const bool is_fine = options_.partition == nullptr && options_.decompose.cutting == decompose::Cutting::Passes &&
                         mesh_.triangles.size() >= k_many_triangles;
    const decompose::Partition first = is_fine ? coarse_partition() : named_partition(mesh_);
    lap("decompose");
    progress("fit", 0);
    const CanonicalMesh canonical = canonical_mesh(mesh_);
    const PartsInput input{*solid_, canonical, hidden_share()};
    const bool is_final = is_fine || options_.partition != nullptr;
    fitted_ = is_final ? fit_partition(input, first, options_) : refine_partition(input, first, options_);
}

/// The first parts, cut where a person would. Names come from them: they do not depend on what the fits need.
decompose::Partition Bake::named_partition(const mesh::Mesh& mesh)
{
    decompose::Partition partition = first_partition(mesh, options_);
    if (options_.partition != nullptr) return partition;
    std::optional<decompose::Mirror> mirror;
    const bool as_named = !hidden_share() && options_.decompose.cutting == decompose::Cutting::Passes;
    if (as_named) {
        partition = decompose::cut_creases(mesh, std::move(partition), {.max_parts = options_.max_parts});
        mirror = decompose::find_mirror(mesh);
        if (mirror) partition = decompose::symmetrised(mesh, *mirror, std::move(partition), options_.max_parts);
    }
    decompose::NamedPartition named{partition, decompose::named_parts(mesh, partition, {}, mirror ? &*mirror : nullptr)};
    if (as_named) named = decompose::smoothed(mesh, named, mirror ? &*mirror : nullptr);
    name_of_triangle_.clear();
    for (const std::uint32_t part : named.partition.part_of_triangle) name_of_triangle_.push_back(named.names[part]);
    return named.partition;
}

/// The parts of a coarse copy, on the mesh: they depend on its shape, not on its detail.
decompose::Partition Bake::coarse_partition()
{
    const mesh::Simplified coarse = mesh::simplified(mesh_, k_coarse_triangles);
    const mesh::Solid solid(coarse.mesh, mesh::find_self_intersections(coarse.mesh).crossed);
    const CanonicalMesh canonical = canonical_mesh(coarse.mesh);
    const decompose::Partition parts =
        refine_partition({solid, canonical, hidden_share()}, named_partition(coarse.mesh), options_).partition;
    // Two corners agree but where three parts meet.
    std::vector<std::uint32_t> labels, names;
    for (const mesh::Triangle& t : mesh_.triangles) {
        const auto part = [&](int k) { return parts.part_of_triangle[coarse.carrier[t[k]]]; };
        const int corner = part(1) == part(2) ? 1 : 0;
        labels.push_back(part(corner));
        names.push_back(name_of_triangle_[coarse.carrier[t[corner]]]);
    }
    name_of_triangle_ = std::move(names);
    return decompose::carried_over(mesh_, parts, std::move(labels));
}

void Bake::polytopes()
{
    parallel::for_each(fitted_.parts.size(), options_.threads, [&](std::size_t i) {
        FittedPart& part = fitted_.parts[i].fitted;
        part.polytope = fit_polytope(mesh_, part, fitted_.parts.size());
    });
}

std::vector<Patch> Bake::patches() const
{
    std::vector<Patch> patches;
    for (const MeasuredPart& part : fitted_.parts) patches.push_back(part.fitted.patch);
    return patches;
}

void Bake::maps()
{
    Draft draft = meet_target();
    maps_ = std::move(draft.maps);
    model_ = std::move(draft.model);
    model_.cure = stored(options_.cured);
}

/// The target is met by measuring: finer cells where the first guess falls short.
Draft Bake::meet_target()
{
    progress("map", 0);
    CentralOptions central = central_options(options_.target_error, mesh::largest_vertex_distance(mesh_));
    const double hidden = hidden_percent(fitted_.parts);
    const bool is_hidden = header_.solid != 0 && hidden > max_hidden();
    if (is_hidden) {
        scale(central, fineness_ = k_hidden_coarser);
        central.least_base = k_hidden_base;
    }
    const auto made = [&](const Draft* coarser) {
        Draft out = draft(central, coarser);
        out.model.measured.q2_share = hidden;
        return out;
    };
    Draft best = made(nullptr);
    accept();
    progress("measure", 0);
    if (is_hidden) return best;
    const double max_bytes = k_max_refined * byte_budget(mesh_.triangles.size(), options_.target_error);
    double factor = 1;
    for (int attempt = 0; attempt < k_refinements; ++attempt) {
        const double before = shortfall(best.model.measured);
        if (!(before > 1) || map_bytes(best.maps) > max_bytes || is_any_full(best.maps)) break;
        progress("refine", static_cast<double>(attempt) / k_refinements);
        const double finer_by = std::clamp(1 / before, 0.5, 0.7);
        scale(central, finer_by);
        factor *= finer_by;
        Draft finer = made(&best);
        const double gain = shortfall(finer.model.measured) / before;
        if (gain >= 1) break;  // keep the better model
        best = std::move(finer);
        accept();
        fineness_ = factor;
        if (gain > std::pow(finer_by, k_least_gain)) break;
    }
    return best;
}

std::vector<PartReport> Bake::part_reports() const
{
    std::vector<PartReport> reports;
    for (std::size_t i = 0; i < fitted_.parts.size(); ++i) {
        const auto& [part, quality] = fitted_.parts[i];
        reports.push_back({part.fit.certificate, part.fit.volume, quality.solid_volume, quality.area, quality.q2_share,
                           part.fit.fallback, maps_[i].base, maps_[i].map_bytes()});
    }
    return reports;
}

model::Measured Bake::measured(const std::function<Evaluation(const EvaluateOptions&)>& evaluate) const
{
    EvaluateOptions options;
    options.points = 4000;
    const model::Measured quick = figures_of(evaluate(options));
    const double miss = shortfall(quick);
    if (miss <= 1 || miss >= k_clear_miss) return quick;
    options.points = 20000;
    return figures_of(evaluate(options));
}

SampledSolid& Bake::samples(const model::ModelView& view)
{
    if (!samples_) samples_.emplace(*solid_, model::normalized(view).header.r_max);
    return *samples_;
}

void Bake::measure_layers(const model::ModelView& view, model::Measured& m)
{
    EvaluateOptions options;
    options.points = m.q2_share > k_mostly_hidden ? 20000 : 4000;
    const LayerErrors errors = layer_errors(view, samples(view), options);
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

std::vector<CentralMapData> bake_central_maps(const mesh::Solid& solid, std::span<const MapSource> sources, unsigned threads)
{
    std::vector<CentralMapData> maps(sources.size());
    parallel::for_each(maps.size(), threads, [&](std::size_t i) {
        const auto& [part, options, known] = sources[i];
        const shape::Superquadricd& sq = part.fit.superquadric;
        const ChartDomain domain =
            known ? domain_of(known->part) : chart_domain(sq, part.centre, corners_of(solid.mesh(), part.patch));
        maps[i] = bake_central_map(solid, {sq, part.centre, domain, part.patch.triangles}, options, known ? &*known : nullptr);
    });
    return maps;
}

std::vector<CentralMapData> Bake::central_maps(const CentralOptions& central, std::span<const CentralMapData> coarser) const
{
    std::vector<MapSource> sources;
    for (std::size_t i = 0; i < fitted_.parts.size(); ++i) {
        MapSource& source = sources.emplace_back(MapSource{fitted_.parts[i].fitted, central});
        if (!coarser.empty()) source.options.least_base = coarser[i].base;
    }
    return bake_central_maps(*solid_, sources, options_.threads);
}

model::ModelData Bake::assembled(const std::vector<CentralMapData>& maps) const
{
    Assembly assembly{*solid_, fitted_.partition.part_of_triangle, {}, nullptr, options_.exact};
    for (std::size_t i = 0; i < maps.size(); ++i) assembly.parts.push_back({&fitted_.parts[i].fitted, &maps[i]});
    return assemble(header_, assembly);
}

}  // namespace sqmap::bake
