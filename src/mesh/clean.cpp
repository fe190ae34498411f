#include "admit_steps.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

namespace sqmap::mesh {
namespace {

constexpr double k_sliver_height = 1e-9;  // of the box's diagonal: lower triangles have no area
constexpr double k_thin_height = 1e-6;    // of the diagonal: extra faces this low are such faces after rounding
constexpr double k_weld_distance = 1e-7;  // of the diagonal: positions closer may be one vertex

/// True if a face is lower than `height` diagonals.
bool is_sliver(const Surface& surface, const Face& f, double height, double diagonal)
{
    const Vec3d a = surface.points[f.v[0]], b = surface.points[f.v[1]], c = surface.points[f.v[2]];
    // In units of the diagonal: squares of small lengths must not vanish.
    const Vec3d u = (b - a) / diagonal, w = (c - a) / diagonal;
    const double longest = std::sqrt(std::max({norm_sq(u), norm_sq(w), norm_sq(w - u)}));
    return norm(cross(u, w)) <= height * longest;
}

class Cleaner {
public:
    Cleaner(Surface& surface, const Box& box) : surface_(surface), box_(box), diagonal_(norm(size(box))) {}

    Cleaned clean()
    {
        drop_faces();
        // A mesh that is closed as it is indexed keeps its indices: shells that touch may do so on purpose.
        if (!is_closed(surface_.faces) && !drop_thin_faces()) {
            std::uint64_t welded = weld(coincident(surface_.points));
            if (welded > 0) drop_faces();
            if (!is_closed(surface_.faces) && !drop_thin_faces()) welded += weld_nearby();
            out_.welded_vertices = welded;
        }
        return out_;
    }

private:
    /// Gives vertices at one position one number; returns how many vertices that saves.
    std::uint64_t weld(const std::vector<std::uint32_t>& first)
    {
        std::uint64_t saved = 0;
        for (std::uint32_t v = 0; v < first.size(); ++v) saved += first[v] != v;
        if (saved == 0) return 0;
        for (Face& f : surface_.faces)
            for (std::uint32_t& v : f.v) v = first[v];
        saved -= std::min(saved, already_welded_);
        already_welded_ += saved;
        return saved;
    }

    std::uint64_t weld_nearby()
    {
        const Surface before = surface_;
        const Cleaned counts = out_;
        const std::uint64_t welded_before = already_welded_;
        const Vec3d centre = box_.lo + 0.5 * size(box_);
        std::vector<Vec3d> local;
        for (const Vec3d& p : surface_.points) local.push_back(p - centre);
        const std::uint64_t saved = weld(coincident_within(local, k_weld_distance * diagonal_));
        if (saved > 0) {
            drop_faces();
            if (is_closed(surface_.faces)) return saved;
        }
        surface_ = before;
        out_ = counts;
        already_welded_ = welded_before;
        return 0;
    }

    /// Drops extra faces that are thin only up to the rounding of a text file; takes that back unless the mesh closes without
    /// them.
    bool drop_thin_faces()
    {
        const std::vector<Face> before = surface_.faces;
        const std::uint64_t count = out_.degenerate_faces;
        drop_loose_slivers(k_thin_height);
        if (is_closed(surface_.faces)) return true;
        surface_.faces = before;
        out_.degenerate_faces = count;
        return false;
    }

    void drop_faces()
    {
        const std::size_t before = surface_.faces.size();
        std::erase_if(surface_.faces, [](const Face& f) { return f.v[0] == f.v[1] || f.v[1] == f.v[2] || f.v[2] == f.v[0]; });
        out_.degenerate_faces += before - surface_.faces.size();
        drop_duplicates();
        drop_loose_slivers(k_sliver_height);
    }

    /// Drops faces without area that are not between exactly three neighbours: that opens nothing.
    void drop_loose_slivers(double height)
    {
        std::vector<bool> sliver(surface_.faces.size());
        bool any = false;
        for (std::size_t f = 0; f < sliver.size(); ++f)
            any = (sliver[f] = is_sliver(surface_, surface_.faces[f], height, diagonal_)) || any;
        while (any) {
            std::vector<bool> loose(surface_.faces.size(), false);
            any = false;
            for_each_edge(edge_uses(surface_.faces), [&](std::span<const EdgeUse> edge) {
                if (edge.size() == 2) return;
                for (const EdgeUse& u : edge)
                    if (sliver[u.half / 3]) any = loose[u.half / 3] = true;
            });
            std::size_t kept = 0;
            for (std::size_t f = 0; f < surface_.faces.size(); ++f)
                if (!loose[f]) {
                    surface_.faces[kept] = surface_.faces[f];
                    sliver[kept++] = sliver[f];
                }
            out_.degenerate_faces += surface_.faces.size() - kept;
            surface_.faces.resize(kept);
            sliver.resize(kept);
        }
    }

