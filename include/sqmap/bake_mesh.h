// The front door: from a mesh to a model that answers. One call reads, admits, cures, bakes and stamps.
//
//     const sqmap::BakedModel model = sqmap::bake_mesh("cow.obj");
//     const double distance = sqmap::query::distance(model.view(), {0, 0, 1}).distance;
//
// Any number of threads, on inputs of their own.
#pragma once

#include "sqmap/bake/notes.h"
#include "sqmap/io/read.h"
#include "sqmap/mesh/admission.h"
#include "sqmap/paper/bake.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace sqmap {

/// The bytes of a mesh file; the extension of the name gives the format. Buffers beside a glTF file are out of reach.
struct MeshBytes {
    std::span<const std::byte> bytes;  ///< outlives the call
    std::string name;                  ///< "cow.obj"
};

/// A mesh as it comes in: a file, a file's bytes, arrays of polygons (without offsets: of triangles), or a mesh.
using MeshInput = std::variant<std::filesystem::path, MeshBytes, mesh::PolygonView, mesh::Mesh>;

/// Which files are read, and how far a mesh may be changed until it bounds a solid.
struct MeshOptions {
    mesh::AdmitOptions admit{};
    io::ReadLimits limits{};
    /// Gets a file's polygons after they are read and before they are judged: it may move them, or keep a copy. Null: none does.
    const std::function<void(io::PolygonSoup&)>* as_read = nullptr;
};

/// A mesh that was admitted, or the diagnosis of one that was refused.
struct AdmittedMesh : mesh::AdmitResult {
    std::string format;  ///< of the file, "OBJ"; empty of arrays, and where it was not recognised
    std::string source;  ///< name of the file without its folder, "arrays" without a file

    /// True where the mesh was refused: `diagnosis` says why, and there are no triangles.
    [[nodiscard]] bool refused() const { return admission == mesh::Admission::Refused; }
    /// Repairs, how far a cure moved the surface, warnings. @throw std::bad_alloc
    [[nodiscard]] std::vector<Note> notes() const;
};

/// Reads and judges a mesh. Failures of the file and of the mesh are in the result, never thrown. @throw std::bad_alloc
/// Cost: linear in the file, and as mesh::admit.
[[nodiscard]] AdmittedMesh admit_mesh(const MeshInput& input, const MeshOptions& options = {});

/// The mesh that a model was baked from, as far as the model keeps it, to be baked again: in mesh units, rounded to float
/// where the model does not keep its input, with what a cure made up. Empty triangles without the exact layer. @throw
/// std::bad_alloc
[[nodiscard]] AdmittedMesh admitted_mesh_of(const model::ModelView& model);

/// A model keeps this text about its making.
struct Provenance {
    std::string made_by = "sqmap";        ///< program and version
    std::optional<std::string> source{};  ///< absent: that of the mesh
    std::string options{};                ///< every option that changed the model, as text
};

/// How a mesh becomes a model.
struct BakeMeshOptions {
    MeshOptions mesh{};
    bake::BakeOptions bake{};                       ///< its `cured` is filled in
    std::optional<paper::MapOptions> paper_maps{};  ///< a paper model's maps; absent: a central model is baked
    Provenance provenance{};
};

/// A model of either kind with the mesh that it was baked from. Several threads may read one at a time.
struct BakedModel {
    BakedModel() = default;
    BakedModel(BakedModel&& other) noexcept { *this = std::move(other); }
    BakedModel& operator=(BakedModel&& other) noexcept;
    ~BakedModel() = default;

    paper::ModelData model;  ///< a central one has no paper maps
    AdmittedMesh mesh;       ///< with the admission, the deviation from the input and the format
    bake::BakeReport report;
    std::vector<Note> notes;  ///< of the mesh, then of the model

    /// Answers queries. Valid until the model is moved, changed or destroyed.
    [[nodiscard]] model::ModelView view() const { return reading ? reading->view() : model.common.view(); }
    /// The rung of the ladder of cures that gave the solid.
    [[nodiscard]] model::Rung rung() const { return model.common.cure.rung; }
    /// The model file's bytes. @throw std::bad_alloc
    [[nodiscard]] std::vector<std::byte> bytes() const;
    /// Writes the model file; path is never partly written. @throw io::ModelFileError
    void save(const std::filesystem::path& path) const;

    std::optional<paper::Reading> reading;  ///< answers for a paper model; bake_mesh and moves make it
};

/// Reads, admits and bakes a mesh.
/// @throw mesh::RefusedMesh with code, element and cure where the file or the mesh is refused, or exceeds the format's limits
/// @throw mesh::InvalidInput for options out of range
/// Cost: seconds for some thousand triangles, on bake.threads threads; the same bytes for any number of them.
[[nodiscard]] BakedModel bake_mesh(const MeshInput& input, const BakeMeshOptions& options = {});

/// The same of a mesh that is admitted already; options.mesh does not count.
[[nodiscard]] BakedModel bake_mesh(AdmittedMesh mesh, const BakeMeshOptions& options = {});

/// The note about a model whose layer 3 may not be relied on; nothing about another.
[[nodiscard]] std::optional<Note> doubt_of(const model::ModelView& model);

}  // namespace sqmap
