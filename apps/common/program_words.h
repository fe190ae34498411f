// Words of the program about meshes: its options stand where a setting is named.
#pragma once

#include "sqmap/bake_mesh.h"

#include <string>

namespace sqmap::app {

/// "--repair safe".
extern const mesh::SettingNames k_program_settings;

/// One line each for the admission, repairs and warnings, as `sqmap check` prints them.
[[nodiscard]] std::string report(const AdmittedMesh& mesh);

}  // namespace sqmap::app
