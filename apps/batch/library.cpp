#include "batch/library.h"

#include "io/files.h"
#include "io/replace_file.h"
#include "sqmap/io/model_archive.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <set>
#include <span>
#include <system_error>
#include <utility>

namespace sqmap::batch {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr int k_format = 2;

std::string name_of(Shard shard)
{
    char text[32];
    std::snprintf(text, sizeof text, "%05u-of-%05u", shard.index, shard.count);
    return text;
}

std::vector<fs::path> files_in(const fs::path& folder, std::string_view ending)
{
    std::vector<fs::path> out;
    std::error_code ignored;
    for (fs::directory_iterator it(folder, ignored), end; it != end; it.increment(ignored))
        if (it->path().extension() == ending) out.push_back(it->path());
    std::sort(out.begin(), out.end());
    return out;
}

std::string read_all(const fs::path& path) { return io::text_of_file(path).value_or(""); }

}  // namespace

fs::path Library::journal(Shard shard) const { return folder_ / "running" / (name_of(shard) + ".part"); }
fs::path Library::archive(Shard shard) const { return folder_ / "shards" / (name_of(shard) + ".tar"); }

fs::path Library::measured_of(const fs::path& archive) { return fs::path(archive).replace_extension(".measured.jsonl"); }
fs::path Library::manifest_of(const fs::path& archive) { return fs::path(archive).replace_extension(".manifest.txt"); }
fs::path Library::rows_of(const fs::path& journal) { return fs::path(journal).replace_extension(".rows.jsonl"); }

std::vector<fs::path> Library::merged() const { return files_in(merged_folder(), ".tar"); }
std::vector<fs::path> Library::shards() const { return files_in(folder_ / "shards", ".tar"); }
std::vector<fs::path> Library::journals() const { return files_in(folder_ / "running", ".part"); }

std::vector<fs::path> Library::archives() const
{
    std::vector<fs::path> out = shards();
    const std::vector<fs::path> before = merged();
    out.insert(out.end(), before.begin(), before.end());
    return out;
}

bool Library::is_of(const fs::path& archive, const std::string& fingerprint)
{
    return read_all(manifest_of(archive)) == fingerprint + "\n";
}

Merged Library::merged_shards() const
{
    const ordered_json json = ordered_json::parse(read_all(merged_folder() / "shards.json"), nullptr, false);
    if (!json.is_object()) return {};
    return {json.value("count", 0u), json.value("finished", std::set<std::uint32_t>()), json.value("manifest", "")};
}

Unfinished Library::unfinished() const
{
    const Recipe recipe = this->recipe();
    const Merged merged = merged_shards();
    const bool is_same = merged.fingerprint == recipe.fingerprint;
    Unfinished out;
    std::error_code ignored;
    for (Shard shard{.count = recipe.shards}; shard.index < shard.count; ++shard.index) {
        const fs::path archive = this->archive(shard);
        const bool exists = fs::exists(archive, ignored) && fs::exists(manifest_of(archive), ignored);
        if (exists && is_of(archive, recipe.fingerprint)) continue;
        if (is_same && merged.has(shard)) continue;
        // An incomplete merge of another number of shards may hold items of this shard.
        const bool was_merged = merged.has(shard) || (merged.count > 0 && merged.count != shard.count);
        (exists || (was_merged && !is_same) ? out.stale : out.absent).push_back(shard);
    }
    return out;
}

std::string Library::shards_to_merge() const
{
    const Recipe recipe = this->recipe();
    const Unfinished unfinished = this->unfinished();
    std::set<std::uint32_t> finished;
    for (std::uint32_t i = 0; i < recipe.shards; ++i) finished.insert(i);
    for (const auto* shards : {&unfinished.absent, &unfinished.stale})
        for (const Shard& shard : *shards) finished.erase(shard.index);
    return ordered_json{{"count", recipe.shards}, {"finished", finished}, {"manifest", recipe.fingerprint}}.dump() + "\n";
}

Recipe Library::recipe() const
{
    const ordered_json json = ordered_json::parse(read_all(folder_ / "batch.json"), nullptr, false);
    try {
        if (json.at("format") != k_format)
            throw io::ModelFileError(folder_.string() + ": made by another version of sqmap batch: bake into another folder");
        return {json.at("made_by"),  json.at("options"), json.at("arguments"),  json.at("shards"),
                json.at("manifest"), json.at("root"),    json.at("fingerprint")};
    } catch (const ordered_json::exception&) {
        throw io::ModelFileError(folder_.string() + ": not a library: make one with 'sqmap batch MANIFEST -o " +
                                 folder_.string() + "'");
    }
}

