#include "batch/manifest.h"

#include "batch/text.h"
#include "io/files.h"

#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <map>
#include <optional>
#include <system_error>
#include <utility>

namespace sqmap::batch {
namespace {

namespace fs = std::filesystem;
using Fields = std::vector<std::string>;

template <std::size_t N>
bool ends_with_one_of(std::string_view name, const std::array<std::string_view, N>& endings)
{
    const std::string text = lower(name);
    return std::any_of(endings.begin(), endings.end(), [&](std::string_view ending) { return text.ends_with(ending); });
}

Entry wrong(std::uint64_t line, const std::string& why, const char* cure)
{
    return {{"", "", line}, outcome_of("unreadable", {"E_MANIFEST", "line " + std::to_string(line), why, cure})};
}

Entry entry_of(std::string path, std::string member, std::uint64_t line)
{
    if (path.empty()) return wrong(line, "it names no path", "give a path, or leave the line out");
    if (path.find('\0') != std::string::npos || member.find('\0') != std::string::npos)
        return wrong(line, "its path holds a zero byte", "write the manifest as text");
    return {{std::move(path), std::move(member), line}, {}};
}

std::string manifest_text(const fs::path& path)
{
    std::optional<std::string> text = io::text_of_file(path);
    if (!text) throw ManifestError(path.string() + ": the manifest cannot be read");
    if (text->starts_with("\xEF\xBB\xBF")) text->erase(0, 3);
    return *std::move(text);
}

std::string_view without_return(std::string_view line) { return line.ends_with('\r') ? line.substr(0, line.size() - 1) : line; }

std::vector<Entry> read_lines(const std::string& text)
{
    std::vector<Entry> out;
    std::uint64_t number = 0;
    each_line(text, [&](std::string_view line) {
        ++number;
        if (!without_return(line).empty()) out.push_back(entry_of(std::string(without_return(line)), "", number));
    });
    return out;
}

std::vector<Entry> read_json_lines(const std::string& text)
{
    std::vector<Entry> out;
    std::uint64_t number = 0;
    const auto text_of = [](const nlohmann::json& object, const char* name) {
        const auto found = object.find(name);
        return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
    };
    each_line(text, [&](std::string_view line) {
        ++number;
        if (without_return(line).empty()) return;
        const nlohmann::json object = nlohmann::json::parse(line, nullptr, false);
        if (object.is_discarded() || !object.is_object())
            out.push_back(wrong(number, "it is not a JSON object in UTF-8", R"(write {"path": "..."})"));
        else
            out.push_back(entry_of(text_of(object, "path"), text_of(object, "member"), number));
    });
    return out;
}

/// Records of a table of RFC 4180; a field may hold line ends between quotes.
class Table {
public:
    explicit Table(std::string_view text) : rest_(text) {}

    /// Reads the next record; false at the end. line() is then the line where the record began; is_open(): a quote had no end.
    bool next(Fields& fields)
    {
        fields.assign(1, "");
        if (rest_.empty()) return false;
        line_ = next_line_;
        bool quoted = false;
        for (std::size_t i = 0; i < rest_.size(); ++i) {
            const char c = rest_[i];
            if (c == '\n') ++next_line_;
            if (quoted) {
                if (c != '"')
                    fields.back() += c;
                else if (i + 1 < rest_.size() && rest_[i + 1] == '"')
                    fields.back() += rest_[++i];
                else
                    quoted = false;
            } else if (c == '"' && fields.back().empty()) {
                quoted = true;
            } else if (c == ',') {
                fields.emplace_back();
            } else if (c == '\n') {
                return ended(fields, i + 1);
            } else {
                fields.back() += c;
            }
        }
        is_open_ = quoted;
        return ended(fields, rest_.size());
    }
    [[nodiscard]] std::uint64_t line() const { return line_; }
    [[nodiscard]] bool is_open() const { return is_open_; }

private:
    bool ended(Fields& fields, std::size_t length)
    {
        rest_.remove_prefix(length);
        if (fields.back().ends_with('\r')) fields.back().pop_back();
        return true;
    }

