#include "sqmap/bake/rebake.h"

#include "assemble.h"
#include "bake/locator/change.h"
#include "bake/parts/refinement.h"
#include "candidate_lists.h"
#include "locator.h"
#include "sqmap/math/rotation.h"
#include "sqmap/mesh/error.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/parallel/for_each.h"
#include "stage_clock.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

namespace sqmap::bake {

namespace {

constexpr double k_max_growth = 1.03;  ///< of a superquadric's axes, until it is fitted again

void check(const model::ModelData& before, std::span<const Vec3d> vertices)
{
    if (before.header.solid == 0 || before.header.projection != static_cast<std::uint32_t>(model::Projection::Central) ||
        before.triangle_part.empty() || before.bricks.empty())
        throw mesh::InvalidInput("rebake needs a solid with central maps, the exact layer and a locator");
    if (3 * vertices.size() != before.vertices.size())
        throw mesh::InvalidInput("rebake needs a place for each of the model's " + std::to_string(before.vertices.size() / 3) +
                                 " vertices");
    for (const Vec3d& v : vertices)
        if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z)) throw mesh::InvalidInput("a vertex is not finite");
}

/// The mesh in model space, as before but for its vertices.
struct Meshes {
    mesh::Mesh before, now;

    Meshes(const model::ModelData& data, std::span<const Vec3d> vertices)
    {
        const model::ModelView view = data.view();
        for (std::size_t v = 0; v < vertices.size(); ++v) {
            before.vertices.push_back(cast<double>(model::vec3(data.vertices.data() + 3 * v)));
            now.vertices.push_back(cast<double>(model::to_model_space(data.header, vertices[v])));
        }
        for (std::uint32_t t = 0; t < data.triangle_part.size(); ++t)
            now.triangles.push_back(
                {model::triangle_vertex(view, t, 0), model::triangle_vertex(view, t, 1), model::triangle_vertex(view, t, 2)});
        before.triangles = now.triangles;
    }
};

/// Triangles with a corner that has moved.
std::vector<std::uint8_t> moved_triangles(const Meshes& meshes)
{
    std::vector<std::uint8_t> moved;
    for (const mesh::Triangle& corners : meshes.now.triangles)
        moved.push_back(std::any_of(corners.begin(), corners.end(),
                                    [&](std::uint32_t v) { return !(meshes.now.vertices[v] == meshes.before.vertices[v]); })
                            ? 1
                            : 0);
    return moved;
}

/// What crosses what. Among those that have not moved, nothing does if nothing did.
std::vector<std::uint8_t> crossed_triangles(const model::ModelData& data, const mesh::Mesh& mesh,
                                            std::span<const std::uint8_t> moved)
{
    constexpr auto k_all = std::numeric_limits<std::uint64_t>::max();
    const bool any = std::find(moved.begin(), moved.end(), 1) != moved.end();
    if (data.header.self_intersecting != 0) return mesh::find_self_intersections(mesh).crossed;
    return any ? mesh::find_self_intersections(mesh, k_all, moved).crossed : std::vector<std::uint8_t>(moved.size(), 0);
}

/// Those that have moved, and those of which another piece is boundary now.
std::vector<std::uint32_t> changed_triangles(const model::ModelData& data, const mesh::Solid& solid,
                                             std::span<const std::uint8_t> moved, std::span<const std::uint16_t> flags)
{
    std::vector<std::uint32_t> changed;
    for (std::uint32_t t = 0; t < moved.size(); ++t) {
        bool other = moved[t] != 0 || flags[t] != (data.triangle_part[t] & ~std::uint32_t{model::k_part_mask});
        if (!other && (flags[t] & model::k_crossed) != 0) {
            const auto [first, last] = std::equal_range(data.piece_triangle.begin(), data.piece_triangle.end(), t);
            const auto pieces = solid.visible(t);
            other = static_cast<std::size_t>(last - first) != pieces.size();
            const float* was = data.pieces.data() + 9 * (first - data.piece_triangle.begin());
            for (std::size_t i = 0; i < 3 * pieces.size() && !other; ++i)
                other = !(cast<float>(pieces[i / 3][i % 3]) == model::vec3(was + 3 * i));
        }
        if (other) changed.push_back(t);
    }
    return changed;
}

