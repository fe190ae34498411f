#include "batch/library.h"

#include "sqmap/io/model_archive.h"
#include "sqmap/io/replace_file.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <set>
#include <span>
#include <system_error>
#include <utility>

namespace sqmap::batch {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr int k_format = 1;

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

std::string read_all(const fs::path& path)
{
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

fs::path Library::journal(Shard shard) const { return folder_ / "running" / (name_of(shard) + ".part"); }
fs::path Library::archive(Shard shard) const { return folder_ / "shards" / (name_of(shard) + ".tar"); }

fs::path Library::measured_of(const fs::path& archive) { return fs::path(archive).replace_extension(".measured.jsonl"); }

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

std::vector<Shard> Library::unfinished() const
{
    const ordered_json merged = ordered_json::parse(read_all(merged_folder() / "shards.json"), nullptr, false);
    Shard shard{.count = recipe().shards};
    std::set<std::uint32_t> finished;
    if (merged.is_object() && merged.value("count", 0u) == shard.count)
        finished = merged.value("finished", std::set<std::uint32_t>());
    std::vector<Shard> out;
    std::error_code ignored;
    for (; shard.index < shard.count; ++shard.index)
        if (!finished.contains(shard.index) && !fs::exists(archive(shard), ignored)) out.push_back(shard);
    return out;
}

std::string Library::merged_shards() const
{
    std::set<std::uint32_t> finished;
    const std::uint32_t count = recipe().shards;
    for (std::uint32_t i = 0; i < count; ++i) finished.insert(i);
    for (const Shard& shard : unfinished()) finished.erase(shard.index);
    return ordered_json{{"count", count}, {"finished", finished}}.dump() + "\n";
}

Recipe Library::recipe() const
{
    const ordered_json json = ordered_json::parse(read_all(folder_ / "batch.json"), nullptr, false);
    try {
        if (json.at("format") != k_format)
            throw io::ModelFileError(folder_.string() + ": made by another version of sqmap batch");
        return {json.at("made_by"), json.at("options"),  json.at("arguments"),
                json.at("shards"),  json.at("manifest"), json.at("root")};
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
                                          {"root", recipe.root}}
                                 .dump(2, ' ', false, ordered_json::error_handler_t::replace) +
                             "\n";
    if (read_all(file) != text) io::replace_file(file, std::as_bytes(std::span(text)));
}

std::string unfinished_words(const Library& library)
{
    constexpr std::size_t k_named = 20;
    const std::vector<Shard> absent = library.unfinished();
    if (absent.empty()) return {};
    std::string out = std::to_string(absent.size()) + " of " + std::to_string(absent.front().count) +
                      (absent.size() == 1 ? " shards is not finished: " : " shards are not finished: ");
    for (std::size_t i = 0; i < std::min(absent.size(), k_named); ++i)
        out += (i == 0 ? "" : ", ") + std::to_string(absent[i].index);
    return absent.size() > k_named ? out + ", ..." : out;
}

Contents::Contents(const std::vector<fs::path>& archives)
{
    for (const fs::path& path : archives) {
        files_.push_back(open_file(path));
        read_archive(path, files_.back().get(), results_);
        const fs::path measured = Library::measured_of(path);
        each_line(read_all(measured), [&](std::string_view line) {
            const auto known = results_.find(key_of_measured(line));
            if (known != results_.end() && known->second.measured.empty()) known->second.measured = line;
        });
        read_rows(path);
    }
    for (Row& row : rows_)
        if (results_.contains(row.key)) row.outcome = {};
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
    return row.outcome.text.empty() ? results_.find(row.key)->second.outcome : row.outcome;
}

std::string Contents::line(const Row& row) const { return Row{row.item, row.key, outcome(row)}.line(); }

std::string_view key_of_measured(std::string_view line)
{
    constexpr std::string_view k_start = R"({"key":")";
    return line.starts_with(k_start) ? line.substr(k_start.size(), 64) : std::string_view();
}

}  // namespace sqmap::batch
