// Polygon File Format (Turk, "The PLY Polygon File Format", 1994): text and binary of both byte orders. Positions,
// faces and triangle strips are kept; other elements and properties are walked over.
#include "parse.h"

#include <algorithm>
#include <array>
#include <bit>
#include <vector>

namespace sqmap::io {
namespace {

enum class Scalar { Int8, Uint8, Int16, Uint16, Int32, Uint32, Float32, Float64 };

struct Property {
    std::string name;
    Scalar type{};
    bool is_list = false;
    Scalar count_type{};
};

struct Element {
    std::string name;
    std::uint64_t count = 0;
    std::vector<Property> properties;
};

enum class Encoding { Text, Little, Big };

struct Header {
    Encoding encoding{};
    std::vector<Element> elements;
};

constexpr std::size_t bytes_of(Scalar s)
{
    constexpr std::array<std::size_t, 8> k_sizes{1, 1, 2, 2, 4, 4, 4, 8};
    return k_sizes[static_cast<std::size_t>(s)];
}

constexpr bool is_real(Scalar s) { return s == Scalar::Float32 || s == Scalar::Float64; }

Scalar scalar_type(TextCursor& cursor, std::string_view name)
{
    constexpr std::pair<std::string_view, Scalar> k_names[] = {
        {"char", Scalar::Int8},     {"int8", Scalar::Int8},       {"uchar", Scalar::Uint8},    {"uint8", Scalar::Uint8},
        {"short", Scalar::Int16},   {"int16", Scalar::Int16},     {"ushort", Scalar::Uint16},  {"uint16", Scalar::Uint16},
        {"int", Scalar::Int32},     {"int32", Scalar::Int32},     {"uint", Scalar::Uint32},    {"uint32", Scalar::Uint32},
        {"float", Scalar::Float32}, {"float32", Scalar::Float32}, {"double", Scalar::Float64}, {"float64", Scalar::Float64}};
    for (const auto& [known, type] : k_names)
        if (name == known) return type;
    cursor.fail_token(name, "a PLY type such as float or int");
}

/// Leaves the cursor at the start of the line after end_header.
Header read_header(TextCursor& cursor)
{
    if (cursor.token() != "ply") fail_format("line 1", "a PLY file starts with the line 'ply'");
    Header header;
    bool has_encoding = false;
    while (cursor.next_line()) {
        const std::string_view keyword = cursor.token_in_line();
        if (keyword.empty() || keyword == "comment" || keyword == "obj_info") continue;
        if (keyword == "format") {
            const std::string_view name = cursor.token_in_line();
            if (name == "ascii")
                header.encoding = Encoding::Text;
            else if (name == "binary_little_endian")
                header.encoding = Encoding::Little;
            else if (name == "binary_big_endian")
                header.encoding = Encoding::Big;
            else
                cursor.fail_token(name, "ascii, binary_little_endian or binary_big_endian");
            has_encoding = true;
        } else if (keyword == "element") {
            Element element;
            element.name = cursor.token_in_line();
            const std::int64_t count = cursor.integer(cursor.token_in_line());
            if (count < 0) fail_format(cursor.where(), "a negative number of elements");
            element.count = static_cast<std::uint64_t>(count);
            header.elements.push_back(std::move(element));
        } else if (keyword == "property") {
            if (header.elements.empty()) fail_format(cursor.where(), "a property before the first element");
            Property property;
            std::string_view type = cursor.token_in_line();
            if (type == "list") {
                property.is_list = true;
                property.count_type = scalar_type(cursor, cursor.token_in_line());
                type = cursor.token_in_line();
                if (is_real(property.count_type)) fail_format(cursor.where(), "a list counted in a real type");
            }
            property.type = scalar_type(cursor, type);
            property.name = cursor.token_in_line();
            header.elements.back().properties.push_back(std::move(property));
        } else if (keyword == "end_header") {
            if (!has_encoding) fail_format(cursor.where(), "no 'format' line in the header");
            if (!cursor.next_line()) cursor.skip_to_line_end();
            return header;
        } else {
            cursor.fail_token(keyword, "a PLY header line");
        }
    }
    fail_truncated("header", "no 'end_header' line");
}

/// Values of the body one after the other, whatever the encoding.
class BodyCursor {
public:
    BodyCursor(const TextCursor& text, const Header& header)
        : text_(text), bytes_(std::as_bytes(std::span(text.rest()))), encoding_(header.encoding)
    {
        if (encoding_ == Encoding::Text) has_lines_ = has_a_line_for_each(header.elements);
    }

    [[nodiscard]] std::uint64_t remaining() const
    {
        return encoding_ == Encoding::Text ? text_.remaining() : bytes_.size() - at_;
    }