/// Whether a triangle may reach into a part's domain, by the nine directions.
bool reaches_domain(const model::Part& part, const std::array<Vec3d, 3>& triangle)
{
    Vec3d x[3];
    for (int k = 0; k < 3; ++k) {
        const Vec3d d = triangle[static_cast<std::size_t>(k)] - cast<double>(model::vec3(part.chart_centre));
        for (int i = 0; i < 3; ++i) x[k][i] = dot(cast<double>(model::vec3(part.chart_rows + 3 * i)), d);
    }
    for (std::size_t i = 0; i < 9; ++i) {
        const double a = domain_coordinate(x[0], i), b = domain_coordinate(x[1], i), c = domain_coordinate(x[2], i);
        const double lo = part.chart_lo[i], hi = part.chart_hi[i], slack = 1e-5 * (hi - lo);
        if (std::max({a, b, c}) < lo - slack || std::min({a, b, c}) > hi + slack) return false;
    }
    return true;
}

bool holds(const model::Part& part, std::span<const Vec3d> points)
{
    return std::all_of(points.begin(), points.end(), [&](Vec3d p) {
        const Vec3d d = p - cast<double>(model::vec3(part.chart_centre));
        Vec3d x;
        for (int i = 0; i < 3; ++i) x[i] = dot(cast<double>(model::vec3(part.chart_rows + 3 * i)), d);
        for (std::size_t i = 0; i < 9; ++i)
            if (!(domain_coordinate(x, i) >= part.chart_lo[i] && domain_coordinate(x, i) <= part.chart_hi[i])) return false;
        return true;
    });
}

ChartDomain domain_of(const model::Part& part)
{
    ChartDomain domain{};
    std::copy(std::begin(part.chart_lo), std::end(part.chart_lo), domain.lo);
    std::copy(std::begin(part.chart_hi), std::end(part.chart_hi), domain.hi);
    return domain;
}

template <class T>
std::uint32_t append_slice(std::vector<T>& to, const std::vector<T>& from, std::size_t first, std::size_t count)
{
    const auto at = static_cast<std::uint32_t>(to.size());
    to.insert(to.end(), from.begin() + static_cast<std::ptrdiff_t>(first),
              from.begin() + static_cast<std::ptrdiff_t>(first + count));
    return at;
}

/// A part as it was, its map's arrays with it.
model::Part kept_part(const model::ModelData& before, const model::Part& was, model::ModelData& data)
{
    model::Part p = was;
    p.first_sample = append_slice(data.samples, before.samples, was.first_sample, was.sample_count);
    append_slice(data.offsets, before.offsets, was.first_sample, was.sample_count);
    append_slice(data.smoothing, before.smoothing, was.first_sample, was.sample_count);
    p.first_cell = append_slice(data.cells, before.cells, was.first_cell, was.cell_count);
    p.first_block = append_slice(data.blocks, before.blocks, was.first_block, was.block_count);
    p.first_split = append_slice(data.splits, before.splits, std::size_t{was.first_split} * model::k_split_size,
                                 std::size_t{was.split_count} * model::k_split_size) /
                    model::k_split_size;
    p.first_special = append_slice(data.specials, before.specials, was.first_special, was.special_count);
    p.first_pool = append_slice(data.pool, before.pool, was.first_pool, was.pool_count);
    return p;
}

