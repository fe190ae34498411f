// Section 5's regions: Q2 against rays cast by brute force in double from feet found by a search, labels against the partition.
#include "paper/bake/regions.h"

#include "sqmap/mesh/shapes.h"
#include "sqmap/shape/surface.h"
#include "support/paper_model.h"
#include "support/shared_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <tuple>

namespace sqmap::paper {
namespace {

using test::PaperModel;

/// Parts alone count: the coarsest maps will do.
PaperModel coarse_model(const mesh::Mesh& mesh)
{
    return PaperModel(mesh, {.target_error = 100, .exact = false}, {.grid = {9, 16}, .subdivisions = 0});
}

mesh::Mesh in_model_space_of(const model::ModelView& view, const mesh::Mesh& mesh)
{
    const model::Header& h = view.header;
    return mesh::normalized(mesh, {{h.origin[0], h.origin[1], h.origin[2]}, h.unit});
}

/// The nearest point of a superquadric: the nearest of a grid of samples, then a pattern search about it; from the nearest sample
/// of each octant, as far as that can lead to the nearest point.
class NearestBySearch {
public:
    explicit NearestBySearch(const shape::Superquadricd& superquadric) : superquadric_(superquadric)
    {
        for (int i = 0; i <= k_rows; ++i)
            for (int j = 0; j < 2 * k_rows; ++j) {
                angles_.push_back({k_pi_here * (double(i) / k_rows - 0.5), k_pi_here * (double(j) / k_rows - 1)});
                points_.push_back(at(angles_.back()));
            }
    }
    [[nodiscard]] Vec3d of(Vec3d p) const
    {
        std::array<std::size_t, 8> best{};
        best.fill(points_.size());
        for (std::size_t k = 0; k < points_.size(); ++k) {
            std::size_t& of_octant = best[octant(angles_[k])];
            if (of_octant == points_.size() || norm_sq(points_[k] - p) < norm_sq(points_[of_octant] - p)) of_octant = k;
        }
        std::sort(best.begin(), best.end(),
                  [&](std::size_t l, std::size_t r) { return norm_sq(points_[l] - p) < norm_sq(points_[r] - p); });
        Vec3d nearest = from(p, best[0]);
        for (std::size_t k = 1; k < best.size(); ++k)
            if (norm(points_[best[k]] - p) < 1.2 * norm(nearest - p))
                if (const Vec3d q = from(p, best[k]); norm_sq(q - p) < norm_sq(nearest - p)) nearest = q;
        return nearest;
    }

private:
    static constexpr int k_rows = 64;
    static constexpr double k_pi_here = 3.14159265358979323846;
    static std::size_t octant(shape::SurfaceAngles<double> a)
    {
        return (a.eta < 0 ? 0u : 4u) +
               std::min<std::size_t>(3, static_cast<std::size_t>((a.omega + k_pi_here) / (k_pi_here / 2)));
    }
    [[nodiscard]] Vec3d from(Vec3d p, std::size_t sample) const
    {
        shape::SurfaceAngles<double> a = angles_[sample];
        Vec3d nearest = points_[sample];
        for (double step = k_pi_here / k_rows; step > 1e-9;) {
            bool better = false;
            for (const auto& [e, o] : {std::pair{step, 0.}, {-step, 0.}, {0., step}, {0., -step}}) {
                const shape::SurfaceAngles<double> tried{std::clamp(a.eta + e, -k_pi_here / 2, k_pi_here / 2), a.omega + o};
                const Vec3d q = at(tried);
                if (norm_sq(q - p) >= norm_sq(nearest - p)) continue;
                nearest = q;
                a = tried;
                better = true;
            }
            if (!better) step /= 2;
        }
        return nearest;
    }
    [[nodiscard]] Vec3d at(shape::SurfaceAngles<double> a) const { return shape::surface_point(superquadric_, a).point; }

