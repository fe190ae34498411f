// The subcommands: each adds itself to the command line, and ends with one of the exit codes 0 (done), 1 (replay found
// differences), 2 (refused input), 64 (wrong usage), 70 (internal error).
#pragma once

#include "command_line.h"

namespace sqmap::app {

void add_bake(CommandLine& line);
void add_batch(CommandLine& line);  // where sqmap_batch is built
void add_check(CommandLine& line);
void add_devices(CommandLine& line);  // rtcheck, touch, replay and view too: on Linux
void add_dress(CommandLine& line);    // where sqmap::sim is built
void add_eval(CommandLine& line);
void add_export(CommandLine& line);
void add_info(CommandLine& line);
void add_query(CommandLine& line);
void add_render(CommandLine& line);  // on Linux
void add_replay(CommandLine& line);
void add_rtcheck(CommandLine& line);
void add_shapes(CommandLine& line);
void add_touch(CommandLine& line);
void add_urdf(CommandLine& line);  // where sqmap::robot is built
void add_view(CommandLine& line);

}  // namespace sqmap::app
