// The options of every subcommand that takes a mesh.
#pragma once

#include "command_line.h"
#include "sqmap/bake_mesh.h"

namespace sqmap::app {

/// Adds --repair, --surface, --thickness, --unit and the limits to a subcommand; options must outlive the parser.
void add_load_options(Command& command, MeshOptions& options);

}  // namespace sqmap::app
