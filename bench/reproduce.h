// Subcommands that make the numbers of the paper's evaluation (section 7) which no race makes.
#pragma once

#include <CLI/App.hpp>

namespace sqmap::bench {

void add_reproduce(CLI::App& app);

}  // namespace sqmap::bench
