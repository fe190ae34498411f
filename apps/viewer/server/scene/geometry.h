// Geometry as bytes for the page, little-endian 32-bit values: triangles, superquadrics, samples, unrolled maps.
#pragma once

#include "viewer/server/scene/object.h"

namespace sqmap::viewer {

/// "SQM1", #vertices, #triangles, #parts; positions (3 floats a vertex, world); corners (3 a triangle); part of each triangle.
[[nodiscard]] std::string mesh_bytes(const Object& object, const Parts& parts);
/// "SQS1", #parts; then a part: #vertices, #triangles, positions, corners.
[[nodiscard]] std::string superquadric_bytes(const Object& object, const Parts& parts, int segments);
/// "SQP1", #samples; positions (3 floats a sample, world), part of each: the base samples of all maps.
[[nodiscard]] std::string sample_bytes(const Object& object);
/// "SQU1", width, height; then a pixel: distance of the surface below the superquadric, m, and the surface point, world. Instead
/// of a distance -1: none on this ray, -2: the ray starts inside the solid, -3: no pixel of the map. A central model gives the
/// six faces of the chart's cube as a cross, each `side` pixels wide; a paper model its grid, at most 8 side wide.
/// @pre part < #parts of the model
[[nodiscard]] std::string map_bytes(const Object& object, std::uint32_t part, int side);

}  // namespace sqmap::viewer
