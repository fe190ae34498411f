// The ladder's third rung on shapes that the project makes and then damages.
#include "sqmap/mesh/admission.h"
#include "sqmap/mesh/bvh.h"
#include "sqmap/mesh/shapes.h"
#include "support/baked_shapes.h"
#include "support/repaired.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace sqmap::mesh {
namespace {

AdmitResult judge(const Mesh& mesh, const AdmitOptions& options = {.repair = Repair::Close})
{
    std::vector<std::int64_t> indices;
    std::vector<std::uint32_t> offsets{0};
    for (const Triangle& t : mesh.triangles) {
        for (const std::uint32_t v : t) indices.push_back(v);
        offsets.push_back(static_cast<std::uint32_t>(indices.size()));
    }
    return admit({mesh.vertices, offsets, indices}, options);
}

/// Takes out the triangles whose middle is where `gone` says.
Mesh without(Mesh mesh, const std::function<bool(Vec3d)>& gone)
{
    std::vector<Triangle> kept;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        if (!gone(triangle_centroid(mesh, t))) kept.push_back(mesh.triangles[t]);
    mesh.triangles = kept;
    return mesh;
}

void expect_closed(const AdmitResult& result, const std::string& what)
{
    ASSERT_EQ(result.admission, Admission::Closed) << what << ": " << result.diagnosis.message;
    EXPECT_TRUE(result.solid) << what;
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> faces, balance;
    for (const Triangle& t : result.mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3];
            ++faces[std::minmax(a, b)];
            balance[std::minmax(a, b)] += a < b ? 1 : -1;
        }
    EXPECT_TRUE(std::all_of(faces.begin(), faces.end(), [](const auto& e) { return e.second == 2; })) << what;
    EXPECT_TRUE(std::all_of(balance.begin(), balance.end(), [](const auto& e) { return e.second == 0; })) << what;
    EXPECT_TRUE(result.deviation.has_value()) << what;
}

