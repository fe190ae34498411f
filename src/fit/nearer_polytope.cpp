// Pattern search (R. Hooke, T. A. Jeeves, 1961) over the directions of a polytope's sides, one at a time, for the least support
// excess: the greatest distance of a corner from the hull, softened to a sum of powers so that each turn has a gain.
#include "fit/polytope.h"
#include "mesh/convex_hull.h"
#include "sqmap/mesh/bvh.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

namespace sqmap::fit {

namespace {

constexpr double k_widest_turn = 0.2, k_narrowest_turn = 0.01;  ///< radians
constexpr int k_sweeps_a_turn = 2;                              ///< over the sides, at most, before turns are halved
constexpr int k_swaps = 5;
constexpr int k_squarings = 4;  ///< distances count with their 16th power

/// Every point where three of some planes meet, and which sides do not hold it: the corners that are left when a side is taken
/// away are read off, and another side in its place changes only what it takes part in.
class Meetings {
public:
    explicit Meetings(std::vector<HalfSpaced> sides) : sides_(std::move(sides))
    {
        for (std::uint32_t i = 0; i < sides_.size(); ++i)
            for (std::uint32_t j = i + 1; j < sides_.size(); ++j)
                for (std::uint32_t k = j + 1; k < sides_.size(); ++k) meetings_.push_back(meeting(i, j, k));
    }

    void replace(std::size_t index, const HalfSpaced& side)
    {
        sides_[index] = side;
        const std::uint32_t bit = 1u << index;
        for (Meeting& m : meetings_)
            if ((m.of & bit) != 0)
                m = meeting(m.i, m.j, m.k);
            else if (m.is_point)
                m.missed_by = (m.missed_by & ~bit) | (mesh::nearly_holds(side, m.at) ? 0 : bit);
    }

    /// The sum of power(corner) over the corners that all sides but one have in common, and that side, where it is given, holds.
    template <class Power>
    double sum_without(std::size_t index, const HalfSpaced* instead, Power power)
    {
        const std::uint32_t bit = 1u << index;
        double sum = 0;
        for (Meeting& m : meetings_) {
            if (!m.is_point || (m.of & bit) != 0 || (m.missed_by & ~bit) != 0) continue;
            if (instead != nullptr && !(dot(instead->normal, m.at) <= instead->offset)) continue;
            if (m.power < 0) m.power = power(m.at);
            sum += m.power;
        }
        return sum;
    }

private:
    struct Meeting {
        Vec3d at;
        double power;                 ///< negative: not known yet
        std::uint32_t of, missed_by;  ///< bits of sides
        std::uint8_t i, j, k;
        bool is_point;
    };

    [[nodiscard]] Meeting meeting(std::uint32_t i, std::uint32_t j, std::uint32_t k) const
    {
        Meeting m{{},
                  -1,
                  1u << i | 1u << j | 1u << k,
                  0,
                  static_cast<std::uint8_t>(i),
                  static_cast<std::uint8_t>(j),
                  static_cast<std::uint8_t>(k),
                  false};
        m.is_point = mesh::meet(sides_[i], sides_[j], sides_[k], m.at);
        if (m.is_point)
            for (std::size_t s = 0; s < sides_.size(); ++s) m.missed_by |= mesh::nearly_holds(sides_[s], m.at) ? 0u : 1u << s;
        return m;
    }

    std::vector<HalfSpaced> sides_;
    std::vector<Meeting> meetings_;
};

class SideTurner {
public:
    SideTurner(const mesh::Mesh& hull, std::span<const HalfSpacef> sides, const Mat3d& frame)
        : hull_(hull), bvh_(hull), frame_(frame)
    {
        for (const HalfSpacef& side : sides) sides_.push_back(touching(cast<double>(side.normal)));
        unit_ = farthest();
    }

    /// Directions of sides whose farthest corner is nearer; empty where no turn brings it nearer.
    std::vector<Vec3d> run()
    {
        if (!(unit_ > 0)) return {};
        turn_while_better();
        for (int i = 0; i < k_swaps && swap_if_better(); ++i) {
        }
        std::vector<Vec3d> directions;
        if (farthest() < unit_)
            for (const HalfSpaced& side : sides_) directions.push_back(side.normal);
        return directions;
    }

private:
    [[nodiscard]] HalfSpaced touching(Vec3d direction) const
    {
        double support = -std::numeric_limits<double>::infinity();
        for (const Vec3d& p : hull_.vertices) support = std::max(support, dot(direction, p));
        return {direction, support};
    }

    [[nodiscard]] double farthest() const { return mesh::farthest_from_hull(hull_, mesh::polytope_corners(sides_)); }

