// Kernels for many points at once give the bits of the functions of one, on every set of instructions that the machine has.
#include "fit/problems.h"
#include "fit/support.h"
#include "fit/undeformed_points.h"

#include "unit/fit/shapes.h"

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <random>
#include <vector>

namespace sqmap::fit {
namespace {

using namespace test;

/// Calls test() with each set of instructions alone.
template <class Test>
void on_each_instruction_set(Test&& test)
{
    int sets = 0;
    for (std::int64_t left = hwy::SupportedTargets() & HWY_TARGETS; left != 0; left &= left - 1, ++sets) {
        hwy::SetSupportedTargetsForTest(left & -left);
        test();
    }
    hwy::SetSupportedTargetsForTest(0);
    EXPECT_GT(sets, 0);
}

/// Points within about twice the unit box; some on its planes of symmetry. Their number is no multiple of a vector's length.
std::vector<Vec3d> points_about(std::mt19937& random, std::size_t count)
{
    std::vector<Vec3d> points;
    for (std::size_t i = 0; i < count; ++i) {
        Vec3d p{uniform(random, -2, 2), uniform(random, -2, 2), uniform(random, -2, 2)};
        if (i % 7 == 0) p[static_cast<int>(i % 3)] = 0;
        points.push_back(p);
    }
    return points;
}

/// Plain, tapered, bent and both; some far enough from the middle of the bend that points lie beyond its centre.
std::vector<shape::Superquadricd> superquadrics(std::mt19937& random)
{
    std::vector<shape::Superquadricd> shapes;
    for (int i = 0; i < 40; ++i) {
        shape::Superquadricd sq;
        for (int k = 0; k < 3; ++k) {
            sq.a[k] = uniform(random, 0.1, 1.5);
            sq.translation[k] = i % 5 == 0 ? 0 : uniform(random, -0.5, 0.5);
        }
        sq.eps1 = uniform(random, 0.1, 2);
        sq.eps2 = uniform(random, 0.1, 2);
        if (i % 3 != 0) sq.rotation = shape::rotation_of(shape::EulerAngles<double>{uniform(random, -3, 3), 1, 2});
        if (i % 2 == 1) sq.taper_x = uniform(random, -0.9, 0.9), sq.taper_y = uniform(random, -0.9, 0.9);
        if (i % 4 >= 2) sq.bend = uniform(random, 0.01, 1.2), sq.bend_angle = uniform(random, -3, 3);
        shapes.push_back(sq);
    }
    return shapes;
}

TEST(ManyPoints, AreUndeformedAndBoundedAsOneIs)
{
    std::mt19937 random(5);
    const std::vector<Vec3d> points = points_about(random, 203);
    for (const shape::Superquadricd& sq : superquadrics(random)) {
        const PowerFreeBound bound(sq);
        on_each_instruction_set([&] {
            UndeformedPoints at;
            at.take(sq, points);
            ASSERT_EQ(at.points().size(), points.size());
            for (std::size_t i = 0; i < points.size(); ++i) {
                const Vec3d u = undeformed(sq, points[i]);
                ASSERT_EQ(at.points()[i], u) << i;
                ASSERT_EQ(at.bounds()[i], bound(u)) << i;
            }
        });
    }
}

TEST(ManyPoints, BoundsHoldTheNorm)
{
    std::mt19937 random(6);
    const std::vector<Vec3d> points = points_about(random, 1000);
    UndeformedPoints at;
    for (const shape::Superquadricd& sq : superquadrics(random)) {
        at.take(sq, points);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double f = std::sqrt(shape::implicit_undeformed(sq.a, sq.eps1, sq.eps2, at.points()[i]));
            ASSERT_GE(at.bounds()[i], f) << i;
        }
    }
}

TEST(ManyPoints, NoneAndFewAreTaken)
{
    std::mt19937 random(7);
    UndeformedPoints at;
    for (std::size_t count = 0; count < 18; ++count) {
        const std::vector<Vec3d> points = points_about(random, count);
        at.take({}, points);
        ASSERT_EQ(at.points().size(), count);
        ASSERT_TRUE(std::equal(points.begin(), points.end(), at.points().begin()));
    }
}

TEST(ManyPoints, LieBeyondPlanesAsOneDoes)
{
    std::mt19937 random(8);
    for (const std::size_t count : {0u, 1u, 7u, 64u, 203u}) {
        const std::vector<Vec3d> points = points_about(random, count);
        const Vec3d direction = normalized(Vec3d{uniform(random, -1, 1), uniform(random, -1, 1), 0.3});
        double greatest = -std::numeric_limits<double>::infinity();
        for (const Vec3d& p : points) greatest = std::max(greatest, dot(direction, p));
        const double offset = count > 3 ? dot(direction, points[3]) : 0;  // a point on the plane does not lie beyond it
        on_each_instruction_set([&] {
            EXPECT_EQ(greatest_along(direction, points), greatest);
            std::vector<std::uint64_t> words((count + 63) / 64, ~std::uint64_t{0});
            mark_beyond(direction, offset, points, words);
            std::size_t marked = 0;
            for (const std::uint64_t word : words) marked += static_cast<std::size_t>(std::popcount(word));
            for (std::size_t i = 0; i < count; ++i) {
                const bool is_beyond = dot(direction, points[i]) > offset;
                marked -= is_beyond ? 1 : 0;
                EXPECT_EQ((words[i / 64] >> (i % 64) & 1) != 0, is_beyond) << i;
            }
            EXPECT_EQ(marked, 0u);
        });
    }
}

}  // namespace
}  // namespace sqmap::fit