/// Both solids have the same points inside, of 20,000 about them that are farther than `beside` from both surfaces.
void expect_same_solid(const Mesh& a, const Mesh& b, double beside, const std::string& what)
{
    const Bvh first(a), second(b);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> in(-1.2, 1.2);
    int wrong = 0, compared = 0;
    for (int i = 0; i < 20'000; ++i) {
        const Vec3d p{in(random), in(random), in(random)};
        if (first.closest_point(p).distance < beside || second.closest_point(p).distance < beside) continue;
        ++compared;
        wrong += (first.winding_number(p) > 0) != (second.winding_number(p) > 0);
    }
    EXPECT_GT(compared, 10'000) << what;
    EXPECT_EQ(wrong, 0) << what;
}

/// 0.5 % of R_max, of the shapes here.
constexpr double k_beside = 0.01;

TEST(Close, FillsASmoothHoleAsTheSurfaceGoesOn)
{
    const Mesh ball = sphere(1, 5);
    const AdmitResult result = judge(without(ball, [](Vec3d p) { return p.z > 0.9; }));
    expect_closed(result, "cap");
    EXPECT_EQ(repaired(result, RepairKind::FilledHoles), 1u);
    EXPECT_EQ(result.facts.self_intersecting_pairs, 0u);
    // A flat lid would be 0.1 below the pole.
    double top = -1;
    for (const Vec3d& p : result.mesh.vertices) top = std::max(top, p.z);
    EXPECT_NEAR(top, 1, 0.02);
    expect_same_solid(ball, result.mesh, 0.03, "cap");
    const std::size_t made = static_cast<std::size_t>(std::count(result.made_up.begin(), result.made_up.end(), 1));
    EXPECT_EQ(made, result.mesh.triangles.size() - without(ball, [](Vec3d p) { return p.z > 0.9; }).triangles.size());
    EXPECT_LT(result.deviation->input_to_result.max, 1e-12);
    EXPECT_LT(result.deviation->result_to_input.max, 1e-12);
    EXPECT_NEAR(result.deviation->made_up_share, 0.05, 0.01);
}

TEST(Close, GivesWhatWasCutOffAFlatFoot)
{
    // Half a ball on a cylinder's wall would bulge if it went on smoothly.
    Mesh block = rounded_box({0.5, 0.5, 0.5}, 0.1, 6);
    block = without(block, [](Vec3d p) { return p.z < -0.3; });
    const AdmitResult result = judge(block);
    expect_closed(result, "foot");
    double lowest = 1;
    for (const Vec3d& p : result.mesh.vertices) lowest = std::min(lowest, p.z);
    double lowest_before = 1;
    for (const Triangle& t : block.triangles)
        for (const std::uint32_t v : t) lowest_before = std::min(lowest_before, block.vertices[v].z);
    EXPECT_NEAR(lowest, lowest_before, 1e-9);
}

TEST(Close, FillsManyHolesAndHugeLoops)
{
    Mesh ball = sphere(1, 5);
    std::mt19937 random(3);
    std::vector<Triangle> kept;
    for (const Triangle& t : ball.triangles)
        if (random() % 200 != 0) kept.push_back(t);
    const Mesh whole = ball;
    ball.triangles = kept;
    const AdmitResult holes = judge(ball);
    expect_closed(holes, "100 holes");
    EXPECT_GT(repaired(holes, RepairKind::FilledHoles), 75u);
    expect_same_solid(whole, holes.mesh, k_beside, "100 holes");
    // One loop of more than a hundred edges.
    const AdmitResult cut = judge(without(whole, [](Vec3d p) { return p.z > 0.7; }));
    expect_closed(cut, "huge loop");
    EXPECT_EQ(cut.facts.self_intersecting_pairs, 0u);
}

TEST(Close, DropsFinsAndInnerWalls)
{
    const Mesh ball = sphere(1, 4);
    Mesh fins = ball;
    for (std::uint32_t i = 0; i < 20; ++i) {
        const Triangle t = ball.triangles[i * 37];
        fins.vertices.push_back(1.2 * triangle_centroid(ball, i * 37));
        fins.triangles.push_back({t[0], t[1], static_cast<std::uint32_t>(fins.vertices.size() - 1)});
    }
    EXPECT_EQ(judge(fins, {.repair = Repair::Safe}).admission, Admission::Refused);
    const AdmitResult result = judge(fins);
    expect_closed(result, "fins");
    EXPECT_EQ(result.mesh.triangles.size(), ball.triangles.size());
    expect_same_solid(ball, result.mesh, 1e-9, "fins");

    // A wall across a box, from edge to edge.
    const Mesh box{{{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {-1, 1, 1}, {1, 1, 1}},
                   {{0, 2, 1},
                    {1, 2, 3},
                    {4, 5, 6},
                    {5, 7, 6},
                    {0, 1, 4},
                    {1, 5, 4},
                    {2, 6, 3},
                    {3, 6, 7},
                    {0, 4, 2},
                    {2, 4, 6},
                    {1, 3, 5},
                    {3, 7, 5}}};
    ASSERT_EQ(judge(box).admission, Admission::Accept);
    Mesh walled = box;
    walled.triangles.push_back({0, 1, 6});
    walled.triangles.push_back({1, 7, 6});
    const AdmitResult wall = judge(walled);
    expect_closed(wall, "wall");
    EXPECT_EQ(repaired(wall, RepairKind::DroppedWalls), 2u);
    EXPECT_NEAR(wall.facts.volume, 8, 1e-12);
    EXPECT_TRUE(wall.made_up.empty());
}

TEST(Close, StitchesCracksAndTJunctions)
{
    const Mesh ball = sphere(1, 4);
    // The halves apart by less than the tolerance, so that no vertex is shared across.
    Mesh cracked = without(ball, [](Vec3d p) { return p.z > 0; });
    const Mesh upper = without(ball, [](Vec3d p) { return p.z <= 0; });
    const auto first = static_cast<std::uint32_t>(cracked.vertices.size());
    for (const Vec3d& p : upper.vertices) cracked.vertices.push_back(p + Vec3d{0, 0, 1e-3});
    for (const Triangle& t : upper.triangles) cracked.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    const AdmitResult result = judge(cracked);
    expect_closed(result, "crack");
    EXPECT_GT(repaired(result, RepairKind::Stitched), 0u);
    EXPECT_EQ(repaired(result, RepairKind::FilledHoles), 0u);
    EXPECT_EQ(result.facts.component_count, 1u);
    EXPECT_LT(result.deviation->input_to_result.max, 1.5e-3);
    expect_same_solid(ball, result.mesh, k_beside, "crack");

    // The face above an edge is split at its middle, the one below is not.
    Mesh junction{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.5, 0, 0}}, {{0, 2, 1}, {0, 3, 2}, {1, 2, 3}}};
    junction.triangles.push_back({0, 4, 3});
    junction.triangles.push_back({4, 1, 3});
    const AdmitResult joined = judge(junction);
    expect_closed(joined, "T-junction");
    EXPECT_TRUE(joined.made_up.empty());
    EXPECT_NEAR(joined.facts.volume, 1.0 / 6, 1e-12);
}

