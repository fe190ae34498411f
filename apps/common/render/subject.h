// The subject of a picture, from a mesh or a model: triangles, their parts, superquadrics.
#pragma once

#include "decompose/locales.h"
#include "sqmap/mesh/mesh.h"
#include "sqmap/paper/model_file.h"
#include "sqmap/shape/superquadric.h"

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <vector>

namespace sqmap::app {

/// Fields that section 3 computes on a mesh before it cuts.
struct SectionThree {
    decompose::Decomposition found;
    decompose::LocaleBands locales;
};

/// Model space throughout.
struct Subject {
    mesh::Mesh mesh;                                  ///< the drawn triangles
    double r_max = 0;                                 ///< the largest distance between two of its vertices
    std::vector<std::uint32_t> part_of_triangle;      ///< #triangles
    std::vector<paper::Region> regions{};             ///< #triangles; empty where the model does not say (section 5)
    std::vector<shape::Superquadricd> superquadrics;  ///< #parts
    std::optional<paper::MappedModel> model;          ///< when it was drawn from a model
    std::optional<SectionThree> section_three{};      ///< once it was computed
};

/// A picture that was asked of the wrong input.
class SubjectError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// A mesh without parts. mesh: validated, mesh units.
[[nodiscard]] Subject bare_subject(const mesh::Mesh& mesh);

/// A mesh's own decomposition (section 3) and the superquadrics that bound its parts, before baking refines either.
/// mesh: validated, mesh units.
[[nodiscard]] Subject subject_of_mesh(const mesh::Mesh& mesh, const decompose::DecomposeOptions& options);

/// Fields of section 3 on the subject's mesh.
[[nodiscard]] SectionThree section_three_of(const Subject& subject, const decompose::DecomposeOptions& options);

/// A model's parts. mesh (mesh units; may be null) is drawn instead of the model's own triangles, and is needed where the
/// model was baked without its exact layer. A paper model knows parts and regions of the triangles of the mesh that it was baked
/// from; of another mesh, and in other models, each triangle goes to the part that owns the surface nearest to it.
/// @throw SubjectError for a model without triangles and no mesh
[[nodiscard]] Subject subject_of_model(paper::MappedModel model, const mesh::Mesh* mesh);

}  // namespace sqmap::app
