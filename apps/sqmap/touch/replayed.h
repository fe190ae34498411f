// The outcome of a replay, whichever program has made the recording.
#pragma once

#include "touch/strip_chart.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace sqmap::app {

struct ReplayArguments {
    std::string trace, against, plot;
    std::vector<std::string> models;  ///< of a page's recording: files to look for its models in
    bool diff = false;
    unsigned threads = 1;
};

struct Replayed {
    std::uint64_t ticks = 0, different = 0, dropped = 0;
    std::size_t first_line = 0;
    double first_time = 0;
    std::string first_columns;
    double largest_force = 0, largest_torque = 0, largest_depth = 0;  ///< differences
    double sum_force_sq = 0;                                          ///< of differences
    std::uint64_t hash = 0xcbf29ce484222325u;                         ///< of all forces that were computed
    bool complete = false;
    std::string error;

    void mix(double value)
    {
        // Every NaN hashes alike.
        const std::uint64_t bits = std::isnan(value) ? ~0ull : std::bit_cast<std::uint64_t>(value);
        hash = (hash ^ bits) * 0x100000001b3u;
    }
};

/// A tick that differs: where it stands, the names of the columns, recorded and computed depth (m) and force (N).
struct Difference {
    std::size_t line = 0;
    double time = 0;
    std::string columns;
    std::array<double, 2> depth{}, force{};
    double force_apart = 0, torque_apart = 0;
};
/// Counts a tick that differs. rows: prints it as CSV.
void add_difference(Replayed& replayed, const Difference& difference, bool rows);

/// The head of the rows of add_difference.
void print_difference_head();

}  // namespace sqmap::app