    [[nodiscard]] double power(Vec3d corner) const
    {
        double power = bvh_.closest_point(corner).distance / unit_;
        for (int i = 0; i < k_squarings; ++i) power *= power;
        return power;
    }

    /// Infinite for sides that do not bound a solid.
    [[nodiscard]] double sum_of(std::span<const HalfSpaced> sides) const
    {
        if (!bound_a_solid(sides)) return std::numeric_limits<double>::infinity();
        double sum = 0;
        for (const Vec3d& p : mesh::polytope_corners(sides)) sum += power(p);
        return sum;
    }

    static bool bound_a_solid(std::span<const HalfSpaced> sides)
    {
        std::vector<Vec3d> directions;
        for (const HalfSpaced& side : sides) directions.push_back(side.normal);
        return is_bounded(directions);
    }

    void turn_while_better()
    {
        Meetings meetings(sides_);
        for (double by = k_widest_turn; by >= k_narrowest_turn; by *= 0.5)
            for (int sweep = 0; sweep < k_sweeps_a_turn; ++sweep) {
                bool is_better = false;
                for (std::size_t i = 0; i < sides_.size(); ++i) is_better = turn_if_better(meetings, i, by) || is_better;
                if (!is_better) break;
            }
    }

    bool turn_if_better(Meetings& meetings, std::size_t index, double by)
    {
        const Vec3d n = sides_[index].normal;
        const Vec3d across = normalized(cross(n, frame_.row[std::abs(dot(n, frame_.row[0])) < 0.6 ? 0 : 1])),
                    third = cross(n, across);
        std::vector<HalfSpaced> others = sides_;
        others.erase(others.begin() + static_cast<std::ptrdiff_t>(index));
        const auto sum_with = [&](const HalfSpaced& side) {
            double sum = meetings.sum_without(index, &side, [&](Vec3d p) { return power(p); });
            for (const Vec3d& p : mesh::corners_on(side, others)) sum += power(p);
            return sum;
        };
        double least = sum_with(sides_[index]);
        HalfSpaced best = sides_[index];
        for (const Vec3d& to : {across, -across, third, -third}) {
            const HalfSpaced side = touching(normalized(n + by * to));
            const double sum = sum_with(side);
            if (!(sum < least)) continue;
            std::vector<HalfSpaced> turned = sides_;
            turned[index] = side;
            if (!bound_a_solid(turned)) continue;
            least = sum;
            best = side;
        }
        if (best == sides_[index]) return false;
        sides_[index] = best;
        meetings.replace(index, best);
        return true;
    }

    /// Gives up the side that is missed least for one that cuts off the farthest corner; false, and all as it was, where that
    /// does not help.
    bool swap_if_better()
    {
        const std::vector<HalfSpaced> before = sides_;
        sides_.push_back(across_farthest_corner());
        std::vector<HalfSpaced> best = before;
        double least = std::numeric_limits<double>::infinity();
        Meetings meetings(sides_);
        for (std::size_t i = 0; i < before.size(); ++i) {
            std::vector<HalfSpaced> fewer = sides_;
            fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(i));
            const double sum = meetings.sum_without(i, nullptr, [&](Vec3d p) { return power(p); });
            if (sum < least && bound_a_solid(fewer)) {
                least = sum;
                best = std::move(fewer);
            }
        }
        sides_ = std::move(best);
        turn_while_better();
        const bool is_better = sum_of(sides_) < sum_of(before);
        if (!is_better) sides_ = before;
        return is_better;
    }

    [[nodiscard]] HalfSpaced across_farthest_corner() const
    {
        mesh::ClosestPoint nearest;
        nearest.distance = 0;
        Vec3d farthest{};
        for (const Vec3d& p : mesh::polytope_corners(sides_))
            if (const mesh::ClosestPoint to = bvh_.closest_point(p); to.distance > nearest.distance) {
                nearest = to;
                farthest = p;
            }
        return touching(normalized(farthest - nearest.point));
    }

    const mesh::Mesh& hull_;
    mesh::Bvh bvh_;
    const Mat3d& frame_;
    std::vector<HalfSpaced> sides_;
    double unit_ = 0;  ///< distance of the farthest corner before any turn
};

}  // namespace

std::vector<HalfSpacef> nearer_polytope(const mesh::Mesh& hull, std::span<const Vec3d> points, std::span<const HalfSpacef> sides,
                                        const Mat3d& frame)
{
    std::vector<HalfSpacef> nearer;
    for (const Vec3d& d : SideTurner(hull, sides, frame).run()) nearer.push_back(touching_side(d, points));
    return nearer;
}

}  // namespace sqmap::fit
