// The options of every subcommand that bakes.
#pragma once

#include "command_line.h"
#include "sqmap/bake/bake.h"

#include <string>

namespace sqmap::app {

/// What the flags set.
struct BakeSettings {
    bake::BakeOptions bake;
    std::string projection = "central";
    bool exact = false, no_exact = false;
    bool no_taper = false, no_bend = false;
    bool exact_geodesics = false;
};

/// Adds the options that change a model to a subcommand; settings must outlive the parser.
void add_bake_options(Command& command, BakeSettings& settings);

/// What the flags say, put in where bake reads it.
[[nodiscard]] bake::BakeOptions bake_options(const BakeSettings& settings);

}  // namespace sqmap::app
