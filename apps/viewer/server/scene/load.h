// Objects from models and from meshes, and the file of names beside a model.
#pragma once

#include "viewer/server/scene/object.h"

namespace sqmap::viewer {

/// An object with its centre at the world's origin. size: m, the extent that R_max of the object becomes; words: names of its
/// parts.
/// @throw std::runtime_error where the bytes are no model
[[nodiscard]] std::shared_ptr<Object> object_from_model(std::vector<std::byte> bytes, const std::string& name, double size,
                                                        const Words& words = {});
/// Bakes a mesh; else the same. @throw mesh::Error
[[nodiscard]] std::shared_ptr<Object> object_from_mesh(AdmittedMesh mesh, const std::string& name, double size,
                                                       BakeMeshOptions options);

/// The file that keeps the names of a model's parts: cow.sqmap has cow.names.json beside it.
[[nodiscard]] std::filesystem::path names_file_of(const std::filesystem::path& model);
/// Reads that file. No words where there is no such file, or where its text is not what names_json writes.
[[nodiscard]] Words words_beside(const std::filesystem::path& model);

}  // namespace sqmap::viewer
