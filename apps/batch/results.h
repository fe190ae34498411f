// Results by key, and the two files that hold them: a journal while a shard is baked, an archive when the shard is finished.
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

namespace sqmap::batch {

/// The result of a key, with the places of its model and picture in an open file.
struct Finished {
    Outcome outcome;
    std::string measured;  ///< a JSON object that differs from run to run: "key", "seconds", "peak_bytes", "host"; or empty
    std::string sha256;    ///< the digest of the model
    int file = -1;         ///< not owned
    std::uint64_t model_offset = 0, model_size = 0;  ///< size 0: none
    std::uint64_t picture_offset = 0, picture_size = 0;
};
using Results = std::map<std::string, Finished, std::less<>>;

/// A file to which a run adds results, one record after another. The journal keeps a record whole or not at all. One process at a
/// time can open a journal.
class Journal {
public:
    /// Opens or makes the file, and cuts off the incomplete last record of a process that was killed.
    /// @throw io::ModelFileError where it cannot be opened, or another process has it
    explicit Journal(const std::filesystem::path& path);

    /// Adds the results that the file held when it was opened; later records replace earlier ones.
    void read_into(Results& results) const;

    /// Copies a result, with the model and the picture of its file, to the end of the journal. Returns it with offsets in the
    /// journal.
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

/// Adds the results of an archive of io::ModelArchive that is open as file. A result that is known already stays, unless only the
/// archive has a model.
void read_archive(const std::filesystem::path& path, int file, Results& results);

/// Writes an archive of those results that have models, with rows as its lines: under another name, synced, renamed. The same
/// input gives the same bytes. @throw io::ModelFileError where it cannot be written; nothing is left behind
void write_archive(const std::filesystem::path& path, std::span<const Results::value_type* const> results, std::string_view rows);

/// @throw io::ModelFileError
[[nodiscard]] Descriptor open_file(const std::filesystem::path& path);
/// Writes a rename in a folder to the disk.
void sync_folder(const std::filesystem::path& folder);

}  // namespace sqmap::batch
