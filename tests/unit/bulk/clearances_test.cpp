// Poses of a tool against the minimum over all of its points, one by one.
#include "sqmap/bulk/clearances.h"

#include "math/random.h"
#include "sqmap/bake_mesh.h"
#include "sqmap/math/rotation.h"
#include "sqmap/mesh/shapes.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

namespace sqmap::bulk {
namespace {

class Clearances : public testing::Test {
protected:
    static void SetUpTestSuite()
    {
        model_ = new BakedModel(bake_mesh(mesh::torus({.major_radius = 1, .minor_radius = 0.3})));
        tool_ = new std::vector<Vec3d>(mesh::ellipsoid({0.3, 0.1, 0.05}, 3).vertices);
    }
    static void TearDownTestSuite()
    {
        delete model_;
        delete tool_;
    }

    /// Poses whose tool lies within `reach` of the middle.
    static std::vector<Pose> poses(std::size_t count, double reach)
    {
        SplitMix64 random(5);
        std::vector<Pose> out;
        for (std::size_t i = 0; i < count; ++i) {
            const Vec3d turn{random.between(-3, 3), random.between(-3, 3), random.between(-3, 3)};
            const Vec3d shift{random.between(-reach, reach), random.between(-reach, reach), random.between(-reach, reach)};
            out.push_back({rotation_by(turn), shift});
        }
        return out;
    }

    static std::vector<PoseClearance> answers(ClearanceQuery query)
    {
        const ToolPoints tool(*tool_);
        query.tool = &tool;
        if (query.touched.model == nullptr) query.touched.model = view();
        std::vector<PoseClearance> out(query.poses.size());
        clearances(query, out);
        return out;
    }

    struct Least {
        query::SignedDistance found;
        std::size_t index;
    };
    static Least least(const query::Body& touched, const Pose& pose)
    {
        Least out{{}, 0};
        out.found.distance = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < tool_->size(); ++i) {
            const query::SignedDistance d = query::exact_distance(touched, apply(pose, (*tool_)[i]));
            if (d.distance < out.found.distance) out = {d, i};
        }
        return out;
    }

    static const model::ModelView* view()
    {
        static const model::ModelView view = model_->view();
        return &view;
    }

