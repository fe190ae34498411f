// Words of the program about meshes: its options stand where a setting is named.
#pragma once

#include "sqmap/bake_mesh.h"

#include <string>
#include <vector>

namespace sqmap::app {

/// "--repair safe".
extern const mesh::SettingNames k_program_settings;

/// Repairs, how far a cure moved the surface, and warnings, a line each.
[[nodiscard]] std::vector<std::string> notes_of(const AdmittedMesh& mesh);

/// One line each for the admission, repairs and warnings, as `sqmap check` prints them.
[[nodiscard]] std::string report(const AdmittedMesh& mesh);

}  // namespace sqmap::app
