// Generated meshes. Superquadric deformations: Solina and Bajcsy, "Recovery of parametric models from range images",
// 1990 (the paper's eq. 2). Subdivision: Loop 1987.
#include "sqmap/mesh/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace sqmap::mesh {
namespace {

using std::numbers::pi;

void require(bool holds, const char* what)
{
    if (!holds) throw std::invalid_argument(what);
}

using Edge = std::pair<std::uint32_t, std::uint32_t>;

Edge edge_of(std::uint32_t u, std::uint32_t v) { return u < v ? Edge{u, v} : Edge{v, u}; }

/// Four triangles for each, with a new vertex on every edge numbered after the old ones in the order of first use.
/// edges: the edge of each new vertex, in that order.
std::vector<Triangle> split_in_four(const Mesh& mesh, std::vector<Edge>& edges)
{
    std::map<Edge, std::uint32_t> middle;
    const auto middle_of = [&](std::uint32_t u, std::uint32_t v) {
        const auto [it, is_new] =
            middle.try_emplace(edge_of(u, v), static_cast<std::uint32_t>(mesh.vertices.size() + edges.size()));
        if (is_new) edges.push_back(it->first);
        return it->second;
    };
    std::vector<Triangle> out;
    out.reserve(4 * mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles) {
        const std::uint32_t ab = middle_of(a, b), bc = middle_of(b, c), ca = middle_of(c, a);
        out.insert(out.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    return out;
}

/// Splits a quad (counter-clockwise) along its shorter diagonal.
void add_quad(Mesh& mesh, std::array<std::uint32_t, 4> q)
{
    const double first = norm_sq(mesh.vertices[q[0]] - mesh.vertices[q[2]]);
    const double second = norm_sq(mesh.vertices[q[1]] - mesh.vertices[q[3]]);
    if (first <= second)
        mesh.triangles.insert(mesh.triangles.end(), {{q[0], q[1], q[2]}, {q[0], q[2], q[3]}});
    else
        mesh.triangles.insert(mesh.triangles.end(), {{q[0], q[1], q[3]}, {q[1], q[2], q[3]}});
}

/// Surface of a box, gridded by the given coordinates along each axis, every vertex moved by `moved`.
template <class Move>
Mesh gridded_box(const std::array<std::vector<double>, 3>& grid, Move moved)
{
    Mesh mesh;
    std::map<std::array<std::size_t, 3>, std::uint32_t> index;
    const auto vertex = [&](std::array<std::size_t, 3> ijk) {
        const auto [it, is_new] = index.try_emplace(ijk, static_cast<std::uint32_t>(mesh.vertices.size()));
        if (is_new) mesh.vertices.push_back(moved(Vec3d{grid[0][ijk[0]], grid[1][ijk[1]], grid[2][ijk[2]]}));
        return it->second;
    };
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        for (const bool upper : {false, true})
            for (std::size_t i = 0; i + 1 < grid[u].size(); ++i)
                for (std::size_t j = 0; j + 1 < grid[v].size(); ++j) {
                    const auto corner = [&](std::size_t du, std::size_t dv) {
                        std::array<std::size_t, 3> ijk{};
                        ijk[axis] = upper ? grid[axis].size() - 1 : 0;
                        ijk[u] = i + du;
                        ijk[v] = j + dv;
                        return vertex(ijk);
                    };
                    if (upper)
                        add_quad(mesh, {corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)});
                    else
                        add_quad(mesh, {corner(0, 0), corner(0, 1), corner(1, 1), corner(1, 0)});
                }
    }
    return canonicalized(mesh);
}

/// n intervals from lo to hi, both ends exact, symmetric about the middle where lo = -hi.
std::vector<double> even(double lo, double hi, int n)
{
    std::vector<double> out;
    for (int i = 0; i <= n; ++i) out.push_back((lo * (n - i) + hi * i) / n);
    return out;
}

struct ProfilePoint {
    double r, z;
};

/// Turns a profile (from the lower pole to the upper, r > 0 between them) about z; the poles are closed by fans.
Mesh revolved(const std::vector<ProfilePoint>& profile, double bottom, double top, int segments)
{
    Mesh mesh;
    const auto n = static_cast<std::uint32_t>(segments);
    for (const ProfilePoint& p : profile)
        for (std::uint32_t k = 0; k < n; ++k) {
            const double angle = 2 * pi * k / n;
            mesh.vertices.push_back({p.r * std::cos(angle), p.r * std::sin(angle), p.z});
        }
    const auto south = static_cast<std::uint32_t>(mesh.vertices.size());
    const std::uint32_t north = south + 1;
    mesh.vertices.insert(mesh.vertices.end(), {{0, 0, bottom}, {0, 0, top}});
    const auto last = static_cast<std::uint32_t>((profile.size() - 1) * n);
    for (std::uint32_t k = 0; k < n; ++k) {
        const std::uint32_t next = (k + 1) % n;
        mesh.triangles.push_back({south, next, k});
        for (std::uint32_t row = 0; row < last; row += n) add_quad(mesh, {row + k, row + next, row + n + next, row + n + k});
        mesh.triangles.push_back({north, last + k, last + next});
    }
    return canonicalized(mesh);
}

/// Taper, then bend: from the undeformed superellipsoid to the local frame (shape/superquadric.h gives the formulas).
Vec3d deformed(const shape::Superquadricd& sq, Vec3d q)
{
    q.x *= sq.taper_x * q.z / sq.a.z + 1;
    q.y *= sq.taper_y * q.z / sq.a.z + 1;
    if (!sq.is_bent()) return q;
    const double ca = std::cos(sq.bend_angle), sa = std::sin(sq.bend_angle);
    const double r = ca * q.x + sa * q.y, centre = 1 / sq.bend, gamma = q.z * sq.bend;
    const double shift = centre - (centre - r) * std::cos(gamma) - r;
    return {q.x + ca * shift, q.y + sa * shift, (centre - r) * std::sin(gamma)};
}

}  // namespace

