// Labels of a model's triangles carried over to the polygons of the file that it was baked from.
#pragma once

#include "sqmap/bake_mesh.h"
#include "sqmap/io/read.h"

#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::app {

/// A label for each polygon of a file, in the file's order: the one that most of the polygon's area has, -1 where admission
/// dropped the polygon. A wrapped mesh has no polygons of the file: there the label of the nearest triangle counts.
/// soup: as read from the file; mesh: what admission made of it, in `unit` metres per unit of the file (1: the file's own);
/// label_of_triangle: #triangles of the mesh.
[[nodiscard]] std::vector<std::int32_t> polygon_labels(const io::PolygonSoup& soup, const AdmittedMesh& mesh,
                                                       std::span<const std::uint32_t> label_of_triangle, double unit = 1);

}  // namespace sqmap::app
