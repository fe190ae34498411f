// Baking a model again after its mesh has moved: the pipeline's steps for the parts that the change reaches.
#include "sqmap/bake/rebake.h"

#include "assemble.h"
#include "bake/locator/change.h"
#include "bake/parts/fit.h"
#include "bake/parts/part.h"
#include "model/flags.h"
#include "parallel/for_each.h"
#include "pipeline.h"
#include "sqmap/math/rotation.h"
#include "sqmap/mesh/error.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/model/named_parts.h"

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

/// True where a part keeps the chart that it had.
bool keeps_chart(const Situation& situation, const model::Part& was, const FittedPart& fitted)
{
    const shape::Superquadricd &sq = fitted.fit.superquadric, before = shape::cast<double>(model::superquadric_of(was));
    return sq.a == before.a && sq.rotation == before.rotation && fitted.centre == model::vec3(was.chart_centre) &&
           holds(was, corners_of(situation.solid.mesh(), fitted.patch));
}

/// The pipeline for a mesh that has moved: parts that the change does not reach are taken over, and so are the locator's cells
/// and the candidate lists.
class Rebake final : public Pipeline {
public:
    Rebake(const model::ModelData& before, std::span<const Vec3d> vertices, const RebakeOptions& options)
        : Pipeline({options.target_error, options.threads}), before_(before), vertices_(vertices), options_(options)
    {
    }
    [[nodiscard]] RebakeResult run()
    {
        RebakeResult result{run_steps(), std::move(report_)};
        result.report.seconds = std::move(seconds_);
        return result;
    }

private:
    void validate() override
    {
        check(before_, vertices_);
        meshes_.emplace(before_, vertices_);
        const std::vector<std::uint8_t> moved = moved_triangles(*meshes_);
        set_mesh(meshes_->now, crossed_triangles(before_, meshes_->now, moved));
        mesh_hash_ = mesh::content_hash({{vertices_.begin(), vertices_.end()}, mesh_.triangles});
        band_ = 100 * static_cast<double>(before_.distance.header.band) / before_.header.r_max;
        if (model::has_input(before_.view())) input_vertices_.assign(vertices_.begin(), vertices_.end());
        source_ = {before_.input.source_triangle, before_.input.source_vertex};
        for (const std::uint16_t word : before_.triangle_part) made_up_.push_back(model::is_made_up(word) ? 1 : 0);
        situation_.emplace(Situation{before_, *meshes_, *solid_, changed_triangles(before_, *solid_, moved), {}});
        for (const std::uint16_t p : before_.triangle_part) situation_->part_of_triangle.push_back(model::part_of(p));
        report_.changed_triangles = situation_->changed.size();
    }

    /// Superquadrics of the parts that the change reaches.
    void parts() override
    {
        reach_ = reach_of(*situation_);
        for (std::uint32_t i = 0; i < reach_.remade.size(); ++i)
            if (reach_.remade[i] != 0) report_.remade.push_back(i);
        if (!report_.remade.empty()) fit_remade();
    }
    void fit_remade()
    {
        decompose::Partition partition;
        partition.part_count = static_cast<std::uint32_t>(reach_.remade.size());
        partition.part_of_triangle = situation_->part_of_triangle;
        std::vector<Patch> patches = patches_of(mesh_, partition);
        std::vector<std::optional<FittedPart>> kept(report_.remade.size());
        parallel::for_each(kept.size(), options_.threads, [&](std::size_t k) {
            kept[k] = kept_fit(*situation_, before_.parts[report_.remade[k]], patches[report_.remade[k]]);
        });
        for (std::size_t k = 0; k < kept.size(); ++k)
            if (!kept[k]) report_.refitted.push_back(report_.remade[k]);
        CanonicalMesh canonical;  // only fits look at it
        if (!report_.refitted.empty()) canonical = canonical_mesh(mesh_);
        fitted_.resize(kept.size());
        parallel::for_each(kept.size(), options_.threads, [&](std::size_t k) {
            fitted_[k] = kept[k] ? std::move(*kept[k])
                                 : fit_patch(*solid_, canonical, std::move(patches[report_.remade[k]]), options_.fit);
        });
    }

    void polytopes() override
    {
        if (before_.polytope_ends.empty()) return;  // a model of before there were polytopes stays without
        parallel::for_each(fitted_.size(), options_.threads,
                           [&](std::size_t k) { fitted_[k].polytope = fit_polytope(mesh_, fitted_[k], before_.parts.size()); });
    }

    /// Maps of these parts; the others keep theirs.
    void maps() override
    {
        CentralOptions central = central_options(options_.target_error, mesh::largest_vertex_distance(mesh_));
        scale(central, options_.fineness);
        std::vector<MapSource> sources;
        for (std::size_t k = 0; k < fitted_.size(); ++k) {
            const model::Part& was = before_.parts[report_.remade[k]];
            central.least_base = central.max_base = was.base;
            MapSource& source = sources.emplace_back(MapSource{fitted_[k], central});
            if (keeps_chart(*situation_, was, fitted_[k]))
                source.known.emplace(KnownMap{was, model::arrays_of(before_, was), meshes_->before, situation_->changed});
        }
        const std::vector<CentralMapData> maps = bake_central_maps(*solid_, sources, options_.threads);
        Assembly assembly{*solid_, situation_->part_of_triangle, {}, &before_, true};
        for (const model::Part& part : before_.parts) assembly.parts.push_back({nullptr, nullptr, &part});
        for (std::size_t k = 0; k < maps.size(); ++k) assembly.parts[report_.remade[k]] = {&fitted_[k], &maps[k], nullptr};
        model_ = assemble(before_.header, assembly);
        model_.made_by = before_.made_by;
        model_.source = before_.source;
        model_.options = before_.options;
        model_.cure = before_.cure;
        for (const std::uint32_t part : report_.remade) model::copy_group(before_.parts[part], model_.parts[part]);
        for (const model::Part& p : model_.parts)
            report_.certificates.push_back(
                {static_cast<double>(p.largest_f), static_cast<double>(p.tolerance), p.largest_f <= 1});
    }

    void locator() override
    {
        static_cast<model::LocatorArrays<model::ArrayData>&>(model_) = before_;
        model_.rises = before_.rises;
        const Change change(std::move(reach_.both), before_.parts, std::move(reach_.remade));
        kept_lists_ = {before_.view(), update_locator({*solid_, situation_->part_of_triangle}, locator_, change, model_)};
    }

    std::vector<Patch> patches() const override
    {
        decompose::Partition partition;
        partition.part_count = static_cast<std::uint32_t>(before_.parts.size());
        partition.part_of_triangle = situation_->part_of_triangle;
        return patches_of(mesh_, partition);
    }

    const model::ModelData& before_;
    std::span<const Vec3d> vertices_;
    const RebakeOptions& options_;
    RebakeReport report_;
    std::optional<Meshes> meshes_;
    std::optional<Situation> situation_;
    Reach reach_;
    std::vector<FittedPart> fitted_;  ///< of report_.remade
};

}  // namespace

RebakeResult rebake(const model::ModelData& before, std::span<const Vec3d> vertices, const RebakeOptions& options)
{
    return Rebake(before, vertices, options).run();
}

}  // namespace sqmap::bake
