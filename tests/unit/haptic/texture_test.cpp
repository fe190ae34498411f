#include "sqmap/haptic/texture.h"

#include "support/baked_shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sqmap::haptic {
namespace {

TEST(Texture, NoiseHasItsAmplitudeAndStaysBelowTheSurface)
{
    std::vector<float> values;
    const Texture t = gaussian_texture({.seed = 4, .amplitude = 0.0002, .wavelength = 0.002}, values);
    sqmap::test::Random random(1);
    double sum = 0, squares = 0;
    constexpr int n = 20000;
    for (int i = 0; i < n; ++i) {
        const double h = relief_at(t, random.in_box({-1, -1, -1}, {1, 1, 1}), {0, 0, 1}).height;
        EXPECT_LE(h, 0);
        sum += h / n, squares += h * h / n;
    }
    EXPECT_NEAR(std::sqrt(squares - sum * sum), 0.0002, 0.00001);
}

TEST(Texture, TheSameSeedGivesTheSameTableAndAnotherAnother)
{
    std::vector<float> a, b, c;
    (void)gaussian_texture({.seed = 4}, a);
    (void)gaussian_texture({.seed = 4}, b);
    (void)gaussian_texture({.seed = 5}, c);
    EXPECT_EQ(a, b);
    EXPECT_NE(a, c);
}

TEST(Texture, GradientMatchesFiniteDifferences)
{
    std::vector<float> noise, image;
    std::vector<std::uint8_t> grey;
    for (int i = 0; i < 256; ++i) grey.push_back(static_cast<std::uint8_t>((i * 37) % 256));
    const Texture textures[] = {gaussian_texture({}, noise), image_texture(grey, {}, image)};
    sqmap::test::Random random(2);
    for (const Texture& t : textures)
        for (int i = 0; i < 200; ++i) {
            const Vec3d p = random.in_box({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}), n = random.direction();
            const Relief r = relief_at(t, p, n);
            for (int axis = 0; axis < 3; ++axis) {
                Vec3d h{};
                h[axis] = 1e-7;
                const double slope = (relief_at(t, p + h, n).height - relief_at(t, p - h, n).height) / 2e-7;
                EXPECT_NEAR(r.gradient[axis], slope, 1e-3 * norm(r.gradient) + 1e-6);
            }
        }
}

TEST(Texture, RepeatsAndHasNoSeam)
{
    std::vector<float> values;
    const Texture t = gaussian_texture({.wavelength = 0.004, .n = 16}, values);
    const double period = 16 * t.step;
    sqmap::test::Random random(3);
    for (int i = 0; i < 100; ++i) {
        const Vec3d p = random.in_box({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1});
        EXPECT_NEAR(relief_at(t, p, {}).height, relief_at(t, p + Vec3d{period, -2 * period, 3 * period}, {}).height, 1e-9);
    }
    for (int k = -40; k < 40; ++k) {  // across every border of cells
        const Vec3d p{(k + 0.5) * t.step, 0.001, 0.002};
        const Relief a = relief_at(t, p - Vec3d{1e-9, 0, 0}, {}), b = relief_at(t, p + Vec3d{1e-9, 0, 0}, {});
        EXPECT_NEAR(a.height, b.height, 1e-8);
        EXPECT_LT(norm(a.gradient - b.gradient), 1e-4);
    }
}

TEST(Texture, AnImageIsCarvedByItsDarkness)
{
    std::vector<std::uint8_t> grey(64, 255);
    std::vector<float> values;
    Texture t = image_texture(grey, {.depth = 0.001, .step = 0.01}, values);
    EXPECT_NEAR(relief_at(t, {0.02, 0.03, 0}, {0, 0, 1}).height, 0, 1e-12);
    grey.assign(64, 0);
    t = image_texture(grey, {.depth = 0.001, .step = 0.01}, values);
    EXPECT_NEAR(relief_at(t, {0.02, 0.03, 0}, {0, 0, 1}).height, -0.001, 1e-9);
    EXPECT_EQ(image_texture(std::vector<std::uint8_t>(63), {}, values).n, 0u);  // not a square
}

TEST(Texture, ProceduralReliefIsWhatItsFunctionSays)
{
    std::vector<float> values;
    const Texture t = procedural_texture(
        [](double x, double, double) { return -0.001 * (1 - std::cos(2 * 3.141592653589793 * x)); }, 32, 0.001, values);
    // Splines of 32 points a wave: half a per cent of smoothing.
    EXPECT_NEAR(relief_at(t, {0.016, 0, 0}, {}).height, -0.002, 2e-5);
    EXPECT_NEAR(relief_at(t, {0.0, 0.5, 0.1}, {}).height, 0, 2e-5);
}

TEST(Texture, WhatIsNotThereIsFlat)
{
    const double nan = std::nan("");
    std::vector<float> values;
    Texture t = gaussian_texture({}, values);
    EXPECT_EQ(relief_at(t, {nan, 0, 0}, {}).height, 0);
    EXPECT_EQ(relief_at({}, {}, {}).height, 0);
    t.values = t.values.first(5);
    EXPECT_EQ(relief_at(t, {}, {}).height, 0);
}

}  // namespace
}  // namespace sqmap::haptic
