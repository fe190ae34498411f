// The options of the forces on the command line.
#pragma once

#include "command_line.h"
#include "touch/options.h"

namespace sqmap::app {

/// Adds the options of forces, coupling, surface and moving objects to a subcommand; options must outlive the parser.
void add_force_options(Command& command, TouchOptions& options);

/// Sets what --force paper stands for where no option of its own says otherwise: friction by eq. 33, no blending.
void finish_force_options(const Command& command, TouchOptions& options);

/// Tells, on standard error, of options that were given and count with others only.
void warn_of_idle(const Command& command, const TouchOptions& options);

}  // namespace sqmap::app
