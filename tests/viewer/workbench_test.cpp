// Compares what the workbench draws and does with closed forms of shapes that are known.
#include "sqmap/mesh/bvh.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/shape/surface.h"
#include "viewer/objects.h"
#include "viewer/server/scene/displacement.h"
#include "viewer/server/scene/edits.h"
#include "viewer/server/scene/fields.h"
#include "viewer/server/scene/geometry.h"
#include "viewer/server/scene/load.h"
#include "viewer/server/touch/tool.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>
#include <set>

namespace sqmap::viewer {
namespace {

std::shared_ptr<Object> baked(const mesh::Mesh& mesh, const char* name)
{
    AdmittedMesh j;
    j.admission = mesh::Admission::Accept;
    j.solid = true;
    j.mesh = mesh;
    return object_from_mesh(j, name, 0.2, {});
}
const std::shared_ptr<Object>& plain_ball()
{
    static const std::shared_ptr<Object> object = baked(mesh::sphere(1, 4), "ball");
    return object;
}
const std::shared_ptr<Object>& torus()
{
    static const std::shared_ptr<Object> object = baked(mesh::torus({.major_segments = 48, .minor_segments = 16}), "torus");
    return object;
}

TEST(Workbench, AConvexBodyHidesNothing)
{
    const std::string bytes = hidden_bytes(*plain_ball());
    ASSERT_EQ(bytes.size(), 8 + 4 * plain_ball()->mesh.triangles.size());
    for (std::size_t t = 0; t < plain_ball()->mesh.triangles.size(); ++t) EXPECT_LE(at<float>(bytes, 8 + 4 * t), 0) << t;
}

TEST(Workbench, HiddenAreaIsTheShareThatBakeMeasured)
{
    // Bake asks every n-th triangle of a part, this all of them. A ring's parts see almost all of their own: so does the measure.
    const Object& o = *torus();
    const std::string bytes = hidden_bytes(o);
    double hidden = 0, all = 0;
    for (std::uint32_t t = 0; t < o.mesh.triangles.size(); ++t) {
        all += mesh::triangle_area(o.mesh, t);
        if (at<float>(bytes, 8 + 4 * static_cast<std::size_t>(t)) == 1.f) hidden += mesh::triangle_area(o.mesh, t);
    }
    EXPECT_NEAR(100 * hidden / all, o.view.measured.q2_share, 1.5);
}

TEST(Workbench, SamplesLieOnTheSurface)
{
    // The ball is 0.2 m across; its corners lie on the sphere, and its faces cut off 0.2 % of the radius at most.
    const std::string bytes = sample_bytes(*plain_ball());
    const auto count = at<std::uint32_t>(bytes, 4);
    ASSERT_EQ(bytes.size(), 8 + 16 * static_cast<std::size_t>(count));
    EXPECT_GT(count, 100u);
    for (std::size_t i = 0; i < count; ++i) {
        Vec3d p;
        for (int k = 0; k < 3; ++k) p[k] = static_cast<double>(at<float>(bytes, 8 + 12 * i + 4 * static_cast<std::size_t>(k)));
        EXPECT_NEAR(norm(p - plain_ball()->position), 0.1, 4e-4);
        EXPECT_LT(at<std::uint32_t>(bytes, 8 + 12 * static_cast<std::size_t>(count) + 4 * i), plain_ball()->view.parts.size());
    }
}

TEST(Workbench, TheOffsetMovesOutwardsByAtMostItsLimit)
{
    const Object& o = *torus();
    const std::string bytes = offset_bytes(o);
    ASSERT_EQ(bytes.size(), 8 + 4 * o.mesh.vertices.size());
    int moved = 0;
    for (std::size_t v = 0; v < o.mesh.vertices.size(); ++v) {
        const auto by = static_cast<double>(at<float>(bytes, 8 + 4 * v));
        EXPECT_GE(by, 0);
        EXPECT_LE(by, 0.021 * 0.2);  // bake bounds it at 2 % of R_max
        if (by > 1e-5) ++moved;
    }
    EXPECT_GT(moved, 0);
}

TEST(Workbench, AMovedCutGivesTrianglesToOnePartAndKeepsAllConnected)
{
    const Object& o = *torus();
    const auto neighbours = neighbours_of(o, o.parts.partition);
    ASSERT_FALSE(neighbours[0].empty());
    const std::uint32_t other = neighbours[0][0];
    std::size_t before = 0;
    for (const double distance : {0.0, 0.004, 0.01}) {
        const auto moved = moved_cut(o, o.parts.partition, 0, other, distance);
        ASSERT_TRUE(moved);
        std::size_t taken = 0;
        for (std::size_t t = 0; t < moved->part_of_triangle.size(); ++t) {
            const std::uint32_t was = o.parts.partition.part_of_triangle[t], is = moved->part_of_triangle[t];
            if (was == is) continue;
            EXPECT_EQ(was, other);
            EXPECT_EQ(is, 0u);
            ++taken;
        }
        EXPECT_GT(taken, before) << distance;  // farther takes more
        before = taken;
        const Parts parts = fitted(o, *moved, &o.parts, {});
        EXPECT_EQ(parts.partition.part_count, o.parts.partition.part_count);
        const auto after = rebaked(o, parts, {}, {});  // refuses what is not connected
        EXPECT_EQ(after->parts.partition.part_of_triangle, moved->part_of_triangle);
    }
    EXPECT_FALSE(moved_cut(o, o.parts.partition, 0, other, 1.0)) << "nothing would be left";
    for (std::uint32_t p = 1; p < o.parts.partition.part_count; ++p)
        if (std::find(neighbours[0].begin(), neighbours[0].end(), p) == neighbours[0].end()) {
            EXPECT_FALSE(moved_cut(o, o.parts.partition, 0, p, 0.004)) << "they do not touch";
        }
}

TEST(Workbench, ARefitChangesOnePartAlone)
{
    const Object& o = *torus();
    const Parts parts = refitted(o, o.parts, 1);
    EXPECT_LE(parts.largest_f[1], 1);
    for (const std::uint32_t p : {0u, 2u}) EXPECT_EQ(parts.superquadrics[p].a, o.parts.superquadrics[p].a);
}

TEST(Displacement, LeadsFromTheSuperquadricToTheMesh)
{
    const Object& o = *torus();
    const mesh::Bvh bvh(o.mesh);
    const double metres = o.view.header.unit * o.metres_per_unit;
    for (std::uint32_t part = 0; part < 2; ++part) {
        const Displacement map = displacement_of(o, o.parts, part, 32, 16);
        int hits = 0;
        for (int row = 0; row < 16; ++row)
            for (int column = 0; column < 32; ++column) {
                const auto below = static_cast<double>(map.below[static_cast<std::size_t>(32 * row + column)]);
                if (below < 0) continue;
                EXPECT_LE(below, static_cast<double>(map.max));
                const auto from = shape::surface_point(
                    o.parts.superquadrics[part], shape::SurfaceAngles<double>{std::numbers::pi * (0.5 - (row + 0.5) / 16),
                                                                              std::numbers::pi * (2 * (column + 0.5) / 32 - 1)});
                // Within a texel where the ray was nudged; else to rounding.
                EXPECT_LT(bvh.closest_point(from.point - below / metres * from.normal).distance, 0.02);
                ++hits;
            }
        EXPECT_GT(hits, 100);
    }
}

TEST(Displacement, ItsPictureSaysHowLargeItIs)
{
    const std::string png = displacement_png({.width = 3, .height = 2, .below = {0, 0.5f, 1, -1, -1, 0.25f}, .max = 1});
    EXPECT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1a\n");
    EXPECT_EQ(png.substr(12, 4), "IHDR");
    const auto big = [&](std::size_t i) {
        return static_cast<unsigned char>(png[i + 3]) + 256u * static_cast<unsigned char>(png[i + 2]);
    };
    EXPECT_EQ(big(16), 3u);
    EXPECT_EQ(big(20), 2u);
    EXPECT_EQ(png[24], 16);  // bits
    EXPECT_EQ(png[25], 4);   // grey and alpha
}

TEST(Displacement, TheSheetFacesOutwardAndIsClosed)
{
    const Object& o = *plain_ball();
    const Sheet sheet = superquadric_sheet(o, o.parts.superquadrics[0], 12, 24);
    ASSERT_EQ(sheet.corners.size(), 3u * 2 * 24 * 11);
    double volume = 0;
    for (std::size_t i = 0; i < sheet.corners.size(); i += 3) {
        const Vec3d a = cast<double>(sheet.positions[sheet.corners[i]] - cast<float>(o.position)),
                    b = cast<double>(sheet.positions[sheet.corners[i + 1]] - cast<float>(o.position)),
                    c = cast<double>(sheet.positions[sheet.corners[i + 2]] - cast<float>(o.position));
        volume += dot(a, cross(b, c)) / 6;
    }
    const double whole = 4 * std::numbers::pi / 3 * 1e-3;  // of the ball that it holds, 0.1 m
    EXPECT_GT(volume, 0.9 * whole);
    EXPECT_LT(volume, 1.2 * whole);
}

TEST(Tool, IsAsLargeAsAskedAboutItsCentre)
{
    for (const ToolKind kind : {ToolKind::Hand, ToolKind::Mesh}) {
        const Tool tool = make_tool({.tool = kind, .tool_size = 0.08}, torus().get());
        Vec3d lo{1e9, 1e9, 1e9}, hi = -1.0 * lo;
        for (const Vec3d& v : tool.mesh.vertices)
            for (int k = 0; k < 3; ++k) {
                lo[k] = std::min(lo[k], v[k]);
                hi[k] = std::max(hi[k], v[k]);
            }
        EXPECT_NEAR(std::max({hi.x - lo.x, hi.y - lo.y, hi.z - lo.z}), 0.08, 1e-3);
        EXPECT_NEAR(norm(lo + hi), 0, 1e-3);
        EXPECT_LE(tool.mesh.vertices.size(), k_max_tool_points);
        double area = 0;
        for (const float w : tool.weights) area += static_cast<double>(w);
        EXPECT_NEAR(area, mesh::surface_area(tool.mesh), 1e-5 * area);
    }
    const std::string bytes = tool_bytes(make_tool({}, nullptr));
    EXPECT_EQ(bytes.substr(0, 4), "SQT1");
}

TEST(Tool, TurnsAboutTheUpwardAxisThenTilts)
{
    // The torus lies in the plane of x and y; turned by 90 degrees it stands in that of y and z.
    const Tool turned = make_tool({.tool = ToolKind::Mesh, .tool_size = 0.08, .tool_turn = 90}, torus().get());
    const Tool tilted = make_tool({.tool = ToolKind::Mesh, .tool_size = 0.08, .tool_tilt = 90}, torus().get());
    double x = 0, y = 0;
    for (const Vec3d& v : turned.mesh.vertices) x = std::max(x, std::abs(v.x));
    for (const Vec3d& v : tilted.mesh.vertices) y = std::max(y, std::abs(v.y));
    // 0.25 of 2.5 across: a tenth of the size to each side.
    EXPECT_NEAR(x, 0.008, 1e-4);
    EXPECT_NEAR(y, 0.008, 1e-4);
}

TEST(Tool, ALargeMeshIsThinnedAndKeepsItsPlace)
{
    const std::shared_ptr<Object> fine = baked(mesh::sphere(1, 1), "fine");
    fine->mesh = mesh::sphere(1, 5);  // a tool is made of the mesh alone
    ASSERT_GT(fine->mesh.vertices.size(), k_max_tool_points);
    const Tool tool = make_tool({.tool = ToolKind::Mesh, .tool_size = 0.1}, fine.get());
    EXPECT_LE(tool.mesh.vertices.size(), k_max_tool_points);
    EXPECT_GT(tool.mesh.vertices.size(), k_max_tool_points / 4);
    for (const Vec3d& v : tool.mesh.vertices) EXPECT_NEAR(norm(v), 0.05, 5e-4);
}

}  // namespace
}  // namespace sqmap::viewer
