// Warnings about a mesh that was closed or wrapped.
#pragma once

#include "sqmap/mesh/admit.h"
#include "sqmap/mesh/deviation.h"

#include <optional>

namespace sqmap::mesh {

/// W_DROPPED where polygons that closing left out stand out of the solid. diagonal: of the input's box, units of the meshes.
[[nodiscard]] std::optional<Warning> dropped_warning(const Mesh& dropped, const Mesh& solid, double diagonal);

/// W_TOLERANCE where a wrapped mesh is farther from the input, or larger, than the options ask.
[[nodiscard]] std::optional<Warning> tolerance_warning(const Mesh& wrapped, const Deviation& moved, const WrapOptions& options);

}  // namespace sqmap::mesh
