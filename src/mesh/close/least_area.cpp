// Least-area triangulation by dynamic programming: G. Barequet and M. Sharir, "Filling gaps in the boundary of a polyhedron",
// 1995. It takes the cube of a loop's length, so longer loops are halved first, where two of their points are near each other.
#include "patch.h"

#include <cmath>
#include <limits>
#include <utility>

namespace sqmap::mesh {
namespace {

constexpr std::size_t k_max_loop = 200;      // points that the cubic search takes at once
constexpr std::size_t k_chord_probes = 128;  // points of a longer loop between which a chord is sought

using Ring = std::vector<std::uint32_t>;

class LeastArea {
public:
    LeastArea(std::span<const Vec3d> points, const EdgeSet& taken) : points_(points), taken_(taken) {}

    std::vector<Triangle> triangulate()
    {
        Ring all(points_.size());
        for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
        std::vector<Ring> open{std::move(all)};
        while (!open.empty()) {
            const Ring ring = std::move(open.back());
            open.pop_back();
            if (ring.size() <= k_max_loop) {
                if (!solve(ring)) return {};
                continue;
            }
            const auto [i, j] = chord(ring);
            if (j == 0) return {};
            open.emplace_back(ring.begin() + static_cast<std::ptrdiff_t>(i), ring.begin() + static_cast<std::ptrdiff_t>(j) + 1);
            Ring rest(ring.begin(), ring.begin() + static_cast<std::ptrdiff_t>(i) + 1);
            rest.insert(rest.end(), ring.begin() + static_cast<std::ptrdiff_t>(j), ring.end());
            open.push_back(std::move(rest));
        }
        return std::move(out_);
    }

private:
    /// The chord that is shortest for the way around, and leaves a fifth of the ring on either side.
    [[nodiscard]] std::pair<std::size_t, std::size_t> chord(const Ring& ring) const
    {
        std::vector<double> along(ring.size() + 1, 0);
        for (std::size_t i = 0; i < ring.size(); ++i)
            along[i + 1] = along[i] + norm(points_[ring[(i + 1) % ring.size()]] - points_[ring[i]]);
        std::pair<std::size_t, std::size_t> best{0, 0};
        double least = std::numeric_limits<double>::infinity();
        const std::size_t fifth = ring.size() / 5;
        for (std::size_t a = 0; a < k_chord_probes; ++a)
            for (std::size_t b = a + 1; b < k_chord_probes; ++b) {
                const std::size_t i = a * ring.size() / k_chord_probes, j = b * ring.size() / k_chord_probes;
                if (j - i < fifth || ring.size() - (j - i) < fifth || taken_.contains(ring[i], ring[j])) continue;
                const double around = std::min(along[j] - along[i], along.back() - (along[j] - along[i]));
                const double ratio = norm(points_[ring[j]] - points_[ring[i]]) / std::max(around, 1e-300);
                if (ratio < least) {
                    least = ratio;
                    best = {i, j};
                }
            }
        return best;
    }

    /// False if every triangulation has a taken side.
    bool solve(const Ring& ring)
    {
        constexpr double k_impossible = std::numeric_limits<double>::infinity();
        const std::size_t n = ring.size();
        std::vector<double> cost(n * n, 0);
        std::vector<std::uint32_t> apex(n * n, 0);
        for (std::size_t span = 2; span < n; ++span)
            for (std::size_t i = 0; i + span < n; ++i) {
                const std::size_t j = i + span;
                double& best = cost[i * n + j];
                best = k_impossible;
                if (span + 1 < n && taken_.contains(ring[i], ring[j])) continue;
                const Vec3d from = points_[ring[i]], side = points_[ring[j]] - from;
                for (std::size_t k = i + 1; k < j; ++k) {
                    const double rest = cost[i * n + k] + cost[k * n + j];
                    if (rest >= best) continue;
                    const double area = rest + 0.5 * norm(cross(points_[ring[k]] - from, side));
                    if (area < best) {
                        best = area;
                        apex[i * n + j] = static_cast<std::uint32_t>(k);
                    }
                }
            }
        if (cost[n - 1] == k_impossible) return false;
        std::vector<std::pair<std::size_t, std::size_t>> open{{0, n - 1}};
        while (!open.empty()) {
            const auto [i, j] = open.back();
            open.pop_back();
            if (j - i < 2) continue;
            const std::size_t k = apex[i * n + j];
            out_.push_back({ring[i], ring[k], ring[j]});
            open.emplace_back(i, k);
            open.emplace_back(k, j);
        }
        return true;
    }

    std::span<const Vec3d> points_;
    const EdgeSet& taken_;
    std::vector<Triangle> out_;
};

}  // namespace

std::vector<Triangle> least_area(std::span<const Vec3d> loop, const EdgeSet& taken)
{
    return LeastArea(loop, taken).triangulate();
}

}  // namespace sqmap::mesh
