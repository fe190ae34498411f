// The race: all methods on the same frames, in turns, in one thread.
#pragma once

#include "method.h"
#include "truth.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sqmap::bench {

struct RaceOptions {
    std::uint32_t passes = 20;
    std::uint32_t slow_frames = 100;  ///< at most so many frames, evenly spread, for methods marked slow
    std::uint32_t block = 100;        ///< frames that a method runs before the next one has its turn; 1: frame by frame
};

/// How far a method's vertices are from the truth; lengths in percent of R_max.
struct Accuracy {
    double missed_pct = 0;  ///< share of the exactly inside probe vertices, all frames together
    double false_pct = 0;   ///< share of the exactly outside ones
    double depth_error_mean_pct = 0, depth_error_max_pct = 0;  ///< over the exactly inside ones; a missed one has depth 0
    double missed_depth_max_pct = 0;                           ///< greatest exact depth of a missed vertex
    double false_distance_max_pct = 0;                         ///< greatest exact distance from the surface of a false one
};

struct Record {
    std::string method;
    double p50_us = 0, p99_us = 0;  ///< over frames, of each frame's median over the passes
    double p999_us = 0;             ///< over all samples
    std::size_t bytes = 0, probe_bytes = 0;
    double build_s = 0;
    double contacts = 0;               ///< a frame, in the mean: vertices, or pairs
    std::optional<Accuracy> accuracy;  ///< none where the method reports pairs
    std::uint64_t hash = 0;            ///< of the answers, frame by frame; depths in steps of 1e-5
    std::uint32_t frames = 0;
    std::size_t stride = 1;                       ///< every so many frames of the path were run
    std::vector<double> frame_us{};               ///< each frame's median over the passes
    std::vector<std::uint32_t> frame_contacts{};  ///< and its contacts
};

struct Contestant {
    const MethodEntry* entry;
    Method* method;
};

/// @throw BenchError where a method answers one frame differently in two passes.
[[nodiscard]] std::vector<Record> race(const Setting& setting, std::span<const Pose> path,
                                       std::span<const std::vector<TrueContact>> truth, std::span<const Contestant> contestants,
                                       const RaceOptions& options);

/// Value of rank ceil(q n) of the sorted samples (nearest rank). @pre not empty, 0 < q <= 1.
[[nodiscard]] double percentile(std::vector<double> samples, double q);

}  // namespace sqmap::bench
