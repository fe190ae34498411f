// The commands for a library that has been baked.
#pragma once

#include "batch/library.h"

#include <cstdint>
#include <filesystem>
#include <string>

namespace sqmap::batch {

/// Prints a line for each item: its row as JSON with "seconds", or verdict, seconds and path. Items of shards that are not
/// finished come last, marked as running.
void list(const Library& library, bool as_json);

/// The answer of merge where shards are missing.
enum class Missing : std::uint8_t { Refused, Allowed };
/// Joins the finished shards, and what was merged before, into archives of about `size` bytes each, in order of keys: the same
/// bytes however many shards there were. Replaces the merged library at once. @throw io::ModelFileError where shards are missing,
/// or are of another state of the manifest
void merge(const Library& library, std::uint64_t size, Missing missing);

struct Verification {
    std::size_t archives = 0, models = 0, rows = 0, faults = 0;
};
/// How deep verify reads.
enum class Depth : std::uint8_t { Index, Models };
/// Compares index and rows; with Depth::Models also checks each model's digest and parses it. Prints each fault as a line on
/// standard error. A shard of another state of the manifest counts as a fault without a line.
[[nodiscard]] Verification verify(const Library& library, Depth depth);

/// Writes the model of an item, which is named by its key or the beginning of it, by its path or member, or by their file name.
/// @throw io::ModelFileError where there is none, or several that differ
void extract(const Library& library, const std::string& item, const std::filesystem::path& output);

struct Freed {
    std::size_t files = 0;
    std::uint64_t bytes = 0;
};
/// Removes files of killed runs, shards that the merged library holds, and models that no row names. @throw io::ModelFileError
[[nodiscard]] Freed collect_garbage(const Library& library);

/// Writes report/index.html and what it loads, and report/rows.csv. @throw io::ModelFileError
void write_report(const Library& library);

}  // namespace sqmap::batch
