// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, sections 2 to 4.1: the whole of preprocessing.
#include "sqmap/bake/bake.h"

#include "assemble.h"
#include "bake/parts/part_work.h"
#include "bake/parts/refinement.h"
#include "budget.h"
#include "candidate_lists.h"
#include "central_map.h"
#include "locator.h"
#include "sqmap/bake/evaluate.h"
#include "sqmap/bake/normal_map.h"
#include "sqmap/fit/fit.h"
#include "sqmap/mesh/error.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/solid.h"
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

/// The paper's own maps, packed into the model's arrays.
void bake_normal_maps(const mesh::Mesh& mesh, const std::vector<PartWork>& parts, const CentralOptions& central, double r_max,
                      const BakeOptions& options, model::ModelData& data)
{
    const MapRays rays(mesh);
    std::vector<NormalMap> maps(parts.size());
    parallel::for_each(parts.size(), options.threads, [&](std::size_t i) {
        const shape::Superquadricd& sq = parts[i].fit.superquadric;
        NormalMapOptions normal;
        normal.subdivisions = options.subdivisions;
        normal.target_error = 2.5 * central.tolerance * r_max / std::max({sq.a.x, sq.a.y, sq.a.z});
        maps[i] = bake_normal_map(rays, parts[i].triangles, sq, normal);
    });
    for (const NormalMap& m : maps) {
        model::NormalPart p{};
        p.eta_count = m.eta_count;
        p.omega_count = m.omega_count;
        p.subdivisions = m.subdivisions;
        p.vertex_count = m.vertex_count;
        p.distance_scale = m.distance_scale;
        p.offset_scale = m.offset_scale;
        p.quantization_error = m.quantization_error;
        p.cut_count = static_cast<std::uint32_t>(m.cuts.size());
        p.correction_row_count = static_cast<std::uint32_t>(m.correction_rows.size());
        p.correction_count = static_cast<std::uint32_t>(m.corrections.size());
        p.gap_row_count = static_cast<std::uint32_t>(m.gap_rows.size());
        p.gap_count = static_cast<std::uint32_t>(m.gaps.size());
        p.offset_count = static_cast<std::uint32_t>(m.offset.size());
        p.seeds_along = m.seed_count;
        p.seeds_mirrored = m.seeds_mirrored ? 1 : 0;
        p.seed_count = static_cast<std::uint32_t>(m.seeds.size());
        p.first_sample = append(data.normal_distance, m.distance);
        append(data.normal_normal, m.normal);
        p.first_cut = append(data.normal_cuts, m.cuts);
        p.first_correction_row = append(data.correction_rows, m.correction_rows);
        p.first_correction = append(data.corrections, m.corrections);
        p.first_gap_row = append(data.gap_rows, m.gap_rows);
        p.first_gap = append(data.gaps, m.gaps);
        p.first_offset = append(data.normal_offset, m.offset);
        append(data.normal_smoothed, m.smoothed);
        p.first_seed = append(data.seeds, m.seeds);
        data.normal_parts.push_back(p);
    }
}

/// Bakes every part's map and packs the model.
model::ModelData assemble(const SurfaceContext& context, const mesh::Normalization& normalization, const mesh::Solid& solid,
                          bool is_solid, const decompose::Partition& partition, std::vector<PartWork>& parts,
                          const CentralOptions& central, const BakeOptions& options)
{
    const mesh::Mesh& mesh = context.mesh;
    const bool is_normal = options.projection == model::Projection::Normal;
    model::ModelData data;
    if (is_normal) bake_normal_maps(mesh, parts, central, context.r_max, options, data);
    parallel::for_each(parts.size(), options.threads, [&](std::size_t i) {
        PartWork& part = parts[i];
        // Beside normal maps the central map knows the nearest surface where they have none, and leads the locator.
        if (is_normal && !options.exact)
            part.map = {};
        else {
            // A base that was beaten before is not tried again: tolerances only get finer.
            CentralOptions finer = central;
            finer.least_base = part.map.base;
            part.map =
                bake_central_map(context, part.fit.superquadric, part.centre,
                                 chart_domain(part.fit.superquadric, part.centre, corners_of(mesh, part)), part.triangles, finer);
        }
    });
    for (const PartWork& part : parts) {
        data.parts.push_back(make_part(mesh, part, data));
        data.header.quantisation = std::max(data.header.quantisation, part.map.quantisation);
    }
    for (int k = 0; k < 3; ++k) data.header.origin[k] = normalization.origin[k];
    data.header.unit = normalization.unit;
    data.header.r_max = context.r_max;
    bounding_sphere(mesh.vertices, data.header.sphere);
    data.header.solid = is_solid ? 1 : 0;
    data.header.projection = static_cast<std::uint32_t>(options.projection);
    data.header.triangle_count = static_cast<std::uint32_t>(mesh.triangles.size());
    data.header.vertex_count = static_cast<std::uint32_t>(mesh.vertices.size());
    data.header.self_intersecting = solid.self_intersecting() ? 1 : 0;
    if (!options.exact) return data;
    append_exact(solid, partition.part_of_triangle, context.flags, data);
    return data;
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

}  // namespace

mesh::Mesh model_space(const mesh::Mesh& mesh)
{
    mesh::Mesh out = mesh::normalized(mesh, mesh::normalization_of(mesh));
    for (Vec3d& v : out.vertices) v = cast<double>(cast<float>(v));
    return out;
}

