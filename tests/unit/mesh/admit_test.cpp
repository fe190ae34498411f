#include "sqmap/mesh/admission.h"
#include "support/repaired.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

namespace sqmap::mesh {
namespace {

struct Polygons {
    std::vector<Vec3d> positions;
    std::vector<std::uint32_t> offsets{0};
    std::vector<std::int64_t> indices;

    void add(std::initializer_list<std::int64_t> corners)
    {
        indices.insert(indices.end(), corners);
        offsets.push_back(static_cast<std::uint32_t>(indices.size()));
    }
    void add(const Polygons& other)
    {
        const auto base = static_cast<std::int64_t>(positions.size());
        positions.insert(positions.end(), other.positions.begin(), other.positions.end());
        for (std::size_t f = 0; f + 1 < other.offsets.size(); ++f) {
            for (std::uint32_t i = other.offsets[f]; i < other.offsets[f + 1]; ++i) indices.push_back(base + other.indices[i]);
            offsets.push_back(static_cast<std::uint32_t>(indices.size()));
        }
    }
    void reverse()
    {
        for (std::size_t f = 0; f + 1 < offsets.size(); ++f)
            std::reverse(indices.begin() + offsets[f], indices.begin() + offsets[f + 1]);
    }
};

/// Without cures, unless options allow them: their tests are in mesh/close.
AdmitResult judge(const Polygons& p, const AdmitOptions& options = {.repair = Repair::Safe})
{
    return admit({p.positions, p.offsets, p.indices}, options);
}
Refusal code(const Polygons& p, const AdmitOptions& options = {.repair = Repair::Safe})
{
    return judge(p, options).diagnosis.code;
}

bool warned(const AdmitResult& result, WarningKind kind)
{
    return std::any_of(result.warnings.begin(), result.warnings.end(), [&](const Warning& w) { return w.kind == kind; });
}

/// Axis-aligned box of triangles, outward.
Polygons polygon_box(Vec3d lo, Vec3d hi)
{
    Polygons p;
    for (int i = 0; i < 8; ++i) p.positions.push_back({i & 1 ? hi.x : lo.x, i & 2 ? hi.y : lo.y, i & 4 ? hi.z : lo.z});
    for (const auto& q : {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
        p.add({q[0], q[1], q[2]});
        p.add({q[0], q[2], q[3]});
    }
    return p;
}
Polygons polygon_cube() { return polygon_box({0, 0, 0}, {1, 1, 1}); }

/// Unit sphere of rings and sectors; its caps are fans.
Polygons polygon_sphere(int rings, int sectors)
{
    Polygons p;
    p.positions.push_back({0, 0, 1});
    for (int r = 1; r < rings; ++r)
        for (int s = 0; s < sectors; ++s) {
            const double theta = std::numbers::pi * r / rings, phi = 2 * std::numbers::pi * s / sectors;
            p.positions.push_back({std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)});
        }
    p.positions.push_back({0, 0, -1});
    const auto at = [&](int r, int s) { return 1 + (r - 1) * sectors + s % sectors; };
    const int last = static_cast<int>(p.positions.size()) - 1;
    for (int s = 0; s < sectors; ++s) {
        p.add({0, at(1, s), at(1, s + 1)});
        for (int r = 1; r + 1 < rings; ++r) {
            p.add({at(r, s), at(r + 1, s), at(r + 1, s + 1)});
            p.add({at(r, s), at(r + 1, s + 1), at(r, s + 1)});
        }
        p.add({last, at(rings - 1, s + 1), at(rings - 1, s)});
    }
    return p;
}

void remove_face(Polygons& p, std::size_t face)
{
    const auto first = p.indices.begin() + p.offsets[face], last = p.indices.begin() + p.offsets[face + 1];
    const auto size = static_cast<std::uint32_t>(last - first);
    p.indices.erase(first, last);
    p.offsets.erase(p.offsets.begin() + static_cast<std::ptrdiff_t>(face) + 1);
    for (std::size_t f = face + 1; f < p.offsets.size(); ++f) p.offsets[f] -= size;
}

TEST(Gate, ACubeIsAcceptedAndKnown)
{
    const AdmitResult result = judge(polygon_cube());
    EXPECT_EQ(result.admission, Admission::Accept);
    EXPECT_TRUE(result.solid);
    EXPECT_TRUE(result.repairs.empty());
    EXPECT_TRUE(result.warnings.empty());
    EXPECT_EQ(result.facts.component_count, 1u);
    EXPECT_EQ(result.facts.genus, 0);
    EXPECT_NEAR(result.facts.volume, 1, 1e-12);
    EXPECT_NEAR(result.facts.area, 6, 1e-12);
    EXPECT_EQ(result.facts.box.hi, (Vec3d{1, 1, 1}));
}

TEST(Gate, IndicesOutOfRangeAreRefusedByFace)
{
    for (const std::int64_t bad : {std::int64_t{8}, std::int64_t{-1}, std::numeric_limits<std::int64_t>::max()}) {
        Polygons p = polygon_cube();
        p.indices[3 * 4 + 1] = bad;
        const AdmitResult result = judge(p);
        EXPECT_EQ(result.diagnosis.code, Refusal::Index);
        EXPECT_EQ(result.diagnosis.element, "face 5");
        EXPECT_TRUE(result.mesh.vertices.empty());
    }
}

TEST(Gate, NumbersThatAreNotFiniteAreRefusedByVertexUsedOrNot)
{
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::infinity()}) {
        Polygons p = polygon_cube();
        p.positions.push_back({0, bad, 0});
        const AdmitResult result = judge(p);
        EXPECT_EQ(result.diagnosis.code, Refusal::NonFinite);
        EXPECT_EQ(result.diagnosis.element, "vertex 9");
    }
}