    /// The least number of bytes that a value can take; in text with the blank that follows it.
    [[nodiscard]] std::uint64_t least_bytes(Scalar type) const { return encoding_ == Encoding::Text ? 2 : bytes_of(type); }

    /// Ends an element. A text's reader skips the rest of the line: some programs write more values there than their header
    /// declares.
    void end_element()
    {
        if (has_lines_) text_.skip_to_line_end();
    }

    double real(Scalar type)
    {
        if (encoding_ == Encoding::Text) return text_.number(text_.token());
        switch (type) {
            case Scalar::Float32:
                return raw<float>();
            case Scalar::Float64:
                return raw<double>();
            default:
                return static_cast<double>(integer(type));
        }
    }

    std::int64_t integer(Scalar type)
    {
        if (encoding_ == Encoding::Text) return text_.integer(text_.token());
        switch (type) {
            case Scalar::Int8:
                return raw<std::int8_t>();
            case Scalar::Uint8:
                return raw<std::uint8_t>();
            case Scalar::Int16:
                return raw<std::int16_t>();
            case Scalar::Uint16:
                return raw<std::uint16_t>();
            case Scalar::Int32:
                return raw<std::int32_t>();
            default:
                return raw<std::uint32_t>();
        }
    }

    void skip(Scalar type, std::uint64_t count)
    {
        if (encoding_ == Encoding::Text) {
            for (std::uint64_t i = 0; i < count; ++i)
                if (text_.token().empty()) text_.fail_token({}, "a value");
        } else {
            need(count * bytes_of(type));
            at_ += count * bytes_of(type);
        }
    }

private:
    /// True if the text has as many lines as elements, as it should. A text with fewer lines is read value by value.
    [[nodiscard]] bool has_a_line_for_each(const std::vector<Element>& elements) const
    {
        std::uint64_t lines = 0;
        TextCursor cursor = text_;
        do lines += cursor.token_in_line().empty() ? 0 : 1;
        while (cursor.next_line());
        for (const Element& element : elements) {
            if (element.count > lines) return false;
            lines -= element.count;
        }
        return true;
    }

    void need(std::uint64_t count) const
    {
        if (count > bytes_.size() - at_)
            fail_truncated("byte " + std::to_string(at_) + " of the body", "the file ends within an element");
    }

    template <class T>
    T raw()
    {
        need(sizeof(T));
        std::array<std::byte, sizeof(T)> copy;
        std::memcpy(copy.data(), bytes_.data() + at_, sizeof(T));
        at_ += sizeof(T);
        if ((encoding_ == Encoding::Little) != (std::endian::native == std::endian::little))
            std::reverse(copy.begin(), copy.end());
        T value;  // libc++ 13 has no std::bit_cast
        std::memcpy(&value, copy.data(), sizeof(T));
        return value;
    }

