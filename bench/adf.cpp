// An adaptive distance field: Frisken, Perry, Rockwood, Jones, "Adaptively Sampled Distance Fields" (SIGGRAPH 2000). An
// octree whose leaves hold their eight corner distances; a cell is split while trilinear interpolation misses the exact
// distance at one of 19 test points (middles of edges, faces and the cell) by more than a tolerance. Cells that the solid
// cannot reach are left alone: their only answer is "outside".
#include "clock.h"
#include "distance_grid.h"
#include "field_bytes.h"
#include "method.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace sqmap::bench {
namespace {

struct Limits {
    double tolerance = 1e-3;      ///< of the object's diagonal
    std::uint32_t max_depth = 9;  ///< 512 cells along the root's side
};
constexpr std::uint32_t k_leaf = 0x80000000u;

class Adf final : public Method {
public:
    explicit Adf(const Setting& setting, Limits limits = {})
        : setting_(setting), limits_(limits), depths_(setting.probe.vertices.size())
    {
        for (const Vec3d& v : setting.probe.vertices) vertices_.push_back(cast<float>(v));
        const double start = process_seconds();
        double reach = 0;
        for (const Vec3d& v : setting.object.vertices)
            for (int k = 0; k < 3; ++k) reach = std::max(reach, std::abs(v[k]));
        side_ = 2.02 * reach;
        const Vec3d lo{-0.5 * side_, -0.5 * side_, -0.5 * side_};
        std::array<double, 8> corners;
        for (int c = 0; c < 8; ++c) corners[c] = signed_distance(setting.solid, lo + side_ * corner(c));
        nodes_.push_back(0);
        build(0, lo, side_, corners, 0);
        build_s = process_seconds() - start;
        bytes = nodes_.size() * sizeof nodes_[0] + leaves_.size() * sizeof leaves_[0];
    }

    void run(const Pose& pose) override
    {
        // Into the root's unit cube.
        Mat3f to_root;
        Vec3f origin;
        for (int i = 0; i < 3; ++i) {
            to_root.row[i] = cast<float>(pose.rotation.row[i] / side_);
            origin[i] = static_cast<float>(pose.translation[i] / side_ + 0.5);
        }
        for (std::size_t i = 0; i < vertices_.size(); ++i) {
            const Vec3f p = to_root * vertices_[i] + origin;
            depths_[i] = 0;
            if (!(p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x < 1 && p.y < 1 && p.z < 1)) continue;
            const float distance = look_up(p);
            if (distance < 0) depths_[i] = -distance;
        }
    }

    void read(FrameAnswer& out) const override
    {
        for (std::uint32_t i = 0; i < depths_.size(); ++i)
            if (depths_[i] > 0) out.vertices.push_back({i, depths_[i]});
    }

private:
    using Corners = std::array<float, 8>;  ///< x fastest

    static Vec3d corner(int c)
    {
        return {static_cast<double>(c & 1), static_cast<double>(c >> 1 & 1), static_cast<double>(c >> 2)};
    }

    static double trilinear(const std::array<double, 8>& v, Vec3d f)
    {
        const auto row = [&](int i) { return v[i] + f.x * (v[i + 1] - v[i]); };
        const auto face = [&](int i) { return row(i) + f.y * (row(i + 2) - row(i)); };
        return face(0) + f.z * (face(4) - face(0));
    }

    void build(std::uint32_t node, Vec3d lo, double side, const std::array<double, 8>& corners, std::uint32_t depth)
    {
        // Exact distances at the 27 points of the cell's 2 x 2 x 2 halves: 8 are known, 19 are tests and, if the cell is
        // split, corners of its children.
        std::array<double, 27> exact;
        double error = 0;
        const double centre = signed_distance(setting_.solid, lo + 0.5 * side * Vec3d{1, 1, 1});
        const bool reached = centre <= 0.5 * std::sqrt(3.0) * side;
        if (reached && depth < limits_.max_depth) {
            for (int i = 0; i < 27; ++i) {
                const Vec3d f{0.5 * (i % 3), 0.5 * (i / 3 % 3), 0.5 * (i / 9)};
                const bool is_corner = i % 3 != 1 && i / 3 % 3 != 1 && i / 9 != 1;
                exact[i] = is_corner ? corners[(i % 3 / 2) + 2 * (i / 3 % 3 / 2) + 4 * (i / 9 / 2)]
                           : i == 13 ? centre
                                     : signed_distance(setting_.solid, lo + side * f);
                error = std::max(error, std::abs(exact[i] - trilinear(corners, f)));
            }
        }
        if (error <= limits_.tolerance) {
            nodes_[node] = k_leaf | static_cast<std::uint32_t>(leaves_.size());
            Corners& leaf = leaves_.emplace_back();
            std::transform(corners.begin(), corners.end(), leaf.begin(), [](double v) { return static_cast<float>(v); });
            return;
        }
        const auto first = static_cast<std::uint32_t>(nodes_.size());
        nodes_[node] = first;
        nodes_.resize(nodes_.size() + 8);
        for (int child = 0; child < 8; ++child) {
            std::array<double, 8> of_child;
            for (int c = 0; c < 8; ++c)
                of_child[c] =
                    exact[(child & 1) + (c & 1) + 3 * ((child >> 1 & 1) + (c >> 1 & 1)) + 9 * ((child >> 2) + (c >> 2))];
            build(first + static_cast<std::uint32_t>(child), lo + 0.5 * side * corner(child), 0.5 * side, of_child, depth + 1);
        }
    }

    [[nodiscard]] float look_up(Vec3f p) const
    {
        std::uint32_t node = nodes_[0];
        while ((node & k_leaf) == 0) {
            std::uint32_t child = 0;
            for (int k = 0; k < 3; ++k) {
                p[k] *= 2;
                const bool upper = p[k] >= 1;
                p[k] -= upper ? 1.0f : 0.0f;
                child |= (upper ? 1u : 0u) << k;
            }
            node = nodes_[node + child];
        }
        const Corners& v = leaves_[node & ~k_leaf];
        const auto row = [&](int i) { return v[i] + p.x * (v[i + 1] - v[i]); };
        const auto face = [&](int i) { return row(i) + p.y * (row(i + 2) - row(i)); };
        return face(0) + p.z * (face(4) - face(0));
    }

    const Setting& setting_;
    const Limits limits_;
    double side_ = 0;
    std::vector<std::uint32_t> nodes_;  ///< first of eight children, or k_leaf and a leaf
    std::vector<Corners> leaves_;
    std::vector<Vec3f> vertices_;
    std::vector<float> depths_;
};

}  // namespace

std::unique_ptr<Method> make_adf(const Setting& setting, int) { return std::make_unique<Adf>(setting); }

std::size_t adf_bytes(const Setting& setting, FieldDensity density)
{
    const auto depth = static_cast<std::uint32_t>(std::countr_zero(density.cells));
    return Adf(setting, {.max_depth = depth}).bytes;
}

}  // namespace sqmap::bench
