#include "sqmap/bake/rebake.h"

#include "assemble.h"
#include "bake/central/central_map.h"
#include "bake/central/central_options.h"
#include "bake/distance/distance.h"
#include "bake/exact/candidate_lists.h"
#include "bake/locator/change.h"
#include "bake/locator/locator.h"
#include "bake/locator/made_up.h"
#include "bake/parts/fit.h"
#include "bake/parts/part.h"
#include "model/flags.h"
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
#include <optional>
#include <string>
#include <utility>

namespace sqmap::bake {

namespace {

constexpr double k_max_growth = 1.03;  ///< of a superquadric's axes, until it is fitted again

void check(const model::ModelData& before, std::span<const Vec3d> vertices)
{
    if (before.header.projection != 0)
        throw mesh::InvalidInput("rebake needs central maps, and this is a paper model: bake the mesh again");
    if (before.header.solid == 0 || before.samples.empty() || before.triangle_part.empty() || before.bricks.empty())
        throw mesh::InvalidInput("rebake needs a solid with central maps, the exact layer and a locator");
    if (3 * vertices.size() != before.vertices.size())
        throw mesh::InvalidInput("rebake needs a position for each of the model's " + std::to_string(before.vertices.size() / 3) +
                                 " vertices");
    for (const Vec3d& v : vertices)
        if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z)) throw mesh::InvalidInput("a vertex is not finite");
}

/// The mesh in model space, as before but for its vertices.
struct Meshes {
    mesh::Mesh before, now;

