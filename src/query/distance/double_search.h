// The nearest of a model's triangles in double, on the coordinates that the caller gave.
#pragma once

#include "query/distance/distance_kernels.h"

#include "sqmap/model/model.h"

#include <cstdint>
#include <span>

namespace sqmap::query {

/// The nearest surface point of a point, mesh frame and units.
struct NearestInDouble {
    Vec3d offset{};  ///< from the point
    Vec3d normal{};  ///< within 2e-9 of the object's radius: unit, outward, of the face, or the angle-weighted one of edge or
                     ///< corner
    double distance = 0;         ///< never negative
    std::uint32_t triangle = 0;  ///< of those as near the one that faces the point most, then the first in the input
    int side = 0;                ///< 1: outside of these triangles, -1: inside, 0: they do not say
};

/// Evaluates in double every triangle that float does not exclude. points: mesh frame; near: as search_near_triangles finds them;
/// a point without an entry is left out. Total, no allocation, 60 kB of stack; the same bits on every instruction set.
/// @pre model::has_input(model), the model has a hierarchy, points are finite and less than 1e15 model units away; near.size()
/// and found.size() >= points.size()
void nearest_in_double(const model::ModelView& model, std::span<const Vec3d> points, std::span<const NearTriangles> near,
                       std::span<NearestInDouble> found) noexcept;

}  // namespace sqmap::query
