// How far a repaired mesh is from the one it was made of, both ways.
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/mesh/mesh.h"

#include <cstdint>
#include <optional>
#include <span>

namespace sqmap::mesh {

/// Distances from points of one surface to the nearest of another, in the unit of the meshes. Mean and p99 weigh by area.
struct Distances {
    double mean = 0, p99 = 0, max = 0;
};

/// Effect of a cure on a surface.
struct Deviation {
    Distances input_to_result;                    ///< from all of the input's surface
    std::optional<Distances> bounding_to_result;  ///< from the input's surface that bounds the solid, of a wrapped one
    Distances result_to_input;                    ///< from the result's surface without what was made up
    double made_up_area = 0;                      ///< unit squared
    double made_up_share = 0;                     ///< of the result's area
};

/// Measured at `samples` points spread evenly over each surface, always the same ones, and, for the greatest distance, at as many
/// of its vertices. input: any triangles, not empty. made_up: #triangles of the result, non-zero where no input stood; empty for
/// none. Cost: n log n in the triangles, samples times the logarithm.
[[nodiscard]] Deviation deviation(const Mesh& input, const Mesh& result, std::span<const std::uint8_t> made_up = {},
                                  std::uint32_t samples = 50'000);

/// Distances from the input's surface where it bounds the solid: where the generalized winding number of the input as it is
/// oriented is above 1/2 on one side and not on the other. Inner walls, and sheets that bound nothing, are left out. Without any
/// such surface all are 0. Arguments and cost as above, and two winding numbers a sample.
[[nodiscard]] Distances bounding_distances(const Mesh& input, const Mesh& result, std::uint32_t samples = 50'000);

}  // namespace sqmap::mesh
