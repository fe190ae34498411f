// The content of a locator cell, from the solid and the parts' maps.
#pragma once

#include "bake/locator/draft.h"
#include "bake/locator/samples.h"
#include "sqmap/mesh/solid.h"

#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::bake {

/// The boundary point nearest to p. A known boundary point limits the search to a ball.
[[nodiscard]] mesh::ClosestPoint closest_from(const mesh::Solid& solid, Vec3d known, Vec3d p);

/// The triangles that are nearest to some point of a cube. distance: of the boundary from its centre.
[[nodiscard]] std::vector<std::uint32_t> triangles_near(const mesh::Solid& solid, const CellCube& cube, double distance);

/// Drafts of cells. Const members are thread-safe.
class CellBaker {
public:
    /// keeps_near: drafts keep the triangles near them (CellDraft::near).
    CellBaker(const LocatorSubject& subject, bool keeps_near) : subject_(subject), keeps_near_(keeps_near) {}

    [[nodiscard]] CellDraft bake(const CellCube& cube, const KnownWinding* outer = nullptr) const;
    /// nearest: of the boundary, to the centre. near: of a cell that this is an eighth of, or nothing. outer: of a point nearby,
    /// or null.
    [[nodiscard]] CellDraft bake(const CellCube& cube, const mesh::ClosestPoint& nearest,
                                 std::span<const std::uint32_t> near = {}, const KnownWinding* outer = nullptr) const;
    /// The eighths of a cell, divided in turn where their seeds miss the surface, so many times in all.
    [[nodiscard]] std::vector<CellDraft> bake_eighths(const CellCube& cube, std::span<const std::uint32_t> near,
                                                      int divisions = model::k_max_divisions,
                                                      const KnownWinding* outer = nullptr) const;
    /// in_full: with the cells of a brick that is stored.
    [[nodiscard]] BrickDraft bake_brick(const Grid& grid, std::size_t brick, bool in_full) const;

private:
    /// Planes, or seeds.
    void find_surface(SurfaceCell cell, CellDraft& draft) const;

    const LocatorSubject& subject_;
    bool keeps_near_;
};

}  // namespace sqmap::bake
