// Small baked models that tests ask, each with the mesh it came from.
#pragma once

#include "bake/bake.h"
#include "math/random.h"
#include "sqmap/bake/evaluate.h"
#include "sqmap/io/read.h"
#include "sqmap/mesh/admission.h"
#include "sqmap/mesh/shapes.h"
#include "support/shared_folder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace sqmap::test {

/// Places and directions.
class Random : public SplitMix64 {
public:
    using SplitMix64::SplitMix64;
    std::uint32_t below(std::size_t n) { return static_cast<std::uint32_t>(bits() % n); }
    Vec3d in_box(Vec3d lo, Vec3d hi) { return {between(lo.x, hi.x), between(lo.y, hi.y), between(lo.z, hi.z)}; }
    Vec3d direction()
    {
        for (;;) {
            const Vec3d d = in_box({-1, -1, -1}, {1, 1, 1});
            if (const double n = norm(d); n > 0.1 && n <= 1) return d / n;
        }
    }
};

struct Shape {
    std::string name;
    mesh::Mesh mesh;
};

/// A mesh moved and scaled.
inline mesh::Mesh mapped(mesh::Mesh m, double scale, Vec3d shift)
{
    for (Vec3d& v : m.vertices) v = scale * v + shift;
    return m;
}

inline mesh::Mesh small_sphere() { return mesh::sphere(1, 3); }
inline mesh::Mesh small_box() { return mesh::rounded_box({1.2, 0.8, 0.6}, 0.2, 3); }
inline mesh::Mesh small_torus()
{
    return mesh::torus({.major_radius = 1, .minor_radius = 0.3, .major_segments = 36, .minor_segments = 16});
}
inline mesh::Mesh small_hand() { return mesh::polygonized(mesh::hand_capsules(), 0.06); }

/// A cube of 12 triangles: as few and as large triangles as can be, edges and corners on the chart's own planes.
inline mesh::Mesh cube()
{
    mesh::Mesh m;
    for (int i = 0; i < 8; ++i) m.vertices.push_back({i & 4 ? 1. : -1., i & 2 ? 1. : -1., i & 1 ? 1. : -1.});
    m.triangles = {{0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5}, {0, 4, 5}, {0, 5, 1},
                   {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
    return mesh::canonicalized(m);
}

/// Both, as they are: where they overlap they cut each other.
inline mesh::Mesh together(mesh::Mesh a, const mesh::Mesh& b)
{
    const auto first = static_cast<std::uint32_t>(a.vertices.size());
    a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
    for (const mesh::Triangle& t : b.triangles) a.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    return mesh::canonicalized(a);
}

inline mesh::Mesh cube_of(Vec3d half)
{
    mesh::Mesh m = cube();
    for (Vec3d& v : m.vertices) v = {half.x * v.x, half.y * v.y, half.z * v.z};
    return m;
}

/// A plus of two bars, 4 by 1 by 1, whose upper and lower faces lie in the same planes.
inline mesh::Mesh crossing_bars() { return together(cube_of({2, 0.5, 0.5}), cube_of({0.5, 2, 0.5})); }
/// How deep a point of its solid lies.
inline double depth_in_crossing_bars(Vec3d p)
{
    const double x = std::abs(p.x), y = std::abs(p.y);
    const auto to_side = [](double from, double to, double along, double across) {
        return std::hypot(std::max({from - along, 0.0, along - to}), across);
    };
    return std::min({0.5 - std::abs(p.z), to_side(0.5, 2, x, 0.5 - y), to_side(0.5, 2, y, 0.5 - x), to_side(0, 0.5, y, 2 - x),
                     to_side(0, 0.5, x, 2 - y)});
}
/// A pencil of triangles six hundred times as long as wide.
inline mesh::Mesh needles()
{
    constexpr std::uint32_t n = 200;
    mesh::Mesh m;
    for (std::uint32_t i = 0; i < n; ++i) {
        const double angle = 2 * 3.14159265358979 * i / n;
        for (const double z : {0., 10.}) m.vertices.push_back({0.5 * std::cos(angle), 0.5 * std::sin(angle), z});
    }
    m.vertices.push_back({0, 0, 0});
    m.vertices.push_back({0, 0, 10});
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t a = 2 * i, b = 2 * ((i + 1) % n);
        m.triangles.push_back({a, b, b + 1});
        m.triangles.push_back({a, b + 1, a + 1});
        m.triangles.push_back({2 * n, b, a});
        m.triangles.push_back({2 * n + 1, a + 1, b + 1});
    }
    return mesh::canonicalized(m);
}
/// A ball within a ball, both turned outward: the inner one adds nothing.
inline mesh::Mesh nested_balls() { return together(mesh::sphere(1, 3), mesh::sphere(0.5, 2)); }

inline std::vector<Shape> small_shapes()
{
    return {
        {"sphere", small_sphere()}, {"ellipsoid", mesh::ellipsoid({1.6, 1.0, 0.5}, 3)}, {"box", small_box()},  {"cube", cube()},
        {"torus", small_torus()},   {"dumbbell", mesh::dumbbell({.segments = 24})},     {"hand", small_hand()}};
}

/// A real mesh, as the gate lets it through; nothing where there is no file (see real_mesh_file).
inline std::optional<mesh::Mesh> shared_mesh(const std::string& name)
{
    const std::filesystem::path path = real_mesh_file(name);
    if (path.empty()) return std::nullopt;
    const io::ReadResult read = io::read_mesh_file(path);
    if (read.error) return std::nullopt;
    const mesh::AdmitResult gate = mesh::admit({read.soup.positions, read.soup.polygon_offsets, read.soup.indices});
    if (gate.admission == mesh::Admission::Refused) return std::nullopt;
    return gate.mesh;
}

inline void skip_without(const std::string& name)
{
    GTEST_SKIP() << "done but for " << name << ": it is not in " << shared_folder() << ", and nothing like it could be fetched";
}

/// For tests that ask it beside shapes of our own: where it is absent they do the rest, and count as skipped.
inline std::optional<mesh::Mesh> shared_mesh_too(const std::string& name)
{
    std::optional<mesh::Mesh> mesh = shared_mesh(name);
    if (!mesh) skip_without(name);
    return mesh;
}

/// One bake and what it is about: the mesh in model space, as the runtime sees it.
struct Baked {
    mesh::Mesh mesh;
    bake::BakeResult result;
    [[nodiscard]] model::ModelView view() const { return result.model.view(); }
    /// Queried where `mesh` is.
    [[nodiscard]] model::ModelView in_model_space() const { return model::normalized(view()); }
};

inline Baked baked(const mesh::Mesh& mesh, const bake::BakeOptions& options = {})
{
    return {bake::model_space(mesh), bake::bake(mesh, true, options)};
}

}  // namespace sqmap::test
