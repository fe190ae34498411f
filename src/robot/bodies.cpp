#include "robot/bodies.h"

#include "math/triangle_crossing.h"
#include "math/trigonometry.h"
#include "query/contacts/triangle_gap.h"
#include "sqmap/math/box.h"
#include "sqmap/mesh/error.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/robot/rewrite.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace sqmap::robot {
namespace {

constexpr std::uint32_t k_leaf_triangles = 2;

/// The solid between two regular polygons that are inscribed to the ends of a cylinder about z.
mesh::Mesh prism(double radius, double length, int sides)
{
    constexpr double k_turn = 6.283185307179586;
    mesh::Mesh out;
    for (int i = 0; i < sides; ++i) {
        const auto [sine, cosine] = sine_cosine(k_turn * i / sides);
        for (const double z : {-0.5 * length, 0.5 * length}) out.vertices.push_back({radius * cosine, radius * sine, z});
    }
    out.vertices.push_back({0, 0, -0.5 * length});
    out.vertices.push_back({0, 0, 0.5 * length});
    const auto n = static_cast<std::uint32_t>(sides);
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t a = 2 * i, b = 2 * ((i + 1) % n);
        out.triangles.push_back({a, b, b + 1});
        out.triangles.push_back({a, b + 1, a + 1});
        out.triangles.push_back({2 * n, b, a});
        out.triangles.push_back({2 * n + 1, a + 1, b + 1});
    }
    return out;
}

mesh::Mesh cuboid(Vec3d size)
{
    mesh::Mesh out;
    for (int i = 0; i < 8; ++i)
        out.vertices.push_back({(i & 1 ? 0.5 : -0.5) * size.x, (i & 2 ? 0.5 : -0.5) * size.y, (i & 4 ? 0.5 : -0.5) * size.z});
    for (const auto& [a, b, c, d] : std::initializer_list<std::array<std::uint32_t, 4>>{
             {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
        out.triangles.push_back({a, b, c});
        out.triangles.push_back({a, c, d});
    }
    return out;
}

void move_by(mesh::Mesh& mesh, const Pose& pose)
{
    for (Vec3d& v : mesh.vertices) v = apply(pose, v);
}

/// A vertex of each connected piece.
std::vector<Vec3d> vertex_of_pieces(const mesh::Mesh& mesh)
{
    std::vector<std::uint32_t> root(mesh.vertices.size());
    std::iota(root.begin(), root.end(), 0u);
    const auto find = [&](std::uint32_t v) {
        while (root[v] != v) v = root[v] = root[root[v]];
        return v;
    };
    for (const mesh::Triangle& t : mesh.triangles) {
        root[find(t[1])] = find(t[0]);
        root[find(t[2])] = find(t[0]);
    }
    std::vector<Vec3d> out;
    for (std::uint32_t v = 0; v < root.size(); ++v)
        if (root[v] == v) out.push_back(mesh.vertices[v]);
    return out;
}

}  // namespace

double distance_of(const Vec3d (&a)[3], const Vec3d (&b)[3]) noexcept
{
    const TriangleCorners of_a{a[0], a[1], a[2]}, of_b{b[0], b[1], b[2]};
    const double apart_sq = query::gap_of(of_a, of_b).distance_sq;  // of triangles that cut each other not that of their insides
    return apart_sq == 0 || crossing_of(of_a, of_b).meets() ? 0 : std::sqrt(apart_sq);
}

LinkShape::LinkShape(const Link& link, const std::filesystem::path& robot_file, const Packages& packages,
                     const MeshOptions& options)
{
    for (const CollisionMesh& m : link.meshes) {
        try {
            add_mesh(m, mesh_path(m.filename, robot_file, packages), options);
        } catch (const mesh::RefusedMesh& e) {
            add_problem(mesh::Words(e.what()) + " (" + e.diagnosis().cure + ")");
        }
    }
    for (const CollisionSolid& s : link.solids) add_solid(s);
    if (triangles_.empty()) return;
    branches_.emplace_back();
    split(0, 0, static_cast<std::uint32_t>(triangles_.size()));
}

void LinkShape::add_problem(const mesh::Words& words)
{
    if (!problem.empty()) problem += "; ";
    problem += words;
}

void LinkShape::add_mesh(const CollisionMesh& mesh, const std::filesystem::path& path, const MeshOptions& options)
{
    LinkMesh loaded = load_mesh(path, mesh, options);
    AdmittedMesh& admitted = loaded.admitted;
    verdict += (verdict.empty() ? "" : ", ") +
               std::string(admitted.refused() ? mesh::name_of(admitted.diagnosis.code) : mesh::name_of(admitted.admission));
    const bool is_whole = admitted.admission == mesh::Admission::Accept || admitted.admission == mesh::Admission::Repaired;
    if (!is_whole || !admitted.solid) {
        add_triangles(loaded.soup, 0);
        for (const mesh::Triangle& t : loaded.soup.triangles) samples_.push_back(loaded.soup.vertices[t[0]]);
    }
    if (!admitted.refused() && admitted.solid) {
        add_triangles(admitted.mesh, 0);
        add_filled(std::move(admitted.mesh), admitted.crossed);
    }
}

void LinkShape::add_solid(const CollisionSolid& solid)
{
    constexpr int k_sides = 96;
    if (solid.kind == CollisionSolid::Kind::Other)
        return add_problem("line " + std::to_string(solid.line) + ": <" + solid.element + "> is no shape of URDF");
    if (!(solid.size.x > 0 && solid.size.y > 0 && solid.size.z > 0))
        return add_problem("line " + std::to_string(solid.line) + ": the " + solid.element + " has a length that is not above 0");
    if (solid.kind == CollisionSolid::Kind::Sphere) {
        const Vec3d c = solid.pose.translation;
        triangles_.push_back({.corner = {c, c, c}, .grown = solid.size.x, .reach = solid.size.x});
        samples_.push_back(c);
        return;
    }
    const bool is_box = solid.kind == CollisionSolid::Kind::Box;
    mesh::Mesh made = is_box ? cuboid(solid.size) : prism(solid.size.x, solid.size.z, k_sides);
    move_by(made, solid.pose);
    constexpr double k_half_angle = 3.141592653589793 / k_sides;
    add_triangles(made, is_box ? 0 : solid.size.x * (1 - sine_cosine(k_half_angle).cosine));
    add_filled(std::move(made), {});
}

void LinkShape::add_triangles(const mesh::Mesh& mesh, double reach)
{
    for (const mesh::Triangle& t : mesh.triangles)
        triangles_.push_back(
            {.corner = {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]}, .grown = 0, .reach = reach});
}