/// Larger by as much as its part sticks out, where that is little.
bool enlarge(const mesh::Mesh& mesh, PartWork& part)
{
    for (int attempt = 0; attempt < 3; ++attempt) {
        shape::Superquadricd& sq = part.fit.superquadric;
        const double room = 1 - fit::float_margin(sq);
        if (part.fit.certificate.largest_f <= room) return true;
        // F grows with the square of the distance from the centre.
        const double by = std::sqrt(part.fit.certificate.largest_f / room) * (1 + 1e-5);
        if (!(by <= k_max_growth)) return false;
        for (int k = 0; k < 3; ++k) sq.a[k] = static_cast<double>(static_cast<float>(sq.a[k] * by));
        sq.bend = static_cast<double>(static_cast<float>(sq.bend / by));
        part.fit.certificate = certify_part(mesh, part, sq);
    }
    return part.fit.certificate.largest_f <= 1 - fit::float_margin(part.fit.superquadric);
}

/// A turn about a point that comes to lie elsewhere.
struct Motion {
    Mat3d turn{};
    Vec3d from, to;

    Vec3d operator()(Vec3d p) const { return to + turn * (p - from); }
};

/// How a part's surface has moved, were it rigid: the least squares of its triangles' middles, by Gauss and Newton.
Motion rigid_motion(const Meshes& meshes, const PartWork& part)
{
    struct Middle {
        Vec3d before, now;
        double area;
    };
    std::vector<Middle> middles;
    Motion motion;
    double area = 0;
    for (const std::uint32_t t : part.triangles) {
        const Middle m{mesh::triangle_centroid(meshes.before, t), mesh::triangle_centroid(meshes.now, t),
                       mesh::triangle_area(meshes.now, t)};
        middles.push_back(m);
        motion.from += m.area * m.before;
        motion.to += m.area * m.now;
        area += m.area;
    }
    if (!(area > 0)) return {};
    motion.from = motion.from / area;
    motion.to = motion.to / area;
    for (int step = 0; step < 10; ++step) {
        // |d - w x r| is to be least, r turned already: sum (r r 1 - r r^T) w = sum r x d.
        Mat3d m{{{}, {}, {}}};
        Vec3d sum{};
        double trace = 0;
        for (const Middle& middle : middles) {
            const Vec3d r = motion.turn * (middle.before - motion.from);
            sum += middle.area * cross(r, middle.now - motion.to);
            for (int i = 0; i < 3; ++i) {
                m.row[i] += -(middle.area * r[i]) * r;
                m.row[i][i] += middle.area * norm_sq(r);
            }
            trace += 2 * middle.area * norm_sq(r);
        }
        for (int i = 0; i < 3; ++i) m.row[i][i] += 1e-9 * trace;  // what lies on a line may turn about it
        const Vec3d c[3] = {cross(m.row[1], m.row[2]), cross(m.row[2], m.row[0]), cross(m.row[0], m.row[1])};
        const double determinant = dot(m.row[0], c[0]);
        if (!(determinant > 0)) break;
        const Vec3d by = (sum.x * c[0] + sum.y * c[1] + sum.z * c[2]) / determinant;
        motion.turn = orthonormal(rotation_by(by) * motion.turn);
        if (norm(by) < 1e-9) break;
    }
    return motion;
}

shape::Superquadricd moved_by(const Motion& motion, shape::Superquadricd sq)
{
    const Mat3d rotation = sq.rotation * transpose(motion.turn);
    for (int i = 0; i < 3; ++i) sq.rotation.row[i] = cast<double>(cast<float>(rotation.row[i]));
    sq.translation = cast<double>(cast<float>(motion(sq.translation)));
    return sq;
}

