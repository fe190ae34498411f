#include "gltf_file.h"

#include "sqmap/io/read.h"
#include "sqmap/math/rotation.h"

#include <algorithm>
#include <bit>
#include <fstream>
#include <utility>

namespace sqmap::io {
namespace {

static_assert(std::endian::native == std::endian::little, "glTF buffers are read in place");

constexpr std::uint32_t k_magic = 0x46546C67, k_chunk_json = 0x4E4F534A, k_chunk_binary = 0x004E4942;

template <std::size_t N>
std::array<double, N> reals(const json& object, const char* key, const std::string& where, const std::array<double, N>& fallback)
{
    const auto found = object.find(key);
    if (found == object.end()) return fallback;
    if (!found->is_array() || found->size() != N)
        fail_format(where, std::string("'") + key + "' is not " + std::to_string(N) + " numbers");
    std::array<double, N> out{};
    for (std::size_t i = 0; i < N; ++i) {
        if (!(*found)[i].is_number()) fail_format(where, std::string("'") + key + "' is not " + std::to_string(N) + " numbers");
        out[i] = (*found)[i].template get<double>();
    }
    return out;
}

std::vector<std::byte> decoded_base64(std::string_view text, const std::string& where)
{
    std::vector<std::byte> out;
    out.reserve(text.size() / 4 * 3);
    std::uint32_t bits = 0;
    int bit_count = 0;
    for (char c : text) {
        if (c == '=') break;
        constexpr std::string_view k_alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        const std::size_t value = k_alphabet.find(c);
        if (value == std::string_view::npos) fail_format(where, "the data URI is not base64");
        bits = (bits << 6) | static_cast<std::uint32_t>(value);
        if ((bit_count += 6) >= 8) out.push_back(static_cast<std::byte>(bits >> (bit_count -= 8)));
    }
    return out;
}

/// The file beside the glTF file; only plain relative names, so that a file can make us read nothing else.
std::filesystem::path path_beside(const std::filesystem::path& folder, const std::string& uri, const std::string& where)
{
    std::string name;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        unsigned code = 0;
        if (uri[i] == '%' && i + 2 < uri.size() && std::from_chars(&uri[i + 1], &uri[i + 3], code, 16).ptr == &uri[i + 3]) {
            name += static_cast<char>(code);
            i += 2;
        } else {
            name += uri[i];
        }
    }
    const std::filesystem::path relative(name);
    const bool climbs = std::find(relative.begin(), relative.end(), "..") != relative.end();
    if (name.empty() || name.find('\0') != std::string::npos || relative.is_absolute() || climbs ||
        name.find("://") != std::string::npos)
        fail_format(where, "the buffer's uri is not a file beside this one");
    std::error_code status;
    const std::filesystem::path path = folder / relative;
    if (folder.empty() || !std::filesystem::is_regular_file(path, status))
        fail_truncated(where, "its file '" + TextCursor::printable(name) + "' is not there");
    return path;
}

std::vector<std::byte> read_beside(const std::filesystem::path& folder, const std::string& uri, const std::string& where,
                                   const ReadLimits& limits)
{
    const std::filesystem::path path = path_beside(folder, uri, where);
    std::error_code status;
    const std::uintmax_t size = std::filesystem::file_size(path, status);
    if (status) fail_truncated(where, "its file cannot be read");
    check_byte_limit(where, size, limits);
    std::vector<std::byte> bytes(size);
    std::ifstream stream(path, std::ios::binary);
    stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
    if (!stream && size > 0) fail_truncated(where, "its file cannot be read");
    return bytes;
}

std::uint32_t word(std::span<const std::byte> bytes, std::size_t at)
{
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

/// Start of the next chunk: at a multiple of four, or at once if a file without padding has its binary chunk there.
std::size_t next_chunk(std::span<const std::byte> bytes, std::size_t end)
{
    const std::size_t padded = (end + 3) / 4 * 4;
    const auto is_binary = [&](std::size_t at) { return at + 8 <= bytes.size() && word(bytes, at + 4) == k_chunk_binary; };
    return is_binary(end) && !is_binary(padded) ? end : padded;
}

/// The JSON chunk of a GLB file, and its binary chunk if there is one; for any other file all bytes.
std::span<const std::byte> text_of(std::span<const std::byte> bytes, std::span<const std::byte>& binary)
{
    std::span<const std::byte> text = bytes;
    if (bytes.size() >= 4 && word(bytes, 0) == k_magic) {
        if (bytes.size() < 20) fail_truncated("header", std::to_string(bytes.size()) + " bytes; a GLB header has 20");
        if (word(bytes, 4) != 2) fail_format("byte 4", "GLB version " + std::to_string(word(bytes, 4)) + "; version 2 is read");
        const std::size_t length = word(bytes, 8);
        if (length > bytes.size())
            fail_truncated("byte 8", std::to_string(length) + " bytes declared, the file has " + std::to_string(bytes.size()));
        bool is_first = true;
        for (std::size_t at = 12; at + 8 <= length;) {
            const std::size_t chunk = word(bytes, at);
            const std::uint32_t type = word(bytes, at + 4);
            if (chunk > length - at - 8)
                fail_truncated("byte " + std::to_string(at),
                               "a chunk of " + std::to_string(chunk) + " bytes reaches beyond the file");
            if (is_first) {
                if (type != k_chunk_json) fail_format("byte 16", "the first chunk is not JSON");
                text = bytes.subspan(at + 8, chunk);
            } else if (type == k_chunk_binary && binary.empty()) {
                binary = bytes.subspan(at + 8, chunk);
            }
            is_first = false;
            at = next_chunk(bytes.first(length), at + 8 + chunk);
        }
        if (is_first) fail_format("byte 12", "no JSON chunk");
    }
    return text;
}

json parsed(std::span<const std::byte> text)
{
    const char* begin = reinterpret_cast<const char*>(text.data());
    json root = json::parse(begin, begin + text.size(), nullptr, false);
    if (root.is_discarded()) {
        // A file that was cut short has no closing brace; anything else is not JSON.
        std::size_t last = text.size();
        while (last > 0 && (begin[last - 1] <= ' ' && begin[last - 1] >= '\0')) --last;
        const std::size_t first = std::string_view(begin, last).find_first_not_of(" \t\r\n");
        if (first != std::string_view::npos && begin[first] == '{' && begin[last - 1] != '}')
            fail_truncated("JSON", "it ends before its closing brace");
        fail_format("JSON", "the text is not JSON");
    }
    if (!root.is_object()) fail_format("JSON", "a glTF file is one JSON object");
    const auto asset = root.find("asset");
    if (asset == root.end() || !asset->is_object() || !asset->contains("version") || !(*asset)["version"].is_string() ||
        !(*asset)["version"].get_ref<const std::string&>().starts_with("2"))
        fail_format("asset", "a glTF file of version 2 says so in asset.version");
    return root;
}

}  // namespace

std::string name_of(const char* array, std::uint64_t index) { return std::string(array) + " " + std::to_string(index); }

/// Element index of one of the file's top-level arrays.
const json& item(const json& root, const char* array, std::uint64_t index)
{
    const auto found = root.find(array);
    if (found == root.end() || !found->is_array() || index >= found->size() || !(*found)[index].is_object())
        fail_format(name_of(array, index), "the file has no such object");
    return (*found)[index];
}

/// A whole number that is not negative; fallback where the key is missing.
std::uint64_t whole(const json& object, const char* key, const std::string& where, std::optional<std::uint64_t> fallback)
{
    const auto found = object.find(key);
    if (found == object.end()) {
        if (fallback) return *fallback;
        fail_format(where, std::string("'") + key + "' is missing");
    }
    if (!found->is_number_unsigned()) fail_format(where, std::string("'") + key + "' is not a whole number");
    return found->get<std::uint64_t>();
}

const json* array_or_null(const json& object, const char* key, const std::string& where)
{
    const auto found = object.find(key);
    if (found == object.end()) return nullptr;
    if (!found->is_array()) fail_format(where, std::string("'") + key + "' is not an array");
    return &*found;
}

JointPose pose_of(const json& node, const std::string& where)
{
    const auto t = reals<3>(node, "translation", where, {0, 0, 0});
    const auto s = reals<3>(node, "scale", where, {1, 1, 1});
    return {{t[0], t[1], t[2]}, reals<4>(node, "rotation", where, {0, 0, 0, 1}), {s[0], s[1], s[2]}};
}

Affine affine_of(const JointPose& pose)
{
    const auto [x, y, z, w] = pose.rotation;
    const Mat3d scale{{{pose.scale.x, 0, 0}, {0, pose.scale.y, 0}, {0, 0, pose.scale.z}}};
    return {rotation_of(w, x, y, z) * scale, pose.translation};
}

Affine affine_of(const json& node, const std::string& where)
{
    if (node.contains("matrix")) {
        const auto m = reals<16>(node, "matrix", where, {});  // columns first
        return {{{{m[0], m[4], m[8]}, {m[1], m[5], m[9]}, {m[2], m[6], m[10]}}}, {m[12], m[13], m[14]}};
    }
    return affine_of(pose_of(node, where));
}

GltfFile::GltfFile(std::span<const std::byte> bytes, std::filesystem::path folder, const ReadLimits& limits)
    : folder_(std::move(folder)), limits_(limits), budget_((std::uint64_t{32} << 20) + 32 * bytes.size())
{
    root_ = parsed(text_of(bytes, binary_));
    if (const json* buffers = array_or_null(root_, "buffers", "buffers")) buffers_.resize(buffers->size());
}

void GltfFile::spend(std::uint64_t bytes, const std::string& where, const char* what, const char* cure)
{
    if (bytes > budget_) fail_limit(where, what, cure);
    budget_ -= bytes;
}

std::span<const std::byte> GltfFile::buffer(std::uint64_t index)
{
    const std::string where = name_of("buffer", index);
    const json& description = item(root_, "buffers", index);
    const std::uint64_t length = whole(description, "byteLength", where);
    auto& loaded = buffers_[index];
    if (!loaded.has_value()) {
        const auto uri = description.find("uri");
        if (uri == description.end()) {
            loaded = Buffer{{}, index == 0 ? binary_ : std::span<const std::byte>{}};
        } else {
            if (!uri->is_string()) fail_format(where, "'uri' is not text");
            const std::string& text = uri->get_ref<const std::string&>();
            if (text.starts_with("data:")) {
                const std::size_t comma = text.find(";base64,");
                if (comma == std::string::npos) fail_format(where, "the data URI is not base64");
                loaded = Buffer{decoded_base64(std::string_view(text).substr(comma + 8), where), {}};
            } else {
                loaded = Buffer{read_beside(folder_, text, where, limits_), {}};
            }
            loaded->bytes = loaded->owned;
        }
    }
    if (length > loaded->bytes.size())
        fail_truncated(where, std::to_string(length) + " bytes declared, " + std::to_string(loaded->bytes.size()) + " are there");
    return loaded->bytes.first(length);
}

Accessor GltfFile::accessor(std::uint64_t index)
{
    const std::string where = name_of("accessor", index);
    const json& a = item(root_, "accessors", index);
    if (a.contains("sparse") || !a.contains("bufferView"))
        fail_format(where, "sparse accessors are not read: export without them");
    Accessor out;
    out.component = whole(a, "componentType", where);
    const auto type = a.find("type");
    if (type == a.end() || !type->is_string()) fail_format(where, "'type' is missing");
    out.type = type->get<std::string>();
    out.is_normalized = a.contains("normalized") && a["normalized"].is_boolean() && a["normalized"].get<bool>();
    const std::uint64_t components = out.type == "SCALAR" ? 1
                                     : out.type == "VEC3" ? 3
                                     : out.type == "VEC4" ? 4
                                     : out.type == "MAT4" ? 16
                                                          : 0;
    const std::uint64_t size = out.component == 5120 || out.component == 5121   ? 1
                               : out.component == 5122 || out.component == 5123 ? 2
                               : out.component == 5125 || out.component == 5126 ? 4
                                                                                : 0;
    if (components == 0 || size == 0) fail_format(where, "not of a kind that is read");
    const std::uint64_t element_bytes = components * size;
    const std::uint64_t view_index = whole(a, "bufferView", where);
    const json& view = item(root_, "bufferViews", view_index);
    const std::string view_where = name_of("bufferView", view_index);
    std::span<const std::byte> bytes = buffer(whole(view, "buffer", view_where));
    const std::uint64_t view_offset = whole(view, "byteOffset", view_where, 0),
                        view_length = whole(view, "byteLength", view_where);
    if (view_offset > bytes.size() || view_length > bytes.size() - view_offset)
        fail_truncated(view_where, "it reaches beyond its buffer of " + std::to_string(bytes.size()) + " bytes");
    bytes = bytes.subspan(view_offset, view_length);
    const std::uint64_t offset = whole(a, "byteOffset", where, 0), count = whole(a, "count", where);
    const std::uint64_t stride = whole(view, "byteStride", view_where, element_bytes);
    if (stride < element_bytes) fail_format(view_where, "byteStride is smaller than an element");
    if (count > 0 && (offset > bytes.size() || element_bytes > bytes.size() - offset ||
                      count - 1 > (bytes.size() - offset - element_bytes) / stride))
        fail_truncated(where, std::to_string(count) + " elements reach beyond the buffer view of " +
                                  std::to_string(bytes.size()) + " bytes");
    if (count > 0) out.bytes = bytes.subspan(offset);
    out.count = count;
    out.stride = stride;
    return out;
}

std::vector<std::filesystem::path> buffers_beside(std::span<const std::byte> gltf, const std::filesystem::path& folder)
{
    std::vector<std::filesystem::path> out;
    try {
        std::span<const std::byte> binary;
        const json root = parsed(text_of(gltf, binary));
        const json* const buffers = array_or_null(root, "buffers", "buffers");
        for (std::size_t i = 0; buffers != nullptr && i < buffers->size(); ++i) {
            const json& uri = (*buffers)[i].is_object() ? (*buffers)[i].value("uri", json()) : json();
            if (uri.is_string() && !uri.get_ref<const std::string&>().starts_with("data:"))
                out.push_back(path_beside(folder, uri.get<std::string>(), name_of("buffer", i)));
        }
    } catch (const ReadFailure&) {
        // The reader stops at the same point and reports it.
    }
    return out;
}

}  // namespace sqmap::io
