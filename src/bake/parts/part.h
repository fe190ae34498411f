// One part on its way to the model: what each step of the bake makes of it.
#pragma once

#include "bake/parts/caps.h"
#include "sqmap/fit/fit.h"
#include "sqmap/math/half_space.h"
#include "sqmap/math/vec.h"
#include "sqmap/mesh/mesh.h"
#include "sqmap/mesh/solid.h"

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace sqmap::bake {

/// A part's share of the surface and what closes it.
struct Patch {
    std::vector<std::uint32_t> triangles;
    std::vector<CapTriangle> caps;

    bool operator==(const Patch&) const = default;
};

/// A patch in its superquadric.
struct FittedPart {
    Patch patch;
    fit::FitReport fit;                  ///< its certificate is about patch and caps
    Vec3f centre;                        ///< of the central projection, model space
    std::vector<HalfSpacef> polytope{};  ///< beside the superquadric: holds patch and caps too; empty until it is fitted
};

/// The share of a part's area that other surface hides from its projection (section 5's Q2), from some of its triangles, whose
/// order does not depend on the mesh's frame. Thread-safe.
using HiddenShare =
    std::function<double(const mesh::Solid& solid, std::span<const std::uint32_t> triangles, const FittedPart& part)>;

/// How well one superquadric and one projection serve a part.
struct PartQuality {
    double area = 0;          ///< of the patch, model units squared
    double solid_volume = 0;  ///< enclosed by patch and caps, model units cubed
    double q2_share = 0;      ///< of the area: hidden from the projection by other surface
};

/// A fitted part that refinement may weigh against others.
struct MeasuredPart {
    FittedPart fitted;
    PartQuality quality;
};

/// The patches of a partition, caps included. mesh: closed, or edges without a partner get no cap.
[[nodiscard]] std::vector<Patch> patches_of(const mesh::Mesh& mesh, const decompose::Partition& partition);

/// Corners of the patch and its caps; a corner of several triangles as often.
[[nodiscard]] std::vector<Vec3d> corners_of(const mesh::Mesh& mesh, const Patch& patch);

/// Volume that patch and caps enclose, by the divergence theorem.
[[nodiscard]] double enclosed_volume(const mesh::Mesh& mesh, const Patch& patch);

/// The mesh in its principal frame: vertices turned and sorted there, every triangle in its old order but starting at its least
/// vertex. Results computed from it depend on the mesh's frame through rounding only.
struct CanonicalMesh {
    mesh::Mesh mesh;
    Mat3d frame;  ///< turns model space into the canonical frame
};
[[nodiscard]] CanonicalMesh canonical_mesh(const mesh::Mesh& mesh);

/// A solid whose parts are fitted, and what refinement counts as hidden.
struct PartsInput {
    const mesh::Solid& solid;        ///< of the mesh in model space
    const CanonicalMesh& canonical;  ///< of the same mesh
    HiddenShare hidden{};            ///< empty: hidden from the central projection
};

}  // namespace sqmap::bake
