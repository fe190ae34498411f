// Words of the program about meshes: its options stand where a setting is named.
#pragma once

#include "sqmap/bake_mesh.h"
#include "sqmap/mesh/words.h"

#include <string>

namespace sqmap::app {

/// "--repair safe".
extern const mesh::SettingNames k_program_settings;

/// "--smoothing-radius" of "smoothing_radius".
[[nodiscard]] std::string as_option(const std::string& name);
/// The option as the programs have it: "--no-gaps".
[[nodiscard]] std::string option_of(const IdleOption& idle);
/// Why it changes nothing, and the cure, in which other options stand likewise.
[[nodiscard]] std::string reason_of(const IdleOption& idle);

/// One line each for the admission, repairs and warnings, as `sqmap check` prints them.
[[nodiscard]] std::string report(const AdmittedMesh& mesh);

}  // namespace sqmap::app
