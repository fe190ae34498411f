// merge writes the archives into a folder of another name, which then replaces the library's.
#include "batch/operations.h"
#include "io/replace_file.h"
#include "sqmap/io/model_archive.h"

#include <algorithm>
#include <cstdio>
#include <set>
#include <span>
#include <system_error>
#include <utility>

namespace sqmap::batch {
namespace {

namespace fs = std::filesystem;
using Pointers = std::vector<const Results::value_type*>;

fs::path beside(const fs::path& folder, const char* ending) { return folder.string() + ending; }

/// Restores the library that a crash between the two renames has left under another name.
void put_back(const fs::path& folder)
{
    std::error_code ignored;
    if (!fs::exists(folder, ignored) && fs::exists(beside(folder, ".old"), ignored))
        fs::rename(beside(folder, ".old"), folder, ignored);
    fs::remove_all(beside(folder, ".old"), ignored);
    fs::remove_all(beside(folder, ".new"), ignored);
}

void swap_in(const fs::path& folder)
{
    std::error_code error;
    if (fs::exists(folder, error)) fs::rename(folder, beside(folder, ".old"), error);
    if (!error) fs::rename(beside(folder, ".new"), folder, error);
    if (error) throw io::ModelFileError("cannot put " + folder.string() + " in place: " + error.message());
    sync_folder(folder.parent_path());
    fs::remove_all(beside(folder, ".old"), error);
}

std::uint64_t stored(const Finished& f) { return f.model_size + f.picture_size + 2048; }

/// The results that rows name, in groups of the size of an archive.
std::vector<Pointers> volumes(const Contents& contents, std::uint64_t size)
{
    std::set<std::string_view> named;
    for (const Row& row : contents.rows()) named.insert(row.key);
    std::vector<Pointers> out(1);
    std::uint64_t bytes = 0;
    for (const auto& result : contents.results()) {
        if (!named.contains(result.first)) continue;
        if (bytes > 0 && bytes + stored(result.second) > size) {
            out.emplace_back();
            bytes = 0;
        }
        out.back().push_back(&result);
        bytes += stored(result.second);
    }
    return out;
}

/// The rows of each volume's keys, in order of items; rows without a key are in the first volume.
std::vector<std::string> rows_of(const Contents& contents, const std::vector<Pointers>& volumes)
{
    std::vector<std::string> out(volumes.size());
    std::vector<std::string_view> last;
    for (const Pointers& volume : volumes) last.push_back(volume.empty() ? std::string_view() : volume.back()->first);
    for (const Row& row : contents.rows()) {
        const auto volume = row.key.empty() ? last.begin() : std::lower_bound(last.begin(), last.end(), row.key);
        const std::size_t i = volume == last.end() ? last.size() - 1 : static_cast<std::size_t>(volume - last.begin());
        out[i] += contents.line(row) + "\n";
    }
    return out;
}

/// Refuses to merge while shards wait for a run: the merge would lose models that only other states of the manifest name.
void refuse_unfinished(const Library& library, Missing missing)
{
    const Unfinished unfinished = library.unfinished();
    if (unfinished.stale.empty() && (unfinished.absent.empty() || missing == Missing::Allowed)) return;
    throw io::ModelFileError(library.folder().string() + ": " + words_of(unfinished) +
                             (unfinished.stale.empty() ? "\n  cure: run them, or merge what there is with --partial" : ""));
}

/// Tells whether the merged library has all rows of a shard.
bool is_merged(const fs::path& shard, const std::set<std::string>& merged_rows)
{
    bool out = true;
    each_line(io::ModelArchive(shard).rows(), [&](std::string_view line) {
        out = out && (line.starts_with(R"({"path":null)") || merged_rows.contains(std::string(line)));
    });
    return out;
}

}  // namespace

void merge(const Library& library, std::uint64_t size, Missing missing)
{
    const fs::path folder = library.merged_folder(), made = beside(folder, ".new");
    put_back(folder);
    refuse_unfinished(library, missing);
    if (library.archives().empty())
        throw io::ModelFileError(library.folder().string() + ": no shard is finished: nothing to merge");
    std::error_code error;
    fs::create_directories(made, error);
    if (error) throw io::ModelFileError("cannot make " + made.string() + ": " + error.message());
    const std::string shards = library.shards_to_merge();  // shards that end meanwhile stay beside the merged library
    const Contents contents(library);
    const std::vector<Pointers> parts = volumes(contents, size);
    const std::vector<std::string> rows = rows_of(contents, parts);
    for (std::size_t i = 0; i < parts.size(); ++i) {
        char name[32];
        std::snprintf(name, sizeof name, "%05zu.tar", i);
        write_archive(made / name, parts[i], rows[i]);
        std::string measured;
        for (const auto* result : parts[i])
            if (!result->second.measured.empty()) measured += result->second.measured + "\n";
        io::replace_file(Library::measured_of(made / name), std::as_bytes(std::span(std::as_const(measured))));
    }
    io::replace_file(made / "shards.json", std::as_bytes(std::span(shards)));
    swap_in(folder);
}

Freed collect_garbage(const Library& library)
{
    put_back(library.merged_folder());
    Freed out;
    std::error_code ignored;
    const auto remove = [&](const fs::path& path) {
        if (!fs::exists(path, ignored)) return;
        out.bytes += fs::file_size(path, ignored);
        out.files += fs::remove(path, ignored) ? 1 : 0;
    };
    std::set<std::string> rows;
    for (const fs::path& path : library.merged())
        each_line(io::ModelArchive(path).rows(), [&](std::string_view line) { rows.emplace(line); });
    const std::string fingerprint = library.merged_shards().fingerprint;
    for (const fs::path& path : library.shards()) {
        if (!Library::is_of(path, fingerprint) || !is_merged(path, rows)) continue;
        for (const fs::path& file : {Library::measured_of(path), Library::manifest_of(path), path}) remove(file);
    }
    for (const char* name : {"shards", "running"})
        for (fs::directory_iterator it(library.folder() / name, ignored), end; it != end; it.increment(ignored))
            if (it->path().extension() == ".tmp") remove(it->path());
    for (const fs::path& path : library.journals()) {
        try {
            const Journal journal(path);
            Results results;
            journal.read_into(results);
            if (!results.empty()) continue;
            remove(Library::rows_of(path));
            remove(path);
        } catch (const io::ModelFileError&) {
            // Another process works on that shard.
        }
    }
    return out;
}

}  // namespace sqmap::batch
