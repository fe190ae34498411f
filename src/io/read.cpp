#include "sqmap/io/read.h"

#include "files.h"
#include "parse.h"
#include "platform/child.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>
#include <new>
#include <vector>

namespace sqmap::io {
namespace {

std::string_view text_of(std::span<const std::byte> bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

/// The format that the first bytes leave no doubt about.
std::optional<MeshFormat> format_of_content(std::span<const std::byte> bytes)
{
    std::string_view text = text_of(bytes);
    if (text.starts_with("glTF")) return MeshFormat::Glb;
    text.remove_prefix(std::min(text.substr(0, 4096).find_first_not_of(" \t\r\n"), text.size()));
    if (text.starts_with("ply\n") || text.starts_with("ply\r")) return MeshFormat::Ply;
    const std::string_view start = text.substr(0, 16);
    const std::size_t off = start.find("OFF");
    if (off != std::string_view::npos && start.substr(0, off).find_first_not_of("STCN") == std::string_view::npos)
        return MeshFormat::Off;
    return std::nullopt;
}

bool is_binary_stl_size(std::span<const std::byte> bytes)
{
    std::uint32_t count = 0;
    if (bytes.size() >= 84) std::memcpy(&count, bytes.data() + 80, sizeof count);
    return bytes.size() == 84 + std::uint64_t{50} * count;
}

/// Weaker signs, for a file whose name says nothing.
std::optional<MeshFormat> guessed_format(std::span<const std::byte> bytes)
{
    if (const auto format = format_of_content(bytes)) return format;
    const std::string_view text = text_of(bytes);
    if (text.starts_with("solid")) return MeshFormat::Stl;
    if (is_binary_stl_size(bytes)) return MeshFormat::Stl;
    const std::string_view start = text.substr(0, 4096);
    const std::size_t first = start.find_first_not_of(" \t\r\n");
    if (first != std::string_view::npos && start[first] == '{') return MeshFormat::Gltf;
    if (start.find("<COLLADA") != std::string_view::npos) return MeshFormat::Dae;
    if (start.starts_with("Kaydara FBX Binary") || start.starts_with("; FBX")) return MeshFormat::Fbx;
    if (start.starts_with("PK\x03\x04")) return MeshFormat::ThreeMf;
    if (start.starts_with("v ") || start.find("\nv ") != std::string_view::npos) return MeshFormat::Obj;
    return std::nullopt;
}

/// Without the byte-order mark that some editors put before text in UTF-8. A binary STL file may begin with any bytes.
std::span<const std::byte> after_byte_order_mark(std::span<const std::byte> bytes)
{
    if (!text_of(bytes).starts_with("\xEF\xBB\xBF") || is_binary_stl_size(bytes)) return bytes;
    return bytes.subspan(3);
}

ReadResult read_bytes(std::span<const std::byte> bytes, std::optional<MeshFormat> format, const std::filesystem::path& folder,
                      const ReadLimits& limits)
{
    ReadResult result;
    result.format = format;
    try {
        if (bytes.empty()) fail_format("byte 0", "the file is empty");
        check_byte_limit("file", bytes.size(), limits);
        bytes = after_byte_order_mark(bytes);
        const auto content = format_of_content(bytes);
        if (!format) result.format = format = guessed_format(bytes);
        if (!format) fail_format("byte 0", "neither name nor content is that of OFF, OBJ, STL, PLY, glTF, GLB, DAE, 3MF or FBX");
        if (content && *content != *format)
            fail_format("byte 0",
                        std::string("the content is ") + format_name(*content) + ", the name says " + format_name(*format));
        switch (*format) {
            case MeshFormat::Off:
                result.soup = read_off(bytes, limits);
                break;
            case MeshFormat::Obj:
                result.soup = read_obj(bytes, limits);
                break;
            case MeshFormat::Stl:
                result.soup = read_stl(bytes, limits);
                break;
            case MeshFormat::Ply:
                result.soup = read_ply(bytes, limits);
                break;
            case MeshFormat::Gltf:
            case MeshFormat::Glb:
                result.soup = read_gltf(bytes, folder, limits);
                break;
            case MeshFormat::Dae:
            case MeshFormat::ThreeMf:
            case MeshFormat::Fbx:
                result.soup = read_through_assimp(bytes, *format, limits);
                break;
        }
    } catch (ReadFailure& failure) {
        result.error = std::move(failure.error);
    } catch (const std::bad_alloc&) {
        result.error = ReadError{"E_LIMIT", "file", "not enough memory", "reduce the mesh", {}};
    }
    return result;
}

}  // namespace

std::optional<MeshFormat> format_of_name(const std::filesystem::path& path)
{
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
    static constexpr const char* k_extensions[] = {".off", ".obj", ".stl", ".ply", ".gltf", ".glb", ".dae", ".3mf", ".fbx"};
    const auto found = std::find(std::begin(k_extensions), std::end(k_extensions), extension);
    if (found == std::end(k_extensions)) return std::nullopt;
    return static_cast<MeshFormat>(found - std::begin(k_extensions));
}

const char* format_name(MeshFormat format)
{
    static constexpr const char* k_names[] = {"OFF", "OBJ", "STL", "PLY", "glTF", "GLB", "DAE", "3MF", "FBX"};
    static_assert(std::size(k_names) == static_cast<std::size_t>(MeshFormat::Fbx) + 1, "in the order of the enumeration");
    const auto i = static_cast<std::size_t>(format);
    return i < std::size(k_names) ? k_names[i] : "?";
}

ReadResult read_mesh_bytes(std::span<const std::byte> bytes, const std::filesystem::path& name, const ReadLimits& limits)
{
    if (const auto format = format_of_name(name); format && (*format <= MeshFormat::Glb || platform::k_starts_programs))
        return read_bytes(bytes, format, {}, limits);
    ReadResult result;
    result.error =
        ReadError{"E_FORMAT",
                  "name",
                  platform::k_starts_programs ? "the name does not end in .off, .obj, .stl, .ply, .gltf, .glb, .dae, .3mf or .fbx"
                                              : "the name does not end in .off, .obj, .stl, .ply, .gltf or .glb",
                  "save the mesh in one of these formats",
                  {}};
    return result;
}

ReadResult read_mesh_bytes(std::span<const std::byte> bytes, MeshFormat format, const ReadLimits& limits)
{
    return read_bytes(bytes, format, {}, limits);
}

ReadResult read_mesh_file(const std::filesystem::path& path, const ReadLimits& limits)
{
    ReadResult result;
    result.format = format_of_name(path);
    std::error_code status;
    // A pipe or a device has no size to check against.
    const bool regular = std::filesystem::is_regular_file(path, status);
    const std::uintmax_t size = regular ? std::filesystem::file_size(path, status) : 0;
    if (!regular || status) {
        const bool is_there = std::filesystem::exists(path, status);
        result.error = is_there ? ReadError{"E_FILE",
                                            path.string(),
                                            "this is no file but a folder, pipe or device",
                                            "give the path of one mesh; sqmap batch takes folders",
                                            {}}
                                : ReadError{"E_FILE", path.string(), k_no_file, k_no_file_cure, {}};
        return result;
    }
    try {
        check_byte_limit("file", size, limits);
        std::vector<std::byte> bytes(size);
        std::ifstream stream(path, std::ios::binary);
        stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
        if (!stream && size > 0) {
            result.error = ReadError{"E_FILE", path.string(), "the file cannot be read", "check its permissions", {}};
            return result;
        }
        return read_bytes(bytes, result.format, path.has_parent_path() ? path.parent_path() : ".", limits);
    } catch (ReadFailure& failure) {
        result.error = std::move(failure.error);
    } catch (const std::bad_alloc&) {
        result.error = ReadError{"E_LIMIT", "file", "not enough memory", "reduce the mesh", {}};
    }
    return result;
}

}  // namespace sqmap::io