TEST(Gate, TheFirstCodeOfTheOrderIsTheVerdict)
{
    Polygons p = polygon_cube();
    p.positions.push_back({0, std::nan(""), 0});
    p.add({0, 1, 99});
    EXPECT_EQ(code(p), Refusal::Index);
    Polygons points;
    points.positions = {{0, 0, 0}};
    EXPECT_EQ(code(points), Refusal::Empty);
    points.positions.push_back({std::nan(""), 0, 0});
    EXPECT_EQ(code(points), Refusal::NonFinite);
    EXPECT_EQ(code({}), Refusal::Empty);
    Polygons fin = polygon_cube();  // open and non-manifold
    fin.positions.push_back({2, 2, 2});
    fin.add({0, 1, 8});
    EXPECT_EQ(code(fin), Refusal::NonManifold);
}

TEST(Gate, SizesThatDoubleCannotHoldAreRefused)
{
    Polygons stray = polygon_cube();
    stray.positions[7] = {1e300, 1e300, 1e300};
    EXPECT_EQ(code(stray), Refusal::Range);
    stray.positions[7] = {1e16, 1, 1};
    EXPECT_EQ(judge(stray).diagnosis.element, "vertex 8");
    for (const double scale : {1e120, 1e-120, 1e-310})
        EXPECT_EQ(code(polygon_box({0, 0, 0}, {scale, scale, scale})), Refusal::Range) << scale;
    EXPECT_EQ(code(polygon_box({1, 1, 1}, {1, 1, 1})), Refusal::Range);
    EXPECT_EQ(code(polygon_box({1e17, 1e17, 1e17}, {1e17 + 64, 1e17 + 64, 1e17 + 64})), Refusal::Range);
}

TEST(Gate, UnitsAndPlaceDoNotMatter)
{
    for (const double scale : {1e-80, 1e-9, 1.0, 1e9, 1e80})
        for (const double shift : {0.0, 1e8}) {
            Polygons p = polygon_sphere(8, 12);
            for (Vec3d& v : p.positions) v = scale * (v + Vec3d{shift, -shift, shift});
            const AdmitResult result = judge(p);
            EXPECT_EQ(result.admission, Admission::Accept) << scale << " at " << shift << ": " << result.diagnosis.message;
            EXPECT_EQ(result.facts.self_intersecting_pairs, 0u);
            p.reverse();
            EXPECT_EQ(repaired(judge(p), RepairKind::Flipped), result.facts.triangle_count);
        }
}

TEST(Gate, UnusedVerticesDoNotInflateTheBox)
{
    Polygons p = polygon_cube();
    p.positions.push_back({1e9, 0, 0});
    p.positions.push_back({1e300, 0, 0});
    const AdmitResult result = judge(p);
    EXPECT_EQ(repaired(result, RepairKind::UnusedVertices), 2u);
    EXPECT_EQ(result.facts.box.hi, (Vec3d{1, 1, 1}));
    EXPECT_EQ(result.facts.vertex_count, 8u);
}