void Library::begin(const Recipe& recipe) const
{
    std::error_code error;
    for (const char* name : {"running", "shards"}) {
        fs::create_directories(folder_ / name, error);
        if (error) throw io::ModelFileError("cannot make " + (folder_ / name).string() + ": " + error.message());
    }
    const fs::path file = folder_ / "batch.json";
    if (fs::exists(file, error)) {
        const Recipe before = this->recipe();
        const auto refuse = [&](const std::string& what, const std::string& was, const std::string& is, const char* cure) {
            throw io::ModelFileError(folder_.string() + " was begun with " + what + " '" + was + "', not '" + is + "': " + cure);
        };
        if (before.made_by != recipe.made_by) refuse("version", before.made_by, recipe.made_by, "choose another folder");
        if (before.options != recipe.options)
            refuse("options", before.options, recipe.options, "give the same, or choose another folder");
        if (before.shards != recipe.shards && (!shards().empty() || !journals().empty()))
            refuse("shards", std::to_string(before.shards), std::to_string(recipe.shards),
                   "go on with as many, or finish, merge and gc first");
    }
    const std::string text = ordered_json{{"format", k_format},        {"made_by", recipe.made_by},
                                          {"options", recipe.options}, {"arguments", recipe.arguments},
                                          {"shards", recipe.shards},   {"manifest", recipe.manifest},
                                          {"root", recipe.root},       {"fingerprint", recipe.fingerprint}}
                                 .dump(2, ' ', false, ordered_json::error_handler_t::replace) +
                             "\n";
    if (read_all(file) != text) io::replace_file(file, std::as_bytes(std::span(text)));
}

namespace {

/// "2 of 10 shards are WHAT: 3, 7"
std::string words_of(const std::vector<Shard>& shards, const std::string& what)
{
    constexpr std::size_t k_named = 20;
    std::string out = std::to_string(shards.size()) + " of " + std::to_string(shards.front().count) +
                      (shards.size() == 1 ? " shards is " : " shards are ") + what + ": ";
    for (std::size_t i = 0; i < std::min(shards.size(), k_named); ++i)
        out += (i == 0 ? "" : ", ") + std::to_string(shards[i].index);
    return shards.size() > k_named ? out + ", ..." : out;
}

/// The key of a line of a .measured.jsonl file.
std::string_view key_of_measured(std::string_view line)
{
    constexpr std::string_view k_start = R"({"key":")";
    return line.starts_with(k_start) ? line.substr(k_start.size(), 64) : std::string_view();
}

}  // namespace

std::string words_of(const Unfinished& unfinished)
{
    std::string out;
    if (!unfinished.absent.empty()) out = words_of(unfinished.absent, "not finished");
    if (!unfinished.stale.empty())
        out += (out.empty() ? "" : "\n") + words_of(unfinished.stale, "of another state of the manifest") +
               "\n  cure: run these shards again; what is baked is not baked again";
    return out;
}

void OpenArchives::read(const fs::path& path)
{
    files_.push_back(open_file(path));
    read_archive(path, files_.back().get(), results_);
    each_line(read_all(Library::measured_of(path)), [&](std::string_view line) {
        const auto known = results_.find(key_of_measured(line));
        if (known != results_.end() && known->second.measured.empty()) known->second.measured = line;
    });
}

Contents::Contents(const Library& library)
{
    const std::string fingerprint = library.recipe().fingerprint;
    for (const fs::path& path : library.shards()) {
        archives_.read(path);
        if (Library::is_of(path, fingerprint)) read_rows(path);
    }
    const bool is_merged = library.merged_shards().fingerprint == fingerprint;
    for (const fs::path& path : library.merged()) {
        archives_.read(path);
        if (is_merged) read_rows(path);
    }
    for (Row& row : rows_)
        if (results().contains(row.key)) row.outcome = {};
    const auto less = [](const Row& a, const Row& b) { return a.item < b.item; };
    std::stable_sort(rows_.begin(), rows_.end(), less);
    const auto same = [](const Row& a, const Row& b) { return a.item == b.item; };
    rows_.erase(std::unique(rows_.begin(), rows_.end(), same), rows_.end());
}

void Contents::read_rows(const fs::path& path)
{
    const io::ModelArchive archive(path);
    each_line(archive.rows(), [&](std::string_view line) {
        Row row = row_of(line);
        if (row.item == R"({"path":null)") return;
        if (!row.key.empty() && row.outcome.verdict() != "killed") row.outcome = {};
        rows_.push_back(std::move(row));
    });
}

const Outcome& Contents::outcome(const Row& row) const
{
    return row.outcome.text.empty() ? results().find(row.key)->second.outcome : row.outcome;
}

std::string Contents::line(const Row& row) const { return Row{row.item, row.key, outcome(row)}.line(); }

}  // namespace sqmap::batch
