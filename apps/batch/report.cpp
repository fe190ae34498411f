// The page holds the columns that it sorts and filters by. Files beside it hold reasons and pictures; the page fetches a file
// when one of its items comes into sight.
#include "batch/operations.h"
#include "batch/text.h"
#include "io/replace_file.h"
#include "sqmap/io/model_file.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <map>
#include <set>
#include <span>
#include <system_error>

// The assembler puts the page of the sources into the program.
asm(".pushsection .rodata\n"
    "k_sqmap_report_page: .incbin \"" SQMAP_REPORT_PAGE
    "\"\n"
    "k_sqmap_report_page_end: .byte 0\n"
    ".popsection\n");
extern "C" const char k_sqmap_report_page[];
extern "C" const char k_sqmap_report_page_end[];

namespace sqmap::batch {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr std::size_t k_chunk = 64;  // items a file

/// The columns of an item that the page itself holds.
struct Summary {
    const Row* row = nullptr;
    std::string path, member, verdict, code;
    double error = 0, seconds = 0;
    std::uint64_t bytes = 0;
};

std::string in_script(const ordered_json& json)
{
    std::string out = dumped(json);
    // The browser would end the script element at the first "</script".
    for (std::size_t at = out.find("</"); at != std::string::npos; at = out.find("</", at + 3)) out.replace(at, 2, "<\\/");
    return out;
}

std::string field(const std::string& text)
{
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    std::string out = "\"";
    for (const char c : text) out.append(c == '"' ? 2 : 1, c);
    return out + "\"";
}

std::string text_of(const ordered_json& value)
{
    if (value.is_null()) return "";
    if (value.is_string()) return value.get<std::string>();
    if (!value.is_array()) return value.dump();
    std::string out;
    for (const ordered_json& one : value) out += (out.empty() ? "" : "; ") + text_of(one);
    return out;
}

/// Writes the table and the page of a library.
class Report {
public:
    explicit Report(const Library& library) : library_(library), contents_(library) {}

    void write()
    {
        const fs::path folder = library_.report_folder();
        std::error_code error;
        fs::remove_all(folder, error);
        fs::create_directories(folder / "items", error);
        if (error) throw io::ModelFileError("cannot make " + folder.string() + ": " + error.message());
        write_table(folder / "rows.csv");
        std::stable_sort(items_.begin(), items_.end(), [](const Summary& a, const Summary& b) { return a.error > b.error; });
        write_items(folder / "items");
        const std::string page = this->page();
        io::replace_file(folder / "index.html", std::as_bytes(std::span(page)));
    }

private:
    [[nodiscard]] static ordered_json measured(const Finished& finished)
    {
        return finished.measured.empty() ? ordered_json::object() : ordered_json::parse(finished.measured, nullptr, false);
    }
    [[nodiscard]] ordered_json measured(const Row& row) const
    {
        const auto found = contents_.results().find(row.key);
        return found == contents_.results().end() ? ordered_json::object() : measured(found->second);
    }

    void write_table(const fs::path& path)
    {
        static constexpr std::array k_columns{"path",    "member", "line",  "key",        "verdict", "code",
                                              "element", "reason", "cure",  "notes",      "format",  "triangles",
                                              "parts",   "bytes",  "r_max", "target_met", "doubtful"};
        std::ofstream out(path, std::ios::binary);
        for (const char* column : k_columns) out << column << ',';
        out << "depth_p99_percent,depth_max_percent,moved_p99,made_up_share,seconds,peak_bytes,host\n";
        for (const Row& row : contents_.rows()) {
            const ordered_json all = ordered_json::parse(contents_.line(row)), time = measured(row);
            const auto at = [&](const char* pointer) {
                return text_of(all.value(ordered_json::json_pointer(pointer), ordered_json()));
            };
            for (const char* column : k_columns) out << field(text_of(all.value(column, ordered_json()))) << ',';
            out << at("/measured/depth_percent/p99") << ',' << at("/measured/depth_percent/max") << ','
                << at("/moved/input_to_result/p99") << ',' << at("/moved/made_up_share") << ','
                << text_of(time.value("seconds", ordered_json())) << ',' << text_of(time.value("peak_bytes", ordered_json()))
                << ',' << field(time.value("host", "")) << '\n';
            items_.push_back({&row, all.value("path", ""), all.value("member", ""), all.value("verdict", ""),
                              all.value("code", ""), all.value(ordered_json::json_pointer("/measured/depth_percent/p99"), 0.0),
                              time.value("seconds", 0.0), all.value("bytes", std::uint64_t{0})});
        }
        out.close();
        if (!out) throw io::ModelFileError("cannot write " + path.string());
    }

