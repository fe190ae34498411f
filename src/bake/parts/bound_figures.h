// How tightly superquadrics, polytopes and both together hold the parts, and the whole.
#pragma once

#include "bake/parts/part.h"
#include "sqmap/mesh/mesh.h"
#include "sqmap/model/model_data.h"

#include <span>
#include <vector>

namespace sqmap::bake {

/// Figures of a model's bounds: #parts, then the whole; nothing for a model without polytopes. mesh: model space; patches: of the
/// model's parts.
/// Volumes of superquadrics and polytopes are closed forms; volumes of both together and of unions are sums over some 1,000
/// points a part (fit::interior_points), with the standard error that random points would have. Support excess is the distance of
/// a bound's farthest point from the convex hull of what it bounds: exact for polytopes, whose farthest points are corners;
/// for superquadrics and both together the greatest over some 600 points of the surface, so the truth may lie a little above.
/// Cost: some 3 ms a part. The same for any number of threads.
[[nodiscard]] std::vector<model::BoundFigures> measure_bounds(const mesh::Mesh& mesh, std::span<const Patch> patches,
                                                              const model::ModelData& model, unsigned threads);

/// How far beyond a hull a superquadric and a polytope together reach: the distance of their farthest common point, as above.
/// sides: bound a solid. Cost: some 2 ms.
[[nodiscard]] double excess_of_both(const mesh::Mesh& hull, const shape::Superquadricd& superquadric,
                                    std::span<const HalfSpacef> sides);

}  // namespace sqmap::bake
