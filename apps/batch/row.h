// Rows, one for each item of a library. A row stays JSON text, because a library has many and most commands only pass them on.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace sqmap::batch {

/// A mesh of the manifest, by path or inside an archive.
struct Item {
    std::string path;    ///< as the manifest has it: any bytes
    std::string member;  ///< its name inside the archive at path; empty for a file
    std::uint64_t line = 0;
};

/// Why there is no model.
struct Fault {
    std::string code, element, message, cure;
};

/// The result of a mesh as a JSON object whose first member is "verdict". It is the same on every machine.
struct Outcome {
    std::string text;

    [[nodiscard]] std::string_view verdict() const;
};

/// "accept", "repaired", "closed" or "wrapped": there is a model.
[[nodiscard]] bool is_baked(std::string_view verdict);

/// verdict: "refused", "unreadable", "duplicate", "timeout", "memory", "output", "crash" or "killed".
[[nodiscard]] Outcome outcome_of(std::string_view verdict, const Fault& fault);

/// A line of rows.jsonl: {"path", "member", "line", "key", and the outcome's members}, without the members that are empty.
struct Row {
    std::string item;  ///< the beginning of the line, up to the key
    std::string key;   ///< empty where the mesh could not be read
    Outcome outcome;

    [[nodiscard]] std::string line() const;
};

/// A row for people: verdict, path, member, and for a fault the manifest's line and the reason. Control characters are escaped as
/// in C.
[[nodiscard]] std::string sentence(const Row& row);

/// A row's line with "seconds" as its last member.
[[nodiscard]] std::string timed_line(const Row& row, double seconds);

/// Makes a row. A path that is not UTF-8 stands in it with replaced characters, and as hexadecimal digits in "path_hex".
[[nodiscard]] Row row_of(const Item& item, std::string key, Outcome outcome);

/// @throw io::ModelFileError for a text that is no row
[[nodiscard]] Row row_of(std::string_view line);

/// Calls take with every line of a text, without its end.
template <class Take>
void each_line(std::string_view text, Take&& take)
{
    while (!text.empty()) {
        const std::size_t end = text.find('\n');
        take(text.substr(0, end));
        text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    }
}

}  // namespace sqmap::batch