    TextCursor text_;
    std::span<const std::byte> bytes_;
    std::size_t at_ = 0;
    Encoding encoding_;
    bool has_lines_ = false;
};

/// Length of a list, checked against the bytes that are left.
std::uint64_t list_length(BodyCursor& body, const Property& property, const std::string& where)
{
    const std::int64_t length = body.integer(property.count_type);
    if (length < 0) fail_format(where, "a list of negative length");
    if (static_cast<std::uint64_t>(length) > (body.remaining() + 1) / body.least_bytes(property.type))
        fail_truncated(where,
                       "a list of " + std::to_string(length) + " values, " + std::to_string(body.remaining()) + " bytes follow");
    return static_cast<std::uint64_t>(length);
}

void check_counts(const Header& header, const BodyCursor& body, const ReadLimits& limits)
{
    std::uint64_t left = body.remaining() + 1;  // the last line end of a text may be missing
    for (const Element& element : header.elements) {
        std::uint64_t least = 0;
        for (const Property& p : element.properties) least += body.least_bytes(p.is_list ? p.count_type : p.type);
        if (element.count == 0) continue;
        if (least == 0) fail_format("header", "element '" + TextCursor::printable(element.name) + "' has no property");
        if (element.count > left / least)
            fail_truncated("header", std::to_string(element.count) + " of element '" + TextCursor::printable(element.name) +
                                         "' declared, " + std::to_string(body.remaining()) + " bytes follow");
        left -= element.count * least;
    }
    for (const Element& element : header.elements)
        if (element.name == "face") check_face_limit(element.count, limits);
}

void read_vertices(const Element& element, BodyCursor& body, PolygonSoup& soup)
{
    std::array<bool, 3> found{};
    constexpr std::string_view k_axes[] = {"x", "y", "z"};
    for (const Property& p : element.properties)
        for (std::size_t i = 0; i < 3; ++i) found[i] = found[i] || (p.name == k_axes[i] && !p.is_list);
    if (!(found[0] && found[1] && found[2])) fail_format("header", "element 'vertex' lacks x, y or z");
    soup.positions.reserve(element.count);
    for (std::uint64_t v = 0; v < element.count; ++v) {
        Vec3d point;
        for (const Property& p : element.properties) {
            const auto axis = std::find(std::begin(k_axes), std::end(k_axes), p.name);
            if (p.is_list)
                body.skip(p.type, list_length(body, p, "vertex " + std::to_string(v + 1)));
            else if (axis != std::end(k_axes))
                point[static_cast<int>(axis - std::begin(k_axes))] = body.real(p.type);
            else
                body.skip(p.type, 1);
        }
        body.end_element();
        soup.positions.push_back(point);
    }
}

void skip_elements(const Element& element, BodyCursor& body)
{
    const std::string name = TextCursor::printable(element.name) + " ";
    for (std::uint64_t e = 0; e < element.count; ++e) {
        for (const Property& p : element.properties)
            body.skip(p.type, p.is_list ? list_length(body, p, name + std::to_string(e + 1)) : 1);
        body.end_element();
    }
}

/// Walks over the elements; calls corners(list, length) at each element's list of vertex indices.
template <class Corners>
void for_each_list(const Element& element, BodyCursor& body, Corners corners)
{
    const auto list = std::find_if(element.properties.begin(), element.properties.end(), [](const Property& p) {
        return p.is_list && (p.name == "vertex_indices" || p.name == "vertex_index");
    });
    const std::string name = TextCursor::printable(element.name);
    if (list == element.properties.end()) fail_format("header", "element '" + name + "' has no list vertex_indices");
    if (is_real(list->type)) fail_format("header", "vertex_indices of a real type");
    for (std::uint64_t e = 0; e < element.count; ++e) {
        for (auto p = element.properties.begin(); p != element.properties.end(); ++p) {
            const std::uint64_t length = p->is_list ? list_length(body, *p, name + " " + std::to_string(e + 1)) : 1;
            if (p == list)
                corners(*list, length);
            else
                body.skip(p->type, length);
        }
        body.end_element();
    }
}

void read_faces(const Element& element, BodyCursor& body, const ReadLimits& limits, PolygonSoup& soup)
{
    soup.polygon_offsets.reserve(soup.polygon_offsets.size() + element.count);
    for_each_list(element, body, [&](const Property& list, std::uint64_t length) {
        for (std::uint64_t i = 0; i < length; ++i) soup.indices.push_back(body.integer(list.type));
        end_polygon(soup, limits);
    });
}

/// A strip's triangles share an edge each with the one before, so every second one lists its corners the other way round. A
/// negative index ends a strip within the list; a corner that repeats only steers it.
void read_strips(const Element& element, BodyCursor& body, const ReadLimits& limits, PolygonSoup& soup)
{
    for_each_list(element, body, [&](const Property& list, std::uint64_t length) {
        if (soup.indices.empty()) {  // for all lists at once: growing takes up to three times as much
            const std::uint64_t bound = std::min(body.remaining() / body.least_bytes(list.type) + 1, limits.max_faces);
            soup.indices.reserve(3 * bound);
            soup.polygon_offsets.reserve(bound + 1);
        }
        std::array<std::int64_t, 3> last{};
        for (std::uint64_t i = 0, run = 0; i < length; ++i) {
            last = {last[1], last[2], body.integer(list.type)};
            run = last[2] < 0 ? 0 : run + 1;
            if (run < 3 || last[0] == last[1] || last[1] == last[2] || last[2] == last[0]) continue;
            if (run % 2 == 0) std::swap(last[0], last[1]);
            soup.indices.insert(soup.indices.end(), last.begin(), last.end());
            if (run % 2 == 0) std::swap(last[0], last[1]);
            end_polygon(soup, limits);
        }
    });
}

}  // namespace

PolygonSoup read_ply(std::span<const std::byte> bytes, const ReadLimits& limits)
{
    TextCursor cursor(bytes);
    const Header header = read_header(cursor);
    BodyCursor body(cursor, header);
    check_counts(header, body, limits);
    PolygonSoup soup;
    for (const Element& element : header.elements) {
        if (element.name == "vertex" && soup.positions.empty())
            read_vertices(element, body, soup);
        else if (element.name == "face" && element.count > 0)
            read_faces(element, body, limits, soup);
        else if (element.name == "tristrips" && element.count > 0)
            read_strips(element, body, limits, soup);
        else
            skip_elements(element, body);
    }
    return soup;
}

}  // namespace sqmap::io
