// The rows that a shard has so far, in a file beside its journal that only `list` reads.
#pragma once

#include "batch/library.h"
#include "batch/row.h"

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace sqmap::batch {

/// An item's row and its CPU time, which is 0 where an earlier run had the result.
struct TimedRow {
    Row row;
    double seconds = 0;
};

class RunningRows {
public:
    /// Begins the file anew. fingerprint: fingerprint_of the manifest's entries.
    RunningRows(const std::filesystem::path& path, const std::string& fingerprint);
    void add(const TimedRow& row);

private:
    std::ofstream out_;
};

/// The rows of all shards that are not finished and are of the recipe's manifest.
[[nodiscard]] std::vector<TimedRow> running_rows(const Library& library);

}  // namespace sqmap::batch