void LinkShape::add_filled(mesh::Mesh mesh, std::span<const std::uint8_t> crossed)
{
    const std::vector<Vec3d> vertices = vertex_of_pieces(mesh);
    samples_.insert(samples_.end(), vertices.begin(), vertices.end());
    // The solid refers to its mesh, which therefore keeps its address.
    filled_.push_back({.mesh = std::make_unique<mesh::Mesh>(std::move(mesh))});
    filled_.back().solid = std::make_unique<mesh::Solid>(*filled_.back().mesh, crossed);
}

bool LinkShape::inside(Vec3d p) const
{
    return std::any_of(filled_.begin(), filled_.end(), [&](const Filled& f) { return f.solid->inside(p); });
}

void LinkShape::split(std::uint32_t branch, std::uint32_t first, std::uint32_t count)
{
    Box box;
    double reach = 0;
    for (std::uint32_t i = first; i < first + count; ++i) {
        for (const Vec3d& c : triangles_[i].corner) extend(box, c);
        reach = std::max(reach, std::max(triangles_[i].grown, triangles_[i].reach));
    }
    Branch made{.centre = 0.5 * (box.lo + box.hi), .first = first, .count = count};
    double radius = 0;
    for (std::uint32_t i = first; i < first + count; ++i)
        for (const Vec3d& c : triangles_[i].corner) radius = std::max(radius, norm(c - made.centre));
    // Rounding of the centre: a length below all that the sweep allows for.
    made.half = (0.5 + 1e-15) * (box.hi - box.lo) + Vec3d{reach, reach, reach};
    made.radius = radius * (1 + 1e-15) + reach;
    if (count > k_leaf_triangles) {
        int axis = 0;
        for (int k = 1; k < 3; ++k)
            if (made.half[k] > made.half[axis]) axis = k;
        const auto begin = triangles_.begin() + first;
        const auto middle = [axis](const GrownTriangle& t) { return t.corner[0][axis] + t.corner[1][axis] + t.corner[2][axis]; };
        // Equal middles are ordered by the corners, so that every standard library makes the same tree.
        const auto key = [&](const GrownTriangle& t) {
            const auto& [a, b, c] = t.corner;
            return std::array{middle(t), a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z};
        };
        std::nth_element(begin, begin + count / 2, begin + count, [&](const GrownTriangle& s, const GrownTriangle& t) {
            return middle(s) != middle(t) ? middle(s) < middle(t) : key(s) < key(t);
        });
        made.count = 0;
        made.first = static_cast<std::uint32_t>(branches_.size());
        branches_.resize(branches_.size() + 2);
        split(made.first, first, count / 2);
        split(made.first + 1, first + count / 2, count - count / 2);
    }
    branches_[branch] = made;
}

