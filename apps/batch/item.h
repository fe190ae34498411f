// One mesh, from its bytes to a model and a picture: what happens in a process of its own.
#pragma once

#include "batch/row.h"
#include "common/load_mesh.h"
#include "sqmap/bake/bake.h"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

namespace sqmap::batch {

/// What a mesh is baked with; the same for every item of a library.
struct Settings {
    app::LoadOptions load;
    bake::BakeOptions bake;
    std::string made_by;  ///< of the models: program and version
    std::string options;  ///< every option that may change a model or its picture, as text
    bool pictures = true;
};

/// Where the bytes of a mesh are.
struct Source {
    std::filesystem::path file;                         ///< to read; of a member, its name
    std::optional<std::span<const std::byte>> bytes{};  ///< of a member of an archive
};

/// Key of a mesh: of its bytes, those of the files that it names, the ending of its name, the options and the version.
[[nodiscard]] std::string key_of(std::span<const std::byte> bytes, const Source& source, const Settings& settings);

// Messages to the driver, a line each. "F" and a JSON text: the outcome of a mesh that cannot be read. "K" and its key: one byte
// comes back, k_go to bake it. "D" and four texts: bytes of model, picture and outcome, which follow each other in the output,
// and the model's SHA-256.
inline constexpr char k_unreadable = 'F', k_key = 'K', k_done = 'D', k_go = 'g', k_skip = 's';

/// Reads, bakes and draws a mesh. Whatever cannot be baked is an outcome; anything thrown is a defect.
void bake_item(const Source& source, const Settings& settings, int channel, int output);

}  // namespace sqmap::batch
