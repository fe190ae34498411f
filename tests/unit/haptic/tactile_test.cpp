#include "sqmap/haptic/tactile.h"

#include "sqmap/math/rotation.h"
#include "touching.h"

#include <gtest/gtest.h>

#include <algorithm>
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

TEST_F(Tactile, ATiltedPadThatSlipsFeelsTheFormulaBitByBit)
{
    options_.tactile_damping = 3;
    const Pose before{rotation_by({0.01, 0, 0}), pressed_},
        now{rotation_by({0.02, -0.03, 0.1}), pressed_ + Vec3d{1e-5, 2e-5, -1e-5}};
    pad_->tick({{&test::box().view, nullptr, {}}, before, 1e-3}, options_, taxels_);
    const TactileResult result = pad_->tick({{&test::box().view, nullptr, {}}, now, 1e-3}, options_, taxels_);
    const query::Probe probe(points_);
    std::vector<query::Contact> contacts(points_.size());
    const query::ProbeResult found =
        query::query_probe({&test::box().view, nullptr, {}}, {nullptr, &probe, now}, options_.query, contacts);
    ASSERT_GT(found.contacts, 20U);
    Vec3d sum{};
    for (const query::Contact& c : found.written(contacts)) {
        const Vec3d p = points_[c.index], out = cast<double>(c.normal), speed = (1 / 1e-3) * (apply(now, p) - apply(before, p));
        const double along = dot(speed, out);
        const double push = std::max(0.0, 500 * static_cast<double>(c.depth) - 3 * along);
        const Vec3d slip = speed - along * out;
        const double drag = std::min(20 * norm(slip), 0.5 * push);
        const Vec3d force = transpose_mul(now.rotation, push * out - (drag / norm(slip)) * slip), normal{0, 0, -1};
        const double pressed = dot(force, normal);
        const Taxel& t = taxels_[c.index];
        EXPECT_EQ(t.normal, static_cast<float>(std::max(0.0, -pressed)));
        EXPECT_TRUE(t.shear == cast<float>(force - pressed * normal));
        sum = sum + force;
    }
    EXPECT_TRUE(sum == result.force);
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
