// Wavefront OBJ: the polygonal geometry of the format's appendix B1 ("v" and "f"); everything else is passed over.
#include "parse.h"

#include <cctype>

namespace sqmap::io {
namespace {

/// Calls line(cursor, keyword) for every line that has one.
template <class Line>
void for_each_line(std::span<const std::byte> bytes, Line line)
{
    TextCursor cursor(bytes, '#', '\\');
    do {
        if (const std::string_view keyword = cursor.token_in_line(); !keyword.empty()) line(cursor, keyword);
    } while (cursor.next_line());
}

/// Vertex index of "7", "7/2", "7//3", "-1/2/3".
std::int64_t corner(TextCursor& cursor, std::string_view token, std::size_t vertex_count)
{
    const std::int64_t i = cursor.integer(token.substr(0, token.find('/')));
    if (i > 0) return i - 1;
    // Negative counts back from the vertices so far; 0 means nothing and stays out of range, for admission to name.
    return i == 0 || i == std::numeric_limits<std::int64_t>::min() ? -1 : i + static_cast<std::int64_t>(vertex_count);
}

}  // namespace

PolygonSoup read_obj(std::span<const std::byte> bytes, const ReadLimits& limits)
{
    // Counted first: growing a vector needs up to three times its final size, and hostile files are all vertices.
    std::uint64_t vertex_count = 0, face_count = 0;
    for_each_line(bytes, [&](TextCursor& cursor, std::string_view keyword) {
        vertex_count += keyword == "v";
        face_count += keyword == "f" || keyword == "fo";
        if (std::isalpha(static_cast<unsigned char>(keyword.front())) == 0)
            fail_format(cursor.where(), "'" + TextCursor::printable(keyword) + "' is not an OBJ statement such as v or f");
    });
    if (vertex_count == 0) fail_format("line 1", "no vertex line 'v x y z' in an OBJ file");
    check_face_limit(face_count, limits);

    PolygonSoup soup;
    soup.positions.reserve(vertex_count);
    soup.polygon_offsets.reserve(face_count + 1);
    soup.indices.reserve(3 * face_count);
    for_each_line(bytes, [&](TextCursor& cursor, std::string_view keyword) {
        if (keyword == "v") {
            Vec3d p;
            for (int i = 0; i < 3; ++i) p[i] = cursor.number(cursor.token_in_line());
            soup.positions.push_back(p);
        } else if (keyword == "f" || keyword == "fo") {
            std::size_t corners = 0;
            for (std::string_view t = cursor.token_in_line(); !t.empty(); t = cursor.token_in_line()) {
                soup.indices.push_back(corner(cursor, t, soup.positions.size()));
                ++corners;
            }
            if (corners < 3) cursor.fail_token({}, "a face with at least three corners");
            end_polygon(soup, limits);
        }
    });
    return soup;
}

}  // namespace sqmap::io