BakeResult bake(const mesh::Mesh& input, bool solid_mesh, const BakeOptions& options)
{
    if (!(options.target_error > 0)) throw mesh::InvalidInput("target error must be above zero");
    if (options.max_parts < 1 || options.max_parts > 1000) throw mesh::InvalidInput("max parts must be from 1 to 1000");
    const auto progress = [&](const char* stage, double done) {
        if (options.progress) options.progress(stage, done);
    };
    if (options.subdivisions < 0 || options.subdivisions > 5) throw mesh::InvalidInput("subdivisions must be from 0 to 5");
    if (!(options.max_looseness >= 1))
        throw mesh::InvalidInput("max looseness must be at least 1: no superquadric is smaller than what it holds");
    if (!(options.max_q2_share >= 0)) throw mesh::InvalidInput("max Q2 share must not be negative");
    if (!(options.split_gain >= 0 && options.split_gain < 1)) throw mesh::InvalidInput("split gain must be in [0, 1)");
    if (options.partition != nullptr) check_partition(*options.partition, input);
    BakeResult result;
    StageClock clock;
    const auto lap = [&](const char* stage) { clock.lap(stage, result.report.seconds); };

    const mesh::Normalization normalization = mesh::normalization_of(input);
    const mesh::Mesh mesh = model_space(input);
    const mesh::Solid solid(mesh, mesh::find_self_intersections(mesh).crossed);
    std::vector<std::uint16_t> flags(mesh.triangles.size(), 0);
    for (std::size_t t = 0; t < flags.size(); ++t) flags[t] = surface_flag(solid.boundary()[t]);
    const Mat3d frame = mesh::principal_frame(mesh);
    const mesh::Mesh canonical = canonical_view(mesh, frame);
    const SurfaceContext context{mesh, solid.bvh(), flags, mesh::largest_vertex_distance(mesh), canonical, frame};
    lap("prepare");

    progress("decompose", 0);
    decompose::DecomposeOptions cuts = options.decompose;
    cuts.max_parts = std::min(cuts.max_parts, options.max_parts);
    decompose::Partition partition = options.partition != nullptr ? *options.partition : decompose::decompose(mesh, cuts);
    if (partition.part_count > model::k_part_mask)
        throw mesh::RefusedMesh(
            {"E_LIMIT", "mesh",
             std::to_string(partition.part_count) + " parts; a model holds " + std::to_string(model::k_part_mask),
             "leave out loose pieces"});
    lap("decompose");

    progress("fit", 0);
    std::vector<PartWork> parts = fit_parts(context, partition, options);
    if (options.partition == nullptr) refine_parts(context, partition, parts, options);
    lap("fit");

    progress("map", 0);
    CentralOptions central = central_options(std::max(options.target_error, k_first_target));
    result.model = assemble(context, normalization, solid, solid_mesh, partition, parts, central, options);
    lap("map");
    // The target is met by measuring: finer cells where the first guess falls short.
    progress("measure", 0);
    model::Measured measured = measure(result.model, solid, options);
    const double max_bytes = k_max_refined * byte_budget(mesh.triangles.size(), options.target_error);
    const auto map_bytes = [](const std::vector<PartWork>& of) {
        double sum = 0;
        for (const PartWork& part : of) sum += static_cast<double>(part.map.map_bytes());
        return sum;
    };
    std::vector<PartWork> trial = parts;
    double fineness = 1;
    for (int attempt = 0; attempt < k_refinements && shortfall(measured, options) > 1; ++attempt) {
        if (map_bytes(parts) > max_bytes) break;
        progress("refine", static_cast<double>(attempt) / k_refinements);
        const double finer_by = std::clamp(1 / shortfall(measured, options), 0.5, 0.7);
        scale(central, finer_by);
        fineness *= finer_by;
        model::ModelData finer = assemble(context, normalization, solid, solid_mesh, partition, trial, central, options);
        const model::Measured better = measure(finer, solid, options);
        const double gain = shortfall(better, options) / shortfall(measured, options);
        if (gain >= 1) break;  // keep the better model
        result.model = std::move(finer);
        measured = better;
        parts = trial;
        result.report.fineness = fineness;
        if (gain > std::pow(finer_by, k_least_gain)) break;
    }
    if (solid_mesh) bake_locator(solid, partition.part_of_triangle, options.target_error, options.threads, result.model);
    lap("locate");
    bake_candidate_lists(solid, options.target_error, options.threads, result.model);
    lap("near");
    measured.q2_share = 0;
    for (const PartWork& part : parts) measured.q2_share += 100 * part.q2_share * part.area;
    double area = 0;
    for (const PartWork& part : parts) area += part.area;
    measured.q2_share /= area;
    result.model.measured = measured;
    result.model.mesh_hash = mesh::content_hash(input);
    result.report.target_met = measured.depth_p99 <= options.target_error;
    progress("measure", 1);
    lap("measure");

    for (const PartWork& part : parts)
        result.report.parts.push_back({part.fit.certificate, part.fit.volume, part.solid_volume, part.area, part.q2_share,
                                       part.fit.fallback, part.map.base, part.map.map_bytes()});
    result.report.partition = std::move(partition);
    return result;
}

}  // namespace sqmap::bake
