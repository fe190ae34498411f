// The triangles that can be the nearest to some point of a box.
#pragma once

#include "bake/locator/rulers.h"
#include "math/triangle.h"
#include "math/triangle_offsets.h"
#include "sqmap/mesh/solid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

namespace sqmap::bake {

/// By how much larger a cell is taken for its list: a point that is queried there may lie beside it by rounding.
constexpr double k_near_slack = 1.0005;

/// A box is judged at the points of a lattice and in the boxes between them, so many along a side.
template <std::size_t k_boxes>
struct BoxLattice {
    static constexpr std::size_t k_side = k_boxes, k_along = k_side + 1;  ///< points along a side, x fastest
    static constexpr std::size_t k_points = k_along * k_along * k_along;
    static constexpr std::size_t k_capacity = (k_points + k_point_step - 1) / k_point_step * k_point_step;
    /// From a small box's lowest corner to its corners, in lattice points.
    static constexpr std::size_t k_steps[8] = {
        0, 1, k_along, k_along + 1, k_along* k_along, k_along* k_along + 1, k_along*(k_along + 1), k_along*(k_along + 1) + 1};
};
/// The triangles nearest to some point of the box about centre of half side h, and a few more; those that are nearest most often
/// first. The distance to a triangle is convex. So in a box it is at most the multilinear function of its values at the corners,
/// and at least its tangent plane at any point; where one triangle's plane is above another's values at all corners, it is
/// nowhere the nearest.
class NearTriangles {
public:
    /// Boxes about centres, all within the box about middle of half side half. distance: of the boundary from the middle, or no
    /// less than that.
    void begin(const mesh::Solid& solid, Vec3d middle, double half, std::span<const Vec3d> centres, double distance)
    {
        solid_ = &solid;
        within_.clear();
        corners_.clear();
        const double reach = (distance + 2 * std::sqrt(3.0) * half) * (1 + 1e-6);
        solid_->bvh().visit_nearest(middle, reach * reach, [&](std::uint32_t t, double radius_sq) {
            if (solid_->boundary()[t] != mesh::Boundary::Buried) within_.push_back(t);
            return radius_sq;
        });
        std::sort(within_.begin(), within_.end());
        put_corners(within_, middle);
        // The last column is the middle itself.
        centres_ = (centres.size() + k_point_step) / k_point_step * k_point_step;
        for (std::size_t k = 0; k < 3; ++k) {
            centre_[k].resize(centres_);
            for (std::size_t i = 0; i < centres_; ++i) {
                const Vec3d p = i < centres.size() ? centres[i] - middle : Vec3d{};
                centre_[k][i] = static_cast<float>(p[static_cast<int>(k)]);
            }
            grow(to_centre_[k], within_.size() * centres_);
        }
        grow(from_centre_, within_.size() * centres_);
        triangle_offsets(corners_, {centre_[0].data(), centre_[1].data(), centre_[2].data(), centres_}, to_centre_[0].data(),
                         to_centre_[1].data(), to_centre_[2].data(), from_centre_.data());
        all_.resize(within_.size());
        std::iota(all_.begin(), all_.end(), 0u);
        collect(all_, centres_ - 1, middle, half, some_);
    }

    /// The candidates of the box about the centre of that number.
    const std::vector<std::uint32_t>& operator()(std::size_t number, Vec3d centre, double h, bool fine)
    {
        collect(some_, number, centre, h, chosen_);
        triangles_.clear();
        for (const std::uint32_t i : chosen_) triangles_.push_back(within_[i]);
        judge<Coarse>(centre, h);
        if (fine) {
            triangles_ = near_;
            std::sort(triangles_.begin(), triangles_.end());
            judge<Fine>(centre, h);
        }
        return near_;
    }

private:
    /// The candidates that the coarse lattice leaves are judged on the fine one; where time counts more than a fifth of the
    /// bytes, they are the list.
    using Coarse = BoxLattice<2>;
    using Fine = BoxLattice<4>;
    /// Bound of the rounding of float, in half sides of the box.
    static constexpr double k_slack = 1e-4;
    static constexpr std::uint32_t k_none = 0xffffffffu;

    /// All of it is written over: what is there need not be cleared.
    static void grow(std::vector<float>& values, std::size_t count)
    {
        if (values.size() < count) values.resize(count);
    }

    Vec3d closest(std::uint32_t triangle, Vec3d p) const
    {
        const mesh::Triangle& t = solid_->mesh().triangles[triangle];
        const auto& v = solid_->mesh().vertices;
        return closest_point_on_triangle(p, v[t[0]], v[t[1]], v[t[2]]);
    }

