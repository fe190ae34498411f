// The options of every subcommand that bakes.
#pragma once

#include "command_line.h"
#include "sqmap/bake_mesh.h"

#include <functional>
#include <string>

namespace sqmap::app {

/// The settings that the flags of section 3 write.
struct DecomposeSettings {
    decompose::DecomposeOptions options, defaults{};  ///< defaults: of the options, as add_decompose_options() leaves them
    bool exact_geodesics = false;
    std::function<bool(const std::string&)> given{};  ///< whether the user gave this option
};

/// Adds the options of section 3; settings must outlive the parser.
void add_decompose_options(Command& command, DecomposeSettings& settings);

/// The flags, and where cuts are as printed, the thresholds of these for what was not given.
/// @throw WrongUsage for options that do not go together
[[nodiscard]] decompose::DecomposeOptions decompose_options(const DecomposeSettings& settings);
/// The same for pictures of section 3's fields, which cuts as printed read whichever are made.
[[nodiscard]] decompose::DecomposeOptions field_options(const DecomposeSettings& settings);

/// The settings that the flags write.
struct BakeSettings {
    bake::BakeOptions bake;
    DecomposeSettings cuts;
    paper::MapOptions maps;
    std::string projection = "central";
    bool exact = false, no_exact = false, no_input = false;
    bool no_taper = false, no_bend = false;
    bool no_locator = false;
    std::function<bool(const std::string&)> given{};  ///< whether the user gave this option
};

/// Adds the options that change a model to a subcommand; settings must outlive the parser.
void add_bake_options(Command& command, BakeSettings& settings);

/// The flags as bake_mesh takes them; how a mesh is read and who made the model are not among them.
/// @throw WrongUsage for options that do not go together
[[nodiscard]] BakeMeshOptions bake_options(const BakeSettings& settings);

}  // namespace sqmap::app
