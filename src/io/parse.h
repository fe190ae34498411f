// Shared by the readers: errors, counting, and a cursor over text.
#pragma once

#include "math/number_text.h"
#include "sqmap/io/read.h"

#include <charconv>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <string_view>
#include <utility>

namespace sqmap::io {

/// Thrown inside the readers only; read_mesh_bytes turns it into the result.
struct ReadFailure {
    ReadError error;
};

[[noreturn]] inline void fail_format(std::string element, std::string message)
{
    throw ReadFailure{
        {"E_FORMAT", std::move(element), std::move(message), "export the mesh again, in the format its name says", {}}};
}
[[noreturn]] inline void fail_truncated(std::string element, std::string message)
{
    throw ReadFailure{
        {"E_TRUNCATED", std::move(element), std::move(message), "copy or export the file again: part of it is missing", {}}};
}
[[noreturn]] inline void fail_limit(std::string element, std::string message, std::string cure, Raisable limit = Raisable::None)
{
    throw ReadFailure{{"E_LIMIT", std::move(element), std::move(message), std::move(cure), limit}};
}

inline void check_byte_limit(std::string element, std::uint64_t bytes, const ReadLimits& limits)
{
    if (bytes > limits.max_bytes)
        fail_limit(std::move(element), std::to_string(bytes) + " bytes; the limit is " + std::to_string(limits.max_bytes),
                   "reduce the mesh", Raisable::MaxBytes);
}

inline void check_face_limit(std::uint64_t faces, const ReadLimits& limits)
{
    if (faces > limits.max_faces)
        fail_limit("face " + std::to_string(limits.max_faces + 1), "more than " + std::to_string(limits.max_faces) + " faces",
                   "reduce the mesh", Raisable::MaxFaces);
}

/// Closes the polygon whose corners were pushed last.
inline void end_polygon(PolygonSoup& soup, const ReadLimits& limits)
{
    if (soup.indices.size() > std::numeric_limits<std::uint32_t>::max())
        fail_limit("face " + std::to_string(soup.polygon_offsets.size()), "more corners than 32 bits can count",
                   "reduce the mesh");
    soup.polygon_offsets.push_back(static_cast<std::uint32_t>(soup.indices.size()));
    check_face_limit(soup.polygon_offsets.size() - 1, limits);
}

/// Walks over text token by token. Lines end with \n, \r\n or \r. A comment ends with its line, whatever stands last in it.
class TextCursor {
public:
    explicit TextCursor(std::span<const std::byte> bytes, char comment = '\0', char continuation = '\0')
        : at_(reinterpret_cast<const char*>(bytes.data())),
          end_(at_ + bytes.size()),
          comment_(comment),
          continuation_(continuation)
    {
    }

    [[nodiscard]] bool at_end() const { return at_ == end_; }
    [[nodiscard]] std::uint64_t remaining() const { return static_cast<std::uint64_t>(end_ - at_); }
    [[nodiscard]] std::uint64_t line() const { return line_; }
    [[nodiscard]] std::string where() const { return "line " + std::to_string(line_); }
    [[nodiscard]] std::string_view rest() const { return {at_, static_cast<std::size_t>(remaining())}; }

    /// Next token of this line; empty at its end.
    std::string_view token_in_line()
    {
        while (at_ != end_ && (is_blank(*at_) || line_goes_on()))
            if (is_blank(*at_))
                ++at_;
            else
                step_over_line_end(at_ + 1);
        if (at_ != end_ && comment_ != '\0' && *at_ == comment_) skip_to_line_end();
        const char* from = at_;
        while (at_ != end_ && !is_blank(*at_) && !is_line_end(*at_)) ++at_;
        return {from, static_cast<std::size_t>(at_ - from)};
    }

    /// Next token, over line ends; empty at the end of the text.
    std::string_view token()
    {
        while (true) {
            const std::string_view t = token_in_line();
            if (!t.empty() || !next_line()) return t;
        }
    }

    /// Moves to the start of the next line; false if there is none.
    bool next_line()
    {
        skip_to_line_end();
        if (at_ == end_) return false;
        step_over_line_end(at_);
        return true;
    }