Mesh sphere(double radius, int subdivisions)
{
    require(radius > 0 && subdivisions >= 0 && subdivisions <= 9, "sphere: radius > 0, 0 to 9 subdivisions");
    const double g = std::numbers::phi;
    Mesh mesh{
        {{-1, g, 0},
         {1, g, 0},
         {-1, -g, 0},
         {1, -g, 0},
         {0, -1, g},
         {0, 1, g},
         {0, -1, -g},
         {0, 1, -g},
         {g, 0, -1},
         {g, 0, 1},
         {-g, 0, -1},
         {-g, 0, 1}},
        {{0, 11, 5}, {0, 5, 1}, {0, 1, 7}, {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
         {3, 9, 4},  {3, 4, 2}, {3, 2, 6}, {3, 6, 8},  {3, 8, 9},   {4, 9, 5}, {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}}};
    for (Vec3d& v : mesh.vertices) v = sqmap::normalized(v);
    for (int i = 0; i < subdivisions; ++i) {
        std::vector<Edge> edges;
        mesh.triangles = split_in_four(mesh, edges);
        for (const auto& [u, v] : edges) mesh.vertices.push_back(sqmap::normalized(mesh.vertices[u] + mesh.vertices[v]));
    }
    for (Vec3d& v : mesh.vertices) v = radius * v;
    return canonicalized(mesh);
}

Mesh ellipsoid(Vec3d semi_axes, int subdivisions)
{
    require(semi_axes.x > 0 && semi_axes.y > 0 && semi_axes.z > 0, "ellipsoid: semi-axes > 0");
    Mesh mesh = sphere(1, subdivisions);
    for (Vec3d& v : mesh.vertices) v = {semi_axes.x * v.x, semi_axes.y * v.y, semi_axes.z * v.z};
    return canonicalized(mesh);
}

Mesh rounded_box(Vec3d half_size, double radius, int segments)
{
    require(radius > 0 && radius < std::min({half_size.x, half_size.y, half_size.z}) && segments >= 1,
            "rounded_box: 0 < radius < half sizes, at least one segment");
    // Rounded edges are gridded at even angles: a point of the outer box at tangent t of the angle from the inner one.
    std::array<std::vector<double>, 3> grid;
    for (int axis = 0; axis < 3; ++axis) {
        const double inner = half_size[axis] - radius;
        const int half = std::max(1, (segments + 1) / 2);
        const int flat = std::max(1, static_cast<int>(std::lround(2 * inner / radius * segments / (pi / 2))));
        std::vector<double> arc;
        for (int i = 1; i <= half; ++i) arc.push_back(i == half ? radius : radius * std::tan(pi / 4 * i / half));
        for (auto it = arc.rbegin(); it != arc.rend(); ++it) grid[axis].push_back(-inner - *it);
        for (const double x : even(-inner, inner, flat)) grid[axis].push_back(x);
        for (const double x : arc) grid[axis].push_back(inner + x);
    }
    return gridded_box(grid, [&](Vec3d p) {
        Vec3d core;
        for (int i = 0; i < 3; ++i) core[i] = std::clamp(p[i], radius - half_size[i], half_size[i] - radius);
        return core + radius * sqmap::normalized(p - core);
    });
}

Mesh torus(const TorusOptions& o)
{
    require(o.minor_radius > 0 && o.minor_radius < o.major_radius && o.major_segments >= 3 && o.minor_segments >= 3,
            "torus: 0 < minor radius < major radius, at least 3 segments");
    Mesh mesh;
    const auto n = static_cast<std::uint32_t>(o.major_segments), m = static_cast<std::uint32_t>(o.minor_segments);
    for (std::uint32_t i = 0; i < n; ++i)
        for (std::uint32_t j = 0; j < m; ++j) {
            const double u = 2 * pi * i / n, v = 2 * pi * j / m, r = o.major_radius + o.minor_radius * std::cos(v);
            mesh.vertices.push_back({r * std::cos(u), r * std::sin(u), o.minor_radius * std::sin(v)});
        }
    for (std::uint32_t i = 0; i < n; ++i)
        for (std::uint32_t j = 0; j < m; ++j) {
            const std::uint32_t i1 = (i + 1) % n, j1 = (j + 1) % m;
            add_quad(mesh, {i * m + j, i1 * m + j, i1 * m + j1, i * m + j1});
        }
    return canonicalized(mesh);
}

Mesh dumbbell(const DumbbellOptions& o)
{
    require(o.bar_radius > 0 && o.bar_radius < o.ball_radius && o.half_distance > o.ball_radius && o.segments >= 3,
            "dumbbell: 0 < bar radius < ball radius < half distance, at least 3 segments");
    // Half a profile: from the equator plane up the bar, over the ball, to just below the pole.
    const double join = std::asin(o.bar_radius / o.ball_radius);  // angle at the ball's centre between bar and axis
    const double foot = o.half_distance - o.ball_radius * std::cos(join);
    const double edge = 2 * pi * o.ball_radius / o.segments;
    std::vector<ProfilePoint> half;
    const int along = std::max(1, static_cast<int>(std::ceil(foot / edge)));
    for (int i = 1; i < along; ++i) half.push_back({o.bar_radius, foot * i / along});
    const int around = std::max(2, static_cast<int>(std::ceil((pi - join) * o.ball_radius / edge)));
    for (int i = 0; i < around; ++i) {
        const double angle = join + (pi - join) * i / around;
        half.push_back({o.ball_radius * std::sin(angle), o.half_distance - o.ball_radius * std::cos(angle)});
    }
    std::vector<ProfilePoint> profile;
    for (auto it = half.rbegin(); it != half.rend(); ++it) profile.push_back({it->r, -it->z});
    profile.push_back({o.bar_radius, 0});
    profile.insert(profile.end(), half.begin(), half.end());
    const double end = o.half_distance + o.ball_radius;
    return revolved(profile, -end, end, o.segments);
}

Mesh superquadric_surface(const shape::Superquadricd& sq, int segments)
{
    require(sq.a.x > 0 && sq.a.y > 0 && sq.a.z > 0 && segments >= 1, "superquadric_surface: semi-axes > 0, a segment");
    std::array<std::vector<double>, 3> grid;
    // Even angles rather than even steps: quads of about the same size on a sphere.
    for (auto& axis : grid)
        for (const double angle : even(-pi / 4, pi / 4, segments))
            axis.push_back(angle == -pi / 4 ? -1.0 : (angle == pi / 4 ? 1.0 : std::tan(angle)));
    return gridded_box(grid, [&](Vec3d p) {
        const Vec3d ray{sq.a.x * p.x, sq.a.y * p.y, sq.a.z * p.z};
        const double f = shape::implicit_undeformed(sq.a, sq.eps1, sq.eps2, ray);  // homogeneous of degree 2
        return shape::to_model(sq, deformed(sq, ray / std::sqrt(f)));
    });
}

Mesh loop_subdivided(const Mesh& mesh, int times)
{
    require(times >= 0, "loop_subdivided: times >= 0");
    Mesh current = mesh;
    for (int round = 0; round < times; ++round) {
        std::map<Edge, std::pair<Vec3d, int>> opposite;  // sum and number of the corners across an edge
        std::vector<Vec3d> ring(current.vertices.size());
        std::vector<int> valence(current.vertices.size());
        for (const Triangle& t : current.triangles)
            for (int i = 0; i < 3; ++i) {
                const std::uint32_t u = t[i], v = t[(i + 1) % 3];
                auto& [sum, count] = opposite[edge_of(u, v)];
                sum += current.vertices[t[(i + 2) % 3]];
                ++count;
                ring[u] += current.vertices[v];
                ++valence[u];
            }
        for (const auto& [edge, across] : opposite) require(across.second == 2, "loop_subdivided: the mesh must be closed");

        Mesh next;
        std::vector<Edge> edges;
        next.triangles = split_in_four(current, edges);
        for (std::size_t v = 0; v < current.vertices.size(); ++v) {
            const double c = 3.0 / 8 + std::cos(2 * pi / valence[v]) / 4;
            const double beta = 5.0 / 8 - c * c;
            next.vertices.push_back((1 - beta) * current.vertices[v] + beta / valence[v] * ring[v]);
        }
        for (const auto& [u, v] : edges)
            next.vertices.push_back(3.0 / 8 * (current.vertices[u] + current.vertices[v]) + 1.0 / 8 * opposite[{u, v}].first);
        current = std::move(next);
    }
    return canonicalized(current);
}

double volume(const Mesh& mesh)
{
    double six_fold = 0;
    const Vec3d base = mesh.vertices.empty() ? Vec3d{} : mesh.vertices.front();
    for (const Triangle& t : mesh.triangles)
        six_fold += dot(mesh.vertices[t[0]] - base, cross(mesh.vertices[t[1]] - base, mesh.vertices[t[2]] - base));
    return six_fold / 6;
}

double surface_area(const Mesh& mesh)
{
    double sum = 0;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) sum += triangle_area(mesh, t);
    return sum;
}

}  // namespace sqmap::mesh
