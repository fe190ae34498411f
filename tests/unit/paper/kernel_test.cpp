#include "paper/query/job.h"
#include "sqmap/query/point.h"
#include "support/bodies.h"
#include "support/paper_model.h"

#include <gtest/gtest.h>

#include <hwy/targets.h>

#include <cmath>
#include <cstdio>

namespace sqmap::paper {
namespace {

using query::PointResult;
using query::query_point;
using query::query_probe;

struct Hand {
    test::PaperModel model{test::small_hand(), {.exact = false}};
    const mesh::Mesh mesh = bake::model_space(test::small_hand());
    const mesh::Solid solid{mesh, mesh::find_self_intersections(mesh).crossed};
    std::vector<Vec3d> points;

    Hand()
    {
        test::Random random(92);
        const model::Header& h = model.view().header;
        const double r = static_cast<double>(h.sphere[3]) * h.unit;
        const Vec3d centre = model::to_mesh_units(h, model::vec3(h.sphere));
        for (int i = 0; i < 20000; ++i) points.push_back(centre + r * random.in_box({-1, -1, -1}, {1, 1, 1}));
    }
    static Hand& get()
    {
        static Hand hand;
        hand.model.set_options({});
        return hand;
    }
};

// Depth by polynomials against double at the same foot.
TEST(PaperKernel, DepthIsThatOfDouble)
{
    Hand& hand = Hand::get();
    const model::ModelView& view = hand.model.in_model_space();
    double max = 0;
    int count = 0;
    for (const Vec3d& point : hand.points) {
        const Vec3f p = model::to_model_space(hand.model.view().header, point);
        for (std::size_t i = 0; i < view.parts.size(); ++i) {
            const MapView map = map_of(view, i);
            const PartAnswer a = project(map, p);
            if (a.verdict == Verdict::Outside) continue;
            const shape::Superquadricd sq = shape::cast<double>(map.superquadric);
            const Vec3d foot = shape::surface_point(sq, shape::SurfaceAngles<double>{static_cast<double>(a.angles.eta),
                                                                                     static_cast<double>(a.angles.omega)})
                                   .point;
            max = std::max(max, std::abs(norm(foot - cast<double>(p)) - static_cast<double>(a.foot_distance)));
            ++count;
        }
    }
    EXPECT_GT(count, 500);
    EXPECT_LE(max, 1e-5 * view.header.r_max);
}

TEST(PaperKernel, AnswersAsOneLaneDoesOnEveryInstructionSet)
{
    Hand& hand = Hand::get();
    const model::ModelView& view = hand.model.view();
    const Probe probe(hand.points);
    std::vector<Contact> reference(hand.points.size()), contacts(hand.points.size());
    const Pose turned{test::rotation_about({0, 0.6, 0.8}, 0.3), {0.02, 0.01, 0}};
    std::size_t total = 0;
    for (const Projector projector : {Projector::Newton, Projector::Pyramid, Projector::Printed})
        for (const Layer layer : {Layer::One, Layer::Two, Layer::Three, Layer::Gate})
            for (const bool smoothing : {false, true}) {
                hand.model.set_options({.projector = projector});
                const query::QueryOptions options{
                    .layer = layer, .offset = projector == Projector::Pyramid, .smoothed_map = smoothing};
                const query::Body touched{.model = &view}, collider{.probe = &probe, .pose = turned};
                const ProbeResult one = run_one_lane({ProbeJob(touched, collider, options, reference), options});
                for (std::int64_t left = hwy::SupportedTargets() & HWY_TARGETS; left != 0; left &= left - 1) {
                    hwy::SetSupportedTargetsForTest(left & -left);
                    const ProbeResult many = query_probe(touched, collider, options, contacts);
                    hwy::SetSupportedTargetsForTest(0);
                    ASSERT_EQ(many.contacts, one.contacts);
                    for (std::size_t i = 0; i < one.contacts; ++i) {
                        const Contact &a = reference[i], &b = contacts[i];
                        ASSERT_EQ(a.witness, b.witness) << i;
                        ASSERT_EQ(a.normal, b.normal);
                        ASSERT_EQ(a.depth, b.depth);
                        ASSERT_EQ(a.index, b.index);
                        ASSERT_EQ(a.part, b.part);
                        ASSERT_EQ(a.status, b.status);
                    }
                }
                total += one.contacts;
            }
    EXPECT_GT(total, 1000u);
}

PointResult of_parts(const model::ModelView& view, Vec3f p, const ProjectionOptions& options)
{
    std::vector<PartAnswer> answers;
    for (std::size_t i = 0; i < view.parts.size(); ++i) {
        const float* sphere = view.parts[i].sphere;
        const bool in_sphere = norm_sq(p - model::vec3(sphere)) <= sphere[3] * sphere[3];
        answers.push_back(in_sphere ? project(map_of(view, i), p, options) : PartAnswer{});
    }
    const CombinedAnswer all = combine(answers);
    PointResult result;
    result.contact = all.contact;
    result.part = all.part;
    result.status = all.contact && !all.has_surface ? k_no_surface : k_ok;
    if (all.has_surface) result.depth = std::max(static_cast<double>(answers[static_cast<std::size_t>(all.part)].depth), 0.);
    return result;
}

// A point by itself, and a part by itself under the witness rule, are the same template.
TEST(PaperKernel, PointsAndPartsAnswerAsTheProbe)
{
    Hand& hand = Hand::get();
    const model::ModelView& view = hand.model.in_model_space();
    std::size_t contacts = 0, open = 0;
    for (const Vec3d& point : hand.points) {
        const Vec3f p = model::to_model_space(hand.model.view().header, point);
        hand.model.set_options({.projector = Projector::Pyramid});
        const PointResult whole = query_point(view, cast<double>(p));
        const PointResult parts = of_parts(view, p, {.projector = Projector::Pyramid, .nearest_steps = 0});
        ASSERT_EQ(parts.contact, whole.contact);
        if (!whole.contact) continue;
        ++contacts;
        EXPECT_EQ(parts.part, whole.part);
        EXPECT_EQ(parts.status, whole.status);
        EXPECT_EQ(parts.depth, whole.depth);
        open += whole.status == k_no_surface ? 1u : 0u;
    }
    EXPECT_GT(contacts, 200u);
    EXPECT_GT(contacts, 2 * open);
}

// Some map shows the surface above a point that lies below caps alone.
TEST(PaperKernel, ContactsBelowCapsFindTheNearestSurface)
{
    Hand& hand = Hand::get();
    const model::ModelView& view = hand.model.in_model_space();
    double error = 0, depth = 0;
    std::size_t open = 0, left = 0;
    for (const Vec3d& point : hand.points) {
        const Vec3f p = model::to_model_space(hand.model.view().header, point);
        hand.model.set_options({.nearest_steps = 0});
        const PointResult alone = query_point(view, cast<double>(p));
        hand.model.set_options({});
        const PointResult found = query_point(view, cast<double>(p));
        if (alone.status != k_no_surface) continue;
        ASSERT_TRUE(found.contact);
        const double truth = hand.solid.closest_boundary(cast<double>(p)).distance;
        error += std::abs(found.depth - truth);
        depth += truth;
        ++open;
        left += found.status == k_no_surface ? 1u : 0u;
    }
    EXPECT_GT(open, 20u);
    EXPECT_LE(10 * left, open);
    EXPECT_LT(error, 0.1 * depth);
}

// Parts that do not hold a point may show its nearest surface; verdicts are not theirs.
TEST(PaperKernel, OtherPartsBringDepthNearerAndChangeNoVerdict)
{
    Hand& hand = Hand::get();
    const model::ModelView& view = hand.model.in_model_space();
    double alone = 0, all = 0;
    std::size_t known = 0;
    for (const Vec3d& point : hand.points) {
        const Vec3f p = model::to_model_space(hand.model.view().header, point);
        const PointResult whole = query_point(view, cast<double>(p)), parts = of_parts(view, p, {});
        ASSERT_EQ(parts.contact, whole.contact);
        if (!whole.contact) continue;
        if (parts.status == k_no_surface) continue;
        EXPECT_EQ(whole.status, k_ok);
        EXPECT_LE(whole.depth, parts.depth);
        const double truth = hand.solid.closest_boundary(cast<double>(p)).distance;
        alone += std::abs(parts.depth - truth);
        all += std::abs(whole.depth - truth);
        ++known;
    }
    EXPECT_GT(known, 200u);
    EXPECT_LE(all, alone);
}

}  // namespace
}  // namespace sqmap::paper
