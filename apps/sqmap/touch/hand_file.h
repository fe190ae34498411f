// A skinned hand out of a glTF file whose joints have WebXR's names.
#pragma once

#include "device/hand.h"

#include <filesystem>
#include <optional>

namespace sqmap::app {

/// Nothing where the file has no skin, or not all 25 joints of a hand: it is then a mesh like any other.
/// @throw BadTouch for a glTF file that cannot be read
[[nodiscard]] std::optional<device::HandMesh> read_hand(const std::filesystem::path& path);

}  // namespace sqmap::app
