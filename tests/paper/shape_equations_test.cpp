// Equations 1, 8 to 10, 13 to 16 and 22 to 31 of the paper, as printed except where the errata corrects them.
#include "sqmap/shape/surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace sqmap::shape {
namespace {

using std::numbers::pi;
using Angles = SurfaceAngles<double>;

Superquadricd plain(double eps1, double eps2)
{
    Superquadricd sq;
    sq.a = {0.7, 1.1, 1.6};
    sq.eps1 = eps1;
    sq.eps2 = eps2;
    return sq;
}

template <class F>
void for_generic_cases(F&& body)
{
    for (double eps1 : {0.2, 0.6, 1.0, 1.5, 2.0})
        for (double eps2 : {0.2, 0.6, 1.0, 1.5, 2.0})
            for (double eta : {-1.1, -0.4, 0.3, 0.9})
                for (double omega : {-2.5, -0.9, 0.4, 1.2, 2.3}) body(plain(eps1, eps2), eta, omega);
}

TEST(Paper, Eq1InsideOutsideAgreesWithItsPrintedPowers)
{
    const Superquadricd sq = plain(0.6, 1.5);
    const double x = 0.3, y = 0.5, z = -0.9;
    const double inner = std::pow(std::pow(x / 0.7, 2 / 1.5) + std::pow(y / 1.1, 2 / 1.5), 1.5 / 0.6);
    EXPECT_NEAR(implicit(sq, Vec3d{x, y, z}), std::pow(inner + std::pow(0.9 / 1.6, 2 / 0.6), 0.6), 1e-13);
    EXPECT_LT(implicit(sq, Vec3d{0.1, 0.1, 0.1}), 1.0);
    EXPECT_GT(implicit(sq, Vec3d{0.7, 1.1, 1.6}), 1.0);
}

TEST(Paper, Eq8ParametricPointsSatisfyEq1)
{
    for_generic_cases([](const Superquadricd& sq, double eta, double omega) {
        EXPECT_NEAR(implicit(sq, printed::point(sq, eta, omega)), 1.0, 1e-10);
    });
}

TEST(Paper, Eq9And10TurnSpacedAnglesIntoThoseOfEq8)
{
    for_generic_cases([](const Superquadricd& sq, double eta, double omega) {
        // Literally: atan(sgn(tan) |tan|^(1/eps)), then pi added or subtracted by the quadrant of omega.
        const double raw_eta = std::atan(signed_power(std::tan(eta), 1 / sq.eps1));
        double raw_omega = std::atan(signed_power(std::tan(omega), 1 / sq.eps2));
        if (omega > pi / 2) raw_omega += pi;
        if (omega < -pi / 2) raw_omega -= pi;
        EXPECT_NEAR(parameter_of_spaced(eta, sq.eps1), raw_eta, 1e-12);
        EXPECT_NEAR(parameter_of_spaced(omega, sq.eps2), raw_omega, 1e-12);
        EXPECT_LT(norm(surface_point(sq, Angles{eta, omega}).point - printed::point(sq, raw_eta, raw_omega)), 1e-10);
    });
}

TEST(Paper, Eq9SpacesSamplesMoreEvenlyThanEq8Alone)
{
    for (double eps : {0.2, 0.5, 1.8}) {
        const auto spread = [&](auto&& at) {  // longest over shortest step along a meridian of 64 samples a quadrant
            double lo = 1e9, hi = 0;
            for (int i = 0; i < 64; ++i) {
                const double step = norm(at(pi / 2 * (i + 1) / 64) - at(pi / 2 * i / 64));
                lo = std::min(lo, step);
                hi = std::max(hi, step);
            }
            return hi / lo;
        };
        Superquadricd sq;
        sq.eps1 = eps;
        EXPECT_LT(2 * spread([&](double t) {
                      return surface_point(sq, Angles{t, 0.0}).point;
                  }),
                  spread([&](double t) { return printed::point(sq, t, 0.0); }));
    }
}

TEST(Paper, Eq13And14SuperellipseParametricPointsLieOnTheCurve)
{
    for (double eps : {0.2, 0.4, 1.0, 1.6, 2.0})
        for (double t = -3.1; t < 3.1; t += 0.31) {
            const Superellipse<double> se{1.0, 0.5, eps};
            EXPECT_NEAR(implicit(se, se.a1 * signed_power(std::cos(t), eps), se.a2 * signed_power(std::sin(t), eps)), 1.0, 1e-9);
        }
}

double brute_force_foot(const Superellipse<double>& se, double x, double y)
{
    double best = 1e9, at = 0;
    for (int i = 0; i < 40000; ++i) {
        const double t = 2 * pi * i / 40000 - pi;
        const Arc<double> arc = arc_through(std::cos(t), std::sin(t), se.eps);
        const double d = std::hypot(se.a1 * arc.c - x, se.a2 * arc.s - y);
        if (d < best) {
            best = d;
            at = t;
        }
    }
    return at;
}

// Points 3 % deep; their radial parameter theta_M against that of the foot, in the spaced angle (monotone in theta).
double wrong_share(double a2, double eps)
{
    const Superellipse<double> se{1.0, a2, eps};
    int wrong = 0, count = 0;
    for (int i = 0; i < 160; ++i) {
        const double t = 2 * pi * (i + 0.37) / 160 - pi;
        const Arc<double> arc = arc_through(std::cos(t), std::sin(t), eps);
        const double x = 0.97 * se.a1 * arc.c, y = 0.97 * se.a2 * arc.s;
        const double moved = std::remainder(brute_force_foot(se, x, y) - t, 2 * pi);
        const int predicted = predicted_direction(parameter_of_spaced(t, eps), eps);
        if (std::abs(moved) < 4 * pi / 40000 || predicted == 0) continue;
        ++count;
        wrong += (moved > 0) != (predicted > 0);
    }
    return static_cast<double>(wrong) / count;
}

TEST(Paper, Eq15And16PredictTheDirectionForEqualAxes)
{
    EXPECT_EQ(wrong_share(1.0, 0.4), 0.0);
    EXPECT_EQ(wrong_share(1.0, 1.6), 0.0);
}

TEST(Paper, Eq16FailsForUnequalAxesSoBothDirectionsAreSearched)
{
    EXPECT_GT(wrong_share(0.5, 0.4) + wrong_share(0.5, 1.6), 0.1);  // errata 5
}

TEST(Paper, Eq23And24CrossProductOfTangentsIsSTimesNd)
{
    for_generic_cases([](const Superquadricd& sq, double eta, double omega) {
        const Vec3d n = cross(printed::point_eta(sq, eta, omega), printed::point_omega(sq, eta, omega));
        const Vec3d expected = printed::normal_scale(sq, eta, omega) * printed::normal_direction(sq, eta, omega);
        EXPECT_LT(norm(n - expected), 1e-9 * norm(expected));
    });
}

TEST(Paper, Eq25ScaleIsNegativeSoEq24PointsInward)
{
    for_generic_cases([](const Superquadricd& sq, double eta, double omega) {
        EXPECT_LT(printed::normal_scale(sq, eta, omega), 0.0);  // errata 2
        const Vec3d nd = printed::normal_direction(sq, eta, omega);
        EXPECT_GT(dot(nd, printed::point(sq, eta, omega)), 0.0);
        const Angles spaced{spaced_of_parameter(eta, sq.eps1), spaced_of_parameter(omega, sq.eps2)};
        EXPECT_LT(norm(surface_point(sq, spaced).normal - normalized(nd)), 1e-8);
    });
}

TEST(Paper, Eq28TangentMatchesFiniteDifferences)
{
    const double h = 1e-6;
    for_generic_cases([&](const Superquadricd& sq, double eta, double omega) {
        const Vec3d fd = (printed::point(sq, eta + h, omega) - printed::point(sq, eta - h, omega)) / (2 * h);
        EXPECT_LT(norm(printed::point_eta(sq, eta, omega) - fd), 1e-6 * (1 + norm(fd)));
        const Vec3d fo = (printed::point(sq, eta, omega + h) - printed::point(sq, eta, omega - h)) / (2 * h);
        EXPECT_LT(norm(printed::point_omega(sq, eta, omega) - fo), 1e-6 * (1 + norm(fo)));
    });
}

TEST(Paper, Eq30CorrectedMatchesFiniteDifferences)
{
    const double h = 1e-6;
    for_generic_cases([&](const Superquadricd& sq, double eta, double omega) {
        const double fd = (printed::normal_scale(sq, eta + h, omega) - printed::normal_scale(sq, eta - h, omega)) / (2 * h);
        EXPECT_NEAR(printed::normal_scale_eta(sq, eta, omega), fd, 1e-5 * (1 + std::abs(fd)));
    });
}

TEST(Paper, Eq29And31MatchFiniteDifferences)
{
    const double h = 1e-6;
    for_generic_cases([&](const Superquadricd& sq, double eta, double omega) {
        const auto nd = [&](double e, double o) { return printed::normal_direction(sq, e, o); };
        const Vec3d fe = (nd(eta + h, omega) - nd(eta - h, omega)) / (2 * h);
        EXPECT_LT(norm(printed::normal_direction_eta(sq, eta, omega) - fe), 1e-6 * (1 + norm(fe)));
        const Vec3d fo = (nd(eta, omega + h) - nd(eta, omega - h)) / (2 * h);
        EXPECT_LT(norm(printed::normal_direction_omega(sq, eta, omega) - fo), 1e-6 * (1 + norm(fo)));
        const auto full = [&](double e) { return printed::normal_scale(sq, e, omega) * nd(e, omega); };
        const Vec3d product = printed::normal_scale_eta(sq, eta, omega) * nd(eta, omega) +
                              printed::normal_scale(sq, eta, omega) * printed::normal_direction_eta(sq, eta, omega);
        const Vec3d fd = (full(eta + h) - full(eta - h)) / (2 * h);
        EXPECT_LT(norm(product - fd), 1e-5 * (1 + norm(fd)));
    });
}

// A smooth distance over the surface stands for the map; S = r - D n is differentiated numerically for comparison.
TEST(Paper, Eq22To27NormalOfTheMappedSurfaceMatchesFiniteDifferences)
{
    const double h = 1e-5;
    const auto map = [](double e, double o) { return 0.1 + 0.03 * std::sin(2 * e) * std::cos(o); };
    for (double eps1 : {0.5, 1.0, 1.5})
        for (double eps2 : {0.5, 1.0, 1.5}) {
            Superquadricd sq = plain(eps1, eps2);
            sq.taper_x = 0.2;
            sq.bend = 0.2;
            for (double eta : {-1.1, -0.4, 0.3, 0.9})
                for (double omega : {-2.5, -0.9, 0.4, 1.2, 2.3}) {
                    const auto mapped = [&](double e, double o) {
                        const SurfacePoint<double> s = surface_point(sq, Angles{e, o});
                        return s.point - map(e, o) * s.normal;
                    };
                    const Vec3d se = mapped(eta + h, omega) - mapped(eta - h, omega);
                    const Vec3d so = mapped(eta, omega + h) - mapped(eta, omega - h);
                    const Vec3d n =
                        mapped_normal(surface_jet(sq, position_at(sq, Angles{eta, omega})), map(eta, omega),
                                      0.06 * std::cos(2 * eta) * std::cos(omega), -0.03 * std::sin(2 * eta) * std::sin(omega));
                    EXPECT_LT(norm(normalized(n) - normalized(cross(so, se))), 1e-5);
                }
        }
}

}  // namespace
}  // namespace sqmap::shape