    static BakedModel* model_;
    static std::vector<Vec3d>* tool_;
};
BakedModel* Clearances::model_ = nullptr;
std::vector<Vec3d>* Clearances::tool_ = nullptr;

TEST_F(Clearances, AreTheLeastOfAllPointsNearAndFar)
{
    const query::Body touched{view(), nullptr, {rotation_by({0.3, -0.2, 1}), {0.1, 0.2, -0.3}}};
    for (const double reach : {1.2, 4.0, 60.0}) {
        const std::vector<Pose> at = poses(150, reach);
        const std::vector<PoseClearance> found = answers({.touched = touched, .poses = at});
        for (std::size_t i = 0; i < at.size(); ++i) {
            const Least want = least(touched, at[i]);
            EXPECT_EQ(found[i].distance, want.found.distance);
            EXPECT_EQ(found[i].index, static_cast<std::int64_t>(want.index));
            EXPECT_EQ(found[i].triangle, want.found.triangle);
            EXPECT_EQ(found[i].known, query::DistanceKind::Exact);
            EXPECT_TRUE(found[i].complete);
            EXPECT_EQ(found[i].point, apply(at[i], (*tool_)[want.index]));
        }
    }
}

TEST_F(Clearances, DerivativesAreThoseOfFiniteDifferences)
{
    constexpr double k_step = 1e-6;
    const std::vector<Pose> at = poses(100, 1.6);
    const std::vector<PoseClearance> found = answers({.poses = at});
    std::size_t compared = 0;
    for (std::size_t i = 0; i < at.size(); ++i)
        for (int k = 0; k < 6; ++k) {
            Vec3d direction{};
            direction[k % 3] = k_step;
            std::array<Pose, 2> moved{at[i], at[i]};
            for (const int side : {0, 1}) {
                const Vec3d by = side == 0 ? -direction : direction;
                if (k < 3)
                    moved[static_cast<std::size_t>(side)].translation = at[i].translation + by;
                else
                    moved[static_cast<std::size_t>(side)].rotation = rotation_by(by) * at[i].rotation;
            }
            const std::vector<PoseClearance> ends = answers({.poses = moved});
            // A crease lies between the ends where their nearest points or triangles differ.
            if (ends[0].index != ends[1].index || ends[0].triangle != ends[1].triangle) continue;
            const double difference = (ends[1].distance - ends[0].distance) / (2 * k_step);
            EXPECT_NEAR(k < 3 ? found[i].by_translation[k] : found[i].by_rotation[k - 3], difference, 1e-5);
            ++compared;
        }
    EXPECT_GT(compared, 500u);
}

TEST_F(Clearances, BeyondTheBandABoundSaysThatNoPointIsNearer)
{
    const std::vector<Pose> at = poses(200, 4);
    const std::vector<PoseClearance> found = answers({.poses = at, .band = 0.5});
    std::size_t bounds = 0;
    for (std::size_t i = 0; i < at.size(); ++i) {
        const double truth = least({view()}, at[i]).found.distance;
        if (found[i].known == query::DistanceKind::LowerBound) {
            EXPECT_GT(found[i].distance, 0.5);
            EXPECT_LE(found[i].distance, truth);
            EXPECT_EQ(found[i].index, -1);
            ++bounds;
        } else {
            EXPECT_EQ(found[i].distance, truth);
        }
        EXPECT_TRUE(truth > 0.5 || found[i].known == query::DistanceKind::Exact);
    }
    EXPECT_GT(bounds, 50u);
}

TEST_F(Clearances, AStopEndsWithAPointThatNear)
{
    const std::vector<Pose> at = poses(200, 1.5);
    const std::vector<PoseClearance> all = answers({.poses = at}), stopped = answers({.poses = at, .stop_below = 0.0});
    std::size_t incomplete = 0;
    for (std::size_t i = 0; i < at.size(); ++i) {
        EXPECT_EQ(stopped[i].distance <= 0, all[i].distance <= 0);
        EXPECT_GE(stopped[i].distance, all[i].distance);
        if (stopped[i].complete)
            EXPECT_EQ(stopped[i].distance, all[i].distance);
        else
            ++incomplete;
    }
    EXPECT_GT(incomplete, 10u);
}

TEST_F(Clearances, APoseThatIsNotFiniteLeavesTheOthersRight)
{
    std::vector<Pose> at = poses(300, 1.5);
    const std::vector<PoseClearance> all = answers({.poses = at});
    at[7].translation.y = std::numeric_limits<double>::quiet_NaN();
    at[8].rotation.row[2].x = std::numeric_limits<double>::infinity();
    const std::vector<PoseClearance> found = answers({.poses = at, .threads = 3});
    for (std::size_t i = 0; i < at.size(); ++i) {
        const bool is_bad = i == 7 || i == 8;
        EXPECT_EQ(std::isnan(found[i].distance), is_bad);
        EXPECT_EQ(found[i].status, is_bad ? query::k_not_finite : query::k_ok);
        if (is_bad) continue;
        EXPECT_EQ(found[i].distance, all[i].distance);
        EXPECT_EQ(found[i].index, all[i].index);
    }
}

TEST_F(Clearances, WithoutTheExactLayerAreApproximate)
{
    const BakedModel model = bake_mesh(mesh::torus({.major_radius = 1, .minor_radius = 0.3}), {.bake = {.exact = false}});
    const model::ModelView view = model.view();
    const std::vector<Pose> at = poses(100, 1.2);
    const std::vector<PoseClearance> found = answers({.touched = {&view}, .poses = at}), exact = answers({.poses = at});
    std::size_t approximate = 0;
    for (std::size_t i = 0; i < at.size(); ++i) {
        if (found[i].known != query::DistanceKind::Approximate) continue;
        EXPECT_NEAR(found[i].distance, exact[i].distance, 0.01 * 2.6);
        ++approximate;
    }
    EXPECT_GT(approximate, 20u);
}

TEST_F(Clearances, OfNothingAreInfinite)
{
    const std::vector<Pose> at(3);
    std::vector<PoseClearance> found(3);
    clearances({.touched = {view()}, .poses = at}, found);
    for (const PoseClearance& c : found) {
        EXPECT_EQ(c.distance, std::numeric_limits<double>::infinity());
        EXPECT_EQ(c.index, -1);
    }
}

TEST(ToolPoints, GroupsHoldEachPointOnce)
{
    SplitMix64 random(2);
    std::vector<Vec3d> points;
    for (int i = 0; i < 1000; ++i) points.push_back({random.uniform(), random.uniform(), 0.1 * random.uniform()});
    points.resize(1010, points.front());  // points at one position are divided too
    const ToolPoints tool(points);
    std::vector<int> seen(points.size());
    std::size_t next = 0;
    for (const ToolPoints::Group& g : tool.groups()) {
        EXPECT_EQ(g.first, next);
        next += g.count;
        for (std::size_t k = g.first; k < g.first + g.count; ++k) {
            EXPECT_EQ(tool.points()[k], points[tool.numbers()[k]]);
            EXPECT_LE(norm(tool.points()[k] - g.centre), g.radius);
            ++seen[tool.numbers()[k]];
        }
    }
    EXPECT_EQ(next, points.size());
    for (const int n : seen) EXPECT_EQ(n, 1);
    EXPECT_LT(tool.groups().size(), 100u);
}

}  // namespace
}  // namespace sqmap::bulk
