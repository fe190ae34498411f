// Records as JSON and as tables.
#pragma once

#include "frames.h"

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace sqmap::bench {

/// Facts of a run, repeated in every record.
struct RunFacts {
    std::string object, probe, path;  ///< file names
    std::string instructions{};       ///< set that sqmap's kernels ran on
    std::uint32_t passes = 0;
    std::size_t object_triangles = 0, probe_vertices = 0;
};

/// A JSON array, a record a method.
[[nodiscard]] std::string json_text(std::span<const Record> records, const RunFacts& facts);

/// A CSV with a row a frame: each method's median time in microseconds and its contacts; empty where it did not run.
[[nodiscard]] std::string series_text(std::span<const Record> records);

/// A Markdown table a kind of path (the last word of a path's name): medians over the files, and times as ratios to
/// fcl_obb_all and to the dense_simd fields. @throw BenchError for a file that json_text has not written.
[[nodiscard]] std::string tables(std::span<const std::filesystem::path> files);

}  // namespace sqmap::bench
