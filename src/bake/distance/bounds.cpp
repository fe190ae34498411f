// Distance changes no faster than position: a cell that is small beside its distance from the surface is bounded by the distance
// of its centre.
#include "bake/distance/distance.h"

#include "model/bound_tree.h"
#include "model/hierarchy.h"
#include "parallel/for_each.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace sqmap::bake {

namespace {

// The bound at a cell's farthest corner is at least half of the distance there: a third, and a little for what is stored.
constexpr double k_reach_of_distance = 0.32;
// Leaves are finer where the band ends: points that the bound does not place beyond the band are searched among the triangles.
constexpr double k_reach_at_band = 0.28;
// The root holds a ball of three times the object's sphere: beyond, the sphere alone is bound enough.
constexpr double k_root_spheres = 3.01;
// Half of the smallest cell's side, of R_max; larger where the tree would take too many bytes.
constexpr double k_least_half = 0.005;
constexpr double k_max_share = 0.05;  // of the model's other bytes

Vec3d eighth(std::size_t k) { return {k & 1 ? 1. : -1., k & 2 ? 1. : -1., k & 4 ? 1. : -1.}; }

struct Cell {
    Vec3d centre;
    double half;
    double distance = 0;  ///< of its centre to the boundary
    bool inside = false;
    std::size_t first = k_leaf;  ///< of its eighths in the next level

    static constexpr std::size_t k_leaf = ~std::size_t{0};
};

/// Cells level by level: a level is made while all of them stay within so many cells.
class BoundTree {
public:
    BoundTree(const mesh::Solid& solid, const model::ModelData& data, unsigned threads)
        : solid_(solid),
          least_half_(k_least_half * data.header.r_max),
          band_(static_cast<double>(data.distance.header.band)),
          is_solid_(data.header.solid != 0),
          threads_(threads)
    {
    }

    void grow(Cell root, std::size_t max_cells)
    {
        levels_ = {{root}};
        std::size_t count = 0;
        for (int depth = 0; depth < model::k_max_bound_depth; ++depth) {
            std::vector<Cell>& level = levels_.back();
            std::vector<std::size_t> divided;
            for (std::size_t i = 0; i < level.size(); ++i)
                if (depth < k_full_levels || !is_leaf(level[i])) divided.push_back(i);
            count += 8 * divided.size();
            if (divided.empty() || count > max_cells) return;
            std::vector<Cell> next(8 * divided.size());
            for (std::size_t d = 0; d < divided.size(); ++d) level[divided[d]].first = 8 * d;
            parallel::for_each(divided.size(), threads_, [&](std::size_t d) {
                for (std::size_t k = 0; k < 8; ++k) next[8 * d + k] = measured_eighth(level[divided[d]], k, depth);
            });
            levels_.push_back(std::move(next));
        }
    }

    /// The eighths of a divided cell side by side, then those of each of them.
    void store(model::DistanceArrays<model::ArrayData>& data) const { store(0, 0, data); }

private:
    static constexpr int k_full_levels = 2;  ///< divided whatever they hold

    Cell measured_eighth(const Cell& of, std::size_t k, int depth) const
    {
        Cell cell{of.centre + 0.5 * of.half * eighth(k), 0.5 * of.half};
        if (depth + 1 < k_full_levels) return cell;
        // The surface nearest to the larger cell's centre is no farther than that, and no point within its distance changes
        // sides.
        const double step = std::sqrt(3.0) * cell.half;
        const bool is_known = depth >= k_full_levels;
        const double within = is_known ? (1 + 1e-9) * (of.distance + step) : std::numeric_limits<double>::infinity();
        cell.distance = solid_.closest_boundary(cell.centre, within).distance;
        cell.inside = is_solid_ && (is_known && step < 0.999 * of.distance ? of.inside : solid_.inside(cell.centre));
        return cell;
    }

    bool is_leaf(const Cell& cell) const
    {
        const double reach = std::sqrt(3.0) * cell.half;
        if (cell.half < least_half_) return true;
        if (cell.distance - reach > band_) return is_bounded(cell);
        return cell.distance + reach < band_ || reach <= k_reach_at_band * cell.distance;
    }
    static bool is_bounded(const Cell& cell) { return std::sqrt(3.0) * cell.half <= k_reach_of_distance * cell.distance; }
    std::uint16_t stored(const Cell& cell) const
    {
        // No query reads the bound of a cell within the band, or of one too near for a bound.
        const bool near = cell.distance + std::sqrt(3.0) * cell.half < band_ || !is_bounded(cell);
        return model::encode_bound(near ? 0 : cell.distance, cell.half, cell.inside);
    }

    void store(std::size_t depth, std::size_t cell, model::DistanceArrays<model::ArrayData>& data) const
    {
        const std::size_t first = data.bounds.size(), from = levels_[depth][cell].first;
        data.bounds.resize(first + 8);
        for (std::size_t k = 0; k < 8; ++k) {
            if (const Cell& eighth = levels_[depth + 1][from + k]; eighth.first == Cell::k_leaf) {
                data.bounds[first + k] = stored(eighth);
            } else {
                data.bounds[first + k] = static_cast<std::uint16_t>(data.bounds.size() / 8);
                store(depth + 1, from + k, data);
            }
        }
    }

    const mesh::Solid& solid_;
    const double least_half_, band_;
    const bool is_solid_;
    const unsigned threads_;
    std::vector<std::vector<Cell>> levels_;
};

}  // namespace

void bake_bounds(const mesh::Solid& solid, std::size_t other_bytes, unsigned threads, model::ModelData& data)
{
    model::DistanceHeader& header = data.distance.header;
    header.half = static_cast<float>(k_root_spheres * static_cast<double>(data.header.sphere[3]));
    for (int k = 0; k < 3; ++k) header.root[k] = data.header.sphere[k];
    const double budget = k_max_share * static_cast<double>(other_bytes) / sizeof(std::uint16_t);
    const std::size_t max_cells = std::min(model::k_max_bounds, std::max<std::size_t>(4096, static_cast<std::size_t>(budget)));
    BoundTree tree(solid, data, threads);
    tree.grow({cast<double>(model::vec3(header.root)), static_cast<double>(header.half)}, max_cells);
    tree.store(data.distance);
}

}  // namespace sqmap::bake
