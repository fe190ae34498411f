#include "batch/operations.h"
#include "batch/running.h"
#include "io/replace_file.h"
#include "sqmap/io/model_archive.h"
#include "sqmap/paper/model_file.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <map>
#include <vector>

namespace sqmap::batch {
namespace {

using nlohmann::json;

double seconds_of(const Contents& contents, const Row& row)
{
    const auto found = contents.results().find(row.key);
    if (found == contents.results().end() || found->second.measured.empty()) return 0;
    return json::parse(found->second.measured, nullptr, false).value("seconds", 0.0);
}

void print(const TimedRow& timed, bool as_json, bool is_running)
{
    if (as_json) {
        std::string line = timed_line(timed.row, timed.seconds);
        if (is_running) line.insert(line.size() - 1, R"(,"running":true)");
        std::printf("%s\n", line.c_str());
    } else {
        std::printf("%8.2f  %s%s\n", timed.seconds, sentence(timed.row).c_str(), is_running ? " (running)" : "");
    }
}

/// How well a text names an item: by a part of its name or key, or in full.
enum class Match : std::uint8_t { None, Loose, Exact };

Match match_of(const Row& row, const std::string& text)
{
    constexpr std::size_t k_shortest_key = 4;
    const json item = json::parse(row.item + "}");
    const std::string path = item.value("path", ""), member = item.value("member", "");
    const auto file_name = [](const std::string& name) { return name.substr(name.rfind('/') + 1); };
    if ((member.empty() ? path : path + "/" + member) == text) return Match::Exact;
    const bool is_key = text.size() >= k_shortest_key && row.key.starts_with(text);
    const bool is_name = member.empty() ? file_name(path) == text : member == text || file_name(member) == text;
    return is_key || is_name ? Match::Loose : Match::None;
}

/// The rows that a text names in full, else the rows that it names in part; one row of each key.
std::vector<Row> rows_named(const Contents& contents, const std::string& text)
{
    std::map<Match, std::map<std::string, Row>> found;
    for (const Row& row : contents.rows())
        if (const Match match = match_of(row, text); match != Match::None)
            found[match].try_emplace(row.key.empty() ? row.item : row.key, Row{row.item, row.key, contents.outcome(row)});
    std::vector<Row> out;
    if (!found.empty())
        for (const auto& [key, row] : found.rbegin()->second) out.push_back(row);
    return out;
}

/// Writes the model of that key; false where there is none.
bool extract_key(const Library& library, const std::string& key, const std::filesystem::path& output)
{
    for (const std::filesystem::path& path : library.archives()) {
        const io::ModelArchive archive(path);
        if (!archive.find(key)) continue;
        io::replace_file(output, paper::MappedModel(archive.map(key), path).bytes());
        return true;
    }
    return false;
}

/// @throw io::ModelFileError where no item or several are named, or the item has no model
std::string key_named(const Library& library, const std::string& text)
{
    constexpr std::size_t k_named = 10;
    const std::string where = library.folder().string() + ": ";
    const std::vector<Row> rows = rows_named(Contents(library), text);
    if (rows.empty())
        throw io::ModelFileError(where + "no item has the key, path or name '" + text +
                                 "'\n  cure: take one of 'sqmap batch list " + library.folder().string() +
                                 "'; with --json it has the keys");
    if (rows.size() == 1 && is_baked(rows[0].outcome.verdict())) return rows[0].key;
    if (rows.size() == 1) throw io::ModelFileError(where + "this item has no model: " + sentence(rows[0]));
    std::string out = where + "'" + text + "' names items of different content:\n";
    for (std::size_t i = 0; i < std::min(rows.size(), k_named); ++i)
        out += "  " + rows[i].key.substr(0, 16) + "  " + sentence(rows[i]) + "\n";
    if (rows.size() > k_named) out += "  and " + std::to_string(rows.size() - k_named) + " more\n";
    throw io::ModelFileError(out + "  cure: give a whole path, or the first digits of a key");
}

}  // namespace

void list(const Library& library, bool as_json)
{
    const Contents contents(library);
    for (const Row& row : contents.rows())
        print({{row.item, row.key, contents.outcome(row)}, seconds_of(contents, row)}, as_json, false);
    for (const TimedRow& row : running_rows(library)) print(row, as_json, true);
}

void extract(const Library& library, const std::string& item, const std::filesystem::path& output)
{
    if (extract_key(library, item, output)) return;
    if (const std::string key = key_named(library, item); !extract_key(library, key, output))
        throw io::ModelFileError(library.folder().string() + ": holds no model of key " + key);
}

}  // namespace sqmap::batch
