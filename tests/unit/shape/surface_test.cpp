#include "sqmap/shape/surface.h"

#include "support/superquadrics.h"

#include <gtest/gtest.h>

#include <numbers>

namespace sqmap::shape {
namespace {

using std::numbers::pi;
using Angles = SurfaceAngles<double>;

std::vector<Angles> generic_angles()
{
    std::vector<Angles> out;
    for (double eta : {-1.3, -0.8, -0.2, 0.35, 0.77, 1.2})
        for (double omega : {-2.9, -2.2, -1.1, -0.3, 0.6, 1.2, 2.0, 2.8}) out.push_back({eta, omega});
    return out;
}

TEST(Surface, ImplicitIsOneOnTheSurface)
{
    for (const Superquadricd& sq : test::sample_superquadrics())
        for (double eta : {-pi / 2, -1.0, 0.0, 0.5, pi / 4, pi / 2})
            for (double omega : {-pi, -pi / 2, -0.4, 0.0, pi / 4, pi / 2, 2.0})
                EXPECT_NEAR(implicit(sq, surface_point(sq, Angles{eta, omega}).point), 1.0, 1e-10);
}

TEST(Surface, AnglesOfAPlaceComeBack)
{
    for (const Superquadricd& sq : test::sample_superquadrics())
        for (const Angles a : generic_angles()) {
            double gauge = 0;
            const Angles b = angles_of(position_through(sq, surface_point(sq, a).point, &gauge));
            EXPECT_NEAR(b.eta, a.eta, 1e-9);
            EXPECT_NEAR(b.omega, a.omega, 1e-9);
            EXPECT_NEAR(gauge, 1.0, 1e-10);
        }
}

TEST(Surface, NormalIsUnitOutwardAndAcrossBothTangents)
{
    const double h = 1e-6;
    for (const Superquadricd& sq : test::sample_superquadrics())
        for (const Angles a : generic_angles()) {
            const SurfacePoint<double> s = surface_point(sq, a);
            const auto at = [&](double e, double o) { return surface_point(sq, Angles{a.eta + e, a.omega + o}).point; };
            EXPECT_NEAR(norm(s.normal), 1.0, 1e-12);
            EXPECT_NEAR(dot(s.normal, normalized(at(h, 0) - at(-h, 0))), 0.0, 1e-5);
            EXPECT_NEAR(dot(s.normal, normalized(at(0, h) - at(0, -h))), 0.0, 1e-5);
            EXPECT_GT(implicit(sq, s.point + 1e-4 * s.normal), 1.0);
            EXPECT_LT(implicit(sq, s.point - 1e-4 * s.normal), 1.0);
        }
}

TEST(Surface, JetMatchesFiniteDifferences)
{
    const double h = 1e-6;
    for (const Superquadricd& sq : test::sample_superquadrics())
        for (const Angles a : generic_angles()) {
            const SurfaceJet<double> jet = surface_jet(sq, position_at(sq, a));
            const auto at = [&](double e, double o) { return surface_point(sq, Angles{a.eta + e, a.omega + o}); };
            EXPECT_LT(norm(jet.point - at(0, 0).point), 1e-13);
            EXPECT_LT(norm(jet.normal - at(0, 0).normal), 1e-12);
            const SurfacePoint<double> n = at(h, 0), s = at(-h, 0), e = at(0, h), w = at(0, -h);
            const auto close = [&](Vec3d d, Vec3d plus, Vec3d minus) {
                const Vec3d fd = (plus - minus) / (2 * h);
                return norm(d - fd) <= 1e-6 * (1 + norm(fd));
            };
            EXPECT_TRUE(close(jet.point_eta, n.point, s.point)) << sq.eps1 << ' ' << sq.eps2;
            EXPECT_TRUE(close(jet.point_omega, e.point, w.point)) << sq.eps1 << ' ' << sq.eps2;
            EXPECT_TRUE(close(jet.normal_eta, n.normal, s.normal)) << sq.eps1 << ' ' << sq.eps2;
            EXPECT_TRUE(close(jet.normal_omega, e.normal, w.normal)) << sq.eps1 << ' ' << sq.eps2;
        }
}

TEST(Surface, GradientMatchesFiniteDifferencesOfF)
{
    const double h = 1e-6;
    for (const Superquadricd& sq : test::sample_superquadrics())
        for (const Angles a : generic_angles())
            for (double gauge : {0.4, 1.0, 1.1}) {
                // Scaled in the undeformed frame, where F is homogeneous.
                const Vec3d q = gauge * undeform(sq, to_local(sq, surface_point(sq, a).point));
                const Vec3d p = to_model(sq, deform(sq, q));
                const Vec3d g = implicit_gradient(sq, p);
                for (int i = 0; i < 3; ++i) {
                    Vec3d d{};
                    d[i] = h;
                    EXPECT_NEAR(g[i], (implicit(sq, p + d) - implicit(sq, p - d)) / (2 * h), 1e-5 * (1 + norm(g)));
                }
            }
}

TEST(Surface, PolesAndOctantPlanesAreFiniteInFloat)
{
    constexpr float half = std::numbers::pi_v<float> / 2;
    for (float eps1 : {0.1f, 0.5f, 1.0f, 1.5f, 2.0f})
        for (float eps2 : {0.1f, 0.5f, 1.0f, 1.5f, 2.0f}) {
            Superquadricf sq;
            sq.a = {0.5f, 1.0f, 2.0f};
            sq.eps1 = eps1;
            sq.eps2 = eps2;
            for (float eta : {-half, 0.0f, half})
                for (float omega : {-2 * half, -half, 0.0f, half, 2 * half}) {
                    const SurfaceJet<float> jet = surface_jet(sq, position_at(sq, SurfaceAnglesf{eta, omega}));
                    for (const Vec3f v :
                         {jet.point, jet.normal, jet.point_eta, jet.point_omega, jet.normal_eta, jet.normal_omega})
                        EXPECT_TRUE(std::isfinite(norm(v)));
                    EXPECT_NEAR(norm(jet.normal), 1.0f, 1e-5f);
                    EXPECT_GT(dot(jet.normal, jet.point), 0.0f);
                }
        }
}

TEST(Surface, FloatNormalsAgreeWithDouble)
{
    for (const Superquadricd& sq : test::sample_superquadrics(false)) {
        Superquadricf f;
        f.a = cast<float>(sq.a);
        f.eps1 = static_cast<float>(sq.eps1);
        f.eps2 = static_cast<float>(sq.eps2);
        Superquadricd d = sq;
        d.rotation = {};
        d.translation = {};
        for (const Angles a : generic_angles()) {
            const auto sf = surface_point(f, SurfaceAnglesf{static_cast<float>(a.eta), static_cast<float>(a.omega)});
            const auto sd = surface_point(d, a);
            EXPECT_LT(norm(cast<double>(sf.point) - sd.point), 1e-5);
            EXPECT_LT(norm(cast<double>(sf.normal) - sd.normal), 1e-4);
        }
    }
}

}  // namespace
}  // namespace sqmap::shape
