#include "batch/row.h"

#include "batch/text.h"
#include "sqmap/io/model_file.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>

namespace sqmap::batch {
namespace {

using nlohmann::ordered_json;

/// JSON escapes quotes within strings, so that these texts occur only between members.
constexpr std::string_view k_key_field = R"(,"key":")", k_verdict = R"(,"verdict":")", k_first_verdict = R"({"verdict":")";
constexpr std::size_t k_key_length = 64;

bool is_utf8(const std::string& text)
{
    try {
        (void)ordered_json(text).dump();
        return true;
    } catch (const ordered_json::type_error&) {
        return false;
    }
}

/// Escapes control characters: a name must not control the terminal that prints it.
std::string printable(const std::string& text)
{
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const auto c = static_cast<unsigned char>(text[i]);
        // UTF-8 has two bytes for U+0080 to U+009F, which are control characters too.
        const bool is_long = c == 0xC2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xA0;
        char escaped[8] = "";
        if (is_long)
            std::snprintf(escaped, sizeof escaped, "\\u%04x", static_cast<unsigned char>(text[++i]));
        else if (c < 0x20 || c == 0x7F)
            std::snprintf(escaped, sizeof escaped, "\\x%02x", c);
        out += escaped[0] != '\0' ? std::string(escaped) : std::string(1, text[i]);
    }
    return out;
}

}  // namespace

std::string_view Outcome::verdict() const
{
    const std::string_view rest = std::string_view(text).substr(k_first_verdict.size());
    return rest.substr(0, rest.find('"'));
}

bool is_baked(std::string_view verdict)
{
    return verdict == "accept" || verdict == "repaired" || verdict == "closed" || verdict == "wrapped";
}

Outcome outcome_of(std::string_view verdict, const Fault& fault)
{
    return {dumped({{"verdict", verdict},
                    {"code", fault.code},
                    {"element", fault.element},
                    {"reason", fault.message},
                    {"cure", fault.cure}})};
}

std::string Row::line() const
{
    std::string out = item;
    if (!key.empty()) out.append(k_key_field).append(key).append("\"");
    return out.append(",").append(outcome.text, 1);
}

std::string sentence(const Row& row)
{
    const ordered_json all = ordered_json::parse(row.line());
    std::string out(row.outcome.verdict());
    out.resize(std::max<std::size_t>(out.size(), 10), ' ');
    out += " " + printable(all.value("path", ""));
    if (all.contains("member")) out += " " + printable(all.value("member", ""));
    if (!all.contains("reason")) return out;
    if (all.contains("line")) out += "  [line " + std::to_string(all["line"].get<std::uint64_t>()) + "]";
    return out + ": " + printable(all.value("reason", ""));
}

std::string timed_line(const Row& row, double seconds)
{
    char text[48];
    std::snprintf(text, sizeof text, ",\"seconds\":%.3f}", seconds);
    std::string out = row.line();
    out.pop_back();
    return out + text;
}

Row row_of(const Item& item, std::string key, Outcome outcome)
{
    ordered_json head{{"path", item.path}};
    if (!is_utf8(item.path)) head["path_hex"] = hexadecimal(item.path);
    if (!item.member.empty()) head["member"] = item.member;
    if (!is_utf8(item.member)) head["member_hex"] = hexadecimal(item.member);
    if (item.line > 0) head["line"] = item.line;
    std::string text = dumped(head);
    text.pop_back();
    return {std::move(text), std::move(key), std::move(outcome)};
}

Row row_of(std::string_view line)
{
    const std::size_t verdict = line.find(k_verdict), key = line.substr(0, verdict).find(k_key_field);
    const bool has_key = key != std::string_view::npos;
    if (!line.starts_with("{\"path\":") || verdict == std::string_view::npos || line.back() != '}' ||
        (has_key && verdict != key + k_key_field.size() + k_key_length + 1))
        throw io::ModelFileError("a line of rows is damaged: " + std::string(line.substr(0, 120)));
    Row out;
    out.item = line.substr(0, has_key ? key : verdict);
    if (has_key) out.key = line.substr(key + k_key_field.size(), k_key_length);
    out.outcome.text = "{" + std::string(line.substr(verdict + 1));
    return out;
}

}  // namespace sqmap::batch
