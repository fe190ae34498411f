// Section 6 on the paper's own maps: eqs. 21, 26, 32 and the mean of an impact zone.
#include "sqmap/paper/force.h"
#include "../haptic/touching.h"
#include "math/random.h"
#include "sqmap/paper/projection.h"
#include "sqmap/query/point.h"
#include "support/paper_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace sqmap::haptic::test {
namespace {

/// The box of touching.h, baked as a paper model.
const model::ModelView& paper_box()
{
    static const sqmap::test::PaperModel baked(mesh::rounded_box({0.05, 0.05, 0.03}, 0.01, 3), {.exact = false});
    return baked.view();
}

TouchedBody body()
{
    TouchedBody s;
    s.model = &paper_box();
    s.material.friction = Friction::None;
    return s;
}

ZoneOptions paper_force() { return sqmap::paper::with_paper_force({.stiffness = k}); }

TEST(PaperForce, WithThePrintedProjectorTheDepthIsEq21sOnTheMapOfTheLayer)
{
    sqmap::test::PaperModel baked(mesh::rounded_box({0.05, 0.05, 0.03}, 0.01, 3), {.exact = false});
    baked.set_options({.projector = paper::Projector::Printed});
    const model::ModelView& view = baked.in_model_space();
    ASSERT_EQ(view.parts.size(), 1u);
    const paper::MapView map = paper::map_of(view, 0);
    SplitMix64 random(5);
    for (const query::Layer layer : {query::Layer::Two, query::Layer::Three}) {
        int touching = 0, other = 0;
        for (int i = 0; i < 20000; ++i) {
            const double r = view.header.r_max;
            const Vec3f p{static_cast<float>(random.between(-r, r)), static_cast<float>(random.between(-r, r)),
                          static_cast<float>(random.between(-r, r))};
            const query::PointResult found = query::query_point(view, cast<double>(p), {.layer = layer, .smoothed_map = true});
            if (!found.contact || found.status != query::k_ok) continue;
            // Eqs. 21 and 26 from the foot of eqs. 15 to 19 and the stored map.
            const paper::PartAnswer foot =
                paper::project(map, p, {.layer = layer, .projector = paper::Projector::Printed, .nearest_steps = 0});
            const paper::MapSample sample = paper::sample_smoothed(map, foot.angles, layer);
            if (sample.flags != 0) continue;
            ++touching;
            EXPECT_NEAR(found.depth, std::max(foot.foot_distance - sample.distance, 0.f), 2e-6 * r) << i;
            EXPECT_LT(norm(found.normal - cast<double>(sample.normal)), 2e-4) << i << ": a contact's normal has 16 bits";
            other += std::abs(found.depth - dot(cast<double>(foot.surface - p), found.normal)) > 1e-3 * r;
        }
        EXPECT_GT(touching, 300);
        EXPECT_GT(other, 10) << "eq. 21's is another depth than that of the tangent plane";
    }
}

TEST(PaperForce, IsTheMeanOfTheSpringsOfTheSmoothedMap)
{
    const std::vector<Vec3d> points = mesh::sphere(0.008, 2).vertices;
    Tool tool(points, paper_force());
    std::size_t touching = 0;
    for (int i = 0; i < 60; ++i) {
        const double a = 0.1 * i;
        const Vec3d at{0.052 * std::cos(a), 0.052 * std::sin(a), 0.02 * std::sin(3 * a)};
        tool.state().reset();
        const Wrench w = tool.touch(body(), at);
        Vec3d sum{}, turn{};
        double count = 0;
        for (const Vec3d& p : points) {
            const query::PointResult c =
                query::query_point(paper_box(), at + p, {.layer = query::Layer::Three, .smoothed_map = true});
            if (!c.contact || (c.status & query::k_no_surface) != 0 || !(c.depth > 0)) continue;
            sum += k * c.depth * c.normal;
            turn += cross(p, k * c.depth * c.normal);
            ++count;
        }
        if (count == 0) {
            EXPECT_EQ(w.force, Vec3d{});
            continue;
        }
        ++touching;
        EXPECT_LT(norm(w.force - sum / count), 1e-4 * (1 + norm(sum / count))) << i;
        EXPECT_LT(norm(w.torque - turn / count), 1e-5) << i;
    }
    EXPECT_GT(touching, 20u);
}

/// 99th percentile of the force's steps while a point slides around a torus of 1,152 triangles, over 48 edges that turn by 7.5
/// degrees and more.
double step_percentile(bool smoothed_map)
{
    static const sqmap::test::PaperModel baked(
        mesh::torus({.major_radius = 0.1, .minor_radius = 0.04, .major_segments = 48, .minor_segments = 12}), {.exact = false});
    ZoneOptions options = paper_force();
    options.smoothed_map = smoothed_map;
    Tool tool({{}}, options);
    TouchedBody ring{.model = &baked.view()};
    ring.material.friction = Friction::None;
    std::vector<double> steps;
    for (const double up : {-0.9, -0.4, 0.15, 0.7, 1.2}) {
        std::optional<Vec3d> before;
        for (int i = 0; i <= 4000; ++i) {
            const double a = 2 * M_PI * i / 4000, tube = 0.04 - 0.003, out = 0.1 + tube * std::cos(up);
            const Vec3d f = tool.touch(ring, Vec3d{out * std::cos(a), out * std::sin(a), tube * std::sin(up)}).force;
            if (before) steps.push_back(norm(f - *before));
            before = f;
        }
    }
    std::sort(steps.begin(), steps.end());
    return steps[steps.size() * 99 / 100];
}

TEST(PaperForce, TheSmoothedMapChangesTheForceBySmallerSteps)
{
    const double plain = step_percentile(false), smoothed = step_percentile(true);
    EXPECT_LT(smoothed, 0.8 * plain) << plain;
    EXPECT_GT(smoothed, 0);
}

TEST(PaperForce, OpposedSpringsWeakenTheMean)
{
    // Two points, pressed 2 mm into opposite sides.
    Tool opposed({{0.048, 0, 0}, {-0.048, 0, 0}}, paper_force());
    EXPECT_LT(norm(opposed.touch(body(), Vec3d{}).force), 0.05);
    // At a right angle the mean is weaker by the root of two; full force across edges is not.
    Tool mean({{0.048, 0, 0}, {0, 0.048, 0}}, paper_force());
    ZoneOptions levelled = paper_force();
    levelled.shading = Shading::Levelled;
    Tool full({{0.048, 0, 0}, {0, 0.048, 0}}, levelled);
    const double weak = norm(mean.touch(body(), Vec3d{}).force), strong = norm(full.touch(body(), Vec3d{}).force);
    EXPECT_NEAR(weak / strong, std::sqrt(0.5), 0.02);
}

}  // namespace
}  // namespace sqmap::haptic::test
