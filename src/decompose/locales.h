// Locales and Boundary Strength of section 3.1.
#pragma once

#include "sqmap/decompose/decompose.h"

#include <cstdint>
#include <vector>

namespace sqmap::decompose {

/// The locales about every salient feature, over the whole mesh: before any cut, where Cutting::Printed measures them within the
/// part that it is about to cut.
struct LocaleBands {
    static constexpr std::uint32_t k_none = 0xffffffffu;
    double width = 0;                           ///< of a locale, mesh units
    std::vector<double> distance;               ///< #vertices: geodesic, to the nearest feature; infinity: none is reached
    std::vector<std::uint32_t> feature;         ///< #triangles: the nearest among salient_vertices; k_none: none is reached
    std::vector<std::vector<double>> strength;  ///< #features: Boundary Strength of each of its locales, see boundary_strength
};

/// Boundary Strength of each locale: the difference of its area and of the area of the one before, over what that is on a plane
/// (2 pi width^2), so that it is free of scale: 1 on a plane, 0 on a cylinder. 0 of the first locale, which has none before it.
/// area: of the locales, from the feature on; width: of each. Section 3.1.
[[nodiscard]] std::vector<double> boundary_strength(const std::vector<double>& area, double width);

/// Locales about a decomposition's salient features. Areas are those between the levels of distance, which cut triangles.
/// found: of the same mesh. Cost: a run of geodesic distances a feature. Thread-safe.
[[nodiscard]] LocaleBands locale_bands(const mesh::Mesh& mesh, const Decomposition& found, const DecomposeOptions& options);

}  // namespace sqmap::decompose