    std::string_view rest_;
    std::uint64_t line_ = 0, next_line_ = 1;
    bool is_open_ = false;
};

std::vector<Entry> read_table(const fs::path& manifest)
{
    std::vector<Entry> out;
    const std::string text = manifest_text(manifest);
    Table table(text);
    Fields fields;
    std::size_t path = 0, member = std::string::npos;
    bool is_first = true;
    while (table.next(fields)) {
        const auto heading = std::find(fields.begin(), fields.end(), "path");
        if (std::exchange(is_first, false) && heading != fields.end()) {
            path = static_cast<std::size_t>(heading - fields.begin());
            const auto second = std::find(fields.begin(), fields.end(), "member");
            if (second != fields.end()) member = static_cast<std::size_t>(second - fields.begin());
            continue;
        }
        if (fields == Fields{""}) continue;
        // The table would take all that follows as one path.
        if (table.is_open())
            throw ManifestError(manifest.string() + ", line " + std::to_string(table.line()) +
                                ": a quote has no end\n  cure: close it, or double it where it is meant");
        out.push_back(
            entry_of(path < fields.size() ? fields[path] : "", member < fields.size() ? fields[member] : "", table.line()));
    }
    return out;
}

bool can_enter(const fs::path& folder) { return ::access(folder.c_str(), R_OK | X_OK) == 0; }

/// The reason why the meshes in a folder are not items; none where they are.
std::optional<Outcome> fault_of_folder(const fs::directory_entry& folder)
{
    std::error_code ignored;
    const auto fault = [](const char* why, const char* cure) {
        return outcome_of("unreadable", {"E_FOLDER", "folder", why, cure});
    };
    if (folder.is_symlink(ignored))
        return fault("it is a link to a folder, which is not followed",
                     "list its meshes in a manifest, or move the link elsewhere");
    if (!can_enter(folder.path())) return fault(std::strerror(errno), "let it be read, or move it elsewhere");
    return std::nullopt;
}

std::vector<Entry> read_folder(const fs::path& folder, const fs::path& skip)
{
    if (!can_enter(folder)) throw ManifestError(folder.string() + ": the folder cannot be read: " + std::strerror(errno));
    std::vector<Entry> out;
    std::error_code ignored;
    for (fs::recursive_directory_iterator it(folder, fs::directory_options::skip_permission_denied, ignored), end; it != end;
         it.increment(ignored)) {
        const std::string name = it->path().filename().string();
        const Item item{it->path().lexically_relative(folder).string(), "", 0};
        if (!it->is_directory(ignored)) {
            if (has_mesh_name(name) || has_archive_name(name)) out.push_back({item, {}});
        } else if (fs::equivalent(it->path(), skip, ignored)) {
            it.disable_recursion_pending();
        } else if (auto fault = fault_of_folder(*it)) {
            out.push_back({item, std::move(fault)});
        }
    }
    std::sort(out.begin(), out.end(), [](const Entry& a, const Entry& b) { return a.item.path < b.item.path; });
    return out;
}

}  // namespace

bool has_mesh_name(std::string_view name) { return io::format_of_name(name).has_value(); }

bool has_archive_name(std::string_view name)
{
    static constexpr std::array<std::string_view, 10> k_endings{".zip",  ".tar",    ".tgz", ".tar.gz",  ".tar.bz2",
                                                                ".tbz2", ".tar.xz", ".txz", ".tar.zst", ".tzst"};
    return ends_with_one_of(name, k_endings);
}

namespace {

std::vector<Entry> read_any(const fs::path& manifest, const ManifestOptions& options)
{
    std::error_code ignored;
    if (fs::is_directory(manifest, ignored)) {
        if (fs::equivalent(manifest, options.skip, ignored))
            throw ManifestError(manifest.string() +
                                ": it is the library's folder too, whose archives would be items\n"
                                "  cure: name another folder for the library, one within it for instance");
        return read_folder(manifest, options.skip);
    }
    if (!fs::is_regular_file(manifest, ignored)) throw ManifestError(manifest.string() + ": there is no such manifest");
    const std::string name = manifest.filename().string();
    if (ends_with_one_of(name, std::array<std::string_view, 1>{".csv"})) return read_table(manifest);
    if (ends_with_one_of(name, std::array<std::string_view, 1>{".txt"})) return read_lines(manifest_text(manifest));
    if (ends_with_one_of(name, std::array<std::string_view, 2>{".jsonl", ".ndjson"}))
        return read_json_lines(manifest_text(manifest));
    if (has_mesh_name(name) || has_archive_name(name)) return {{{name, "", 0}, {}}};
    throw ManifestError(manifest.string() +
                        ": a manifest is a folder, a mesh, an archive, or ends in .csv, .jsonl, .ndjson or .txt");
}

}  // namespace

std::vector<Entry> read_manifest(const fs::path& manifest, const ManifestOptions& options)
{
    std::vector<Entry> out = read_any(manifest, options);
    if (out.empty())
        throw ManifestError(
            manifest.string() +
            ": it names no mesh\n"
            "  cure: give a folder with meshes (.off, .obj, .stl, .ply, .gltf, .glb, ...) or archives of them, or a "
            "list with a path a line");
    return out;
}

void mark_duplicates(std::vector<Entry>& entries)
{
    std::map<std::pair<std::string_view, std::string_view>, std::uint64_t> lines;
    for (Entry& entry : entries) {
        if (entry.outcome) continue;
        const auto [first, is_new] = lines.try_emplace({entry.item.path, entry.item.member}, entry.item.line);
        if (!is_new)
            entry.outcome = outcome_of("duplicate", {"E_DUPLICATE", "line " + std::to_string(entry.item.line),
                                                     "it repeats line " + std::to_string(first->second), "leave it out"});
    }
}

std::string fingerprint_of(const std::vector<Entry>& entries)
{
    std::string all;
    for (const Entry& entry : entries) all += row_of(entry.item, "", {}).item + (entry.outcome ? entry.outcome->text : "") + "\n";
    return std::to_string(entries.size()) + (entries.size() == 1 ? " item" : " items") + ", SHA-256 " + sha256(all);
}

fs::path root_of(const fs::path& manifest, const fs::path& root)
{
    if (!root.empty()) return fs::absolute(root);
    std::error_code ignored;
    return fs::is_directory(manifest, ignored) ? fs::absolute(manifest) : fs::absolute(manifest).parent_path();
}

fs::path file_of(const Item& item, const fs::path& root) { return root / item.path; }

}  // namespace sqmap::batch