    shape::Superquadricd superquadric_;
    std::vector<shape::SurfaceAngles<double>> angles_;
    std::vector<Vec3d> points_;
};

/// Moeller and Trumbore, over every triangle.
bool crosses_any(const mesh::Mesh& m, Vec3d from, Vec3d to)
{
    const Vec3d d = to - from;
    return std::any_of(m.triangles.begin(), m.triangles.end(), [&](const mesh::Triangle& t) {
        const Vec3d a = m.vertices[t[0]], ab = m.vertices[t[1]] - a, ac = m.vertices[t[2]] - a;
        const Vec3d h = cross(d, ac);
        const double det = dot(ab, h);
        if (det == 0) return false;
        const Vec3d s = from - a;
        const double u = dot(s, h) / det;
        if (u < 0 || u > 1) return false;
        const Vec3d q = cross(s, ab);
        const double v = dot(d, q) / det, at = dot(ac, q) / det;
        return v >= 0 && u + v <= 1 && at > 0 && at < 1;
    });
}

/// The share of a part's area whose triangles' middles are hidden from the nearest point of its superquadric.
double hidden_by_brute_force(const mesh::Mesh& m, const std::vector<std::uint32_t>& triangles, const shape::Superquadricd& sq)
{
    const NearestBySearch nearest(sq);
    const double margin = 1e-4 * std::max({sq.a.x, sq.a.y, sq.a.z});
    double hidden = 0, total = 0;
    for (const std::uint32_t t : triangles) {
        const double area = mesh::triangle_area(m, t);
        total += area;
        const Vec3d p = mesh::triangle_centroid(m, t), foot = nearest.of(p);
        const double depth = norm(foot - p);
        if (depth > 2 * margin && crosses_any(m, foot, p + margin / depth * (foot - p))) hidden += area;
    }
    return total > 0 ? hidden / total : 0;
}

TEST(Feet, OfBoxesAndRodsAreTheNearestPoints)
{
    std::mt19937 random(7);
    std::uniform_real_distribution<double> within(-1, 1);
    for (const auto& [eps1, eps2, bend] :
         {std::tuple{0.12, 0.12, 0.}, {0.84, 0.12, 0.}, {0.3, 1.9, 0.}, {0.12, 0.76, 0.3}, {1., 1., 0.}}) {
        shape::Superquadricd sq;
        sq.a = {0.5, 0.8, 1.3};
        sq.eps1 = eps1;
        sq.eps2 = eps2;
        sq.bend = bend;
        const ExactFeet feet(sq);
        const NearestBySearch search(sq);
        for (int i = 0; i < 400;) {
            const Vec3d p{0.5 * within(random), 0.8 * within(random), 1.3 * within(random)};
            if (shape::implicit(sq, p) >= 1) continue;
            ++i;
            const shape::Foot<double> foot = feet.of(p);
            EXPECT_TRUE(foot.converged) << eps1 << ' ' << eps2 << " at " << p.x << ' ' << p.y << ' ' << p.z;
            EXPECT_LT(norm(foot.point - p), norm(search.of(p) - p) + 1e-5) << eps1 << ' ' << eps2;
        }
    }
}

class RegionsOfMesh : public testing::TestWithParam<const char*> {};

TEST_P(RegionsOfMesh, HaveTheQ2OfRaysCastByBruteForce)
{
    const std::optional<mesh::Mesh> found = test::shared_mesh(GetParam());
    if (!found) return test::skip_without(GetParam());
    const PaperModel model = coarse_model(*found);
    const mesh::Mesh m = in_model_space_of(model.view(), *found);
    const ModelView view = model.data().view();
    ASSERT_EQ(view.maps.labels.size(), m.triangles.size());
    std::vector<std::vector<std::uint32_t>> triangles(view.maps.records.size());
    for (std::uint32_t t = 0; t < m.triangles.size(); ++t) triangles[decode_label(view.maps.labels[t]).part].push_back(t);
    double printed = 0, brute = 0, total = 0;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        double area = 0, labelled = 0;
        for (const std::uint32_t t : triangles[i]) {
            area += mesh::triangle_area(m, t);
            if (decode_label(view.maps.labels[t]).region == Region::Q2) labelled += mesh::triangle_area(m, t);
        }
        const double share = double(view.maps.records[i].grid.q2_share);
        EXPECT_NEAR(labelled, share * area, 1e-6 * area) << "part " << i;
        const double exact = hidden_by_brute_force(m, triangles[i], shape::cast<double>(map_of(view, i).superquadric));
        EXPECT_NEAR(100 * share, 100 * exact, 1) << "part " << i;
        printed += share * area;
        brute += exact * area;
        total += area;
    }
    EXPECT_NEAR(100 * printed / total, 100 * brute / total, 0.1);
    EXPECT_NEAR(view.common.measured.q2_share, 100 * brute / total, 0.1);
    RecordProperty("q2_percent", std::to_string(100 * printed / total));
    RecordProperty("brute_percent", std::to_string(100 * brute / total));
}

INSTANTIATE_TEST_SUITE_P(Ten, RegionsOfMesh,
                         testing::Values("elephant_10272.obj", "horse_5946.obj", "camel_4512.obj", "cat_8108.obj",
                                         "bull_7154.obj", "armadillo_10000.obj", "hand_9344.obj", "hand_9556.obj",
                                         "bunny_6966.obj", "fertility_9000.obj"),
                         [](const auto& test) { return std::string(test.param, std::string(test.param).find('.')); });

std::set<Region> regions_of(const mesh::Mesh& mesh)
{
    const PaperModel model = coarse_model(mesh);
    std::set<Region> out;
    for (const std::uint16_t code : model.data().maps.labels) out.insert(decode_label(code).region);
    return out;
}

TEST(Regions, OfAConvexSolidAreConvex) { EXPECT_EQ(regions_of(mesh::ellipsoid({1.6, 1, 0.5}, 3)), std::set{Region::Convex}); }

TEST(Regions, AWaistIsConcaveAndSeenByItsFoot)
{
    // One superquadric about all of a dumbbell: the bar's ends are creases that no ball hides.
    const mesh::Mesh m = mesh::dumbbell({.segments = 24});
    const mesh::Bvh bvh(m);
    std::vector<std::uint32_t> all(m.triangles.size());
    std::iota(all.begin(), all.end(), 0u);
    std::vector<TriangleLabel> labels(all.size());
    label_concave(m, labels);
    shape::Superquadricd sq;
    sq.a = {1.2, 1.2, 3};
    sq.eps1 = 0.4;
    EXPECT_EQ(label_hidden({bvh, m, all}, ExactFeet(sq), labels), 0);
    bool is_concave = false;
    for (const std::uint32_t t : all) {
        if (labels[t].region == Region::Convex) continue;
        is_concave = true;
        EXPECT_EQ(labels[t].region, Region::Q1);
        EXPECT_LT(std::abs(mesh::triangle_centroid(m, t).z), 1.1) << "of a bar between balls at 1.8 of radius 1";
    }
    EXPECT_TRUE(is_concave);
}

TEST(Regions, OfARingInATallCylinderAreHiddenInside)
{
    const mesh::Mesh m = mesh::torus({.major_radius = 1, .minor_radius = 0.35});
    const mesh::Bvh bvh(m);
    std::vector<std::uint32_t> all(m.triangles.size());
    std::iota(all.begin(), all.end(), 0u);
    std::vector<TriangleLabel> labels(all.size());
    shape::Superquadricd sq;
    sq.a = {1.4, 1.4, 1.8};
    sq.eps1 = 0.3;
    const double share = label_hidden({bvh, m, all}, ExactFeet(sq), labels);
    EXPECT_NEAR(share, hidden_by_brute_force(m, all, sq), 1e-3);
    EXPECT_NEAR(hidden_from_feet({bvh, m, all}, ExactFeet(sq)), share, 1e-12);
    EXPECT_NEAR(hidden_from_feet({bvh, m, all}, ExactFeet(sq), 300), share, 0.1) << "of every 15th triangle";
    for (const std::uint32_t t : all) {
        const Vec3d c = mesh::triangle_centroid(m, t);
        if (labels[t].region == Region::Q2) {
            EXPECT_LT(std::hypot(c.x, c.y), 1.05) << "the inner side";
        }
    }
}

TEST(MaxQ2, CutsPartsThatTheirFeetDoNotSee)
{
    // Neither looseness nor curvature cuts: what is cut on top is cut because it is hidden.
    bake::BakeOptions options{.target_error = 100, .exact = false};
    options.max_looseness = 1e6;
    options.max_q2_share = 1;
    options.decompose.hyperbolic_curvature = 1000;
    const mesh::Mesh hand = test::small_hand();
    const MapOptions maps{.grid = {9, 16}, .subdivisions = 0};
    const BakeResult as_it_is = bake(hand, true, options, maps);
    options.max_q2_share = 0.005;
    const BakeResult cut = bake(hand, true, options, maps);
    EXPECT_GT(as_it_is.model.common.measured.q2_share, 0.5);
    EXPECT_GT(cut.report.parts.size(), as_it_is.report.parts.size());
    EXPECT_LT(cut.model.common.measured.q2_share, 0.7 * as_it_is.model.common.measured.q2_share);
    options.threads = 3;
    EXPECT_EQ(serialize(bake(hand, true, options, maps).model), serialize(cut.model)) << "on three threads";
}

TEST(Labels, AreThePartsThatTheBakeReports)
{
    const mesh::Mesh hand = test::small_hand();
    const BakeResult baked = bake(hand, true, {.target_error = 100, .exact = false}, MapOptions{.grid = {9, 16}});
    const std::vector<std::uint32_t>& parts = baked.report.partition.part_of_triangle;
    ASSERT_EQ(baked.model.maps.labels.size(), parts.size());
    for (std::size_t t = 0; t < parts.size(); ++t) EXPECT_EQ(decode_label(baked.model.maps.labels[t]).part, parts[t]);
}

TEST(Labels, ComeBackFromTheirCode)
{
    for (const std::uint32_t part : {0u, 1u, 8191u, (1u << k_label_part_bits) - 1})
        for (const Region region : {Region::Convex, Region::Q1, Region::Q2}) {
            const TriangleLabel label = decode_label(encode_label({part, region}));
            EXPECT_EQ(label.part, part);
            EXPECT_EQ(label.region, region);
        }
}

TEST(Labels, OfPartsAndRegionsThatThereAreNotAreRefused)
{
    const BakeResult baked = bake(test::small_sphere(), true, {.target_error = 100, .exact = false}, MapOptions{.grid = {9, 16}});
    const auto status_with = [&](auto change) {
        ModelData data = baked.model;
        change(data.maps.labels);
        const std::vector<std::byte> bytes = serialize(data);
        ModelView view;
        return parse(bytes, view);
    };
    EXPECT_EQ(status_with([](auto&) {}), model::ParseStatus::Ok);
    EXPECT_EQ(status_with([](auto& l) { l.clear(); }), model::ParseStatus::Ok) << "no labels are none of a wrong part";
    EXPECT_EQ(status_with([](auto& l) { l[0] = encode_label({1, Region::Convex}); }), model::ParseStatus::BadValue);
    EXPECT_EQ(status_with([](auto& l) { l[0] = 3u << k_label_part_bits; }), model::ParseStatus::BadValue);
    EXPECT_EQ(status_with([](auto& l) { l.pop_back(); }), model::ParseStatus::BadValue);
}

TEST(Counts, OfAMapsRaysAddUpToItsSamples)
{
    const PaperModel model = coarse_model(test::small_hand());
    const ModelView view = model.data().view();
    for (std::size_t i = 0; i < view.maps.records.size(); ++i) {
        const MapView map = map_of(view, i);
        const MapCounts counts = counts_of(map);
        EXPECT_EQ(counts.hits + counts.caps + counts.misses, map.distance.size());
        EXPECT_GT(counts.hits, 0u);
        EXPECT_LE(map.occluded_vertices, map.vertex_count);
    }
}

}  // namespace
}  // namespace sqmap::paper
