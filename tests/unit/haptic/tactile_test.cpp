#include "sqmap/haptic/tactile.h"

#include "sqmap/math/rotation.h"
#include "touching.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <vector>

namespace sqmap::haptic {
namespace {

constexpr double k_gap = 0.005, k_deep = 0.002, k_top = 0.03;  // m: between taxels; of the pad in the box; of the box

/// A flat pad of 7 x 7 taxels that looks down on a box.
class Tactile : public testing::Test {
protected:
    Tactile()
    {
        for (int i = -3; i <= 3; ++i)
            for (int j = -3; j <= 3; ++j) points_.push_back({k_gap * i, k_gap * j, 0});
        pad_.emplace(points_, std::vector<Vec3d>(points_.size(), Vec3d{0, 0, -2}));
        taxels_.resize(points_.size());
    }
    TactileResult tick(Vec3d at, double dt = 1e-3)
    {
        return pad_->tick({{&test::box().view, nullptr, {}}, {{}, at}, dt}, options_, taxels_);
    }

    std::vector<Vec3d> points_;
    std::optional<TactilePad> pad_;
    TactileOptions options_{.tactile_kn = 500, .tactile_kt = 20, .tactile_mu = 0.5, .query = {.layer = query::Layer::Exact}};
    std::vector<Taxel> taxels_;
    const Vec3d pressed_{0, 0, k_top - k_deep};
};

TEST_F(Tactile, APressedPadFeelsStiffnessTimesDepthOnEveryTaxel)
{
    const TactileResult result = tick(pressed_);
    EXPECT_EQ(result.contacts, points_.size());
    for (const Taxel& t : taxels_) {
        EXPECT_NEAR(static_cast<double>(t.normal), 500 * k_deep, 1e-3);
        EXPECT_NEAR(static_cast<double>(t.depth), k_deep, 1e-7);
        EXPECT_NEAR(norm(cast<double>(t.shear)), 0, 1e-3);
    }
    EXPECT_NEAR(result.force.z, static_cast<double>(points_.size()) * 500 * k_deep, 0.05);
}

TEST_F(Tactile, ALiftedPadFeelsNothing)
{
    tick(pressed_);
    const TactileResult result = tick({0, 0, 0.04});
    EXPECT_EQ(result.contacts, 0U);
    for (const Taxel& t : taxels_) EXPECT_TRUE(t.normal == 0 && t.depth == 0 && t.shear == Vec3f{});
}

TEST_F(Tactile, SlowSlipIsViscousAgainstTheMotion)
{
    tick(pressed_);
    tick(pressed_ + Vec3d{1e-5, 0, 0});  // 1 cm/s
    for (const Taxel& t : taxels_) EXPECT_NEAR(static_cast<double>(t.shear.x), -20 * 0.01, 1e-3);
}

TEST_F(Tactile, FastSlipIsCoulombs)
{
    tick(pressed_);
    tick(pressed_ + Vec3d{0, 5e-3, 0});
    for (const Taxel& t : taxels_) {
        EXPECT_NEAR(static_cast<double>(t.shear.y), -0.5 * static_cast<double>(t.normal), 1e-3);
        EXPECT_LE(norm(cast<double>(t.shear)), 0.5 * 500 * static_cast<double>(t.depth) * (1 + 1e-5));
    }
}

TEST_F(Tactile, APadThatRidesOnTheBodyDoesNotSlip)
{
    const Mat3d turn = rotation_by({0.1, -0.2, 0.3});
    for (const Vec3d at : {Vec3d{}, Vec3d{0.4, 0.1, -0.2}}) {
        const Pose body{turn, at}, pad{turn, turn * pressed_ + at};
        pad_->tick({{&test::box().view, nullptr, body}, pad, 1e-3}, options_, taxels_);
        for (const Taxel& t : taxels_) EXPECT_NEAR(norm(cast<double>(t.shear)), 0, 1e-3);
    }
}

TEST_F(Tactile, ARestartHasNoSlip)
{
    tick({0.02, 0, k_top - k_deep});
    pad_->restart();
    tick(pressed_);
    for (const Taxel& t : taxels_) EXPECT_NEAR(norm(cast<double>(t.shear)), 0, 1e-3);
}

TEST_F(Tactile, DampingPushesAgainstTheApproachAndNeverPulls)
{
    options_.tactile_damping = 2000;
    tick(pressed_);
    tick(pressed_ - Vec3d{0, 0, 1e-4});  // 0.1 m/s downwards
    for (const Taxel& t : taxels_) EXPECT_NEAR(static_cast<double>(t.normal), 500 * (k_deep + 1e-4) + 2000 * 0.1, 0.05);
    tick(pressed_ + Vec3d{0, 0, 1e-4});
    for (const Taxel& t : taxels_) EXPECT_EQ(t.normal, 0);
}

TEST_F(Tactile, WhatIsNotFiniteIsZero)
{
    tick(pressed_);
    const double bad = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(tick({bad, 0, 0}).status, query::k_not_finite);
    for (const Taxel& t : taxels_) EXPECT_TRUE(t.normal == 0 && t.shear == Vec3f{});
    EXPECT_EQ(tick(pressed_, bad).contacts, 0U);
    EXPECT_EQ(tick(pressed_).contacts, points_.size());
}

}  // namespace
}  // namespace sqmap::haptic
