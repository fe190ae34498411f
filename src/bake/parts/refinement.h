// The error-driven pass: splits parts that one superquadric and one projection serve badly, joins what it need not have
// split.
#pragma once

#include "bake/parts/part_work.h"
#include "sqmap/bake/bake.h"
#include "sqmap/decompose/decompose.h"

#include <vector>

namespace sqmap::bake {

/// Everything of a part that has its triangles and caps, but for its map.
void finish(const SurfaceContext& context, PartWork& part, const BakeOptions& options);

/// Superquadric and centre of a part that has its triangles and caps.
void fit_and_centre(const SurfaceContext& context, PartWork& part, const BakeOptions& options);

/// Whether, and how narrowly, a superquadric holds a part's patch and caps.
[[nodiscard]] fit::Certificate certify_part(const mesh::Mesh& mesh, const PartWork& part,
                                            const shape::Superquadricd& superquadric);

/// Fits every part of a partition, caps included.
[[nodiscard]] std::vector<PartWork> fit_parts(const SurfaceContext& context, const decompose::Partition& partition,
                                              const BakeOptions& options);

/// Splits the part that is served worst while that pays, up to options.max_parts, then undoes cuts of its own kind that
/// one superquadric serves as well. Cuts that passed a test of section 3 stay. Changes partition and parts together.
void refine_parts(const SurfaceContext& context, decompose::Partition& partition, std::vector<PartWork>& parts,
                  const BakeOptions& options);

}  // namespace sqmap::bake