Placement::Placement(const LinkShape& a_shape, const LinkShape& b_shape, const Pose& b_in_a)
    : a(a_shape), b(b_shape), pose_(b_in_a)
{
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) size_.row[i][j] = std::abs(b_in_a.rotation.row[i][j]);
}

double Placement::lower_bound(const Branch& branch_a, const Branch& branch_b) const noexcept
{
    const Vec3d between = centre_in_a(branch_b) - branch_a.centre;
    const double balls = norm(between) - branch_a.radius - branch_b.radius;
    const Vec3d b_in_a = size_ * branch_b.half, a_in_b = transpose_mul(size_, branch_a.half);
    const Vec3d turned = transpose_mul(pose_.rotation, between);
    double apart_a = 0, apart_b = 0;
    for (int k = 0; k < 3; ++k) {
        const double gap_a = std::abs(between[k]) - branch_a.half[k] - b_in_a[k];
        const double gap_b = std::abs(turned[k]) - branch_b.half[k] - a_in_b[k];
        if (gap_a > 0) apart_a += gap_a * gap_a;
        if (gap_b > 0) apart_b += gap_b * gap_b;
    }
    return std::max(balls, std::sqrt(std::max(apart_a, apart_b)));
}

Placement::Gap Placement::gap(std::uint32_t triangle_a, std::uint32_t triangle_b) const noexcept
{
    const GrownTriangle& s = a.triangles()[triangle_a];
    const GrownTriangle& t = b.triangles()[triangle_b];
    const Vec3d moved[3] = {apply(pose_, t.corner[0]), apply(pose_, t.corner[1]), apply(pose_, t.corner[2])};
    const double apart = distance_of(s.corner, moved);
    return {apart - s.reach - t.reach, std::max(0., apart - s.grown - t.grown)};
}

double Placement::distance(double within, TrianglePair& nearest) const
{
    struct Entry {
        std::uint32_t a, b;
        double bound;
    };
    within = std::min(within, gap(nearest.a, nearest.b).upper);
    std::vector<Entry> stack{{0, 0, lower_bound(a.branches()[0], b.branches()[0])}};
    while (!stack.empty() && within > 0) {
        const Entry at = stack.back();
        stack.pop_back();
        if (at.bound >= within) continue;
        const Branch& s = a.branches()[at.a];
        const Branch& t = b.branches()[at.b];
        if (s.count > 0 && t.count > 0) {
            for (std::uint32_t i = s.first; i < s.first + s.count; ++i)
                for (std::uint32_t j = t.first; j < t.first + t.count; ++j)
                    if (const double apart = gap(i, j).upper; apart < within) {
                        within = apart;
                        nearest = {i, j};
                    }
            continue;
        }
        const bool splits_a = t.count > 0 || (s.count == 0 && s.radius >= t.radius);
        Entry next[2];
        for (std::uint32_t k = 0; k < 2; ++k) {
            next[k] = splits_a ? Entry{s.first + k, at.b, 0} : Entry{at.a, t.first + k, 0};
            next[k].bound = lower_bound(a.branches()[next[k].a], b.branches()[next[k].b]);
        }
        if (next[0].bound < next[1].bound) std::swap(next[0], next[1]);
        for (const Entry& e : next)
            if (e.bound < within) stack.push_back(e);
    }
    return within;
}

bool Placement::contained() const
{
    const auto b_samples = b.samples(), a_samples = a.samples();
    return std::any_of(b_samples.begin(), b_samples.end(), [&](Vec3d p) { return a.inside(apply(pose_, p)); }) ||
           std::any_of(a_samples.begin(), a_samples.end(), [&](Vec3d p) { return b.inside(apply(inverse(pose_), p)); });
}

}  // namespace sqmap::robot
