// Object File Format as Geomview defines it, text form, with the optional colours and normals passed over.
#include "parse.h"

namespace sqmap::io {

PolygonSoup read_off(std::span<const std::byte> bytes, const ReadLimits& limits)
{
    TextCursor cursor(bytes, '#');
    std::string_view magic = cursor.token(), first;
    if (const std::size_t digits = magic.find_first_of("0123456789", 1); digits != std::string_view::npos) {
        first = magic.substr(digits);  // "OFF8 6 12"
        magic = magic.substr(0, digits);
    }
    for (const std::string_view prefix : {"ST", "C", "N"})
        if (magic.size() > 3 && magic.starts_with(prefix)) magic.remove_prefix(prefix.size());
    if (magic != "OFF") fail_format(cursor.where(), "an OFF file starts with OFF (also COFF, NOFF, STOFF), in three dimensions");

    if (first.empty()) first = cursor.token();
    if (first == "BINARY") fail_format(cursor.where(), "binary OFF is not read: write it as text");
    const std::int64_t vertex_count = cursor.integer(first);
    const std::int64_t face_count = cursor.integer(cursor.token());
    cursor.skip_to_line_end();  // the number of edges, which files often give wrong
    if (vertex_count < 0 || face_count < 0) fail_format(cursor.where(), "a negative number of vertices or faces");
    // At least 6 bytes a line ("0 0 0\n", "3 0 1 2\n"), the last line end may be missing. Divided, not multiplied: the
    // counts may be anything.
    const std::uint64_t lines = (cursor.remaining() + 1) / 6;
    const auto vertices = static_cast<std::uint64_t>(vertex_count), faces = static_cast<std::uint64_t>(face_count);
    if (vertices > lines || faces > lines - vertices)
        fail_truncated("header", std::to_string(vertices) + " vertices and " + std::to_string(faces) + " faces declared, " +
                                     std::to_string(cursor.remaining()) + " bytes follow");
    check_face_limit(faces, limits);

    PolygonSoup soup;
    soup.positions.reserve(vertices);
    for (std::uint64_t v = 0; v < vertices; ++v) {
        Vec3d p;
        for (int i = 0; i < 3; ++i) p[i] = cursor.number(cursor.token());
        soup.positions.push_back(p);
        cursor.skip_to_line_end();  // normals, colours, texture coordinates
    }
    soup.polygon_offsets.reserve(faces + 1);
    for (std::uint64_t f = 0; f < faces; ++f) {
        const std::int64_t degree = cursor.integer(cursor.token());
        if (degree < 0) fail_format(cursor.where(), "a face with a negative number of corners");
        if (static_cast<std::uint64_t>(degree) > (cursor.remaining() + 1) / 2)
            fail_truncated(cursor.where(), "a face of " + std::to_string(degree) + " corners, " +
                                               std::to_string(cursor.remaining()) + " bytes follow");
        for (std::int64_t i = 0; i < degree; ++i) soup.indices.push_back(cursor.integer(cursor.token()));
        end_polygon(soup, limits);
        cursor.skip_to_line_end();  // colours
    }
    return soup;
}

}  // namespace sqmap::io
