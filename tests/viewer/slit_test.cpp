// Cuts along a line: what hangs together is counted by brute force, areas are the pattern's.
#include "viewer/server/cloth/slit.h"

#include "math/triangle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

namespace sqmap::viewer {
namespace {

const sim::Garment& sheet()
{
    static const sim::Garment garment = sim::sheet({.centre = {0, 1, 0}, .width = 1, .depth = 1, .vertices = 900});
    return garment;
}

/// The place on the cloth that is nearest to each point.
std::vector<ClothPoint> on(const sim::Garment& g, const std::vector<Vec3d>& x, const std::vector<Vec3d>& points)
{
    std::vector<ClothPoint> out;
    for (const Vec3d& p : points) {
        double least = 1e300;
        for (std::uint32_t t = 0; t < g.triangles.size(); ++t) {
            const Vec3d a = x[g.triangles[t][0]], b = x[g.triangles[t][1]], c = x[g.triangles[t][2]];
            const Vec3d q = closest_point_on_triangle(p, a, b, c), n = cross(b - a, c - a);
            if (norm_sq(q - p) >= least) continue;
            least = norm_sq(q - p);
            const auto share = [&](Vec3d from, Vec3d to) { return std::clamp(dot(cross(from, to), n) / norm_sq(n), 0.0, 1.0); };
            if (out.size() <= static_cast<std::size_t>(&p - points.data())) out.emplace_back();
            out.back() = {t, share(q - a, c - a), share(b - a, q - a)};
        }
    }
    return out;
}

std::vector<Vec3d> straight(Vec3d a, Vec3d b, int points = 9)
{
    std::vector<Vec3d> out;
    for (int i = 0; i < points; ++i) out.push_back(a + static_cast<double>(i) / (points - 1) * (b - a));
    return out;
}

std::optional<Slit> slit(const sim::Garment& garment, const std::vector<Vec3d>& x, const std::vector<Vec3d>& points,
                         const char* name)
{
    return viewer::slit(garment, x, on(garment, x, points), name);
}

/// Pieces that triangles with common vertices make.
std::size_t pieces(const sim::Garment& g)
{
    std::vector<std::uint32_t> root(g.start.size());
    std::iota(root.begin(), root.end(), 0u);
    const auto find = [&](std::uint32_t v) {
        while (root[v] != v) v = root[v] = root[root[v]];
        return v;
    };
    for (const auto& t : g.triangles) root[find(t[0])] = find(t[1]), root[find(t[1])] = find(t[2]);
    std::set<std::uint32_t> roots;
    for (const auto& t : g.triangles) roots.insert(find(t[0]));
    return roots.size();
}

/// #vertices - #edges + #triangles: 1 of a disc, one less with each hole.
long euler(const sim::Garment& g)
{
    std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
    std::set<std::uint32_t> used;
    for (const auto& t : g.triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            edges.insert(std::minmax(t[k], t[(k + 1) % 3]));
            used.insert(t[k]);
        }
    return static_cast<long>(used.size()) - static_cast<long>(edges.size()) + static_cast<long>(g.triangles.size());
}

double area(const std::vector<Vec3d>& p, const std::array<std::uint32_t, 3>& t)
{
    return 0.5 * norm(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]));
}

double area(const sim::Garment& g)
{
    double sum = 0;
    for (const auto& t : g.triangles) sum += area(g.flat, t);
    return sum;
}

TEST(Slit, AcrossTheClothMakesTwoPiecesOfIt)
{
    const auto cut = slit(sheet(), sheet().start, straight({-0.6, 1, 0.13}, {0.6, 1, -0.21}), "cut 1");
    ASSERT_TRUE(cut);
    EXPECT_EQ(pieces(sheet()), 1u);
    EXPECT_EQ(pieces(cut->garment), 2u);
    EXPECT_EQ(cut->garment.triangles.size(), sheet().triangles.size());
    EXPECT_EQ(cut->garment.start.size(), sheet().start.size() + cut->from.size());
    EXPECT_EQ(cut->positions.size(), cut->garment.start.size());
    EXPECT_NEAR(area(cut->garment), area(sheet()), 1e-12) << "nothing is lost or laid double";
    const sim::Seam& seam = cut->garment.seams.back();
    EXPECT_EQ(seam.name, "cut 1");
    EXPECT_FALSE(seam.sewn);
    EXPECT_EQ(seam.pairs.size(), cut->from.size());
    for (const auto& [a, b] : seam.pairs) {
        EXPECT_EQ(cut->positions[a], cut->positions[b]);
        EXPECT_EQ(cut->garment.flat[a], cut->garment.flat[b]);
    }
}

TEST(Slit, FollowsTheLineAndLeavesNoSliver)
{
    const Vec3d a{-0.3, 1, 0.13}, b{0.31, 1, -0.21};
    const auto cut = slit(sheet(), sheet().start, straight(a, b), "cut 1");
    ASSERT_TRUE(cut);
    const Vec3d along = (1 / norm(b - a)) * (b - a);
    std::vector<double> off;
    for (const auto& pair : cut->garment.seams.back().pairs) off.push_back(norm(cross(along, cut->positions[pair[0]] - a)));
    std::sort(off.begin(), off.end());
    const double spacing = 1.0 / std::sqrt(900.0);
    EXPECT_LT(off.back(), 0.4 * spacing);
    EXPECT_LT(off[off.size() / 2], 0.02 * spacing) << "most of its vertices lie on the line";
    double least = 1;
    for (const auto& t : cut->garment.triangles) least = std::min(least, area(cut->garment.flat, t));
    EXPECT_GT(least, 0.05 * 0.5 * spacing * spacing);
    // Flat cloth stays flat: the folds moved as the pattern did.
    for (const auto& t : cut->garment.triangles) EXPECT_NEAR(area(cut->positions, t), area(cut->garment.flat, t), 1e-12);
}

