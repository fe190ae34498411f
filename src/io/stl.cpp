// Stereolithography files, text and binary (3D Systems 1988); facet normals are passed over, corners are not shared.
#include "parse.h"

#include <algorithm>
#include <bit>

namespace sqmap::io {
namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is read in place");

constexpr std::size_t k_header_bytes = 84;
constexpr std::size_t k_facet_bytes = 50;

bool is_word(std::string_view token, std::string_view word)
{
    return std::equal(token.begin(), token.end(), word.begin(), word.end(),
                      [](char a, char b) { return (a >= 'A' && a <= 'Z' ? static_cast<char>(a - 'A' + 'a') : a) == b; });
}

void expect(TextCursor& cursor, std::string_view word)
{
    const std::string_view token = cursor.token();
    if (!is_word(token, word)) cursor.fail_token(token, "'" + std::string(word) + "'");
}

PolygonSoup read_text(std::span<const std::byte> bytes, const ReadLimits& limits)
{
    PolygonSoup soup;
    TextCursor cursor(bytes);
    for (std::string_view solid = cursor.token(); !solid.empty(); solid = cursor.token()) {
        if (!is_word(solid, "solid")) cursor.fail_token(solid, "'solid'");
        cursor.skip_to_line_end();  // its name
        while (true) {
            const std::string_view token = cursor.token();
            if (is_word(token, "endsolid")) break;
            if (!is_word(token, "facet")) cursor.fail_token(token, "'facet' or 'endsolid'");
            expect(cursor, "normal");
            for (int i = 0; i < 3; ++i) cursor.number(cursor.token());
            expect(cursor, "outer");
            expect(cursor, "loop");
            for (int corner = 0; corner < 3; ++corner) {
                expect(cursor, "vertex");
                Vec3d p;
                for (int i = 0; i < 3; ++i) p[i] = cursor.number(cursor.token());
                soup.indices.push_back(static_cast<std::int64_t>(soup.positions.size()));
                soup.positions.push_back(p);
            }
            expect(cursor, "endloop");
            expect(cursor, "endfacet");
            end_polygon(soup, limits);
        }
        cursor.skip_to_line_end();
    }
    return soup;
}

PolygonSoup read_binary(std::span<const std::byte> bytes, const ReadLimits& limits)
{
    if (bytes.size() < k_header_bytes)
        fail_truncated("header", std::to_string(bytes.size()) + " bytes; a binary STL file has a header of 84");
    std::uint32_t count = 0;
    std::memcpy(&count, bytes.data() + 80, sizeof count);
    if (count > (bytes.size() - k_header_bytes) / k_facet_bytes)
        fail_truncated("header", std::to_string(count) + " facets of 50 bytes declared, " +
                                     std::to_string(bytes.size() - k_header_bytes) + " bytes follow");
    check_face_limit(count, limits);
    PolygonSoup soup;
    soup.positions.reserve(3 * std::size_t{count});
    soup.indices.reserve(3 * std::size_t{count});
    soup.polygon_offsets.reserve(std::size_t{count} + 1);
    for (std::size_t f = 0; f < count; ++f) {
        float corners[9];
        std::memcpy(corners, bytes.data() + k_header_bytes + f * k_facet_bytes + 12, sizeof corners);
        for (int k = 0; k < 3; ++k) {
            soup.indices.push_back(static_cast<std::int64_t>(soup.positions.size()));
            soup.positions.push_back({corners[3 * k], corners[3 * k + 1], corners[3 * k + 2]});
        }
        end_polygon(soup, limits);
    }
    return soup;
}

}  // namespace

PolygonSoup read_stl(std::span<const std::byte> bytes, const ReadLimits& limits)
{
    // Binary files may start with "solid" too: a size that fits the count, or a zero byte, shows that they are not text.
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const std::size_t first = text.find_first_not_of(" \t\r\n");
    const bool says_solid = first != std::string_view::npos && is_word(text.substr(first, 5), "solid");
    if (!says_solid) {
        const bool plain =
            std::all_of(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(text.size(), 84)),
                        [](char c) { return (c >= ' ' && c <= '~') || c == '\n' || c == '\r' || c == '\t'; });
        if (plain) fail_format("byte 0", "an STL file in text starts with 'solid', a binary one holds a count of facets");
        return read_binary(bytes, limits);
    }
    std::uint32_t count = 0;
    if (bytes.size() >= k_header_bytes) std::memcpy(&count, bytes.data() + 80, sizeof count);
    const bool size_fits =
        bytes.size() >= k_header_bytes && bytes.size() == k_header_bytes + std::uint64_t{k_facet_bytes} * count;
    const bool has_zero = text.substr(0, 1024).find('\0') != std::string_view::npos;
    return size_fits || has_zero ? read_binary(bytes, limits) : read_text(bytes, limits);
}

}  // namespace sqmap::io
