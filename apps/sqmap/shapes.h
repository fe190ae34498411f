// The meshes the project makes itself, by name.
#pragma once

#include "sqmap/mesh/mesh.h"

#include <string>
#include <vector>

namespace sqmap::app {

[[nodiscard]] std::vector<std::string> shape_names();
/// @throw std::out_of_range for a name not among shape_names()
[[nodiscard]] mesh::Mesh made_shape(const std::string& name);

}  // namespace sqmap::app
