// The folder of a library: what is in it and under which name.
//
//     batch.json                      what it is baked with; every run has to agree
//     running/00003-of-00010.part     the journal of a shard that is not finished
//     shards/00003-of-00010.tar       a finished shard; .measured.jsonl beside it
//     library/00000.tar               all shards merged; .measured.jsonl beside each
//     library/shards.json             which shards those are
//     report/index.html
#pragma once

#include "batch/results.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace sqmap::batch {

struct Shard {
    std::uint32_t index = 0, count = 1;
};

/// What batch.json holds.
struct Recipe {
    std::string made_by, options;
    std::vector<std::string> arguments;  ///< the options as they were given, for retry
    std::uint32_t shards = 1;
    std::string manifest, root;  ///< absolute
};

class Library {
public:
    explicit Library(std::filesystem::path folder) : folder_(std::move(folder)) {}

    [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }
    [[nodiscard]] std::filesystem::path journal(Shard shard) const;
    [[nodiscard]] std::filesystem::path archive(Shard shard) const;
    /// What was measured of an archive's items.
    [[nodiscard]] static std::filesystem::path measured_of(const std::filesystem::path& archive);
    [[nodiscard]] std::filesystem::path merged_folder() const { return folder_ / "library"; }
    [[nodiscard]] std::filesystem::path report_folder() const { return folder_ / "report"; }

    /// Archives in order of their names; of the merged library, of finished shards, or of both.
    [[nodiscard]] std::vector<std::filesystem::path> merged() const;
    [[nodiscard]] std::vector<std::filesystem::path> shards() const;
    [[nodiscard]] std::vector<std::filesystem::path> archives() const;
    [[nodiscard]] std::vector<std::filesystem::path> journals() const;

    /// Those of the recipe that have no archive and were not merged: not begun, running, or killed.
    [[nodiscard]] std::vector<Shard> unfinished() const;
    /// What shards.json is to hold when all that is finished is merged.
    [[nodiscard]] std::string merged_shards() const;

    /// Makes the folders. @throw io::ModelFileError where the folder holds what was baked otherwise, or cannot be written
    void begin(const Recipe& recipe) const;
    /// @throw io::ModelFileError where the folder is no library
    [[nodiscard]] Recipe recipe() const;

private:
    std::filesystem::path folder_;
};

/// "2 of 10 shards are not finished: 3, 7", or nothing.
[[nodiscard]] std::string unfinished_words(const Library& library);

/// All that a library holds, shards before what was merged earlier: results by key, and rows sorted, one an item.
class Contents {
public:
    /// @throw io::ModelFileError for archives that are damaged
    explicit Contents(const std::vector<std::filesystem::path>& archives);

    [[nodiscard]] const Results& results() const { return results_; }
    /// One an item, sorted. A row's own outcome is empty where its key has one.
    [[nodiscard]] const std::vector<Row>& rows() const { return rows_; }
    [[nodiscard]] const Outcome& outcome(const Row& row) const;
    /// The row as a line, with the outcome of its key.
    [[nodiscard]] std::string line(const Row& row) const;

private:
    void read_rows(const std::filesystem::path& archive);

    std::vector<Descriptor> files_;
    Results results_;
    std::vector<Row> rows_;
};

/// A line of what was measured, by key.
[[nodiscard]] std::string_view key_of_measured(std::string_view line);

}  // namespace sqmap::batch
