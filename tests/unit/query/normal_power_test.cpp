// One lane, as the reference is compiled.
#undef HWY_COMPILE_ONLY_STATIC
#define HWY_COMPILE_ONLY_SCALAR
#include "sqmap/shape/surface.h"
#include "support/bodies.h"

#include <hwy/highway.h>

#include "query/superquadric/surface-inl.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace sqmap::query {
namespace {

namespace lanes = HWY_NAMESPACE;
constexpr double pi = 3.14159265358979323846;

float value(lanes::F v) { return lanes::hn::GetLane(v); }

TEST(NormalPower, IsAsNearAsItSays)
{
    double power = 0, root = 0;
    for (int i = 1; i <= 2000; ++i)
        for (int j = 0; j <= 200; ++j) {
            const float e = 1.f + 19.f * static_cast<float>(j) / 200, x = static_cast<float>(i) / 2000;
            const double exact = std::pow(static_cast<double>(x), static_cast<double>(e));
            power = std::max(power, std::abs(static_cast<double>(value(lanes::power(lanes::set(x), lanes::set(e)))) - exact));
            const float r = -0.05f - 0.95f * static_cast<float>(j) / 200;
            const double exact_root = std::pow(1.0 + static_cast<double>(x), static_cast<double>(r));
            const float found = value(lanes::power(lanes::set(1.f + x), lanes::set(r)));
            root = std::max(root, std::abs(static_cast<double>(found) / exact_root - 1) - 6e-8);  // 1 + x is rounded
        }
    EXPECT_LE(power, k_power_error);
    EXPECT_LE(root, k_root_error);
    // Not so far that the constants say nothing.
    EXPECT_GE(2 * power, k_power_error);
    EXPECT_GE(2 * root, k_root_error);
}

TEST(NormalPower, AnglesAreAsNearAsTheySay)
{
    double sine = 0, angle = 0;
    for (int i = -100000; i <= 100000; ++i) {
        const float a = 3.14159265f * static_cast<float>(i) / 100000;
        const lanes::SineCosine found = lanes::sine_cosine(lanes::set(a));
        const auto exact = static_cast<double>(a);
        sine = std::max({sine, std::abs(static_cast<double>(value(found.sine)) - std::sin(exact)),
                         std::abs(static_cast<double>(value(found.cosine)) - std::cos(exact))});
        const auto x = static_cast<float>(std::cos(exact)), y = static_cast<float>(std::sin(exact));
        const double back = std::atan2(static_cast<double>(y), static_cast<double>(x));
        angle = std::max(angle, std::abs(static_cast<double>(value(lanes::angle_of(lanes::set(y), lanes::set(x)))) - back));
    }
    EXPECT_LE(sine, k_angle_error);
    EXPECT_LE(angle, k_angle_error);
}

shape::Superquadricd random_shape(test::Random& random)
{
    shape::Superquadricd sq;
    sq.a = {random.between(0.3, 1), random.between(0.3, 1), random.between(0.3, 1)};
    sq.eps1 = random.between(0.1, 2);
    sq.eps2 = random.between(0.1, 2);
    sq.rotation = test::rotation_about(random.direction(), random.between(0, 3));
    sq.translation = random.in_box({-1, -1, -1}, {1, 1, 1});
    const double kind = random.between(0, 3);
    if (kind < 1) {
        sq.taper_x = random.between(-0.6, 0.6);
        sq.taper_y = random.between(-0.6, 0.6);
    } else if (kind < 2) {
        sq.bend = random.between(0.05, 1.0);
        sq.bend_angle = random.between(-3, 3);
    }
    return shape::cast<double>(shape::cast<float>(sq));
}

// A point that the certificate proves to be inside is held, whatever powers lose.
TEST(NormalPower, NoPointOfASuperquadricIsOutside)
{
    test::Random random(91);
    double max = 0;
    for (int n = 0; n < 300; ++n) {
        const shape::Superquadricd sq = random_shape(random);
        const lanes::SuperquadricLanes part(shape::cast<float>(sq));
        for (int i = 0; i < 200; ++i) {
            const shape::SurfaceAngles<double> at{random.between(-pi / 2, pi / 2), random.between(-pi, pi)};
            const Vec3f p = cast<float>(shape::surface_point(sq, at).point);
            const lanes::V3 v{lanes::set(p.x), lanes::set(p.y), lanes::set(p.z)};
            lanes::F gauge;
            (void)part.through(part.to_unit(part.to_local(v)), gauge);
            const double exact = std::sqrt(shape::implicit(sq, cast<double>(p)));
            max = std::max(max, static_cast<double>(value(gauge)) - exact);
        }
    }
    EXPECT_LE(max, static_cast<double>(k_gauge_error));
}

}  // namespace
}  // namespace sqmap::query