    Meshes(const model::ModelData& data, std::span<const Vec3d> vertices)
    {
        before = now = baked_mesh(data.view());
        for (std::size_t v = 0; v < vertices.size(); ++v)
            now.vertices[v] = cast<double>(model::to_model_space(data.header, vertices[v]));
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

/// Flags the triangles that cross another one. Triangles that have not moved cross each other only if they did before, so for a
/// mesh that had no crossing it suffices to test the moved ones.
std::vector<std::uint8_t> crossed_triangles(const model::ModelData& data, const mesh::Mesh& mesh,
                                            std::span<const std::uint8_t> moved)
{
    constexpr auto k_all = std::numeric_limits<std::uint64_t>::max();
    const bool any = std::find(moved.begin(), moved.end(), 1) != moved.end();
    if (data.header.self_intersecting != 0) return mesh::find_self_intersections(mesh).crossed;
    return any ? mesh::find_self_intersections(mesh, k_all, moved).crossed : std::vector<std::uint8_t>(moved.size(), 0);
}

/// Lists the triangles that have moved, and the triangles of which another piece bounds the solid now.
std::vector<std::uint32_t> changed_triangles(const model::ModelData& data, const mesh::Solid& solid,
                                             std::span<const std::uint8_t> moved)
{
    std::vector<std::uint32_t> changed;
    for (std::uint32_t t = 0; t < moved.size(); ++t) {
        const std::uint16_t flag = surface_flag(solid.boundary()[t]);
        bool other = moved[t] != 0 || flag != model::flags_of(data.triangle_part[t]);
        if (!other && model::is_crossed(flag)) {
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

/// False where one of the nine directions proves that a triangle stays outside a part's domain.
bool reaches_domain(const model::Part& part, const std::array<Vec3d, 3>& triangle)
{
    Vec3d x[3];
    for (int k = 0; k < 3; ++k) {
        const Vec3d d = triangle[static_cast<std::size_t>(k)] - cast<double>(model::vec3(part.chart_centre));
        for (int i = 0; i < 3; ++i) x[k][i] = dot(cast<double>(model::vec3(part.chart_rows + 3 * i)), d);
    }
    for (std::size_t i = 0; i < 9; ++i) {
        const double a = model::domain_coordinate(x[0], i), b = model::domain_coordinate(x[1], i),
                     c = model::domain_coordinate(x[2], i);
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
            if (!(model::domain_coordinate(x, i) >= part.chart_lo[i] && model::domain_coordinate(x, i) <= part.chart_hi[i]))
                return false;
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

/// Larger by as much as its part sticks out, where that is little.
bool enlarge(const mesh::Mesh& mesh, FittedPart& part)
{
    for (int attempt = 0; attempt < 3; ++attempt) {
        shape::Superquadricd& sq = part.fit.superquadric;
        const double limit = 1 - fit::float_margin(sq);
        if (part.fit.certificate.largest_f <= limit) return true;
        // F grows with the square of the distance from the centre.
        const double by = std::sqrt(part.fit.certificate.largest_f / limit) * (1 + 1e-5);
        if (!(by <= k_max_growth)) return false;
        for (int k = 0; k < 3; ++k) sq.a[k] = static_cast<double>(static_cast<float>(sq.a[k] * by));
        sq.bend = static_cast<double>(static_cast<float>(sq.bend / by));
        part.fit.certificate = certify_patch(mesh, part.patch, sq);
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
Motion rigid_motion(const Meshes& meshes, const Patch& patch)
{
    struct Middle {
        Vec3d before, now;
        double area;
    };
    std::vector<Middle> middles;
    Motion motion;
    double area = 0;
    for (const std::uint32_t t : patch.triangles) {
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

/// The mesh before and after, and what of it has changed.
struct Situation {
    const model::ModelData& before;
    const Meshes& meshes;
    const mesh::Solid& solid;            ///< after the change
    std::vector<std::uint32_t> changed;  ///< triangles
    std::vector<std::uint32_t> part_of_triangle;
};

/// The part of the model that a change reaches.
struct Reach {
    mesh::Mesh both;                   ///< changed triangles, where they were and where they are
    std::vector<std::uint8_t> remade;  ///< #parts: charts that see one of these, or whose centre changed sides
};

Reach reach_of(const Situation& situation)
{
    const std::vector<model::Part>& parts = situation.before.parts;
    Reach reach;
    reach.remade.assign(parts.size(), 0);
    for (const mesh::Mesh* m : {&situation.meshes.before, &situation.meshes.now})
        for (const std::uint32_t t : situation.changed) {
            const auto first = static_cast<std::uint32_t>(reach.both.vertices.size());
            std::array<Vec3d, 3> corners;
            for (std::size_t k = 0; k < 3; ++k) reach.both.vertices.push_back(corners[k] = m->vertices[m->triangles[t][k]]);
            reach.both.triangles.push_back({first, first + 1, first + 2});
            reach.remade[situation.part_of_triangle[t]] = 1;
            for (std::size_t i = 0; i < parts.size(); ++i)
                if (reach.remade[i] == 0 && reaches_domain(parts[i], corners)) reach.remade[i] = 1;
        }
    for (std::size_t i = 0; i < parts.size() && !situation.changed.empty(); ++i)
        if (reach.remade[i] == 0 &&
            situation.solid.bvh().winding_number(cast<double>(model::vec3(parts[i].chart_centre))) != parts[i].centre_winding)
            reach.remade[i] = 1;
    return reach;
}

/// Superquadric and centre of a part as they were, or the superquadric moved with its part, where they still serve. Nothing: it
/// has to be fitted again.
std::optional<FittedPart> kept_fit(const Situation& situation, const model::Part& was, const Patch& patch)
{
    const mesh::Mesh& mesh = situation.solid.mesh();
    const mesh::Bvh& bvh = situation.solid.bvh();
    FittedPart part{patch, {}, model::vec3(was.chart_centre)};
    part.fit.superquadric = shape::cast<double>(model::superquadric_of(was));
    part.fit.certificate = certify_patch(mesh, patch, part.fit.superquadric);
    part.fit.fallback = model::is_fallback(was);
    if (!enlarge(mesh, part)) {
        const Motion motion = rigid_motion(situation.meshes, patch);
        part.fit.superquadric = moved_by(motion, shape::cast<double>(model::superquadric_of(was)));
        part.fit.certificate = certify_patch(mesh, patch, part.fit.superquadric);
        if (!enlarge(mesh, part)) return std::nullopt;
        part.centre = cast<float>(motion(cast<double>(part.centre)));
    }
    part.fit.certificate.bounding = true;
    // A centre that the surface has come near or passed would see it badly.
    const Vec3d centre = cast<double>(part.centre);
    const shape::Superquadricd& sq = part.fit.superquadric;
    const double floor = 0.02 * std::min({sq.a.x, sq.a.y, sq.a.z});
    if (bvh.winding_number(centre) != was.centre_winding || bvh.closest_point(centre, floor).distance < floor)
        part.centre = choose_centre(situation.solid, sq, patch.triangles);
    return part;
}

/// A part whose map is new.
struct RemadePart {
    std::uint32_t number = 0;
    FittedPart fitted;
    bool refitted = false;
    CentralMapData map;
};

/// In the domain that it had, where that still serves.
CentralMapData remade_map(const Situation& situation, const RemadePart& part, CentralOptions central)
{
    const model::Part& was = situation.before.parts[part.number];
    const FittedPart& fitted = part.fitted;
    const shape::Superquadricd& sq = fitted.fit.superquadric;
    const std::vector<Vec3d> corners = corners_of(situation.solid.mesh(), fitted.patch);
    const shape::Superquadricd before = shape::cast<double>(model::superquadric_of(was));
    const bool stays = !part.refitted && sq.a == before.a && sq.rotation == before.rotation &&
                       fitted.centre == model::vec3(was.chart_centre) && holds(was, corners);
    central.least_base = central.max_base = was.base;
    const KnownMap known{situation.before, was, situation.meshes.before, situation.changed};
    const ChartDomain domain = stays ? domain_of(was) : chart_domain(sq, fitted.centre, corners);
    return bake_central_map(situation.solid, {sq, fitted.centre, domain, fitted.patch.triangles}, central,
                            stays ? &known : nullptr);
}

/// Fits and maps of the parts that a change reaches.
std::vector<RemadePart> remake(const Situation& situation, const Reach& reach, const RebakeOptions& options)
{
    std::vector<RemadePart> parts;
    for (std::uint32_t i = 0; i < reach.remade.size(); ++i)
        if (reach.remade[i] != 0) parts.emplace_back().number = i;
    if (parts.empty()) return parts;
    const mesh::Mesh& mesh = situation.solid.mesh();
    decompose::Partition partition;
    partition.part_count = static_cast<std::uint32_t>(reach.remade.size());
    partition.part_of_triangle = situation.part_of_triangle;
    std::vector<Patch> patches = patches_of(mesh, partition);
    parallel::for_each(parts.size(), options.threads, [&](std::size_t k) {
        RemadePart& part = parts[k];
        std::optional<FittedPart> kept = kept_fit(situation, situation.before.parts[part.number], patches[part.number]);
        part.refitted = !kept;
        if (kept) part.fitted = std::move(*kept);
    });
    CanonicalMesh canonical;  // only fits look at it
    if (std::any_of(parts.begin(), parts.end(), [](const RemadePart& part) { return part.refitted; }))
        canonical = canonical_mesh(mesh);
    CentralOptions central = central_options(options.target_error, mesh::largest_vertex_distance(mesh));
    scale(central, options.fineness);
    parallel::for_each(parts.size(), options.threads, [&](std::size_t k) {
        RemadePart& part = parts[k];
        if (part.refitted) part.fitted = fit_patch(situation.solid, canonical, std::move(patches[part.number]), options.fit);
        part.map = remade_map(situation, part, central);
    });
    return parts;
}

/// The model but for its locator and candidate lists, which are those of before.
model::ModelData assemble_again(const Situation& situation, const std::vector<RemadePart>& remade)
{
    const model::ModelData& before = situation.before;
    Assembly assembly{situation.solid, situation.part_of_triangle, {}, &before, true};
    for (const model::Part& part : before.parts) assembly.parts.push_back({nullptr, nullptr, &part});
    for (const RemadePart& part : remade) assembly.parts[part.number] = {&part.fitted, &part.map, nullptr};
    model::ModelData data = assemble(before.header, assembly);
    static_cast<model::LocatorArrays<model::ArrayData>&>(data) = before;
    data.rises = before.rises;
    data.made_by = before.made_by;
    data.source = before.source;
    data.options = before.options;
    data.cure = before.cure;
    return data;
}

}  // namespace

RebakeResult rebake(const model::ModelData& before, std::span<const Vec3d> vertices, const RebakeOptions& options)
{
    check(before, vertices);
    RebakeResult result;
    RebakeReport& report = result.report;
    StageClock clock;
    const auto lap = [&](const char* stage) { clock.lap(stage, report.seconds); };

    const Meshes meshes(before, vertices);
    const std::vector<std::uint8_t> moved = moved_triangles(meshes);
    const mesh::Solid solid(meshes.now, crossed_triangles(before, meshes.now, moved));
    Situation situation{before, meshes, solid, changed_triangles(before, solid, moved), {}};
    for (const std::uint16_t p : before.triangle_part) situation.part_of_triangle.push_back(model::part_of(p));
    report.changed_triangles = situation.changed.size();
    lap("prepare");

    Reach reach = reach_of(situation);
    const std::vector<RemadePart> remade = remake(situation, reach, options);
    lap("parts");
    result.model = assemble_again(situation, remade);
    for (const RemadePart& part : remade) {
        report.remade.push_back(part.number);
        if (part.refitted) report.refitted.push_back(part.number);
    }
    for (const model::Part& p : result.model.parts)
        report.certificates.push_back({static_cast<double>(p.largest_f), static_cast<double>(p.tolerance), p.largest_f <= 1});
    lap("pack");

    const Change change(std::move(reach.both), before.parts, std::move(reach.remade));
    const LocatorOptions locator{options.target_error, options.threads};
    const LocatorUpdate update = update_locator({solid, situation.part_of_triangle}, locator, change, result.model);
    lap("locate");
    update_candidate_lists(solid, {before.view(), update}, locator, result.model);
    std::vector<std::uint8_t> made_up;
    for (const std::uint16_t word : before.triangle_part) made_up.push_back(model::is_made_up(word) ? 1 : 0);
    mark_made_up(meshes.now, made_up, result.model);
    lap("near");
    const double band = 100 * static_cast<double>(before.distance.header.band) / before.header.r_max;
    bake_distance(solid, {band, options.threads}, result.model);
    lap("distance");
    result.model.mesh_hash = mesh::content_hash({{vertices.begin(), vertices.end()}, meshes.now.triangles});
    return result;
}

}  // namespace sqmap::bake