TEST(Close, DropsDoubledSheetsAndKeepsLargeOnes)
{
    const Mesh ball = sphere(1, 4);
    Mesh doubled = without(ball, [](Vec3d p) { return p.z > 0.95; });
    const Mesh sheet = without(ball, [](Vec3d p) { return p.x < 0.9; });
    const auto first = static_cast<std::uint32_t>(doubled.vertices.size());
    for (const Vec3d& p : sheet.vertices) doubled.vertices.push_back((1 + 1e-4) * p);
    for (const Triangle& t : sheet.triangles) doubled.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    const AdmitResult result = judge(doubled);
    expect_closed(result, "doubled sheet");
    EXPECT_EQ(repaired(result, RepairKind::DroppedSheets), sheet.triangles.size());
    expect_same_solid(ball, result.mesh, 0.03, "doubled sheet");
}

TEST(Close, DropsFinsThatLieCloseOverTheSurface)
{
    const Mesh ball = sphere(1, 4);
    Mesh fins = ball;
    // From an edge to a point just above the ball nearby: of each, one side alone is seen well.
    for (std::uint32_t i = 0; i < 20; ++i) {
        const Triangle t = ball.triangles[i * 37];
        const Vec3d across = ball.vertices[t[2]] - 0.5 * (ball.vertices[t[0]] + ball.vertices[t[1]]);
        const Vec3d over = normalized(ball.vertices[t[2]] + 4.0 * across);
        fins.vertices.push_back(1.03 * over);
        fins.triangles.push_back({t[0], t[1], static_cast<std::uint32_t>(fins.vertices.size() - 1)});
    }
    const AdmitResult result = judge(fins);
    expect_closed(result, "fins close by");
    EXPECT_TRUE(result.made_up.empty());
    expect_same_solid(ball, result.mesh, 1e-9, "fins close by");
}

TEST(Close, WarnsOfASheetThatItDropsAndThatStandsOut)
{
    Mesh winged = sphere(1, 4);
    const auto first = static_cast<std::uint32_t>(winged.vertices.size());
    const auto has = [](const AdmitResult& result, WarningKind kind) {
        return std::any_of(result.warnings.begin(), result.warnings.end(), [&](const Warning& w) { return w.kind == kind; });
    };
    // One corner in the ball, two outside.
    winged.vertices.insert(winged.vertices.end(), {{0, 0, 0}, {2, 0, 0.1}, {2, 0.1, 0}});
    winged.triangles.push_back({first, first + 1, first + 2});
    const AdmitResult result = judge(winged);
    expect_closed(result, "a wing");
    EXPECT_EQ(repaired(result, RepairKind::DroppedSheets), 1u);
    EXPECT_TRUE(has(result, WarningKind::DroppedSurface));
    winged.vertices[first + 1] = winged.vertices[first + 2] = {0.5, 0, 0.1};
    winged.vertices[first + 2].y = 0.2;
    EXPECT_FALSE(has(judge(winged), WarningKind::DroppedSurface));
}

TEST(Close, StopsAtTheShareThatMayBeFilled)
{
    const Mesh half = without(sphere(1, 4), [](Vec3d p) { return p.z > 0; });
    const AdmitResult refused = judge(half);
    EXPECT_EQ(refused.admission, Admission::Refused);
    EXPECT_EQ(refused.diagnosis.code, Refusal::Open);
    expect_closed(judge(half, {.repair = Repair::Close, .max_filled = 0.4}), "half a ball");
    EXPECT_EQ(judge(half, {.wrap = {.tolerance = 0.005, .thickness = 0.0075}}).admission, Admission::Wrapped);
}

TEST(Close, IsBoundedBeforeItStarts)
{
    const Mesh open = without(sphere(1, 4), [](Vec3d p) { return p.z > 0.9; });
    const AdmitResult refused = judge(open, {.max_cured_faces = 1000});
    EXPECT_EQ(refused.diagnosis.code, Refusal::Limit);
    EXPECT_NE(refused.diagnosis.cure.text().find("AdmitOptions::max_cured_faces"), std::string::npos);
}

TEST(Close, DoesNotDependOnTheOrderOfTheFile)
{
    const Mesh open = without(sphere(1, 4), [](Vec3d p) { return p.z > 0.8 || p.x < -0.9; });
    Mesh shuffled = open;
    std::shuffle(shuffled.triangles.begin(), shuffled.triangles.end(), std::mt19937(5));
    const AdmitResult a = judge(open), b = judge(shuffled);
    expect_closed(a, "as it is");
    EXPECT_EQ(a.mesh.triangles, b.mesh.triangles);
    EXPECT_EQ(content_hash(a.mesh), content_hash(b.mesh));
    EXPECT_EQ(a.made_up, b.made_up);
}

TEST(Close, LeavesNoModelOfWhatHasNoVolume)
{
    const Mesh flat{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}};
    EXPECT_EQ(judge(flat, {}).diagnosis.code, Refusal::Flat);
    const Mesh line{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}};
    EXPECT_EQ(judge(line, {}).admission, Admission::Refused);
}

}  // namespace
}  // namespace sqmap::mesh