/// Superquadric and centre of a part as they were, or the superquadric moved with its part, where they still serve. False: it has
/// to be fitted again.
bool keep(const SurfaceContext& context, const Meshes& meshes, const model::Part& was, PartWork& part)
{
    const mesh::Mesh& mesh = context.mesh;
    const mesh::Bvh& bvh = context.bvh;
    part.fit.superquadric = shape::cast<double>(model::superquadric_of(was));
    part.fit.certificate = certify_part(mesh, part, part.fit.superquadric);
    part.fit.fallback = (was.flags & model::k_fit_fallback) != 0;
    part.centre = model::vec3(was.chart_centre);
    if (!enlarge(mesh, part)) {
        const Motion motion = rigid_motion(meshes, part);
        part.fit.superquadric = moved_by(motion, shape::cast<double>(model::superquadric_of(was)));
        part.fit.certificate = certify_part(mesh, part, part.fit.superquadric);
        if (!enlarge(mesh, part)) return false;
        part.centre = cast<float>(motion(cast<double>(part.centre)));
    }
    part.fit.certificate.bounding = true;
    // A centre that the surface has come near or passed would see it badly.
    const Vec3d centre = cast<double>(part.centre);
    const shape::Superquadricd& sq = part.fit.superquadric;
    const double floor = 0.02 * std::min({sq.a.x, sq.a.y, sq.a.z});
    if (bvh.winding_number(centre) != was.centre_winding || bvh.closest_point(centre, floor).distance < floor)
        part.centre = choose_centre(context, sq, part.triangles);
    return true;
}

/// In the domain that it had, where that still serves.
void make_map(const SurfaceContext& context, const KnownMap& known, bool kept, const CentralOptions& central, PartWork& part)
{
    const model::Part& was = known.part;
    const shape::Superquadricd& sq = part.fit.superquadric;
    const std::vector<Vec3d> corners = corners_of(context.mesh, part);
    const shape::Superquadricd before = shape::cast<double>(model::superquadric_of(was));
    const bool stays = kept && sq.a == before.a && sq.rotation == before.rotation &&
                       part.centre == model::vec3(was.chart_centre) && holds(was, corners);
    CentralOptions same_base = central;
    same_base.least_base = same_base.max_base = was.base;
    part.map = bake_central_map(context, sq, part.centre, stays ? domain_of(was) : chart_domain(sq, part.centre, corners),
                                part.triangles, same_base, stays ? &known : nullptr);
}

}  // namespace

