// P. Liepa, "Filling holes in meshes", 2003, after P. Pfeifle and H.-P. Seidel, "Triangular B-splines for blending and filling of
// polygonal holes", 1996.
#include "patch.h"

#include <cmath>
#include <limits>

namespace sqmap::mesh {
namespace {

constexpr std::uint32_t k_border = std::numeric_limits<std::uint32_t>::max();
constexpr int k_passes = 40;      // of splitting; each makes triangles a third
constexpr int k_turn_passes = 8;  // of turning edges, after each

class Refiner {
public:
    Refiner(Patch& patch, std::size_t max_triangles) : patch_(patch), t_(patch.triangles), max_triangles_(max_triangles)
    {
        link();
    }

    void run()
    {
        turn_edges();
        for (int pass = 0; pass < k_passes && split_large(); ++pass) turn_edges();
    }

private:
    static std::uint32_t next(std::uint32_t half) { return half / 3 * 3 + (half + 1) % 3; }
    static std::uint32_t previous(std::uint32_t half) { return half / 3 * 3 + (half + 2) % 3; }
    [[nodiscard]] std::uint32_t from(std::uint32_t half) const { return t_[half / 3][half % 3]; }

    void link()
    {
        std::vector<std::array<std::uint32_t, 3>> sides;  // lo, hi, half
        mate_.assign(3 * t_.size(), k_border);
        for (std::uint32_t half = 0; half < mate_.size(); ++half) {
            const std::uint32_t a = from(half), b = from(next(half));
            sides.push_back({std::min(a, b), std::max(a, b), half});
            edges_.insert(a, b);
        }
        std::sort(sides.begin(), sides.end());
        for (std::size_t i = 0; i + 1 < sides.size(); ++i)
            if (sides[i][0] == sides[i + 1][0] && sides[i][1] == sides[i + 1][1]) pair(sides[i][2], sides[i + 1][2]);
    }

    void pair(std::uint32_t a, std::uint32_t b)
    {
        if (a != k_border) mate_[a] = b;
        if (b != k_border) mate_[b] = a;
    }

    bool split_large()
    {
        bool any = false;
        const auto count = static_cast<std::uint32_t>(t_.size());
        for (std::uint32_t t = 0; t < count && t_.size() + 2 <= max_triangles_; ++t) {
            const Triangle v = t_[t];
            const auto& p = patch_.points;
            const Vec3d middle = (p[v[0]] + p[v[1]] + p[v[2]]) / 3.0;
            const double spacing = (patch_.spacing[v[0]] + patch_.spacing[v[1]] + patch_.spacing[v[2]]) / 3;
            const bool large = std::all_of(v.begin(), v.end(), [&](std::uint32_t m) {
                const double reach = std::sqrt(2.0) * norm(middle - p[m]);
                return reach > spacing && reach > patch_.spacing[m];
            });
            if (!large) continue;
            split(t, middle, spacing);
            any = true;
        }
        return any;
    }

    void split(std::uint32_t t, Vec3d middle, double spacing)
    {
        const auto c = static_cast<std::uint32_t>(patch_.points.size());
        patch_.points.push_back(middle);
        patch_.spacing.push_back(spacing);
        const auto u = static_cast<std::uint32_t>(t_.size()), w = u + 1;
        const Triangle v = t_[t];
        const std::uint32_t over_1 = mate_[3 * t + 1], over_2 = mate_[3 * t + 2];
        t_[t] = {v[0], v[1], c};
        t_.push_back({v[1], v[2], c});
        t_.push_back({v[2], v[0], c});
        mate_.resize(3 * t_.size(), k_border);
        mate_[3 * u] = mate_[3 * w] = k_border;
        pair(3 * u, over_1);
        pair(3 * w, over_2);
        pair(3 * t + 1, 3 * u + 2);
        pair(3 * u + 1, 3 * w + 2);
        pair(3 * w + 1, 3 * t + 2);
        for (const std::uint32_t corner : v) edges_.insert(corner, c);
    }

    /// Cotangent of the angle opposite a side.
    [[nodiscard]] double cotangent(std::uint32_t half) const
    {
        const Vec3d c = patch_.points[from(previous(half))];
        const Vec3d u = patch_.points[from(half)] - c, w = patch_.points[from(next(half))] - c;
        return dot(u, w) / std::max(norm(cross(u, w)), 1e-300);
    }

    void turn_edges()
    {
        for (int pass = 0; pass < k_turn_passes; ++pass) {
            bool any = false;
            for (std::uint32_t half = 0; half < mate_.size(); ++half)
                if (mate_[half] != k_border && half < mate_[half]) any = turn(half) || any;
            if (!any) return;
        }
    }

    /// Turns an edge whose opposite angles sum to more than a half turn.
    bool turn(std::uint32_t half)
    {
        const std::uint32_t other = mate_[half];
        if (!(cotangent(half) + cotangent(other) < -1e-9)) return false;
        const std::uint32_t a = from(half), b = from(other), c = from(previous(half)), d = from(previous(other));
        if (c == d || edges_.contains(c, d) || patch_.taken.contains(c, d)) return false;
        const std::uint32_t over_bc = mate_[next(half)], over_ca = mate_[previous(half)];
        const std::uint32_t over_ad = mate_[next(other)], over_db = mate_[previous(other)];
        const std::uint32_t t = half / 3, u = other / 3;
        t_[t] = {a, d, c};
        t_[u] = {d, b, c};
        for (const std::uint32_t f : {t, u})
            for (std::uint32_t k = 0; k < 3; ++k) mate_[3 * f + k] = k_border;
        pair(3 * t, over_ad);
        pair(3 * t + 2, over_ca);
        pair(3 * u, over_db);
        pair(3 * u + 1, over_bc);
        pair(3 * t + 1, 3 * u + 2);
        edges_.erase(a, b);
        edges_.insert(c, d);
        return true;
    }

    Patch& patch_;
    std::vector<Triangle>& t_;
    std::size_t max_triangles_;
    std::vector<std::uint32_t> mate_;
    EdgeSet edges_;
};

}  // namespace

void refine(Patch& patch, std::size_t max_triangles) { Refiner(patch, max_triangles).run(); }

}  // namespace sqmap::mesh
