// Constructors of skinned shapes, which allocate: they run outside the frame.
#include "sqmap/query/skin.h"

#include <algorithm>
#include <cmath>

namespace sqmap::query {

namespace {

/// The points about the lattice's middle, none far from it: the probe keeps its positions relative to where its points first
/// were.
std::vector<Vec3d> moved_to(const SkinLattice& lattice, std::span<const Vec3d> points)
{
    Vec3d mean{};
    for (const Vec3d& p : points)
        if (is_finite(p)) mean += p / static_cast<double>(points.size());
    std::vector<Vec3d> moved;
    for (const Vec3d& p : points) {
        Vec3d& at = moved.emplace_back();
        for (int k = 0; k < 3; ++k) {
            const double side = lattice.cell * lattice.size[static_cast<std::size_t>(k)];
            at[k] = lattice.origin[k] + 0.5 * side + (is_finite(p) ? std::clamp(p[k] - mean[k], -2 * side, 2 * side) : 0);
        }
    }
    return moved;
}

}  // namespace

PosedSkin::PosedSkin(const SkinLattice& lattice)
    : lattice_(&lattice),
      maps_(lattice.bones),
      back_(lattice.bones),
      sign_(lattice.bones),
      corners_(lattice.first_pull.empty() ? 0 : lattice.first_pull.size() - 1),
      boxes_(lattice.nodes.size())
{
    (void)pose(std::vector<Affine>(lattice.bones));
}

MovingSkin::MovingSkin(const SkinLattice& lattice)
    : lattice_(&lattice), from_(lattice), to_(lattice), between_(lattice), maps_(lattice.bones)
{
}

SkinWorkspace::SkinWorkspace(const SkinLattice& lattice, std::span<const Vec3d> points)
    : size_(points.size()),
      probe_(moved_to(lattice, points)),
      positions_(k_max * points.size()),
      found_positions_(k_max * Probe::k_cluster),
      first_(points.size()),
      count_(points.size()),
      active_positions_(points.size()),
      active_(points.size()),
      covered_(points.size()),
      best_(points.size()),
      found_(points.size()),
      at_(points.size()),
      fast_(points.size()),
      contact_(points.size()),
      swept_(points.size())
{
}

}  // namespace sqmap::query