    void skip_to_line_end()
    {
        for (bool in_comment = false; at_ != end_ && !is_line_end(*at_);) {
            in_comment = in_comment || (comment_ != '\0' && *at_ == comment_);
            if (!in_comment && line_goes_on())
                step_over_line_end(at_ + 1);
            else
                ++at_;
        }
    }

    /// A coordinate from the next token. A token that the end of the file cuts is a truncation, not a bad format.
    double number(std::string_view t)
    {
        double value = 0;
        if (t.empty() || !parse_number(t, value)) fail_token(t, "a number");
        return value;
    }

    std::int64_t integer(std::string_view t)
    {
        std::int64_t value = 0;
        if (t.empty() || !parse_integer(t, value)) fail_token(t, "an integer");
        return value;
    }

    [[noreturn]] void fail_token(std::string_view t, const std::string& expected) const
    {
        if (at_end()) fail_truncated(where(), "the file ends where " + expected + " is expected");
        if (t.empty()) fail_format(where(), "the line ends where " + expected + " is expected");
        fail_format(where(), "'" + printable(t) + "' where " + expected + " is expected");
    }

    static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
    static bool is_line_end(char c) { return c == '\n' || c == '\r'; }

    /// A short form of a token that can be shown: the file may hold anything.
    static std::string printable(std::string_view t)
    {
        std::string out;
        for (char c : t.substr(0, 24)) out += (c >= ' ' && c <= '~') ? c : '?';
        return t.size() > 24 ? out + "..." : out;
    }

    /// Decimal or "nan", "inf" in any case and Microsoft's "1.#QNAN"; beyond double's range becomes infinite, below it 0.
    static bool parse_number(std::string_view t, double& value)
    {
        if (t.size() > 1 && t[0] == '+' && t[1] != '-') t.remove_prefix(1);
        const auto [end, status] = sqmap::from_chars(t.data(), t.data() + t.size(), value);
        if (status == std::errc::invalid_argument) return false;
        const std::string_view rest(end, static_cast<std::size_t>(t.data() + t.size() - end));
        if (!rest.empty() && rest[0] == '#') {
            value = std::numeric_limits<double>::quiet_NaN();
            return true;
        }
        if (status == std::errc::result_out_of_range) value = std::strtod(std::string(t).c_str(), nullptr);
        return rest.empty();
    }

    /// Beyond 64 bits becomes the extreme value, which no count and no index can be.
    static bool parse_integer(std::string_view t, std::int64_t& value)
    {
        if (t.size() > 1 && t[0] == '+' && t[1] != '-') t.remove_prefix(1);
        const auto [end, status] = std::from_chars(t.data(), t.data() + t.size(), value);
        if (status == std::errc::result_out_of_range)
            value = t[0] == '-' ? std::numeric_limits<std::int64_t>::min() : std::numeric_limits<std::int64_t>::max();
        return status != std::errc::invalid_argument && end == t.data() + t.size();
    }

private:
    /// At the mark that joins this line to the next.
    [[nodiscard]] bool line_goes_on() const
    {
        return continuation_ != '\0' && *at_ == continuation_ && at_ + 1 != end_ && is_line_end(at_[1]);
    }

    void step_over_line_end(const char* line_end)
    {
        at_ = line_end + (*line_end == '\r' && line_end + 1 != end_ && line_end[1] == '\n' ? 2 : 1);
        ++line_;
    }

    const char* at_;
    const char* end_;
    char comment_, continuation_;
    std::uint64_t line_ = 1;
};

PolygonSoup read_off(std::span<const std::byte> bytes, const ReadLimits& limits);
PolygonSoup read_obj(std::span<const std::byte> bytes, const ReadLimits& limits);
PolygonSoup read_stl(std::span<const std::byte> bytes, const ReadLimits& limits);
PolygonSoup read_ply(std::span<const std::byte> bytes, const ReadLimits& limits);
/// folder: where buffers beside the file are looked for; empty: nowhere.
PolygonSoup read_gltf(std::span<const std::byte> bytes, const std::filesystem::path& folder, const ReadLimits& limits);
/// DAE, 3MF and FBX, by a program that need not be there.
PolygonSoup read_through_assimp(std::span<const std::byte> bytes, MeshFormat format, const ReadLimits& limits);

}  // namespace sqmap::io