    void put_corners(std::span<const std::uint32_t> triangles, Vec3d from)
    {
        corners_.clear();
        for (const std::uint32_t t : triangles)
            for (const std::uint32_t v : solid_->mesh().triangles[t])
                corners_.push_back(cast<float>(solid_->mesh().vertices[v] - from));
    }

    /// Whatever is no farther from the centre than the nearest by more than the box's diagonal, and not ruled out by that one.
    /// from, to: indices in within_.
    void collect(const std::vector<std::uint32_t>& from, std::size_t number, Vec3d centre, double h,
                 std::vector<std::uint32_t>& to) const
    {
        to.clear();
        std::size_t nearest = within_.size();
        for (const std::uint32_t i : from)
            if ((nearest == within_.size() || from_centre_[i * centres_ + number] < from_centre_[nearest * centres_ + number]) &&
                solid_->boundary()[within_[i]] == mesh::Boundary::Whole)
                nearest = i;
        if (nearest == within_.size()) {
            to = from;
            return;
        }
        const auto corner = [&](int k) { return h * Vec3d{k & 1 ? 1. : -1., k & 2 ? 1. : -1., k & 4 ? 1. : -1.}; };
        double limit[8];
        for (int k = 0; k < 8; ++k)
            limit[k] = norm(centre + corner(k) - closest(within_[nearest], centre + corner(k))) + k_slack * h;
        const auto fh = static_cast<float>(h);
        const float reach = from_centre_[nearest * centres_ + number] + (2 * 1.7321f + static_cast<float>(k_slack)) * fh;
        for (const std::uint32_t i : from) {
            const std::size_t at = i * centres_ + number;
            const float distance = from_centre_[at];
            if (distance > reach) continue;
            bool above = i != nearest && distance > fh * static_cast<float>(k_slack);
            const float scale = above ? -fh / distance : 0;
            for (int k = 0; k < 8 && above; ++k)
                above = static_cast<double>(distance + scale * ((k & 1 ? 1.f : -1.f) * to_centre_[0][at] +
                                                                (k & 2 ? 1.f : -1.f) * to_centre_[1][at] +
                                                                (k & 4 ? 1.f : -1.f) * to_centre_[2][at])) > limit[k];
            if (!above) to.push_back(i);
        }
    }

    /// The triangles that are nearest somewhere on a lattice, or that some of its small boxes cannot rule out.
    template <class L>
    void judge(Vec3d centre, double h)
    {
        measure<L>(centre, h);
        near_.clear();
        wins_.assign(triangles_.size(), 0);
        for (std::size_t i = 0; i < L::k_points; ++i)
            if (nearest_[i] != k_none) ++wins_[nearest_[i]];
        order_.clear();
        auto& losers = losers_;
        losers.clear();
        for (std::uint32_t t = 0; t < triangles_.size(); ++t) (wins_[t] > 0 ? order_ : losers).push_back(t);
        const float side = static_cast<float>(2 * h / L::k_side), slack = static_cast<float>(k_slack * h);
        const std::size_t out = rule_out<L>(0, losers.size(), 0, L::k_side, side, slack);
        order_.insert(order_.end(), losers.begin() + static_cast<std::ptrdiff_t>(out), losers.end());
        std::sort(order_.begin(), order_.end(), [&](std::uint32_t l, std::uint32_t r) {
            return wins_[l] != wins_[r] ? wins_[l] > wins_[r] : triangles_[l] < triangles_[r];
        });
        for (const std::uint32_t t : order_) near_.push_back(triangles_[t]);
    }

