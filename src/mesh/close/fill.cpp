// P. Liepa, "Filling holes in meshes", 2003, with two changes. A filling continues the surface smoothly only where the surface
// leads into it, else it is taut: a statue that was cut off gets a flat foot. And of the shapes made the one that crosses least
// is taken.
#include "steps.h"

#include "patch.h"
#include "sqmap/math/box.h"
#include "sqmap/mesh/self_intersection.h"

#include <cmath>
#include <map>
#include <utility>

namespace sqmap::mesh {
namespace {

constexpr double k_flat_loop = 1e-3;      // of the loop's diagonal: a loop so near its plane is filled in it
constexpr double k_min_smooth = 0.5;      // share of a loop that leads into the filling, where the filling is smooth
constexpr double k_max_bulge = 1.5;       // a smooth filling has at most this many times the least area
constexpr std::size_t k_min_budget = 64;  // triangles that a hole may always take if any are allowed

/// One way of closing a hole.
struct Shape {
    std::vector<Vec3d> inner;         ///< points made up
    std::vector<Triangle> triangles;  ///< positions in the loop, then of inner
};

struct Hole {
    std::vector<std::uint32_t> loop;
    std::vector<Shape> shapes;  ///< the one to take first, first
    std::size_t used = 0;
};

double area_of(const Patch& patch)
{
    double area = 0;
    for (const Triangle& t : patch.triangles)
        area += 0.5 * norm(cross(patch.points[t[1]] - patch.points[t[0]], patch.points[t[2]] - patch.points[t[0]]));
    return area;
}

bool is_flat(const Patch& patch)
{
    Vec3d normal{};
    Box box;
    const Vec3d base = patch.points[0];
    for (std::uint32_t i = 0; i < patch.loop_size; ++i) {
        extend(box, patch.points[i]);
        normal += cross(patch.points[i] - base, patch.points[(i + 1) % patch.loop_size] - base);
    }
    normal = normalized(normal);
    double lo = 0, hi = 0;
    for (std::uint32_t i = 0; i < patch.loop_size; ++i) {
        const double height = dot(patch.points[i] - base, normal);
        lo = std::min(lo, height);
        hi = std::max(hi, height);
    }
    return hi - lo <= k_flat_loop * norm(size(box));
}

class Filler {
public:
    Filler(Surface& surface, std::size_t max_triangles) : surface_(surface), budget_(max_triangles), refine_(max_triangles > 0) {}

    std::uint32_t fill()
    {
        const auto loops = boundary_loops(surface_);
        if (loops.empty()) return 0;
        index_boundary(loops);
        for (const auto& loop : loops)
            if (loop.size() >= 3) holes_.push_back(shaped(loop));
        avoid_crossings();
        for (const Hole& hole : holes_) put(surface_, hole);
        return static_cast<std::uint32_t>(holes_.size());
    }

private:
    void index_boundary(const std::vector<std::vector<std::uint32_t>>& loops)
    {
        std::vector<bool> on_boundary(surface_.points.size(), false);
        for (const auto& loop : loops)
            for (const std::uint32_t v : loop) on_boundary[v] = true;
        faces_of_.assign(surface_.points.size(), {});
        for (std::uint32_t f = 0; f < surface_.faces.size(); ++f) {
            const Triangle& v = surface_.faces[f].v;
            for (std::size_t k = 0; k < 3; ++k)
                if (on_boundary[v[k]]) faces_of_[v[k]].push_back(f);
        }
    }

    /// The loop with the faces about it, and no triangles yet.
    [[nodiscard]] Patch around(const std::vector<std::uint32_t>& loop) const
    {
        Patch patch;
        std::map<std::uint32_t, std::uint32_t> local;
        patch.loop_size = static_cast<std::uint32_t>(loop.size());
        for (const std::uint32_t v : loop) {
            local.emplace(v, static_cast<std::uint32_t>(patch.points.size()));
            patch.points.push_back(surface_.points[v]);
        }
        std::vector<std::uint32_t> rim;
        for (const std::uint32_t v : loop) rim.insert(rim.end(), faces_of_[v].begin(), faces_of_[v].end());
        std::sort(rim.begin(), rim.end());
        rim.erase(std::unique(rim.begin(), rim.end()), rim.end());
        std::vector<double> length(loop.size(), 0);
        std::vector<int> count(loop.size(), 0);
        for (const std::uint32_t f : rim) {
            Triangle t;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t v = surface_.faces[f].v[k];
                const auto [at, is_new] = local.emplace(v, static_cast<std::uint32_t>(patch.points.size()));
                if (is_new) patch.points.push_back(surface_.points[v]);
                t[k] = at->second;
            }
            patch.rim.push_back(t);
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = t[k], b = t[(k + 1) % 3];
                for (const std::uint32_t end : {a, b})
                    if (end < loop.size()) {
                        length[end] += norm(patch.points[b] - patch.points[a]);
                        ++count[end];
                    }
                if (a < loop.size() && b < loop.size()) patch.taken.insert(a, b);
            }
        }
        patch.first_inner = static_cast<std::uint32_t>(patch.points.size());
        patch.spacing.assign(patch.points.size(), 0);
        for (std::size_t i = 0; i < loop.size(); ++i) patch.spacing[i] = length[i] / std::max(count[i], 1);
        return patch;
    }

