// Distances change no faster than places: a cell that is small beside its distance from the surface is bounded by the distance of
// its centre.
#include "bake/distance/bounds.h"

#include "model/bound_tree.h"
#include "model/hierarchy.h"
#include "sqmap/parallel/for_each.h"

#include <array>
#include <cmath>
#include <vector>

namespace sqmap::bake {

namespace {

// The bound at a cell's farthest corner is at least half of the distance there: a third, and a little for what is stored.
constexpr double k_reach_of_distance = 0.32;
// Where the band ends, finer: what the bound does not put beyond the band is sought among the triangles.
constexpr double k_reach_at_band = 0.28;
// The root holds a ball of three times the object's sphere: beyond, the sphere alone is bound enough.
constexpr double k_root_spheres = 3.01;
// Half of the smallest cell's side, of R_max; larger where the tree would take too many bytes.
constexpr double k_least_half = 0.005;
constexpr double k_coarser = 1.4;
constexpr double k_max_share = 0.05;  // of the model's other bytes

Vec3d eighth(std::size_t k) { return {k & 1 ? 1. : -1., k & 2 ? 1. : -1., k & 4 ? 1. : -1.}; }

/// A cell's eighths, or what is stored of a leaf.
struct Cell {
    std::uint16_t bound = 0;
    std::vector<Cell> eighths;
};

class BoundTree {
public:
    BoundTree(const mesh::Solid& solid, const model::ModelData& data, double least_half)
        : solid_(solid),
          least_half_(least_half),
          band_(static_cast<double>(data.distance.header.band)),
          is_solid_(data.header.solid != 0)
    {
    }

    Cell grow(Vec3d centre, double half, int depth) const
    {
        const Measured m = measure(centre);
        if (is_leaf(m, half) || depth >= model::k_max_bound_depth) return {stored(m, half), {}};
        Cell cell;
        cell.eighths.resize(8);
        for (std::size_t k = 0; k < 8; ++k) cell.eighths[k] = grow(centre + 0.5 * half * eighth(k), 0.5 * half, depth + 1);
        return cell;
    }

private:
    struct Measured {
        double distance;
        bool inside;
    };
    Measured measure(Vec3d p) const
    {
        const mesh::ClosestPoint c = solid_.closest_boundary(p);
        return {c.distance, is_solid_ && solid_.inside(p)};
    }

    bool is_leaf(const Measured& m, double half) const
    {
        const double reach = std::sqrt(3.0) * half;
        if (half < least_half_) return true;
        if (m.distance - reach > band_) return is_bounded(m, half);
        return m.distance + reach < band_ || reach <= k_reach_at_band * m.distance;
    }
    static bool is_bounded(const Measured& m, double half) { return std::sqrt(3.0) * half <= k_reach_of_distance * m.distance; }
    std::uint16_t stored(const Measured& m, double half) const
    {
        // Within the band, or too near for a bound: nobody reads how near.
        const bool near = m.distance + std::sqrt(3.0) * half < band_ || !is_bounded(m, half);
        return model::encode_bound(near ? 0 : m.distance, half, m.inside);
    }

    const mesh::Solid& solid_;
    const double least_half_, band_;
    const bool is_solid_;
};

std::size_t cells_below(const Cell& cell)
{
    std::size_t count = cell.eighths.size();
    for (const Cell& eighth : cell.eighths) count += cells_below(eighth);
    return count;
}

/// The eighths of a divided cell side by side, then those of each of them.
void store(const Cell& cell, model::DistanceArrays<model::ArrayData>& data)
{
    const std::size_t first = data.bounds.size();
    data.bounds.resize(first + 8);
    for (std::size_t k = 0; k < 8; ++k) {
        const Cell& eighth = cell.eighths[k];
        if (eighth.eighths.empty()) {
            data.bounds[first + k] = eighth.bound;
        } else {
            data.bounds[first + k] = static_cast<std::uint16_t>(data.bounds.size() / 8);
            store(eighth, data);
        }
    }
}

/// The root and its eighths are divided whatever they hold, so that there is work for many threads.
Cell grow_root(const BoundTree& tree, const model::DistanceHeader& header, unsigned threads)
{
    const Vec3d centre = cast<double>(model::vec3(header.root));
    const auto half = static_cast<double>(header.half);
    Cell root;
    root.eighths.resize(8);
    for (Cell& cell : root.eighths) cell.eighths.resize(8);
    parallel::for_each(64, threads, [&](std::size_t i) {
        const Vec3d middle = centre + 0.5 * half * eighth(i / 8) + 0.25 * half * eighth(i % 8);
        root.eighths[i / 8].eighths[i % 8] = tree.grow(middle, 0.25 * half, 2);
    });
    return root;
}

}  // namespace

void bake_bounds(const mesh::Solid& solid, std::size_t other_bytes, unsigned threads, model::ModelData& data)
{
    model::DistanceHeader& header = data.distance.header;
    header.half = static_cast<float>(k_root_spheres * static_cast<double>(data.header.sphere[3]));
    for (int k = 0; k < 3; ++k) header.root[k] = data.header.sphere[k];
    const double budget = k_max_share * static_cast<double>(other_bytes) / sizeof(std::uint16_t);
    const std::size_t max_cells = std::min(model::k_max_bounds, std::max<std::size_t>(4096, static_cast<std::size_t>(budget)));
    for (double least_half = k_least_half * data.header.r_max;; least_half *= k_coarser) {
        const Cell root = grow_root({solid, data, least_half}, header, threads);
        if (cells_below(root) > max_cells && least_half < static_cast<double>(header.half)) continue;
        store(root, data.distance);
        return;
    }
}

}  // namespace sqmap::bake
