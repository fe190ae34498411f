// One mesh, from its bytes to a model and a picture: what happens in a process of its own.
#pragma once

#include "batch/row.h"
#include "sqmap/bake_mesh.h"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

namespace sqmap::batch {

/// The settings of a bake, which are the same for every item of a library.
struct Settings {
    BakeMeshOptions bake;
    std::string options;  ///< every option that may change a model or its picture, as text
    bool pictures = true;
};

/// A mesh as a file, or as bytes in memory.
struct Source {
    std::filesystem::path file;                         ///< the file to read, or a member's name
    std::optional<std::span<const std::byte>> bytes{};  ///< the content of an archive's member
};

/// The key of a mesh: a digest of its bytes, of the files that it names, of the ending of its name, of options and version.
[[nodiscard]] std::string key_of(std::span<const std::byte> bytes, const Source& source, const Settings& settings);

// Messages to the driver, a line each. "F" and a JSON text: the outcome of a mesh that cannot be read. "K" and its key: one byte
// comes back, k_go to bake it. "D" and four texts: bytes of model, picture and outcome, which follow each other in the output,
// and the model's SHA-256.
inline constexpr char k_unreadable = 'F', k_key = 'K', k_done = 'D', k_go = 'g', k_skip = 's';

/// Reads, bakes and draws a mesh. A mesh that cannot be baked gives an outcome; an exception means a defect.
void bake_item(const Source& source, const Settings& settings, int channel, int output);

}  // namespace sqmap::batch
