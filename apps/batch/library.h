// The folder of a library: what is in it and under which name.
//
//     batch.json                      what it is baked with; every run has to agree
//     running/00003-of-00010.part     the journal of a shard that is not finished; .rows.jsonl beside it
//     shards/00003-of-00010.tar       a finished shard; .measured.jsonl and .manifest.txt beside it
//     library/00000.tar               all shards merged; .measured.jsonl beside each
//     library/shards.json             which shards those are
//
// The items are the manifest's as the last run read it. A shard that was made from another state of the manifest contributes its
// results, but not its rows.
//     report/index.html
#pragma once

#include "batch/results.h"

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace sqmap::batch {

struct Shard {
    std::uint32_t index = 0, count = 1;
};

/// The content of batch.json.
struct Recipe {
    std::string made_by, options;
    std::vector<std::string> arguments;  ///< the options as they were given, for retry
    std::uint32_t shards = 1;
    std::string manifest, root;  ///< absolute
    std::string fingerprint;     ///< fingerprint_of the entries that the last run read
};

/// The content of library/shards.json.
struct Merged {
    std::uint32_t count = 0;
    std::set<std::uint32_t> shards;
    std::string fingerprint;

    /// Tells whether the merged library has that shard: all shards of one division hold the items of any other.
    [[nodiscard]] bool has(Shard shard) const
    {
        return count == shard.count ? shards.contains(shard.index) : count > 0 && shards.size() == count;
    }
};

/// The shards that wait for a run.
struct Unfinished {
    std::vector<Shard> absent;  ///< not begun, running, or killed
    std::vector<Shard> stale;   ///< made from another state of the manifest
};

class Library {
public:
    explicit Library(std::filesystem::path folder) : folder_(std::move(folder)) {}

    [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }
    [[nodiscard]] std::filesystem::path journal(Shard shard) const;
    [[nodiscard]] std::filesystem::path archive(Shard shard) const;
    /// The file of what was measured while an archive's items were baked.
    [[nodiscard]] static std::filesystem::path measured_of(const std::filesystem::path& archive);
    /// The file with the fingerprint of the manifest that a shard's archive was made from, as a line.
    [[nodiscard]] static std::filesystem::path manifest_of(const std::filesystem::path& archive);
    /// The file with the rows of a shard that is not finished.
    [[nodiscard]] static std::filesystem::path rows_of(const std::filesystem::path& journal);
    [[nodiscard]] std::filesystem::path merged_folder() const { return folder_ / "library"; }
    [[nodiscard]] std::filesystem::path report_folder() const { return folder_ / "report"; }

    /// Archives in order of their names: of the merged library, of finished shards, or of both, shards first.
    [[nodiscard]] std::vector<std::filesystem::path> merged() const;
    [[nodiscard]] std::vector<std::filesystem::path> shards() const;
    [[nodiscard]] std::vector<std::filesystem::path> archives() const;
    [[nodiscard]] std::vector<std::filesystem::path> journals() const;

    /// The shards for which neither an archive nor the merged library was made from the recipe's manifest.
    [[nodiscard]] Unfinished unfinished() const;
    [[nodiscard]] Merged merged_shards() const;
    /// The content that shards.json gets when all finished shards are merged.
    [[nodiscard]] std::string shards_to_merge() const;
    /// Tells whether a shard's archive was made from that state of the manifest.
    [[nodiscard]] static bool is_of(const std::filesystem::path& archive, const std::string& fingerprint);

    /// Makes the folders and batch.json. @throw io::ModelFileError where the folder holds models of another recipe, or cannot be
    /// written
    void begin(const Recipe& recipe) const;
    /// @throw io::ModelFileError where the folder is no library
    [[nodiscard]] Recipe recipe() const;

private:
    std::filesystem::path folder_;
};

/// "2 of 10 shards are not finished: 3, 7", then the shards that are of another state of the manifest, with the cure. Empty where
/// all are finished.
[[nodiscard]] std::string words_of(const Unfinished& unfinished);

/// Results by key of archives, whose files stay open: models and pictures are read from them.
class OpenArchives {
public:
    /// Adds an archive's results, and what was measured while they were baked. A result that is known stays.
    /// @throw io::ModelFileError for an archive that is damaged
    void read(const std::filesystem::path& archive);
    [[nodiscard]] const Results& results() const { return results_; }
    [[nodiscard]] Results& results() { return results_; }

private:
    std::vector<Descriptor> files_;
    Results results_;
};

/// All that a library holds: results by key, and sorted rows, one for each item. A shard's results count before merged ones.
class Contents {
public:
    /// @throw io::ModelFileError for archives that are damaged
    explicit Contents(const Library& library);

    [[nodiscard]] const Results& results() const { return archives_.results(); }
    /// One row for each item, sorted. A row's own outcome is empty where its key has one.
    [[nodiscard]] const std::vector<Row>& rows() const { return rows_; }
    [[nodiscard]] const Outcome& outcome(const Row& row) const;
    /// The row as a line, with the outcome of its key.
    [[nodiscard]] std::string line(const Row& row) const;

private:
    void read_rows(const std::filesystem::path& archive);

    OpenArchives archives_;
    std::vector<Row> rows_;
};

}  // namespace sqmap::batch
