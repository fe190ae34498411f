#include "near_lists.h"

#include "parallel.h"
#include "sqmap/math/triangle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace sqmap::bake {

namespace {

using model::PlaceKind;

/// The lattice of a box: its corners, the middles of its edges and faces, its centre; x fastest.
constexpr std::size_t k_lattice = 27, k_centre = 13;
/// Lattice points at the corners of the eighth whose lowest corner is lattice point i.
constexpr std::size_t k_steps[] = {0, 1, 3, 4, 9, 10, 12, 13};
constexpr std::size_t k_corner[] = {0, 2, 6, 8, 18, 20, 24, 26};

Vec3d lattice_offset(double h, std::size_t i)
{
    return h * Vec3d{static_cast<double>(i % 3) - 1, static_cast<double>(i / 3 % 3) - 1, static_cast<double>(i / 9) - 1};
}

/// A triangle that may be nearest to some point of a box.
struct Candidate {
    std::uint32_t triangle;
    double distance;  ///< from the box's centre
    Vec3d away;       ///< its gradient there
};

/// The triangles nearest to some point of the box about centre of half side h, each once, ascending, and some more. The distance
/// to a triangle is convex. So in a box it is at most the multilinear function of its values at the corners, and at least its
/// tangent plane at any point; where one triangle's plane is above another's values at all corners, it is nowhere the nearest.
class NearTriangles {
public:
    explicit NearTriangles(const mesh::Solid& solid) : solid_(solid) {}

    std::vector<std::uint32_t> operator()(Vec3d centre, double h)
    {
        centre_ = centre;
        h_ = h;
        rulers_.clear();
        collect();
        std::vector<std::uint32_t> near;
        for (const Candidate& c : candidates_)
            if (!is_ruled_out(c)) near.push_back(c.triangle);
        std::sort(near.begin(), near.end());
        return near;
    }

private:
    /// What rules others out: a triangle and its distances from the lattice.
    struct Ruler {
        std::uint32_t triangle;
        std::array<double, k_lattice> at;
    };

    Vec3d closest(std::uint32_t triangle, Vec3d p) const
    {
        const mesh::Triangle& t = solid_.mesh().triangles[triangle];
        const auto& v = solid_.mesh().vertices;
        return closest_point_on_triangle(p, v[t[0]], v[t[1]], v[t[2]]);
    }

    /// One that is cut may not be boundary where it is nearest, and rules out nothing.
    void add_ruler(std::uint32_t triangle)
    {
        if (solid_.boundary()[triangle] != mesh::Boundary::Whole) return;
        for (const Ruler& r : rulers_)
            if (r.triangle == triangle) return;
        Ruler& ruler = rulers_.emplace_back();
        ruler.triangle = triangle;
        for (std::size_t i = 0; i < k_lattice; ++i) {
            const Vec3d p = centre_ + lattice_offset(h_, i);
            ruler.at[i] = norm(p - closest(triangle, p));
        }
    }

    /// Whatever is no farther from the centre than the nearest by more than the box's diagonal, and not ruled out by the centre's
    /// nearest; rulers are the triangles nearest to the lattice.
    void collect()
    {
        candidates_.clear();
        mesh::ClosestPoint nearest = solid_.closest_boundary(centre_);
        add_ruler(nearest.triangle);
        const double reach = (nearest.distance + 2 * std::sqrt(3.0) * h_) * (1 + 1e-6);
        solid_.bvh().visit_nearest(centre_, reach * reach, [&](std::uint32_t t, double radius_sq) {
            if (solid_.boundary()[t] == mesh::Boundary::Buried) return radius_sq;
            const Vec3d offset = centre_ - closest(t, centre_);
            const double distance = norm(offset);
            if (distance > reach) return radius_sq;
            const Candidate c{t, distance, distance > 0 ? offset / distance : Vec3d{}};
            if (!rulers_.empty() && is_above_all(c, rulers_.front())) return radius_sq;
            candidates_.push_back(c);
            return radius_sq;
        });
        for (std::size_t i = 0; i < k_lattice; ++i) {
            if (i == k_centre) continue;
            const Vec3d p = centre_ + lattice_offset(h_, i);
            const double within = (nearest.distance + norm(p - centre_)) * (1 + 1e-9) + 1e-12;
            add_ruler(solid_.closest_boundary(p, within).triangle);
        }
    }

    /// The plane at the centre against a ruler at all corners.
    bool is_above_all(const Candidate& c, const Ruler& r) const
    {
        if (r.triangle == c.triangle) return false;
        for (const std::size_t i : k_corner)
            if (!(c.distance + dot(c.away, lattice_offset(h_, i)) > r.at[i] + slack())) return false;
        return true;
    }

