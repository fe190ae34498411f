// Bad input to the C interface has a code, an element and a cure; structs of older and newer headers are taken.
#include "capi/fixture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

namespace sqmap {
namespace {

using test::Capi;
using test::expect_refused;
using test::k_nan;

TEST_F(Capi, StructsOfOtherHeadersAreTaken)
{
    const sqmap_points in = points();
    std::vector<double> distance(points_.size());
    // A shorter struct: what it lacks has its default, and nothing is written behind it.
    struct Shorter {
        std::size_t size;
        double* distance;
        std::uint64_t behind;
    } shorter{2 * sizeof(std::size_t), distance.data(), 0x1234567890abcdef};
    EXPECT_EQ(sqmap_signed_distances(model_, &in, nullptr, reinterpret_cast<sqmap_distances*>(&shorter)), SQMAP_OK);
    EXPECT_EQ(shorter.behind, 0x1234567890abcdefu);
    // A longer one whose unknown member is zero is taken, another is not.
    struct Longer {
        sqmap_query_options known;
        std::uint64_t unknown;
    } longer{};
    longer.known.size = sizeof longer;
    sqmap_distances out{sizeof out, distance.data(), nullptr, nullptr, nullptr, nullptr, nullptr, nullptr};
    EXPECT_EQ(sqmap_signed_distances(model_, &in, &longer.known, &out), SQMAP_OK);
    longer.unknown = 1;
    expect_refused(sqmap_signed_distances(model_, &in, &longer.known, &out), SQMAP_E_ARGUMENT, "options");
    longer.known.size = 0;
    expect_refused(sqmap_signed_distances(model_, &in, &longer.known, &out), SQMAP_E_ARGUMENT, "options.size");
}

TEST_F(Capi, BadArgumentsAreNamed)
{
    const sqmap_points in = points();
    sqmap_contacts out{};
    out.size = sizeof out;
    expect_refused(sqmap_query_points(model_, nullptr, nullptr, &out), SQMAP_E_ARGUMENT, "points");
    expect_refused(sqmap_query_points(model_, &in, nullptr, nullptr), SQMAP_E_ARGUMENT, "contacts");
    sqmap_points none = in;
    none.xyz = nullptr;
    expect_refused(sqmap_query_points(model_, &none, nullptr, &out), SQMAP_E_ARGUMENT, "points.xyz");
    const sqmap_pose scaled{{2, 0, 0, 0, 2, 0, 0, 0, 2}, {0, 0, 0}}, lost{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, k_nan, 0}};
    sqmap_points posed = in;
    posed.pose = &scaled;
    expect_refused(sqmap_query_points(model_, &posed, nullptr, &out), SQMAP_E_ARGUMENT, "points.pose.rotation");
    posed.pose = &lost;
    expect_refused(sqmap_query_points(model_, &posed, nullptr, &out), SQMAP_E_ARGUMENT, "points.pose.translation[1]");
    expect_refused(sqmap_open(nullptr, &model_), SQMAP_E_ARGUMENT, "path");
    EXPECT_EQ(model_.id, 0u);
    expect_refused(sqmap_open("model.sqmap", nullptr), SQMAP_E_ARGUMENT, "model");
    expect_refused(sqmap_open("there/is/none.sqmap", &model_), SQMAP_E_FILE, "there/is/none.sqmap");
    expect_refused(sqmap_open_archived(nullptr, "", &model_), SQMAP_E_ARGUMENT, "archive");
    expect_refused(sqmap_open_archived("a.tar", nullptr, &model_), SQMAP_E_ARGUMENT, "key");
    expect_refused(sqmap_open_archived("there/is/none.tar", "", &model_), SQMAP_E_FILE, "there/is/none.tar");
    expect_refused(sqmap_save({42}, "model.sqmap"), SQMAP_E_HANDLE, "model");
}

TEST_F(Capi, RotationsAreMendedWithinTheTolerance)
{
    points_[17].y = 0;
    const double angle = 0.7, c = std::cos(angle), s = std::sin(angle);
    const sqmap_pose exact{{c, -s, 0, s, c, 0, 0, 0, 1}, {0.1, 0, 0}};
    const auto distances_with = [&](double off) {
        sqmap_pose pose = exact;
        pose.rotation[0] += off;
        pose.rotation[5] -= off;
        sqmap_points in = points();
        in.pose = &pose;
        std::vector<double> distance(points_.size());
        sqmap_closest out{sizeof out, nullptr, distance.data(), nullptr};
        EXPECT_EQ(sqmap_closest_points(model_, &in, nullptr, &out), SQMAP_OK) << sqmap_last_error()->message;
        return distance;
    };
    // Below 1e-6 a rotation is taken bit for bit as it is given.
    const double tiny = 3e-7;
    const Pose back = inverse(Pose{{{{c + tiny, -s, 0}, {s, c, -tiny}, {0, 0, 1}}}, {0.1, 0, 0}});
    std::vector<Vec3d> own;
    for (const Vec3d p : points_) own.push_back(apply(back, p));
    const sqmap_points in_own{sizeof in_own, &own[0].x, own.size(), nullptr};
    std::vector<double> expected(own.size());
    sqmap_closest answer{sizeof answer, nullptr, expected.data(), nullptr};
    ASSERT_EQ(sqmap_closest_points(model_, &in_own, nullptr, &answer), SQMAP_OK);
    EXPECT_EQ(distances_with(tiny), expected);
    // Above, it is made orthonormal.
    const double large = 5e-5;
    const std::vector<double> mended = distances_with(large), straight = distances_with(0);
    for (std::size_t i = 0; i < mended.size(); ++i) EXPECT_NEAR(mended[i], straight[i], 4 * large);
    sqmap_pose pose = exact;
    pose.rotation[0] += large;
    pose.rotation[5] -= large;
    sqmap_points in = points();
    in.pose = &pose;
    std::vector<Vec3d> closest(points_.size());
    sqmap_closest out{sizeof out, &closest[0].x, nullptr, nullptr};
    ASSERT_EQ(sqmap_closest_points(model_, &in, nullptr, &out), SQMAP_OK);
    for (std::size_t i = 0; i < mended.size(); ++i) EXPECT_NEAR(norm(closest[i] - points_[i]), mended[i], 1e-12);
    pose = exact;
    pose.rotation[0] += 2e-4;
    expect_refused(sqmap_closest_points(model_, &in, nullptr, &out), SQMAP_E_ARGUMENT, "points.pose.rotation");
    EXPECT_NE(std::string(sqmap_last_error()->message).find("the tolerance is 0.0001"), std::string::npos);
    pose = exact;
    pose.rotation[4] = k_nan;
    expect_refused(sqmap_closest_points(model_, &in, nullptr, &out), SQMAP_E_ARGUMENT, "points.pose.rotation[4]");
    EXPECT_STREQ(sqmap_last_error()->message, "is NaN");
}

TEST_F(Capi, BytesThatAreNoModelAreRefused)
{
    const std::vector<std::byte>& whole = bytes_;
    sqmap_model model{};
    for (const std::size_t size : {std::size_t{0}, std::size_t{7}, whole.size() / 2, whole.size() - 1}) {
        expect_refused(sqmap_open_bytes(whole.data(), size, &model), SQMAP_E_MODEL, "bytes");
        EXPECT_EQ(model.id, 0u);
    }
    expect_refused(sqmap_open_bytes(nullptr, 8, &model), SQMAP_E_ARGUMENT, "bytes");
}

TEST_F(Capi, HandlesAreNotGivenTwice)
{
    sqmap_model first{}, second{};
    ASSERT_EQ(sqmap_open_bytes(bytes_.data(), bytes_.size(), &first), SQMAP_OK);
    ASSERT_EQ(sqmap_close_model(first), SQMAP_OK);
    ASSERT_EQ(sqmap_open_bytes(bytes_.data(), bytes_.size(), &second), SQMAP_OK);
    EXPECT_NE(first.id, second.id);
    expect_refused(sqmap_close_model(first), SQMAP_E_HANDLE, "model");
    expect_refused(sqmap_close_probe({second.id}), SQMAP_E_HANDLE, "probe");  // a model is no probe
    EXPECT_EQ(sqmap_close_model(second), SQMAP_OK);
    EXPECT_EQ(sqmap_close_model({0}), SQMAP_OK);
}

TEST_F(Capi, ErrorsBelongToTheirThread)
{
    expect_refused(sqmap_close_model({99}), SQMAP_E_HANDLE, "model");
    std::thread([] { EXPECT_EQ(sqmap_last_error()->code, SQMAP_OK); }).join();
    EXPECT_EQ(sqmap_last_error()->code, SQMAP_E_HANDLE);
}

}  // namespace
}  // namespace sqmap
