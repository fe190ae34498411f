// sqmap urdf --sweep
#pragma once

#include "commands.h"
#include "sqmap/robot/sweep.h"

#include <memory>
#include <string>
#include <vector>

namespace sqmap::app {

/// Options of a sweep as the user gives them.
struct SweepArguments {
    bool sweep = false, json = false;
    std::vector<std::string> pairs{};
    robot::SweepOptions options{};
};

/// Adds them to the command.
void add_sweep_options(Command& command, SweepArguments& sweep);

/// The files of a sweep: where they go, and about which robot.
struct SweepFiles {
    std::string robot;               ///< URDF file
    std::string output{}, report{};  ///< SRDF and JSON to write; empty: none
};
/// Sweeps, prints the table or JSON, writes the files; the exit code.
int run_sweep(const SweepArguments& arguments, const std::string& text, const SweepFiles& files);

}  // namespace sqmap::app
