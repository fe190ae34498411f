// Results by key, and the two files that hold them: a journal while a shard is baked, an archive when it is done.
#pragma once

#include "batch/child.h"
#include "batch/descriptor.h"
#include "batch/row.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sqmap::batch {

/// What is known of a key, and where its model and picture stand in an open file.
struct Finished {
    Outcome outcome;
    std::string measured;  ///< a JSON object that differs from run to run: "key", "seconds", "peak_bytes", "host"; or empty
    std::string sha256;    ///< of the model
    int file = -1;         ///< not owned
    std::uint64_t model_offset = 0, model_size = 0;  ///< size 0: none
    std::uint64_t picture_offset = 0, picture_size = 0;
};
using Results = std::map<std::string, Finished, std::less<>>;

/// A file that results are added to, one record after another; a record is there whole or not at all. One process at a time has
/// it.
class Journal {
public:
    /// Opens or makes it; what a process that was killed left of its last record is cut off.
    /// @throw io::ModelFileError where it cannot be opened, or another process has it
    explicit Journal(const std::filesystem::path& path);

    /// What it held when it was opened: later records replace earlier ones.
    void read_into(Results& results) const;

    /// Adds a result whose model, if any, and picture are in another file. Its offsets are those in the journal.
    /// @throw io::ModelFileError where the disk is full: the journal is as before
    Finished append(const std::string& key, Finished result);

private:
    void recover();
    [[noreturn]] void fail(const char* what) const;

    std::filesystem::path path_;
    Descriptor file_;
    std::uint64_t end_ = 0;
    Results found_;
};

/// Adds the results of an archive of io::ModelArchive that is open as file. Those that are there stay, unless they alone lack a
/// model.
void read_archive(const std::filesystem::path& path, int file, Results& results);

/// Writes an archive of those results that have models, with rows as its lines: under another name, synced, renamed. The same
/// input gives the same bytes. @throw io::ModelFileError where it cannot be written; nothing is left behind
void write_archive(const std::filesystem::path& path, std::span<const Results::value_type* const> results, std::string_view rows);

/// @throw io::ModelFileError
[[nodiscard]] Descriptor open_file(const std::filesystem::path& path);
/// Makes a rename in a folder last.
void sync_folder(const std::filesystem::path& folder);

}  // namespace sqmap::batch
