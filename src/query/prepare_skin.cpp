// What skinned shapes set up outside the frame: the allocating half.
#include "sqmap/query/skin.h"

namespace sqmap::query {

namespace {

/// The points about the lattice's middle: the probe keeps its places relative to where its points first were.
std::vector<Vec3d> moved_to(const SkinLattice& lattice, std::span<const Vec3d> points)
{
    Vec3d mean{};
    for (const Vec3d& p : points) mean += p / static_cast<double>(points.size());
    std::vector<Vec3d> moved;
    for (const Vec3d& p : points) {
        const Vec3d to_middle =
            0.5 * lattice.cell * Vec3d{double(lattice.size[0]), double(lattice.size[1]), double(lattice.size[2])};
        moved.push_back(p - mean + lattice.origin + to_middle);
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

SkinRoom::SkinRoom(const SkinLattice& lattice, std::span<const Vec3d> points)
    : size_(points.size()),
      probe_(moved_to(lattice, points)),
      places_(k_most * points.size()),
      count_(points.size()),
      asked_places_(points.size()),
      asked_(points.size()),
      covered_(points.size()),
      best_(points.size()),
      found_(points.size())
{
}

}  // namespace sqmap::query
