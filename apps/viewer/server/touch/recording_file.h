// A recording as a file: a trace (docs/trace-format.md) whose fields name the objects and hold the settings.
#pragma once

#include "viewer/server/touch/recording.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace sqmap::viewer {

/// Stands for the number of an object that is hidden.
inline constexpr std::uint32_t k_hidden_object = 0xffffffff;

/// A recording as its file has it: the takes name their objects, but the file does not hold them.
struct RecordingFile {
    struct NamedObject {
        std::string name;
        std::uint64_t hash = 0;  ///< model::content_hash
        double metres_per_unit = 1;
        Vec3d position{};  ///< of the centre of its box in the world, m
        Up up = Up::Y;
    };
    std::vector<NamedObject> objects;
    std::vector<std::shared_ptr<Take>> takes;
    std::vector<std::vector<std::uint32_t>> objects_of;  ///< #takes: numbers in objects
    /// Recorded by sqmap touch: positions are of the models' origins, and settings the page's that are nearest to those of then.
    bool of_touch = false;
};

/// @throw device::TraceError where no temporary file can be written
[[nodiscard]] std::string recording_text(const Recording& recording);
/// name: of the file, for what is wrong with it.
/// @throw device::TraceError where the text is no recording of the page, nor one of sqmap touch with one ball or point over
/// objects that stand still
[[nodiscard]] RecordingFile read_recording(const std::string& text, const std::string& name);

}  // namespace sqmap::viewer
