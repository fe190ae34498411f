#include "bake/parts/caps.h"

#include "sqmap/mesh/bvh.h"
#include "sqmap/mesh/mesh.h"
#include "support/baked_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

namespace sqmap::bake {
namespace {

using Key = std::tuple<double, double, double>;
Key key(Vec3d p) { return {p.x, p.y, p.z}; }

/// A patchwork that grows from random triangles: connected parts with ragged borders and many junctions.
decompose::Partition random_partition(const mesh::Mesh& mesh, std::uint32_t parts, std::uint64_t seed)
{
    test::Random random(seed);
    const mesh::DualGraph graph = mesh::dual_graph(mesh);
    decompose::Partition p;
    p.part_count = parts;
    p.part_of_triangle.assign(mesh.triangles.size(), mesh::k_no_triangle);
    std::vector<std::uint32_t> front;
    for (std::uint32_t i = 0; i < parts;) {
        const std::uint32_t t = random.below(mesh.triangles.size());
        if (p.part_of_triangle[t] != mesh::k_no_triangle) continue;
        p.part_of_triangle[t] = i++;
        front.push_back(t);
    }
    while (!front.empty()) {
        const std::uint32_t at = random.below(front.size()), t = front[at];
        std::vector<std::uint32_t> open;
        for (const std::uint32_t n : graph.neighbours[t])
            if (n != mesh::k_no_triangle && p.part_of_triangle[n] == mesh::k_no_triangle) open.push_back(n);
        if (open.empty()) {
            front[at] = front.back();
            front.pop_back();
            continue;
        }
        const std::uint32_t n = open[random.below(open.size())];
        p.part_of_triangle[n] = p.part_of_triangle[t];
        front.push_back(n);
    }
    return p;
}

std::vector<CapTriangle> closed_part(const mesh::Mesh& mesh, const decompose::Partition& p,
                                     const std::vector<std::vector<CapTriangle>>& caps, std::uint32_t part)
{
    std::vector<CapTriangle> all = caps[part];
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        if (p.part_of_triangle[t] == part)
            all.push_back(
                {mesh.vertices[mesh.triangles[t][0]], mesh.vertices[mesh.triangles[t][1]], mesh.vertices[mesh.triangles[t][2]]});
    return all;
}

/// Winding number of a closed surface by solid angles (van Oosterom and Strackee 1983).
double winding(const std::vector<CapTriangle>& triangles, Vec3d p)
{
    double sum = 0;
    for (const CapTriangle& t : triangles) {
        const Vec3d a = t[0] - p, b = t[1] - p, c = t[2] - p;
        const double la = norm(a), lb = norm(b), lc = norm(c);
        sum += 2 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
    }
    return sum / (4 * std::numbers::pi);
}

struct Case {
    test::Shape shape;
    decompose::Partition partition;
};

std::vector<Case> cases()
{
    std::vector<Case> out;
    for (test::Shape& shape : test::small_shapes())
        for (const std::uint32_t parts : {2u, 3u, 7u})
            out.push_back({shape, random_partition(shape.mesh, parts, 31 * parts + out.size())});
    return out;
}

TEST(Caps, CloseEveryPartOfARandomPatchwork)
{
    for (const Case& c : cases()) {
        const auto caps = cap_parts(c.shape.mesh, c.partition);
        ASSERT_EQ(caps.size(), c.partition.part_count);
        for (std::uint32_t part = 0; part < c.partition.part_count; ++part) {
            std::map<std::pair<Key, Key>, int> boundary;
            for (const CapTriangle& t : closed_part(c.shape.mesh, c.partition, caps, part))
                for (std::size_t i = 0; i < 3; ++i) {
                    const Key a = key(t[i]), b = key(t[(i + 1) % 3]);
                    if (a < b) ++boundary[{a, b}];
                    if (b < a) --boundary[{b, a}];
                }
            for (const auto& [edge, n] : boundary) ASSERT_EQ(n, 0) << c.shape.name << " part " << part << " has an open edge";
        }
    }
}

TEST(Caps, OfNeighboursCancelAsChains)
{
    for (const Case& c : cases()) {
        std::map<std::array<Key, 3>, int> chain;
        for (const auto& part : cap_parts(c.shape.mesh, c.partition))
            for (const CapTriangle& t : part) {
                std::array<Key, 3> k{key(t[0]), key(t[1]), key(t[2])};
                // An even permutation keeps the sign.
                std::rotate(k.begin(), std::min_element(k.begin(), k.end()), k.end());
                const int sign = k[1] < k[2] ? 1 : -1;
                if (sign < 0) std::swap(k[1], k[2]);
                chain[k] += sign;
            }
        for (const auto& [triangle, n] : chain) ASSERT_EQ(n, 0) << c.shape.name;
    }
}

TEST(Caps, MakeTheWindingNumbersOfThePartsAddUp)
{
    test::Random random(3);
    for (const Case& c : cases()) {
        if (c.shape.mesh.triangles.size() > 3000) continue;
        const auto caps = cap_parts(c.shape.mesh, c.partition);
        const mesh::Bvh bvh(c.shape.mesh);
        for (int i = 0; i < 30; ++i) {
            const Vec3d p = random.in_box({-1.5, -1, -1}, {1.5, 1, 1});
            if (bvh.closest_point(p).distance < 1e-3) continue;
            double sum = 0;
            for (std::uint32_t part = 0; part < c.partition.part_count; ++part) {
                const double w = winding(closed_part(c.shape.mesh, c.partition, caps, part), p);
                ASSERT_NEAR(w, std::round(w), 1e-6) << "a closed surface winds a whole number of times";
                sum += std::round(w);
            }
            EXPECT_EQ(sum, bvh.winding_number(p)) << c.shape.name << " at " << p.x << ' ' << p.y << ' ' << p.z;
        }
    }
}

TEST(Caps, OfASinglePartAreNone)
{
    const mesh::Mesh mesh = test::small_sphere();
    decompose::Partition p;
    p.part_count = 1;
    p.part_of_triangle.assign(mesh.triangles.size(), 0);
    EXPECT_TRUE(cap_parts(mesh, p).front().empty());
}

}  // namespace
}  // namespace sqmap::bake