    /// Keeps one of several faces with the same corners. Two that are back to back cancel if the rest closes without them: they
    /// are a wall inside a solid, which no winding number sees.
    void drop_duplicates()
    {
        const auto& faces = surface_.faces;
        std::vector<std::uint32_t> order(faces.size());
        std::iota(order.begin(), order.end(), 0u);
        std::vector<Triangle> key(faces.size());
        for (std::size_t f = 0; f < faces.size(); ++f) {
            key[f] = faces[f].v;
            std::sort(key[f].begin(), key[f].end());
        }
        std::sort(order.begin(), order.end(), [&](auto a, auto b) { return key[a] != key[b] ? key[a] < key[b] : a < b; });
        const auto is_even = [&](std::uint32_t f) {
            const Triangle& v = faces[f].v;
            return (v[0] < v[1]) + (v[1] < v[2]) + (v[2] < v[0]) == 2;
        };
        std::vector<bool> keep(faces.size(), false), keep_uncancelled(faces.size(), false);
        bool any_opposite = false, any_left = false;
        for (std::size_t i = 0; i < order.size();) {
            std::size_t j = i;
            bool both = false;
            for (; j < order.size() && key[order[j]] == key[order[i]]; ++j) both = both || is_even(order[j]) != is_even(order[i]);
            keep[order[i]] = true;
            keep_uncancelled[order[i]] = !both;
            any_opposite = any_opposite || both;
            any_left = any_left || !both;
            i = j;
        }
        const auto kept = [&](const std::vector<bool>& keeps) {
            std::vector<Face> out;
            for (std::size_t f = 0; f < faces.size(); ++f)
                if (keeps[f]) out.push_back(faces[f]);
            return out;
        };
        std::vector<Face> left;
        if (any_opposite && any_left) left = kept(keep_uncancelled);
        if (left.empty() || !is_closed(left)) left = kept(keep);
        out_.duplicate_faces += faces.size() - left.size();
        surface_.faces = std::move(left);
    }

    Surface& surface_;
    const Box& box_;
    double diagonal_ = 0;
    std::uint64_t already_welded_ = 0;
    Cleaned out_;
};

}  // namespace

Cleaned clean(Surface& surface, const Box& box) { return Cleaner(surface, box).clean(); }

TightSlivers remove_tight_slivers(Surface& surface, double diagonal)
{
    constexpr int k_passes = 16;  // a fan of slivers takes one pass for each
    std::uint64_t removed = 0, left = 0;
    for (int pass = 0; pass < k_passes; ++pass) {
        std::vector<std::uint32_t> slivers;
        for (std::uint32_t f = 0; f < surface.faces.size(); ++f)
            if (is_sliver(surface, surface.faces[f], k_sliver_height, diagonal)) slivers.push_back(f);
        left = slivers.size();
        if (slivers.empty()) break;
        const std::vector<EdgeUse> uses = edge_uses(surface.faces);
        const auto sides_of = [&](std::uint32_t a, std::uint32_t b) {
            const auto order = [](const EdgeUse& u, const EdgeUse& w) { return std::tie(u.lo, u.hi) < std::tie(w.lo, w.hi); };
            return std::equal_range(uses.begin(), uses.end(), EdgeUse{std::min(a, b), std::max(a, b), 0, false}, order);
        };
        std::vector<bool> touched(surface.faces.size(), false);
        std::vector<std::pair<std::uint32_t, std::uint32_t>> added;
        std::uint64_t turned = 0;
        for (const std::uint32_t f : slivers) {
            std::uint32_t k = 0;
            double longest = -1;
            for (std::uint32_t i = 0; i < 3; ++i) {
                const double length =
                    norm(surface.points[surface.faces[f].v[(i + 1) % 3]] - surface.points[surface.faces[f].v[i]]);
                if (length > longest) {
                    longest = length;
                    k = i;
                }
            }
            const Triangle v = surface.faces[f].v;
            const std::uint32_t a = v[k], b = v[(k + 1) % 3], c = v[(k + 2) % 3];
            const auto [first, last] = sides_of(a, b);
            if (touched[f] || last - first != 2) continue;
            const std::uint32_t other = first->half / 3 == f ? (first + 1)->half : first->half;
            const std::uint32_t g = other / 3, d = surface.faces[g].v[(other + 2) % 3];
            const auto [cd, cd_end] = sides_of(c, d);
            const std::pair new_edge(std::min(c, d), std::max(c, d));
            if (touched[g] || c == d || cd != cd_end || std::find(added.begin(), added.end(), new_edge) != added.end()) continue;
            surface.faces[f].v = {a, d, c};
            surface.faces[g].v = {d, b, c};
            touched[f] = touched[g] = true;
            added.push_back(new_edge);
            ++turned;
        }
        removed += turned;
        if (turned == 0) break;
    }
    return {removed, left};
}

}  // namespace sqmap::mesh