    /// Distances from the lattice, relative to the centre so that float is enough, and the nearest of each of its points. A
    /// triangle that is cut may not be boundary where it is nearest, and rules out nothing.
    template <class L>
    void measure(Vec3d centre, double h)
    {
        put_corners(triangles_, centre);
        for (std::size_t i = 0; i < L::k_capacity; ++i) {
            const std::size_t p = std::min(i, L::k_points - 1);
            const auto coordinate = [&](std::size_t k) {
                return static_cast<float>(h * (2.0 / L::k_side * static_cast<double>(k % L::k_along) - 1));
            };
            point_[0][i] = coordinate(p);
            point_[1][i] = coordinate(p / L::k_along);
            point_[2][i] = coordinate(p / (L::k_along * L::k_along));
        }
        for (auto* values : {&offset_[0], &offset_[1], &offset_[2], &distance_}) grow(*values, triangles_.size() * L::k_capacity);
        triangle_offsets(corners_, {point_[0].data(), point_[1].data(), point_[2].data(), L::k_capacity}, offset_[0].data(),
                         offset_[1].data(), offset_[2].data(), distance_.data());
        nearest_.fill(k_none);
        least_.fill(INFINITY);
        std::uint32_t* __restrict nearest = nearest_.data();
        float* __restrict least = least_.data();
        for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
            if (solid_->boundary()[triangles_[t]] != mesh::Boundary::Whole) continue;
            const float* __restrict d = &distance_[t * L::k_capacity];
            for (std::size_t i = 0; i < L::k_capacity; ++i) {
                const std::uint32_t nearer = d[i] < least[i] ? 0xffffffffu : 0u;
                nearest[i] = (nearest[i] & ~nearer) | (t & nearer);
                least[i] = std::min(d[i], least[i]);
            }
        }
    }

    /// Moves those of count losers to the front that are nearest nowhere in the box whose lowest corner is lattice point low and
    /// which has boxes small ones a side; returns their number.
    template <class L>
    std::size_t rule_out(std::size_t first, std::size_t count, std::size_t low, std::size_t boxes, float small_side, float slack)
    {
        const float side = small_side * static_cast<float>(boxes);
        auto& losers = losers_;
        Rulers rulers;
        std::size_t corners[8];
        for (std::size_t k = 0; k < 8; ++k) corners[k] = low + L::k_steps[k] * boxes;
        for (const std::size_t at : corners) {
            const std::uint32_t r = nearest_[at];
            if (r == k_none || std::find(rulers.triangle, rulers.triangle + rulers.count, r) != rulers.triangle + rulers.count)
                continue;
            for (std::size_t k = 0; k < 8; ++k) rulers.value[rulers.count][k] = distance_[r * L::k_capacity + corners[k]];
            rulers.triangle[rulers.count++] = r;
        }
        std::size_t out = first;
        for (std::size_t i = first; i < first + count; ++i) {
            const std::uint32_t t = losers[i];
            // Distances change no faster than positions.
            if (distance_[t * L::k_capacity + low] - least_[low] > 2 * 1.7321f * side + slack ||
                is_above<L>(t, corners, rulers, boxes == 1, side, slack))
                std::swap(losers[out++], losers[i]);
        }
        if (boxes == 1) return out - first;
        // The others have to lose in every small box.
        std::size_t still = first + count - out;
        for (std::size_t k = 0; k < 8 && still > 0; ++k)
            still = rule_out<L>(out, still, low + L::k_steps[k] * (boxes / 2), boxes / 2, small_side, slack);
        return out - first + still;
    }

    /// By the planes at the corners; all of them, or the most promising one.
    template <class L>
    bool is_above(std::uint32_t t, const std::size_t (&corners)[8], const Rulers& rulers, bool all, float side, float slack) const
    {
        // The plane that touches where it matters most is the best as a rule; in the end all are tried.
        const std::size_t first = t * L::k_capacity;
        std::size_t nearest = 0;
        float least_margin = INFINITY;
        for (std::size_t k = 0; k < 8; ++k) {
            const float margin = distance_[first + corners[k]] - least_[corners[k]];
            nearest = margin < least_margin ? k : nearest;
            least_margin = std::min(margin, least_margin);
        }
        if (!(least_margin > slack)) return false;
        const LatticeDistances mine{&distance_[first], {&offset_[0][first], &offset_[1][first], &offset_[2][first]}};
        return rulers.rule_out(mine, corners, nearest, all ? 8 : 1, side, slack);
    }

    const mesh::Solid* solid_ = nullptr;
    std::vector<std::uint32_t> triangles_, near_, order_, wins_, losers_;
    std::vector<Vec3f> corners_;
    // Triangles that can be nearest somewhere in the boxes, and their distances from the boxes' centres.
    std::vector<std::uint32_t> within_, all_, some_, chosen_;
    std::size_t centres_ = 0;
    std::vector<float> centre_[3], to_centre_[3], from_centre_;
    std::array<float, Fine::k_capacity> point_[3];
    std::vector<float> offset_[3], distance_;              // triangle after triangle, the lattice's values each
    std::array<std::uint32_t, Fine::k_capacity> nearest_;  // on the lattice
    std::array<float, Fine::k_capacity> least_;
};

}  // namespace sqmap::bake
