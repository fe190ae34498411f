// The pieces of a thing for which shapes are made: parts of a model, or of a mesh that need not be a solid.
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/collider/export.h"
#include "sqmap/mesh/mesh.h"
#include "sqmap/model/model.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sqmap::collider {

/// A piece, in the mesh's frame and units.
struct Piece {
    std::string name;
    std::vector<Vec3d> points;  ///< their convex hull holds the piece's solid: corners of its surface and of what closes it
    double volume = 0;          ///< of its solid; 0 where it has none
    std::optional<shape::Superquadricd> superquadric{};
    bool certified = true;  ///< the superquadric holds the solid
};

/// A thing and its pieces, whose solids together are the thing's.
struct Pieces {
    std::string name;
    mesh::Mesh surface;  ///< closed where is_solid
    bool is_solid = false;
    std::vector<std::uint8_t> crossed{};  ///< as mesh::AdmitResult has it
    std::vector<Piece> pieces{};
    std::vector<std::array<Vec3d, 3>> held{};  ///< triangles that shapes hold as well, which the solid may not
    /// The whole as one piece.
    [[nodiscard]] Piece whole() const;
};

/// The parts of a model, "part_0" and on, with their superquadrics.
/// model: with its exact layer. @throw mesh::InvalidInput without it, with the cure
/// Cost: linear in the triangles.
[[nodiscard]] Pieces pieces_of(const model::ModelView& model, const std::string& name);
/// Edited parts, which replace the model's own. @throw as above, and where a span has another length than the partition
[[nodiscard]] Pieces pieces_of(const model::ModelView& model, const EditedParts& parts, const std::string& name);

/// How a mesh is cut.
struct CutOptions {
    std::uint32_t max_parts = 1;  ///< 1: not cut
    unsigned threads = 0;         ///< 0: one a core; the result does not depend on it
    bool superquadrics = false;   ///< fit them
};
/// A mesh as it was read, and the solid that it bounds, if one was found.
struct CutInput {
    std::string name;
    std::span<const std::array<Vec3d, 3>> triangles;  ///< all that is to be held beside the solid
    const mesh::Mesh* solid = nullptr;                ///< null: only the triangles are known, and they are one piece
    std::span<const std::uint8_t> crossed{};          ///< of the solid's triangles
};
/// Pieces that hold every triangle: each stands in a piece whose surface is nearest to its middle. Superquadrics hold the solid
/// alone, or are enlarged until they hold the triangles as well.
/// Cost: without parts linear; with them that of a decomposition, some 0.2 s for 10,000 triangles, and of fits.
[[nodiscard]] Pieces pieces_of(const CutInput& input, const CutOptions& options = {});

/// Shapes that hold the pieces. threads: 0 one a core; the result does not depend on it.
/// @throw mesh::InvalidInput for superquadrics that a piece lacks, and for spheres of a thing without a solid
/// Cost: as enclosing, covering_spheres and figures_of.
[[nodiscard]] Colliders colliders_of(const Pieces& pieces, const ShapeChoice& choice, unsigned threads = 0);

}  // namespace sqmap::collider
