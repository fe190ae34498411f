// A tool of one zone and a solid of metres, for tests of steps.
#pragma once

#include "haptic/stencil.h"
#include "sqmap/haptic/step.h"
#include "support/bodies.h"

#include <optional>
#include <vector>

namespace sqmap::haptic::test {

using sqmap::test::mapped;
using sqmap::test::rotation_about;
using sqmap::test::shifted;

inline constexpr double k = 500;  ///< N/m
inline const ZoneOptions exact{.layer = query::Layer::Exact, .stiffness = k};

inline ZoneOptions with(Averaging averaging, ZoneOptions options = exact)
{
    options.averaging = averaging;
    return options;
}

inline double angle_between(Vec3d a, Vec3d b) { return std::acos(std::clamp(dot(normalized(a), normalized(b)), -1., 1.)); }

/// The top of a box, as a tool: a flat square of 2 cm, n by n points, z = 0.
inline std::vector<Vec3d> square(int n)
{
    std::vector<Vec3d> points;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) points.push_back({0.02 * (i / (n - 1.) - 0.5), 0.02 * (j / (n - 1.) - 0.5), 0});
    return points;
}

/// A box of 10 x 10 x 6 cm about the origin, its top flat: z = 3 cm for |x|, |y| < 4 cm.
inline const sqmap::test::Solid& box()
{
    static const sqmap::test::Solid solid(mesh::rounded_box({0.05, 0.05, 0.03}, 0.01, 3));
    return solid;
}
/// A plate 2 mm thick, 10 x 10 cm, its top at z = 1 mm.
inline const sqmap::test::Solid& plate()
{
    static const sqmap::test::Solid solid([] {
        mesh::Mesh m = sqmap::test::cube();
        for (Vec3d& v : m.vertices) v = {0.05 * v.x, 0.05 * v.y, 0.001 * v.z};
        return m;
    }());
    return solid;
}
/// A bar along y whose top is two slopes that meet at the origin, each tilted by k_roof: a ridge (1) or a valley (-1).
inline constexpr double k_roof = 0.35;
inline const sqmap::test::Solid& roof(int side)
{
    const auto bar = [](double slope) {
        // The outline in x and z, from the top's middle on; a fan about that sees all of it.
        const double h = 0.04 * std::tan(slope), x[] = {0, -0.04, -0.04, 0.04, 0.04}, z[] = {0, -h, -0.04, -0.04, -h};
        mesh::Mesh m;
        for (const double y : {-0.04, 0.04})
            for (int i = 0; i < 5; ++i) m.vertices.push_back({x[i], y, z[i]});
        for (std::uint32_t i = 0; i < 5; ++i) {
            const std::uint32_t j = (i + 1) % 5;
            m.triangles.push_back({i, j + 5, j});
            m.triangles.push_back({i, i + 5, j + 5});
            if (i == 0 || i == 4) continue;
            m.triangles.push_back({0, i, j});
            m.triangles.push_back({5, j + 5, i + 5});
        }
        return m;
    };
    static const sqmap::test::Solid ridge(bar(k_roof)), valley(bar(-k_roof));
    return side > 0 ? ridge : valley;
}
/// A hand of 20 cm.
inline const sqmap::test::Solid& hand()
{
    static const sqmap::test::Solid solid(mapped(sqmap::test::small_hand(), 0.2, {}));
    return solid;
}

inline TouchedBody frictionless(const sqmap::test::Solid& solid, const Pose& pose = {})
{
    TouchedBody s;
    s.model = &solid.view;
    s.pose = pose;
    s.material.friction = Friction::None;
    return s;
}

/// One zone.
class Tool {
public:
    Tool(const std::vector<Vec3d>& points, const ZoneOptions& options, std::vector<float> weights = {})
        : probe_(points),
          weights_(std::move(weights)),
          zone_{.probe = &probe_, .weights = weights_, .options = options},
          state_(std::span(&zone_, 1))
    {
    }
    Tool(const Tool&) = delete;
    Tool& operator=(const Tool&) = delete;

    static Tool point(ZoneOptions options)
    {
        options.averaging = Averaging::Stencil;
        return Tool(stencil_points(options.smoothing), options);
    }

    Wrench touch(std::span<const TouchedBody> solids, const Pose& pose)
    {
        Wrench w;
        StepInput in = input;
        in.touched = solids;
        in.poses = std::span(&pose, 1);
        result = step(state_, in, std::span(&w, 1), on_touched);
        return w;
    }
    Wrench touch(const TouchedBody& solid, const Pose& pose) { return touch(std::span(&solid, 1), pose); }
    Wrench touch(const TouchedBody& solid, Vec3d at) { return touch(solid, shifted(at)); }

    [[nodiscard]] const ZoneReport& report() const { return state_.report(0); }
    State& state() { return state_; }

    StepInput input{};  ///< dt, degraded, twists
    StepResult result{};
    std::vector<Wrench> on_touched;

private:
    query::Probe probe_;
    std::vector<float> weights_;
    Zone zone_;
    State state_;
};

}  // namespace sqmap::haptic::test
