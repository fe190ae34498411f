// Clusters of cells in three ways: greedy splitting of the one whose ball reaches out farthest; covers by balls within the solid,
// whose protrusion is bounded, a bound that is halved while few enough suffice; equal boxes. Then rounds in the manner of S.
// Lloyd, "Least squares quantization in PCM", 1982: cells go to the ball that has to grow least for them, where balls that reach
// out far count as smaller than they are, and each ball becomes the smallest about its cells.
#include "collider/spheres.h"

#include "collider/inner_balls.h"
#include "collider/numbers.h"
#include "collider/searches.h"
#include "sqmap/math/box.h"
#include "sqmap/mesh/error.h"
#include "sqmap/mesh/solid.h"

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace sqmap::collider {
namespace {

constexpr int k_cells_along = 44;  ///< of the longest side of the box
constexpr int k_rounds = 30;
constexpr int k_halvings = 10;             ///< of the bound on protrusion
constexpr int k_tried_directions = 40;     ///< of a half sphere, in which a ball's protrusion is probed
constexpr double k_ball_rounding = 1e-12;  ///< of the greatest coordinate

using Index = std::array<int, 3>;
using Corners = std::array<Vec3d, 3>;  ///< of a triangle

class Grid {
public:
    Grid(const mesh::Mesh& mesh, const mesh::Solid& solid, std::span<const Corners> held)
        : mesh_(mesh), solid_(solid), held_(held), box_(box_of(mesh.vertices))
    {
        for (const Corners& t : held)
            for (const Vec3d& p : t) extend(box_, p);
        const Vec3d s = size(box_);
        side_ = std::max({s.x, s.y, s.z}) / k_cells_along;
        for (int k = 0; k < 3; ++k) count_[k] = std::max(1, static_cast<int>(std::ceil(s[k] / side_)));
    }

    std::vector<GridPiece> pieces()
    {
        for (const mesh::Triangle& t : mesh_.triangles) clip({mesh_.vertices[t[0]], mesh_.vertices[t[1]], mesh_.vertices[t[2]]});
        for (const Corners& t : held_) clip(t);
        add_inner();
        std::vector<GridPiece> out;
        for (auto& [index, corners] : cells_) {
            GridPiece piece{.corners = std::move(corners)};
            for (const Vec3d& p : piece.corners) piece.middle += p;
            piece.middle = piece.middle / static_cast<double>(piece.corners.size());
            out.push_back(std::move(piece));
        }
        return out;
    }

    /// Corners of the grid within the solid.
    [[nodiscard]] const std::vector<Vec3d>& inner() const { return inner_; }

private:
    [[nodiscard]] Vec3d corner(const Index& i) const
    {
        return box_.lo + side_ * Vec3d{static_cast<double>(i[0]), static_cast<double>(i[1]), static_cast<double>(i[2])};
    }
    [[nodiscard]] int cell_of(double v, int k) const
    {
        return std::clamp(static_cast<int>(std::floor((v - box_.lo[k]) / side_)), 0, count_[k] - 1);
    }

    void clip(const Corners& t)
    {
        Box box;
        for (const Vec3d& p : t) extend(box, p);
        Index lo, hi, i;
        for (int k = 0; k < 3; ++k) {
            lo[static_cast<std::size_t>(k)] = std::max(0, cell_of(box.lo[k], k) - 1);
            hi[static_cast<std::size_t>(k)] = cell_of(box.hi[k], k);
        }
        for (i[0] = lo[0]; i[0] <= hi[0]; ++i[0])
            for (i[1] = lo[1]; i[1] <= hi[1]; ++i[1])
                for (i[2] = lo[2]; i[2] <= hi[2]; ++i[2]) clip(t, i);
    }
    void clip(const Corners& t, const Index& i)
    {
        std::vector<Vec3d> polygon(t.begin(), t.end()), next;
        const Vec3d lo = corner(i), hi = corner({i[0] + 1, i[1] + 1, i[2] + 1});
        for (int k = 0; k < 3; ++k)
            for (const double sign : {1., -1.}) {
                const double limit = sign > 0 ? hi[k] : -lo[k];
                next.clear();
                for (std::size_t j = 0; j < polygon.size(); ++j) {
                    const Vec3d &a = polygon[j], &b = polygon[(j + 1) % polygon.size()];
                    const double da = sign * a[k] - limit, db = sign * b[k] - limit;
                    if (da <= 0) next.push_back(a);
                    if ((da < 0 && db > 0) || (da > 0 && db < 0)) next.push_back(a + da / (da - db) * (b - a));
                }
                polygon.swap(next);
                if (polygon.empty()) return;
            }
        std::vector<Vec3d>& corners = cells_[i];
        corners.insert(corners.end(), polygon.begin(), polygon.end());
    }

    /// Corners of cells that lie in the solid: to each cell that has them.
    void add_inner()
    {
        Index i;
        for (i[0] = 0; i[0] <= count_[0]; ++i[0])
            for (i[1] = 0; i[1] <= count_[1]; ++i[1])
                for (i[2] = 0; i[2] <= count_[2]; ++i[2]) {
                    const Vec3d p = corner(i);
                    if (!solid_.inside(p)) continue;
                    inner_.push_back(p);
                    for (int c = 0; c < 8; ++c) {
                        const Index cell{i[0] - (c & 1), i[1] - ((c >> 1) & 1), i[2] - ((c >> 2) & 1)};
                        bool is_cell = true;
                        for (std::size_t k = 0; k < 3; ++k) is_cell = is_cell && cell[k] >= 0 && cell[k] < count_[k];
                        if (is_cell) cells_[cell].push_back(p);
                    }
                }
    }

    const mesh::Mesh& mesh_;
    const mesh::Solid& solid_;
    std::span<const Corners> held_;
    Box box_;
    double side_ = 0;
    int count_[3] = {};
    std::map<Index, std::vector<Vec3d>> cells_;
    std::vector<Vec3d> inner_;
};

class Cover {
public:
    Cover(const std::vector<GridPiece>& pieces, const mesh::Solid& solid) : pieces_(pieces), solid_(solid)
    {
        directions_ = half_sphere(k_tried_directions);
    }

    /// At most count balls that hold all pieces. Fewer where more would protrude more.
    std::vector<Cluster> run(std::size_t count, std::vector<Vec3d> inner)
    {
        Cluster all;
        all.pieces.resize(pieces_.size());
        std::iota(all.pieces.begin(), all.pieces.end(), std::size_t{0});
        fit(all);
        std::vector<Cluster> best{all};
        const auto offer = [&] {
            if (worst(clusters_) < worst(best)) best = clusters_;
        };
        const auto improve = [&] {
            settle();
            offer();
            while (clusters_.size() < count && split_worst()) offer();
            settle();
            offer();
        };
        // Cuts serve flat bodies better, boxes of a lattice compact ones, balls within the solid round ones and limbs.
        clusters_ = {all};
        improve();
        clusters_ = least_cover(count, all.ball.radius, std::move(inner));
        if (!clusters_.empty()) improve();
        clusters_ = in_lattice(count);
        offer();
        improve();
        return best;
    }

private:
    static double worst(const std::vector<Cluster>& clusters)
    {
        double out = 0;
        for (const Cluster& c : clusters) out = std::max(out, c.protrusion);
        return out;
    }

    [[nodiscard]] double protrusion_of(const Sphere& ball) const
    {
        double protrusion = 0;
        for (const Vec3d& d : directions_)
            for (const double sign : {1., -1.}) {
                const Vec3d p = ball.centre + sign * ball.radius * d;
                if (!solid_.inside(p)) protrusion = std::max(protrusion, solid_.bvh().closest_point(p).distance);
            }
        return protrusion;
    }

    /// The smallest ball about the pieces.
    void fit(Cluster& c) const
    {
        std::vector<Vec3d> points;
        for (const std::size_t i : c.pieces) points.insert(points.end(), pieces_[i].corners.begin(), pieces_[i].corners.end());
        c.ball = least_ball(points);
        c.protrusion = protrusion_of(c.ball);
    }

    /// The smallest ball about the pieces, or the smallest about its own centre where that protrudes less.
    void shrink(Cluster& c) const
    {
        Sphere own{c.ball.centre, 0};
        for (const std::size_t i : c.pieces) own.radius = std::max(own.radius, reach_of(pieces_[i], own.centre));
        fit(c);
        const double protrusion = protrusion_of(own);
        if (protrusion >= c.protrusion) return;
        c.ball = own;
        c.protrusion = protrusion;
    }

    /// At most count balls about points within the solid, of those that were met the ones that protrude least. None where no such
    /// balls protrude by less than greatest.
    [[nodiscard]] std::vector<Cluster> least_cover(std::size_t count, double greatest, std::vector<Vec3d> inner) const
    {
        const InnerBalls balls(pieces_, solid_, std::move(inner));
        std::vector<Cluster> best;
        double low = 0, high = greatest;
        for (int halving = 0; halving < k_halvings; ++halving) {
            const double middle = 0.5 * (low + high);
            std::vector<Cluster> found = balls.cover(middle, count);
            (found.empty() ? low : high) = middle;
            if (found.empty()) continue;
            for (Cluster& c : found) shrink(c);
            if (best.empty() || worst(found) <= worst(best)) best = std::move(found);
        }
        return best;
    }

    /// The pieces in each of the equal boxes of a lattice, which are as small as count allows.
    [[nodiscard]] std::vector<Cluster> in_lattice(std::size_t count) const
    {
        Box box;
        for (const GridPiece& piece : pieces_) extend(box, piece.middle);
        const Vec3d s = size(box);
        const auto clusters_of = [&](double side) {
            std::map<Index, Cluster> boxes;
            for (std::size_t i = 0; i < pieces_.size(); ++i) {
                Index at{};
                for (int k = 0; k < 3; ++k) {
                    const double along = std::ceil(std::max(s[k] / side, 1.0));
                    const double where = s[k] > 0 ? (pieces_[i].middle[k] - box.lo[k]) / s[k] * along : 0;
                    at[static_cast<std::size_t>(k)] = static_cast<int>(std::min(where, along - 1));
                }
                boxes[at].pieces.push_back(i);
            }
            return boxes;
        };
        const double longest = std::max({s.x, s.y, s.z});
        double low = longest / k_cells_along, high = longest;
        for (int halving = 0; halving < k_halvings && longest > 0; ++halving) {
            const double side = 0.5 * (low + high);
            (clusters_of(side).size() <= count ? high : low) = side;
        }
        std::vector<Cluster> out;
        for (auto& [at, cluster] : clusters_of(longest > 0 ? high : 1)) {
            fit(cluster);
            out.push_back(std::move(cluster));
        }
        return out;
    }

    /// Moves pieces between the clusters in rounds, and leaves the best that was met.
    void settle()
    {
        std::vector<Cluster> best = clusters_;
        for (int round = 0; round < k_rounds && reassign(); ++round)
            if (worst(clusters_) < worst(best)) best = clusters_;
        clusters_ = std::move(best);
    }

    /// Unit directions of the spread of the cluster's pieces, the one along which they spread most first.
    [[nodiscard]] std::array<Vec3d, 3> spread(const Cluster& c) const
    {
        Eigen::Matrix<double, 3, Eigen::Dynamic> middles(3, static_cast<Eigen::Index>(c.pieces.size()));
        for (std::size_t i = 0; i < c.pieces.size(); ++i) {
            const Vec3d& m = pieces_[c.pieces[i]].middle;
            middles.col(static_cast<Eigen::Index>(i)) << m.x, m.y, m.z;
        }
        middles.colwise() -= middles.rowwise().mean().eval();
        const Eigen::Matrix3d covariance = middles * middles.transpose();
        const Eigen::Matrix3d axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvectors();
        const auto axis = [&](int k) { return Vec3d{axes(0, k), axes(1, k), axes(2, k)}; };
        return {axis(2), axis(1), axis(0)};
    }

    bool split_worst()
    {
        std::size_t at = clusters_.size();
        for (std::size_t i = 0; i < clusters_.size(); ++i)
            if (clusters_[i].pieces.size() > 1 && (at == clusters_.size() || clusters_[i].protrusion > clusters_[at].protrusion))
                at = i;
        if (at == clusters_.size()) return false;
        std::array<Cluster, 2> best;
        double least = -1;
        const std::array<Vec3d, 3> axes = spread(clusters_[at]);
        for (const Vec3d& axis : axes)
            for (const double share : {0.5, 0.4, 0.6}) {
                std::array<Cluster, 2> halves;
                double lo = dot(axis, pieces_[clusters_[at].pieces[0]].middle), hi = lo;
                for (const std::size_t i : clusters_[at].pieces) {
                    lo = std::min(lo, dot(axis, pieces_[i].middle));
                    hi = std::max(hi, dot(axis, pieces_[i].middle));
                }
                for (const std::size_t i : clusters_[at].pieces)
                    halves[dot(axis, pieces_[i].middle) < lo + share * (hi - lo) ? 0 : 1].pieces.push_back(i);
                if (halves[0].pieces.empty() || halves[1].pieces.empty()) continue;
                for (Cluster& h : halves) fit(h);
                const double cost = std::max(halves[0].protrusion, halves[1].protrusion);
                if (least >= 0 && cost >= least) continue;
                least = cost;
                best = halves;
            }
        if (least < 0) return false;
        clusters_[at] = best[0];
        clusters_.push_back(best[1]);
        return true;
    }

    /// False where every piece stays.
    bool reassign()
    {
        double mean = 0;
        for (const Cluster& c : clusters_) mean += c.protrusion / static_cast<double>(clusters_.size());
        std::vector<std::vector<std::size_t>> pieces(clusters_.size());
        for (std::size_t i = 0; i < pieces_.size(); ++i) {
            std::size_t best = 0;
            double least = INFINITY;
            for (std::size_t k = 0; k < clusters_.size(); ++k) {
                const Cluster& c = clusters_[k];
                const double allowed = c.ball.radius - 0.3 * (c.protrusion - mean);
                if (norm(pieces_[i].middle - c.ball.centre) - allowed > least) continue;
                const double grown = reach_of(pieces_[i], c.ball.centre) - allowed;
                if (grown < least) {
                    least = grown;
                    best = k;
                }
            }
            pieces[best].push_back(i);
        }
        bool moved = false;
        for (std::size_t k = 0; k < clusters_.size(); ++k) {
            if (pieces[k] == clusters_[k].pieces) continue;
            moved = true;
            clusters_[k].pieces = std::move(pieces[k]);
            if (!clusters_[k].pieces.empty()) fit(clusters_[k]);
        }
        std::erase_if(clusters_, [](const Cluster& c) { return c.pieces.empty(); });
        return moved;
    }

    const std::vector<GridPiece>& pieces_;
    const mesh::Solid& solid_;
    std::vector<Vec3d> directions_;
    std::vector<Cluster> clusters_;
};

}  // namespace

std::vector<Shape> covering_spheres(const mesh::Mesh& surface, std::span<const std::uint8_t> crossed, std::size_t count,
                                    std::span<const Corners> held)
{
    if (surface.triangles.empty() || count == 0) throw mesh::InvalidInput("spheres: give a closed mesh and a number from 1 on");
    const mesh::Solid solid(surface, crossed);
    Grid grid(surface, solid, held);
    const std::vector<GridPiece> pieces = grid.pieces();
    double reach = 0;
    for (const Vec3d& v : surface.vertices) reach = std::max(reach, norm(v));
    for (const Corners& t : held)
        for (const Vec3d& p : t) reach = std::max(reach, norm(p));
    std::vector<Shape> out;
    for (const Cluster& c : Cover(pieces, solid).run(count, grid.inner())) {
        Shape ball{.kind = Kind::Sphere, .xyz = rounded(c.ball.centre)};
        double radius = 0;
        for (const std::size_t i : c.pieces)
            for (const Vec3d& p : pieces[i].corners) radius = std::max(radius, norm(p - ball.xyz));
        radius = rounded_up(radius + k_ball_rounding * reach);
        ball.size = {radius, radius, radius};
        out.push_back(ball);
    }
    return out;
}

}  // namespace sqmap::collider
