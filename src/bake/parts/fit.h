// The superquadric of one part: fitted, turned into model space, rounded to float and proven to hold the part.
#pragma once

#include "bake/parts/part.h"
#include "sqmap/fit/fit.h"
#include "sqmap/mesh/solid.h"

#include <vector>

namespace sqmap::bake {

/// Superquadric and projection centre of a patch. solid: of the mesh in model space; canonical: of the same mesh.
/// Cost: that of fit::fit_bounding, some 25 ms. Thread-safe.
[[nodiscard]] FittedPart fit_patch(const mesh::Solid& solid, const CanonicalMesh& canonical, Patch patch,
                                   const fit::FitOptions& options);

/// The convex polytope of a part beside its superquadric. part_count: of the mesh; where they are few the sides are turned until
/// the part's support excess is small, if that of both bounds together does not rise by it. mesh: in model space. Cost: some 3
/// ms; 0.1 s where sides are turned. Thread-safe.
[[nodiscard]] std::vector<HalfSpacef> fit_polytope(const mesh::Mesh& mesh, const FittedPart& part, std::size_t part_count);

/// How well the fit serves. No sample depends on the file's frame.
[[nodiscard]] PartQuality quality_of(const PartsInput& input, const FittedPart& part);

/// Patch and caps of a part as one surface, for certificates.
struct HeldSurface {
    std::vector<Vec3d> points;
    std::vector<mesh::Triangle> triangles;
};
[[nodiscard]] HeldSurface held_by(const mesh::Mesh& mesh, const Patch& patch);

/// Certifies that a superquadric holds a patch and its caps, and how narrowly.
[[nodiscard]] fit::Certificate certify_patch(const mesh::Mesh& mesh, const Patch& patch,
                                             const shape::Superquadricd& superquadric);

}  // namespace sqmap::bake