    Hole shaped(const std::vector<std::uint32_t>& loop)
    {
        Hole hole{loop, {}, 0};
        Patch plain = around(loop);
        // Takes edges that other fillings made between points of this loop, too.
        for (std::uint32_t i = 0; i < loop.size(); ++i)
            for (const std::uint32_t v : made_[loop[i]])
                if (const auto at = std::find(loop.begin(), loop.end(), v); at != loop.end())
                    plain.taken.insert(i, static_cast<std::uint32_t>(at - loop.begin()));
        plain.triangles = least_area(std::span(plain.points).first(plain.loop_size), plain.taken);
        if (plain.triangles.empty()) fan(plain);
        const std::size_t allowed = plain.triangles.size() + std::max(budget_, k_min_budget);
        const bool smooth = smooth_share(plain) >= k_min_smooth;
        if (refine_ && (smooth || !is_flat(plain))) {
            Patch refined = plain;
            refine(refined, allowed);
            budget_ -= std::min(budget_, refined.triangles.size() - plain.triangles.size());
            if (Patch fairest = refined;
                smooth && fair(fairest, Fairing::Smooth) && area_of(fairest) <= k_max_bulge * area_of(plain))
                keep(hole, fairest);
            if (Patch taut = refined; fair(taut, Fairing::Taut)) keep(hole, taut);
        }
        keep(hole, plain);
        return hole;
    }

    /// Fills with a fan around a point in the middle, when no triangulation of the loop's points avoids the surface.
    static void fan(Patch& patch)
    {
        Vec3d middle{};
        for (std::uint32_t i = 0; i < patch.loop_size; ++i) middle += patch.points[i] - patch.points[0];
        const auto c = static_cast<std::uint32_t>(patch.points.size());
        patch.points.push_back(patch.points[0] + middle / static_cast<double>(patch.loop_size));
        double spacing = 0;
        for (std::uint32_t i = 0; i < patch.loop_size; ++i) spacing += patch.spacing[i] / patch.loop_size;
        patch.spacing.push_back(spacing);
        for (std::uint32_t i = 0; i < patch.loop_size; ++i) patch.triangles.push_back({i, (i + 1) % patch.loop_size, c});
    }

    void remember(const Patch& patch, const std::vector<std::uint32_t>& loop)
    {
        for (const Triangle& t : patch.triangles)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = t[k], b = t[(k + 1) % 3];
                if (a >= loop.size() || b >= loop.size()) continue;
                made_[loop[a]].push_back(loop[b]);
                made_[loop[b]].push_back(loop[a]);
            }
    }

    void keep(Hole& hole, const Patch& patch)
    {
        remember(patch, hole.loop);
        Shape out;
        out.inner.assign(patch.points.begin() + patch.first_inner, patch.points.end());
        out.triangles = patch.triangles;
        for (Triangle& t : out.triangles)
            for (std::uint32_t& v : t)
                if (v >= patch.first_inner) v = v - patch.first_inner + patch.loop_size;
        hole.shapes.push_back(std::move(out));
    }

    static void put(Surface& surface, const Hole& hole)
    {
        const Shape& shape = hole.shapes[hole.used];
        const auto first = static_cast<std::uint32_t>(surface.points.size()), n = static_cast<std::uint32_t>(hole.loop.size());
        for (const Vec3d& p : shape.inner) {
            surface.points.push_back(p);
            surface.source.push_back(k_none);
        }
        const auto global = [&](std::uint32_t v) { return v < n ? hole.loop[v] : first + (v - n); };
        for (const Triangle& t : shape.triangles) surface.faces.push_back({{global(t[0]), global(t[1]), global(t[2])}, k_none});
    }

    /// Counts the faces of each hole's shape that others cut.
    [[nodiscard]] std::vector<std::size_t> crossings() const
    {
        Surface all = surface_;
        std::vector<std::size_t> ends;
        for (const Hole& hole : holes_) {
            put(all, hole);
            ends.push_back(all.faces.size());
        }
        Mesh mesh{all.points, {}};
        for (const Face& f : all.faces) mesh.triangles.push_back(f.v);
        std::vector<std::uint8_t> among(all.faces.size(), 0);
        std::fill(among.begin() + static_cast<std::ptrdiff_t>(surface_.faces.size()), among.end(), std::uint8_t{1});
        const SelfIntersections found = find_self_intersections(mesh, k_max_pairs, among);
        std::vector<std::size_t> out;
        std::size_t first = surface_.faces.size();
        for (const std::size_t end : ends) {
            std::size_t count = 0;
            for (; first < end; ++first) count += found.crossed[first];
            out.push_back(count);
        }
        return out;
    }

    void avoid_crossings()
    {
        std::vector<std::pair<std::size_t, std::size_t>> best(holes_.size(), {~std::size_t{0}, 0});  // cut faces, shape
        for (bool retry = true; retry;) {
            retry = false;
            const std::vector<std::size_t> cut = crossings();
            for (std::size_t h = 0; h < holes_.size(); ++h) {
                if (best[h].first == 0) continue;
                best[h] = std::min(best[h], {cut[h], holes_[h].used});
                if (cut[h] > 0 && holes_[h].used + 1 < holes_[h].shapes.size()) {
                    ++holes_[h].used;
                    retry = true;
                }
            }
        }
        for (std::size_t h = 0; h < holes_.size(); ++h) holes_[h].used = best[h].second;
    }

    static constexpr std::uint64_t k_max_pairs = 1'000'000;

    Surface& surface_;
    std::size_t budget_;
    bool refine_;
    std::vector<std::vector<std::uint32_t>> faces_of_;          ///< of vertices of the boundary
    std::map<std::uint32_t, std::vector<std::uint32_t>> made_;  ///< ends of edges that fillings made
    std::vector<Hole> holes_;
};

}  // namespace

std::uint32_t fill_holes(Surface& surface, std::size_t max_triangles) { return Filler(surface, max_triangles).fill(); }

}  // namespace sqmap::mesh