TEST(Gate, PolygonsBecomeTrianglesThatCoverThemOnce)
{
    // A prism over an L: six corners, one of them reflex; the area tells a wrong ear.
    Polygons p;
    const std::vector<std::array<double, 2>> outline{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
    for (const double z : {0.0, 1.0})
        for (const auto& [x, y] : outline) p.positions.push_back({x, y, z});
    p.add({5, 4, 3, 2, 1, 0});
    p.add({6, 7, 8, 9, 10, 11});
    for (std::int64_t i = 0; i < 6; ++i) p.add({i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6});
    const AdmitResult result = judge(p);
    EXPECT_EQ(result.admission, Admission::Repaired);
    EXPECT_EQ(repaired(result, RepairKind::Triangulated), 8u);
    EXPECT_EQ(result.facts.triangle_count, 20u);
    EXPECT_NEAR(result.facts.volume, 3, 1e-12);
    EXPECT_NEAR(result.facts.area, 6 + 8, 1e-12);
}

TEST(Gate, TrianglesNameThePolygonsThatTheyWereCutFrom)
{
    Polygons p;
    p.positions = polygon_cube().positions;
    p.add({1, 1, 3});  // dropped
    for (const auto& q : {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
        p.add({q[0], q[1], q[2], q[3]});
    const AdmitResult result = judge(p);
    ASSERT_EQ(result.source_triangle.size(), 12u);
    std::vector<int> triangles(7, 0);
    for (std::uint32_t t = 0; t < 12; ++t) {
        const std::uint32_t polygon = result.source_triangle[t];
        ASSERT_LT(polygon, 7u);
        ++triangles[polygon];
        for (const std::uint32_t v : result.mesh.triangles[t]) {
            const auto first = p.indices.begin() + p.offsets[polygon], end = p.indices.begin() + p.offsets[polygon + 1];
            EXPECT_TRUE(std::any_of(first, end, [&](std::int64_t corner) {
                return p.positions[static_cast<std::size_t>(corner)] == result.mesh.vertices[v];
            })) << t;
        }
    }
    EXPECT_EQ(triangles, (std::vector<int>{0, 2, 2, 2, 2, 2, 2}));
}

TEST(Gate, FillingsAreOfNoPolygon)
{
    Polygons p = polygon_cube();
    remove_face(p, 3);
    const AdmitResult result = judge(p, {.repair = Repair::Close});
    ASSERT_EQ(result.made_up.size(), result.source_triangle.size());
    for (std::size_t t = 0; t < result.made_up.size(); ++t)
        EXPECT_EQ(result.source_triangle[t] == k_no_polygon, result.made_up[t] != 0);
}

TEST(Gate, FileOrderHasNoInfluence)
{
    const AdmitResult expected = judge(polygon_cube());
    const Polygons c = polygon_cube();
    Polygons p;
    p.positions.assign(c.positions.rbegin(), c.positions.rend());
    for (std::size_t f = 12; f-- > 0;) p.add({7 - c.indices[3 * f + 2], 7 - c.indices[3 * f], 7 - c.indices[3 * f + 1]});
    EXPECT_EQ(judge(p).mesh.vertices, expected.mesh.vertices);
    EXPECT_EQ(judge(p).mesh.triangles, expected.mesh.triangles);
}

TEST(Gate, SoupIsWelded)
{
    const Polygons c = polygon_cube();
    Polygons p;
    for (const std::int64_t i : c.indices) {
        p.positions.push_back(c.positions[static_cast<std::size_t>(i)]);
        p.indices.push_back(static_cast<std::int64_t>(p.indices.size()));
        if (p.indices.size() % 3 == 0) p.offsets.push_back(static_cast<std::uint32_t>(p.indices.size()));
    }
    EXPECT_EQ(repaired(judge(p), RepairKind::WeldedVertices), 28u);
    // Rounded apart, by less than 1e-7 of the size.
    for (std::size_t i = 0; i < p.positions.size(); ++i) p.positions[i].x += 1e-9 * static_cast<double>(i % 5);
    const AdmitResult nearly = judge(p);
    EXPECT_EQ(nearly.facts.vertex_count, 8u) << nearly.diagnosis.message;
    // Too far apart to be meant as one.
    for (std::size_t i = 0; i < p.positions.size(); ++i) p.positions[i].x += 1e-4 * static_cast<double>(i % 5);
    EXPECT_EQ(code(p), Refusal::Open);
}

TEST(Gate, FacesWithoutAreaGo)
{
    Polygons p = polygon_cube();
    p.add({0, 0, 1});
    p.positions.push_back({0.5, 0, 0});
    p.add({0, 1, 8});  // on an edge
    const AdmitResult result = judge(p);
    EXPECT_EQ(result.admission, Admission::Repaired);
    EXPECT_EQ(repaired(result, RepairKind::DegenerateFaces), 2u);
    EXPECT_EQ(result.facts.triangle_count, 12u);
    EXPECT_EQ(result.facts.vertex_count, 8u);
}

TEST(Gate, AFlatFaceBetweenNeighboursIsFlippedAwayAndOpensNothing)
{
    // A corner in the middle of the bottom edge 0-1: one face there has no area, yet three neighbours need it.
    Polygons p = polygon_box({0, 0, 0}, {1, 1, 1});
    p.positions.push_back({0.5, 0, 0});
    for (std::size_t f = 0; f < 12; ++f) {
        const auto corner = [&](std::size_t k) { return p.indices[3 * f + k]; };
        if (corner(0) == 0 && corner(1) == 1 && corner(2) == 5) {
            p.indices[3 * f] = 8;  // 8 1 5
            p.add({0, 8, 5});
        }
    }
    p.add({8, 0, 1});
    const AdmitResult result = judge(p);
    EXPECT_EQ(result.admission, Admission::Repaired) << result.diagnosis.message;
    EXPECT_TRUE(result.solid);
    EXPECT_EQ(repaired(result, RepairKind::DegenerateFaces), 1u);
    EXPECT_FALSE(warned(result, WarningKind::Degenerate));
    EXPECT_NEAR(result.facts.volume, 1, 1e-12);
    EXPECT_NEAR(result.facts.area, 6, 1e-12);
}

TEST(Gate, DuplicateFacesGoAndAWallInsideCancels)
{
    Polygons p = polygon_cube();
    p.add({0, 2, 3});
    p.add({3, 0, 2});
    EXPECT_EQ(repaired(judge(p), RepairKind::DuplicateFaces), 2u);
    // A wall across the cube, both sides of it: the solid is the same without.
    Polygons wall = polygon_cube();
    wall.add({0, 1, 7});
    wall.add({0, 7, 1});
    const AdmitResult result = judge(wall);
    EXPECT_EQ(result.admission, Admission::Repaired) << result.diagnosis.message;
    EXPECT_EQ(result.facts.triangle_count, 12u);
}

TEST(Gate, FacesAreTurnedAlikeAndOutward)
{
    Polygons p = polygon_cube();
    std::swap(p.indices[0], p.indices[1]);
    std::swap(p.indices[15], p.indices[16]);
    EXPECT_EQ(repaired(judge(p), RepairKind::Reoriented), 2u);
    EXPECT_NEAR(judge(p).facts.volume, 1, 1e-12);
    Polygons inside_out = polygon_cube();
    inside_out.reverse();
    EXPECT_EQ(repaired(judge(inside_out), RepairKind::Flipped), 12u);
    EXPECT_TRUE(warned(judge(inside_out), WarningKind::Flipped));
    // One of two shells inside out.
    Polygons two = polygon_cube();
    Polygons other = polygon_box({5, 0, 0}, {6, 1, 1});
    other.reverse();
    two.add(other);
    EXPECT_EQ(repaired(judge(two), RepairKind::Flipped), 12u);
    EXPECT_NEAR(judge(two).facts.volume, 2, 1e-12);
}

TEST(Gate, AMoebiusBandCannotBeOriented)
{
    Polygons p;
    constexpr int n = 12;
    for (int i = 0; i < n; ++i) {
        const double u = 2 * std::numbers::pi * i / n;
        for (const double v : {-0.3, 0.3})
            p.positions.push_back(
                {(1 + v * std::cos(u / 2)) * std::cos(u), (1 + v * std::cos(u / 2)) * std::sin(u), v * std::sin(u / 2)});
    }
    for (std::int64_t i = 0; i < n; ++i) {
        const bool last = i == n - 1;
        const std::int64_t a = 2 * i, b = 2 * i + 1, c = last ? 1 : 2 * i + 2, d = last ? 0 : 2 * i + 3;
        p.add({a, c, b});
        p.add({b, c, d});
    }
    EXPECT_EQ(code(p), Refusal::Orient);
    EXPECT_EQ(code(p, {.accept_surface = true}), Refusal::Orient);
}

TEST(Gate, ShellsThatTouchAreSplitApart)
{
    // Two cubes that share a vertex, then an edge, by index.
    Polygons corner = polygon_cube();
    Polygons second = polygon_box({1, 1, 1}, {2, 2, 2});
    corner.add(second);
    for (std::int64_t& i : corner.indices)
        if (i == 8) i = 7;
    AdmitResult result = judge(corner);
    EXPECT_EQ(repaired(result, RepairKind::SplitVertices), 1u) << result.diagnosis.message;
    EXPECT_EQ(result.facts.component_count, 2u);
    EXPECT_NEAR(result.facts.volume, 2, 1e-12);

    Polygons edge = polygon_cube();
    edge.add(polygon_box({1, 1, 0}, {2, 2, 1}));
    for (std::int64_t& i : edge.indices) i = i == 8 ? 3 : (i == 12 ? 7 : i);
    result = judge(edge);
    EXPECT_EQ(repaired(result, RepairKind::SplitVertices), 2u) << result.diagnosis.message;
    EXPECT_EQ(result.facts.component_count, 2u);
    EXPECT_NEAR(result.facts.volume, 2, 1e-12);
}

TEST(Gate, CavitiesStayCavities)
{
    Polygons p = polygon_box({0, 0, 0}, {4, 4, 4});
    Polygons hollow = polygon_box({1, 1, 1}, {2, 2, 2});
    hollow.reverse();
    p.add(hollow);
    const AdmitResult result = judge(p);
    EXPECT_EQ(result.admission, Admission::Accept);
    EXPECT_TRUE(warned(result, WarningKind::Cavities));
    EXPECT_NEAR(result.facts.volume, 63, 1e-10);
    p.reverse();
    EXPECT_NEAR(judge(p).facts.volume, 63, 1e-10) << "all of it inside out";
    // The same shell turned outward lies inside the solid and adds nothing: also as it is.
    Polygons nested = polygon_box({0, 0, 0}, {4, 4, 4});
    nested.add(polygon_box({1, 1, 1}, {2, 2, 2}));
    EXPECT_EQ(judge(nested).admission, Admission::Accept);
    EXPECT_FALSE(warned(judge(nested), WarningKind::Cavities));
}

TEST(Gate, OverlappingShellsAreAcceptedWithTheirPairs)
{
    Polygons p = polygon_cube();
    p.add(polygon_box({0.5, 0.25, 0.25}, {1.5, 0.75, 0.75}));
    const AdmitResult result = judge(p);
    EXPECT_EQ(result.admission, Admission::Accept);
    EXPECT_TRUE(warned(result, WarningKind::SelfIntersections));
    EXPECT_EQ(result.crossed.size(), result.mesh.triangles.size());
    EXPECT_TRUE(judge(polygon_cube()).crossed.empty());
}

TEST(Gate, SheetsAreFlatAndBecomePlatesOnRequest)
{
    Polygons p;
    p.positions = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}};
    p.add({0, 1, 2});
    p.add({0, 2, 3});
    EXPECT_EQ(code(p), Refusal::Flat);
    EXPECT_EQ(code(p, {.accept_surface = true}), Refusal::Flat);
    Polygons doubled = p;
    doubled.add({2, 1, 0});
    doubled.add({3, 2, 0});
    EXPECT_EQ(code(doubled), Refusal::Flat);
    // Tilted and moved far away: still flat, though no coordinate is constant.
    Polygons tilted = p;
    for (Vec3d& v : tilted.positions) v = {v.x + 1e6, v.y - 1e6, 0.3 * v.x + 0.7 * v.y};
    EXPECT_EQ(code(tilted), Refusal::Flat);

    const AdmitResult plate = judge(p, {.thickness = 0.1});
    EXPECT_EQ(plate.admission, Admission::Repaired) << plate.diagnosis.message;
    EXPECT_TRUE(plate.solid);
    EXPECT_NEAR(plate.facts.volume, 0.2, 1e-12);
    EXPECT_EQ(plate.facts.box.hi, (Vec3d{2, 1, 0.05}));
    EXPECT_EQ(plate.facts.self_intersecting_pairs, 0u);
    EXPECT_TRUE(warned(judge(polygon_cube(), {.thickness = 0.1}), WarningKind::Thickness));
}

TEST(Gate, AClosedSheetSaysHowThinItIsAndBecomesAPlateOnRequest)
{
    const auto refused = [](const Polygons& p) { return judge(p).diagnosis; };
    const Polygons thin = polygon_box({0, 0, 0}, {1, 1, 1e-6});
    EXPECT_EQ(refused(thin).code, Refusal::Flat);
    EXPECT_NE(refused(thin).message.find("1e-06 thick"), std::string::npos) << refused(thin).message;
    EXPECT_NE(refused(thin).cure.text().find("AdmitOptions::thickness"), std::string::npos);

    // Far from the origin and tilted, too: a turn by 3-4-5 in the plane of y and z.
    Polygons tilted = thin;
    for (Vec3d& v : tilted.positions) v = {v.x + 1000, 0.6 * v.y - 0.8 * v.z - 1000, 0.8 * v.y + 0.6 * v.z};
    for (const Polygons& p : {thin, tilted}) {
        const AdmitResult plate = judge(p, {.thickness = 0.05});
        EXPECT_EQ(plate.admission, Admission::Repaired) << plate.diagnosis.message;
        EXPECT_TRUE(plate.solid);
        EXPECT_EQ(repaired(plate, RepairKind::Thickened), 2u);
        EXPECT_NEAR(plate.facts.volume, 0.05, 1e-6);
        EXPECT_EQ(plate.facts.self_intersecting_pairs, 0u);
    }
    // The least thickness that the cure names is enough, a tenth of it is not.
    const std::string cure = refused(thin).cure.text();
    const double least = std::stod(cure.substr(cure.find("at least ") + 9));
    EXPECT_EQ(judge(thin, {.thickness = least}).admission, Admission::Repaired);
    EXPECT_EQ(code(thin, {.thickness = 0.1 * least}), Refusal::Flat);

    // A lens, and a sheet that is bent: the upper half of a thin shell's walls.
    Polygons lens = polygon_sphere(20, 40);
    for (Vec3d& v : lens.positions) v.z *= 1e-7;
    EXPECT_EQ(code(lens), Refusal::Flat);
    const AdmitResult disc = judge(lens, {.thickness = 0.1});
    EXPECT_EQ(disc.admission, Admission::Repaired) << disc.diagnosis.message;
    EXPECT_NEAR(disc.facts.volume, 0.1 * 20 * std::sin(std::numbers::pi / 20), 1e-6);
    Polygons bent;  // half a tube's wall, 1e-7 thick: every quad of it is closed by those beside it
    constexpr int k_steps = 16;
    for (const double r : {1.0, 1 - 1e-7})
        for (int i = 0; i <= k_steps; ++i)
            for (const double z : {0.0, 1.0}) {
                const double t = std::numbers::pi * i / k_steps;
                bent.positions.push_back({r * std::cos(t), r * std::sin(t), z});
            }
    constexpr int k_in = 2 * (k_steps + 1), k_last = 2 * k_steps;
    for (int i = 0; i < k_last; i += 2) {
        bent.add({i, i + 2, i + 3, i + 1});
        bent.add({k_in + i, k_in + i + 1, k_in + i + 3, k_in + i + 2});
        bent.add({i, k_in + i, k_in + i + 2, i + 2});
        bent.add({i + 1, i + 3, k_in + i + 3, k_in + i + 1});
    }
    bent.add({0, 1, k_in + 1, k_in});
    bent.add({k_last, k_in + k_last, k_in + k_last + 1, k_last + 1});
    EXPECT_EQ(code(bent), Refusal::Flat);
    EXPECT_NE(refused(bent).message.find("sheets folded"), std::string::npos) << refused(bent).message;
    const AdmitResult wall = judge(bent, {.thickness = 0.1});
    EXPECT_EQ(wall.admission, Admission::Repaired) << wall.diagnosis.message;
    // Between polygons of radius 1.05 and 0.95, but for the ends, which are cut square.
    EXPECT_NEAR(wall.facts.volume, 0.1 * k_steps * std::sin(std::numbers::pi / k_steps), 2e-4);
}

TEST(Gate, SmallSolidsFarApartAndLongRodsAreNotFlat)
{
    Polygons p = polygon_cube();
    p.add(polygon_box({1e6, 0, 0}, {1e6 + 1, 1, 1}));
    EXPECT_EQ(judge(p).admission, Admission::Accept) << judge(p).diagnosis.message;
    EXPECT_EQ(judge(polygon_box({0, 0, 0}, {1e6, 1, 1})).admission, Admission::Accept);
    EXPECT_EQ(code(polygon_box({0, 0, 0}, {1, 1, 1e-7})), Refusal::Flat);
}

TEST(Gate, OpenMeshesAreRefusedOrTakenAsSurfaces)
{
    Polygons p = polygon_cube();
    remove_face(p, 0);
    remove_face(p, 0);
    EXPECT_EQ(code(p), Refusal::Open);
    const AdmitResult surface = judge(p, {.accept_surface = true});
    EXPECT_EQ(surface.admission, Admission::Accept);
    EXPECT_FALSE(surface.solid);
    EXPECT_TRUE(warned(surface, WarningKind::Surface));
    EXPECT_EQ(surface.facts.boundary_edge_count, 4u);
    const AdmitResult shell = judge(p, {.thickness = 0.01});
    EXPECT_TRUE(shell.solid) << shell.diagnosis.message;
    EXPECT_GT(shell.facts.volume, 0);
}

TEST(Gate, HolesAreFilledAlsoWhereTwoTouch)
{
    Polygons p = polygon_sphere(60, 120);
    const double volume = judge(p).facts.volume;
    // Two faces of one fan that share only its vertex, and a hole of several faces elsewhere.
    const auto at = [](int r, int s) { return 1 + (r - 1) * 120 + s; };
    const auto remove = [&](std::vector<std::int64_t> corners) {
        for (std::size_t f = 0; f + 1 < p.offsets.size(); ++f)
            if (std::equal(corners.begin(), corners.end(), p.indices.begin() + p.offsets[f])) return remove_face(p, f);
        FAIL() << "no such face";
    };
    remove({at(30, 10), at(31, 10), at(31, 11)});
    remove({at(29, 9), at(30, 10), at(29, 10)});
    remove({at(20, 50), at(21, 50), at(21, 51)});
    remove({at(20, 50), at(21, 51), at(20, 51)});
    EXPECT_EQ(code(p), Refusal::Open);
    const AdmitResult result = judge(p, {.repair = Repair::Close});
    EXPECT_EQ(result.admission, Admission::Closed) << result.diagnosis.message;
    EXPECT_EQ(repaired(result, RepairKind::FilledHoles), 3u);
    EXPECT_EQ(repaired(result, RepairKind::SplitVertices), 0u);
    EXPECT_NEAR(result.facts.volume, volume, 1e-4);
    EXPECT_EQ(result.facts.self_intersecting_pairs, 0u);
}

TEST(Gate, WithoutRepairTheDefectIsTheVerdict)
{
    const AdmitOptions none{.repair = Repair::None};
    EXPECT_EQ(judge(polygon_cube(), none).admission, Admission::Accept);
    Polygons p = polygon_cube();
    std::swap(p.indices[0], p.indices[1]);
    EXPECT_EQ(code(p, none), Refusal::Orient);
    p = polygon_cube();
    p.add({0, 2, 3});
    EXPECT_EQ(code(p, none), Refusal::NonManifold);
    p = polygon_cube();
    p.positions.push_back({0, 0, 0});
    EXPECT_EQ(code(p, none), Refusal::Repair);
}

TEST(Gate, UnitsScaleTheResultAndAreAskedFor)
{
    Polygons p = polygon_box({0, 0, 0}, {100, 100, 100});
    EXPECT_TRUE(warned(judge(p), WarningKind::Unit));
    const AdmitResult result = judge(p, {.unit = 1e-3});
    EXPECT_FALSE(warned(result, WarningKind::Unit));
    EXPECT_NEAR(result.facts.volume, 1e-3, 1e-15);
    EXPECT_DOUBLE_EQ(result.mesh.vertices.back().x, 0.1);
}

}  // namespace
}  // namespace sqmap::mesh