    bool is_ruled_out(const Candidate& c) const
    {
        for (const Ruler& r : rulers_)
            if (is_above_all(c, r)) return true;
        // Eighth by eighth: the planes at the centre and at the eighth's outer corner.
        for (std::size_t eighth = 0; eighth < 8; ++eighth) {
            const std::size_t low = k_steps[eighth];
            const Vec3d from = lattice_offset(h_, k_corner[eighth]), offset = centre_ + from - closest(c.triangle, centre_ + from);
            const double distance = norm(offset);
            double by_centre[8], by_corner[8];
            for (std::size_t k = 0; k < 8; ++k) {
                const Vec3d p = lattice_offset(h_, low + k_steps[k]);
                by_centre[k] = c.distance + dot(c.away, p);
                by_corner[k] = distance > 1e-9 * h_ ? distance + dot(offset, p - from) / distance : 0;
            }
            const bool out = std::any_of(rulers_.begin(), rulers_.end(), [&](const Ruler& r) {
                if (r.triangle == c.triangle) return false;
                bool centre = true, corner = true;
                for (std::size_t k = 0; k < 8 && (centre || corner); ++k) {
                    const double limit = r.at[low + k_steps[k]] + slack();
                    centre = centre && by_centre[k] > limit;
                    corner = corner && by_corner[k] > limit;
                }
                return centre || corner;
            });
            if (!out) return false;
        }
        return true;
    }

    double slack() const { return 1e-5 * h_; }

    const mesh::Solid& solid_;
    Vec3d centre_{};
    double h_ = 0;
    std::vector<Candidate> candidates_;
    std::vector<Ruler> rulers_;
};

}  // namespace

void bake_near_lists(const mesh::Solid& solid, unsigned threads, model::ModelData& data)
{
    data.near_bricks.clear();
    data.near.clear();
    if (data.bricks.empty() || data.triangle_part.empty()) return;
    const model::Locator& l = data.locator;
    const bool wide = data.triangle_part.size() > 0x10000;
    std::vector<std::vector<std::uint16_t>> packed(data.bricks.size());
    parallel_for(data.bricks.size(), threads, [&](std::size_t i) {
        const std::uint32_t brick = data.bricks[i];
        if ((brick & model::k_free_brick) != 0) return;
        NearTriangles near_triangles(solid);
        constexpr int n = model::k_brick;
        const double cell = static_cast<double>(l.cell);
        const Vec3d origin = cast<double>(model::vec3(l.origin));
        const Vec3d lowest = origin + n * cell * Vec3d{double(i % l.bricks[0]), double(i / l.bricks[0] % l.bricks[1]),
                                                       double(i / (std::size_t{l.bricks[0]} * l.bricks[1]))};
        const bool deep = (brick & model::k_deep_brick) != 0;
        // What is asked there may lie beside it by rounding.
        const double slack = 1.0005;
        std::vector<std::uint16_t>& out = packed[i];
        std::vector<std::uint16_t> refs, starts{0};
        std::uint64_t occupied = 0;
        const auto add = [&](Vec3d centre, double h) {
            const std::vector<std::uint32_t> near = near_triangles(centre, slack * h);
            // Where a brick's lists are too long, the rest of its places is asked point by point.
            if (refs.size() + near.size() * (wide ? 2 : 1) <= 0xffff)
                for (const std::uint32_t t : near) {
                    refs.push_back(static_cast<std::uint16_t>(t));
                    if (wide) refs.push_back(static_cast<std::uint16_t>(t >> 16));
                }
            starts.push_back(static_cast<std::uint16_t>(refs.size()));
        };
        if (deep) {
            occupied = 1;
            add(lowest + 0.5 * n * cell * Vec3d{1, 1, 1}, 0.5 * n * cell);
        } else {
            const std::uint32_t first = brick;
            for (int k = 0; k < n * n * n; ++k) {
                if (model::place_kind(data.places[first + static_cast<std::uint32_t>(k)]) == PlaceKind::Free) continue;
                occupied |= std::uint64_t{1} << k;
                add(lowest + cell * Vec3d{k % n + 0.5, k / n % n + 0.5, k / (n * n) + 0.5}, 0.5 * cell);
            }
        }
        for (int k = 0; k < 4; ++k) out.push_back(static_cast<std::uint16_t>(occupied >> 16 * k));
        out.insert(out.end(), starts.begin(), starts.end());
        out.insert(out.end(), refs.begin(), refs.end());
    });
    for (const auto& brick : packed) {
        data.near_bricks.push_back(brick.empty() ? model::k_no_near : static_cast<std::uint32_t>(data.near.size()));
        data.near.insert(data.near.end(), brick.begin(), brick.end());
    }
}

}  // namespace sqmap::bake
