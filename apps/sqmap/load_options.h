// The options of every subcommand that takes a mesh.
#pragma once

#include "common/load_mesh.h"

#include <CLI/CLI.hpp>

namespace sqmap::app {

/// Adds --repair, --surface, --thickness, --unit and the limits to a subcommand; options must outlive the parser.
void add_load_options(CLI::App& command, LoadOptions& options);

}  // namespace sqmap::app
