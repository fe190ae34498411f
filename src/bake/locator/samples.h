// Sample points of a locator cell, each with its nearest surface point.
#pragma once

#include "bake/locator/draft.h"
#include "bake/locator/known_winding.h"
#include "bake/locator/nearby.h"
#include "sqmap/mesh/solid.h"

#include <span>
#include <vector>

namespace sqmap::bake {

struct Sample {
    Vec3d point;
    mesh::ClosestPoint nearest;  ///< of the boundary
    bool inside;
};

/// By the side of the nearest triangle where the point is right above its face; else by another sample that no surface can be
/// between, for it is nearer; else by the winding number. known: of a point nearby, or of p itself.
[[nodiscard]] bool is_inside(const KnownWinding& known, Vec3d p, const mesh::ClosestPoint& nearest,
                             std::span<const Sample> others = {});

/// Outward normal of the surface at the point nearest to a sample, of any length. cell: the locator's.
[[nodiscard]] Vec3d normal_at(const mesh::Solid& solid, const Sample& sample, double cell);

/// A cell that may have a surface near it.
struct SurfaceCell {
    const LocatorSubject& subject;
    CellCube cube;
    model::LocatorCellKind kind;  ///< Mixed or Inside
    Sample centre;
    std::span<const std::uint32_t> near;  ///< triangles that can be nearest to a point of it, or none: not known
    double tolerance;                     ///< by how much its planes may miss the surface, model units
    const KnownWinding& winding;          ///< about its centre
};

class CellSampler {
public:
    explicit CellSampler(const SurfaceCell& cell);

    /// Near the cell's corners and the middles of its faces, and its centre.
    [[nodiscard]] std::vector<Sample> samples();
    /// Adds samples for checking several planes: between the cell's centre and its corners, and near the middles of its edges.
    void add_more(std::vector<Sample>& samples);
    /// The surface within the cell: corners and middles of the triangles' pieces. Where planes are near all of it, a point
    /// farther from them is on the side of a corner of the cell, which is a sample: so their side is right but for a band.
    void add_surface(std::vector<Sample>& samples) const;

private:
    void add(std::span<const Vec3d> offsets, std::vector<Sample>& samples);

    const SurfaceCell& cell_;
    Nearby nearby_;
};

}  // namespace sqmap::bake