    /// The function reads the picture and does not map it: a mapping of all pictures would stay in memory.
    [[nodiscard]] std::string picture(const std::string& key) const
    {
        const auto found = contents_.results().find(key);
        if (found == contents_.results().end()) return {};
        try {
            return base64(read_at(found->second.file, found->second.picture_offset, found->second.picture_size));
        } catch (const io::ModelFileError&) {
            return {};
        }
    }

    void write_items(const fs::path& folder) const
    {
        for (std::size_t first = 0; first < items_.size(); first += k_chunk) {
            char name[32];
            std::snprintf(name, sizeof name, "%06zu.js", first / k_chunk);
            std::ofstream out(folder / name, std::ios::binary);
            out << "chunk([\n";
            for (std::size_t i = first; i < std::min(first + k_chunk, items_.size()); ++i) {
                const Row& row = *items_[i].row;
                ordered_json all = ordered_json::parse(contents_.line(row));
                for (const char* there : {"path", "member", "verdict", "code", "measured"}) all.erase(there);
                all["host"] = measured(row).value("host", "");
                if (items_[i].bytes > 0) all["picture"] = picture(row.key);
                out << in_script(all) << ",\n";
            }
            out << "]);\n";
            out.close();
            if (!out) throw io::ModelFileError("cannot write " + (folder / name).string());
        }
    }

    /// Adds an array of the names that occur, and an array of each item's index among them.
    template <class Get>
    static void add_names(ordered_json& data, const char* names, const char* numbers, const std::vector<Summary>& items,
                          Get&& get)
    {
        std::map<std::string, std::size_t> known;
        for (const Summary& item : items) known.emplace(get(item), 0);
        std::size_t next = 0;
        data[names] = ordered_json::array();
        for (auto& [name, number] : known) {
            number = next++;
            data[names].push_back(name);
        }
        data[numbers] = ordered_json::array();
        for (const Summary& item : items) data[numbers].push_back(known.at(get(item)));
    }

    [[nodiscard]] std::string page() const
    {
        const Recipe recipe = library_.recipe();
        ordered_json data{{"title", fs::absolute(library_.folder()).lexically_normal().filename().string()},
                          {"made_by", recipe.made_by},
                          {"options", recipe.options},
                          {"unfinished", words_of(library_.unfinished())},
                          {"chunk", k_chunk}};
        std::uint64_t models = 0, model_bytes = 0;
        double seconds = 0;
        std::set<std::string_view> named;
        for (const Summary& item : items_) named.insert(item.row->key);
        for (const auto& [key, finished] : contents_.results()) {
            if (!named.contains(key)) continue;
            models += finished.model_size > 0 ? 1 : 0;
            model_bytes += finished.model_size;
            seconds += measured(finished).value("seconds", 0.0);
        }
        data["models"] = models;
        data["model_bytes"] = model_bytes;
        data["cpu_seconds"] = seconds;
        add_names(data, "verdicts", "verdict", items_, [](const Summary& item) { return item.verdict; });
        add_names(data, "codes", "code", items_, [](const Summary& item) { return item.code; });
        for (const char* column : {"path", "member", "error", "bytes", "seconds"}) data[column] = ordered_json::array();
        for (const Summary& item : items_) {
            data["path"].push_back(item.path);
            data["member"].push_back(item.member);
            data["error"].push_back(item.error);
            data["bytes"].push_back(item.bytes);
            data["seconds"].push_back(item.seconds);
        }
        constexpr std::string_view k_mark = "/*DATA*/null";
        std::string out(k_sqmap_report_page, k_sqmap_report_page_end);
        return out.replace(out.find(k_mark), k_mark.size(), in_script(data));
    }

    const Library& library_;
    Contents contents_;
    std::vector<Summary> items_;
};

}  // namespace

void write_report(const Library& library)
{
    (void)library.recipe();
    Report(library).write();
}

}  // namespace sqmap::batch
