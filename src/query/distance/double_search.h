// The nearest of a model's triangles in double, on the coordinates that the caller gave.
#pragma once

#include "query/distance/distance_kernels.h"

#include "sqmap/model/model.h"

#include <cstdint>

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

/// Evaluates in double every triangle that float does not exclude. point: mesh frame; near: as search_near_triangles
/// finds them, with an entry. Total, no allocation, 30 kB of stack; the same bits on every instruction set.
/// @pre model::has_input(model), the model has a hierarchy, point is finite and less than 1e15 model units away
[[nodiscard]] NearestInDouble nearest_in_double(const model::ModelView& model, Vec3d point, const NearTriangles& near) noexcept;

}  // namespace sqmap::query
