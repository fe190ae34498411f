// The mesh file that a model was baked from, read again.
#pragma once

#include "sqmap/bake_mesh.h"
#include "sqmap/model/model.h"

#include <optional>
#include <string>

namespace sqmap::app {

/// The mesh of a file, if the model was baked from it. Otherwise says on standard error why it is not: the mesh is refused, or
/// another one, and which options to give. mesh, model_name: paths of the files.
[[nodiscard]] std::optional<AdmittedMesh> mesh_of_model(const model::ModelView& model, const std::string& model_name,
                                                        const std::string& mesh, const MeshOptions& options);

}  // namespace sqmap::app
