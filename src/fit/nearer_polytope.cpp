// Pattern search (R. Hooke, T. A. Jeeves, 1961) over the directions of a polytope's sides, one at a time, for the least support
// excess: the greatest distance of a corner from the hull, softened to a sum of powers so that each turn has a gain.
#include "fit/polytope.h"
#include "mesh/convex_hull.h"
#include "sqmap/mesh/bvh.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

namespace sqmap::fit {

namespace {

constexpr double k_widest_turn = 0.2, k_narrowest_turn = 0.01;  ///< radians
constexpr int k_sweeps_a_turn = 2;                              ///< over the sides, at most, before turns are halved
constexpr int k_swaps = 5;
constexpr int k_squarings = 4;  ///< distances count with their 16th power

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
        for (double by = k_widest_turn; by >= k_narrowest_turn; by *= 0.5)
            for (int sweep = 0; sweep < k_sweeps_a_turn; ++sweep) {
                bool is_better = false;
                for (std::size_t i = 0; i < sides_.size(); ++i) is_better = turn_if_better(i, by) || is_better;
                if (!is_better) break;
            }
    }

    bool turn_if_better(std::size_t index, double by)
    {
        const Vec3d n = sides_[index].normal;
        const Vec3d across = normalized(cross(n, frame_.row[std::abs(dot(n, frame_.row[0])) < 0.6 ? 0 : 1])),
                    third = cross(n, across);
        const Others others(*this, index);
        double least = others.sum_with(sides_[index]);
        std::vector<HalfSpaced> best = sides_;
        for (const Vec3d& to : {across, -across, third, -third}) {
            const HalfSpaced side = touching(normalized(n + by * to));
            const double sum = others.sum_with(side);
            if (!(sum < least)) continue;
            std::vector<HalfSpaced> turned = sides_;
            turned[index] = side;
            if (!bound_a_solid(turned)) continue;
            least = sum;
            best = std::move(turned);
        }
        const bool is_better = !(best[index] == sides_[index]);
        sides_ = std::move(best);
        return is_better;
    }

    /// Gives up the side that is missed least for one that cuts off the farthest corner; false, and all as it was, where that
    /// does not help.
    bool swap_if_better()
    {
        const std::vector<HalfSpaced> before = sides_;
        sides_.push_back(across_farthest_corner());
        std::vector<HalfSpaced> best = before;
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < before.size(); ++i) {
            std::vector<HalfSpaced> fewer = sides_;
            fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(i));
            if (const double sum = sum_of(fewer); sum < least) {
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
        mesh::ClosestPoint nearest{.distance = 0};
        Vec3d farthest{};
        for (const Vec3d& p : mesh::polytope_corners(sides_))
            if (const mesh::ClosestPoint to = bvh_.closest_point(p); to.distance > nearest.distance) {
                nearest = to;
                farthest = p;
            }
        return touching(normalized(farthest - nearest.point));
    }

    /// The corners that all sides but one have in common, each with its power.
    class Others {
    public:
        Others(const SideTurner& turner, std::size_t index) : turner_(turner), sides_(turner.sides_)
        {
            sides_.erase(sides_.begin() + static_cast<std::ptrdiff_t>(index));
            for (const Vec3d& p : mesh::polytope_corners(sides_)) corners_.push_back({p, turner.power(p)});
        }

        /// The sum over the corners of the polytope with one more side.
        [[nodiscard]] double sum_with(const HalfSpaced& side) const
        {
            double sum = 0;
            for (const auto& [at, power] : corners_)
                if (dot(side.normal, at) <= side.offset) sum += power;
            for (const Vec3d& p : mesh::corners_on(side, sides_)) sum += turner_.power(p);
            return sum;
        }

    private:
        struct Corner {
            Vec3d at;
            double power;
        };
        const SideTurner& turner_;
        std::vector<HalfSpaced> sides_;
        std::vector<Corner> corners_;
    };

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