RebakeResult rebake(const model::ModelData& before, std::span<const Vec3d> vertices, const RebakeOptions& options)
{
    check(before, vertices);
    RebakeResult result;
    StageClock clock;
    const auto lap = [&](const char* stage) { clock.lap(stage, result.report.seconds); };

    const Meshes meshes(before, vertices);
    const mesh::Mesh& mesh = meshes.now;
    const std::vector<std::uint8_t> moved = moved_triangles(meshes);
    const mesh::Solid solid(mesh, crossed_triangles(before, mesh, moved));
    std::vector<std::uint16_t> flags;
    for (const mesh::Boundary b : solid.boundary()) flags.push_back(surface_flag(b));
    decompose::Partition partition;
    partition.part_count = static_cast<std::uint32_t>(before.parts.size());
    for (const std::uint16_t p : before.triangle_part) partition.part_of_triangle.push_back(p & model::k_part_mask);
    const std::vector<std::uint32_t> changed = changed_triangles(before, solid, moved, flags);
    result.report.changed_triangles = changed.size();
    const double r_max = mesh::largest_vertex_distance(mesh);
    lap("prepare");

    // Charts that see a changed triangle where it was or where it is, or whose centre changed sides.
    mesh::Mesh both;
    std::vector<std::uint8_t> remade(before.parts.size(), 0);
    for (const mesh::Mesh* m : {&meshes.before, &meshes.now})
        for (const std::uint32_t t : changed) {
            const auto first = static_cast<std::uint32_t>(both.vertices.size());
            std::array<Vec3d, 3> corners;
            for (std::size_t k = 0; k < 3; ++k) both.vertices.push_back(corners[k] = m->vertices[m->triangles[t][k]]);
            both.triangles.push_back({first, first + 1, first + 2});
            remade[partition.part_of_triangle[t]] = 1;
            for (std::size_t i = 0; i < remade.size(); ++i)
                if (remade[i] == 0 && reaches_domain(before.parts[i], corners)) remade[i] = 1;
        }
    for (std::size_t i = 0; i < remade.size() && !changed.empty(); ++i)
        if (remade[i] == 0 &&
            solid.bvh().winding_number(cast<double>(model::vec3(before.parts[i].chart_centre))) != before.parts[i].centre_winding)
            remade[i] = 1;

    BakeOptions bake_options;
    bake_options.fit = options.fit;
    mesh::Mesh canonical;  // looked at by fits alone
    SurfaceContext context{mesh, solid.bvh(), flags, r_max, canonical, {}};
    CentralOptions central = central_options(std::max(options.target_error, k_first_target));
    scale(central, options.fineness);
    std::vector<PartWork> parts(before.parts.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) parts[partition.part_of_triangle[t]].triangles.push_back(t);
    std::vector<std::vector<CapTriangle>> caps;
    if (!changed.empty()) caps = cap_parts(mesh, partition);
    for (std::uint32_t i = 0; i < parts.size(); ++i)
        if (remade[i] != 0) result.report.remade.push_back(i);
    std::vector<std::uint8_t> kept(parts.size(), 1);
    const auto each_remade = [&](auto&& work) {
        parallel::for_each(result.report.remade.size(), options.threads, [&](std::size_t k) { work(result.report.remade[k]); });
    };
    each_remade([&](std::uint32_t i) {
        parts[i].caps = std::move(caps[i]);
        kept[i] = keep(context, meshes, before.parts[i], parts[i]) ? 1 : 0;
    });
    if (std::find(kept.begin(), kept.end(), 0) != kept.end()) {
        context.frame = mesh::principal_frame(mesh);
        canonical = canonical_view(mesh, context.frame);
    }
    each_remade([&](std::uint32_t i) {
        if (kept[i] == 0) fit_and_centre(context, parts[i], bake_options);
        make_map(context, {before, before.parts[i], meshes.before, changed}, kept[i] != 0, central, parts[i]);
    });
    lap("parts");

    model::ModelData& data = result.model;
    data.header = before.header;
    data.header.r_max = r_max;
    data.header.self_intersecting = solid.self_intersecting() ? 1 : 0;
    if (!changed.empty()) bounding_sphere(mesh.vertices, data.header.sphere);
    for (std::uint32_t i = 0; i < parts.size(); ++i) {
        const model::Part& was = before.parts[i];
        data.parts.push_back(remade[i] != 0 ? make_part(mesh, parts[i], data) : kept_part(before, was, data));
        const model::Part& p = data.parts.back();
        result.report.certificates.push_back(
            {static_cast<double>(p.largest_f), static_cast<double>(p.tolerance), p.largest_f <= 1});
        if (remade[i] != 0) data.header.quantisation = std::max(data.header.quantisation, parts[i].map.quantisation);
        if (kept[i] == 0) result.report.refitted.push_back(i);
    }
    append_exact(solid, partition.part_of_triangle, flags, data);
    data.locator = before.locator;
    data.bricks = before.bricks;
    data.places = before.places;
    data.part_lists = before.part_lists;
    data.planes = before.planes;
    data.locator_seeds = before.locator_seeds;
    data.rises = before.rises;
    data.made_by = before.made_by;
    data.source = before.source;
    data.options = before.options;
    lap("pack");

    const Change change(std::move(both), before.parts, std::move(remade));
    const LocatorUpdate update =
        update_locator(solid, partition.part_of_triangle, options.target_error, change, options.threads, data);
    lap("locate");
    update_candidate_lists(solid, before.view(), update, options.target_error, options.threads, data);
    lap("near");
    data.mesh_hash = mesh::content_hash({{vertices.begin(), vertices.end()}, mesh.triangles});
    return result;
}

}  // namespace sqmap::bake