TEST(Slit, InsideTheClothOpensAHoleAndKeepsItsEnds)
{
    const auto cut = slit(sheet(), sheet().start, straight({-0.2, 1, 0}, {0.25, 1, 0.1}), "cut 1");
    ASSERT_TRUE(cut);
    EXPECT_EQ(pieces(cut->garment), 1u);
    EXPECT_EQ(euler(sheet()), 1);
    EXPECT_EQ(euler(cut->garment), 0);
}

TEST(Slit, SecondCutCrossesTheFirst)
{
    const auto first = slit(sheet(), sheet().start, straight({-0.6, 1, 0}, {0.6, 1, 0}), "cut 1");
    ASSERT_TRUE(first);
    const auto half = slit(first->garment, first->positions, straight({0.02, 1, 0.06}, {0.02, 1, 0.6}), "cut 2");
    ASSERT_TRUE(half);
    EXPECT_EQ(half->garment.seams.size(), 2u);
    EXPECT_LE(pieces(half->garment), 3u);
    EXPECT_NEAR(area(half->garment), area(sheet()), 1e-12);
}

TEST(Slit, KeepsSeamsAndWaistOnBothSides)
{
    const sim::Garment skirt = sim::skirt({.centre = {0, 1, 0}, .waist_radius = 0.15, .length = 0.5, .vertices = 900});
    const auto cut = slit(skirt, skirt.start, straight({0.14, 1, 0}, {0.66, 1, 0}), "cut 1");
    ASSERT_TRUE(cut);
    EXPECT_EQ(euler(skirt), 0);
    EXPECT_EQ(euler(cut->garment), 1) << "a ring that is cut open";
    EXPECT_GT(cut->garment.waist.size(), skirt.waist.size()) << "the waistband holds both sides";
    const sim::Garment shirt = sim::shirt({.vertices = 1200});
    const Vec3d middle = shirt.start[shirt.seams[0].pairs[shirt.seams[0].pairs.size() / 2][0]];
    const auto from_seam = slit(shirt, shirt.start, straight(middle, middle - Vec3d{0, 0.2, 0}), "cut 1");
    ASSERT_TRUE(from_seam);
    EXPECT_GT(from_seam->garment.seams[0].pairs.size(), shirt.seams[0].pairs.size()) << "both sides stay sewn";
}

TEST(Slit, RefusesWhatCutsNothing)
{
    EXPECT_FALSE(slit(sheet(), sheet().start, straight({0, 1, 0}, {0.001, 1, 0}), "cut 1")) << "too short";
    const std::vector<ClothPoint> none{{0, 0.3, 0.3}, {static_cast<std::uint32_t>(sheet().triangles.size()), 0.3, 0.3}};
    EXPECT_FALSE(viewer::slit(sheet(), sheet().start, none, "cut 1")) << "no such triangle";
    const std::vector<Vec3d> point{{0, 1, 0}};
    EXPECT_FALSE(slit(sheet(), sheet().start, point, "cut 1"));
    const sim::Garment shirt = sim::shirt({.vertices = 1200});
    const std::vector<Vec3d> through{{0, 1.2, 0.16}, {0, 1.2, -0.16}};
    EXPECT_FALSE(slit(shirt, shirt.start, through, "cut 1")) << "front and back are two panels";
}

TEST(Slit, EndsWhereThePanelEndsAndHeedsNoFoldUponIt)
{
    const sim::Garment shirt = sim::shirt({.vertices = 1200});
    // Down the front, then on to the back.
    std::vector<Vec3d> points = straight({0, 1.3, 0.16}, {0, 1.1, 0.16});
    points.push_back({0, 1.1, -0.16});
    const auto cut = slit(shirt, shirt.start, points, "cut 1");
    ASSERT_TRUE(cut);
    const std::vector<Vec3d> front(points.begin(), points.end() - 1);
    EXPECT_EQ(cut->garment.triangles, slit(shirt, shirt.start, front, "cut 1")->garment.triangles);
    // A sheet folded in two: the other half lies a millimetre below, its vertices as near as the own.
    std::vector<Vec3d> folded = sheet().start;
    for (Vec3d& p : folded)
        if (p.x > 0) p = {-p.x, 0.999, p.z};
    const auto line = on(sheet(), sheet().start, straight({-0.4, 1, 0.02}, {-0.1, 1, 0.05}));
    const auto flat = viewer::slit(sheet(), sheet().start, line, "cut 1"), fold = viewer::slit(sheet(), folded, line, "cut 1");
    ASSERT_TRUE(flat && fold);
    EXPECT_EQ(flat->garment.triangles, fold->garment.triangles);
}

}  // namespace
}  // namespace sqmap::viewer
