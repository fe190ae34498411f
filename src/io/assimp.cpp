// DAE, 3MF and FBX: Debian's program assimp makes a GLB file of them, in a process of its own and within limits. Its library is
// not linked, so that a broken file can only harm that process.
#include "parse.h"
#include "platform/child.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>

namespace sqmap::io {
namespace {

namespace fs = std::filesystem;

constexpr const char* k_cure = "open the mesh in a modelling program and save it as GLB, OBJ, PLY or STL";
constexpr const char *k_converted = "mesh.glb", *k_log = "log";

/// True for a file; follows links.
bool is_file(const fs::path& path)
{
    std::error_code ignored;
    return fs::is_regular_file(path, ignored);
}

std::string first_bytes(const fs::path& path, std::size_t count)
{
    std::string text(count, '\0');
    std::ifstream stream(path, std::ios::binary);
    stream.read(text.data(), static_cast<std::streamsize>(count));
    text.resize(static_cast<std::size_t>(stream.gcount()));
    return text;
}

/// The program's own error message.
std::string complaint(const fs::path& log)
{
    const std::string text = first_bytes(log, 1 << 16);
    std::size_t from = text.rfind("ERROR");
    if (from == std::string::npos) from = text.rfind('\n', text.size() - std::min<std::size_t>(text.size(), 2)) + 1;
    std::string line;
    for (const char c : text.substr(from, text.find('\n', from) - from).substr(0, 200)) line += c >= ' ' && c <= '~' ? c : '?';
    return line.empty() ? "it gave no reason" : line;
}

void check_result(const platform::ChildResult& result, const fs::path& folder, const platform::ChildLimits& limits)
{
    using platform::ChildEnd;
    const std::string seconds = std::to_string(limits.seconds) + " s";
    switch (result.how) {
        case ChildEnd::NotStarted:
            fail_limit("assimp", "no process can be started for it", "end other programs");
        case ChildEnd::TooLong:
            fail_limit("assimp", "it did not end within three times " + seconds, k_cure);
        case ChildEnd::TooMuchTime:
            fail_limit("assimp", "it took more than " + seconds + " of CPU time", k_cure);
        case ChildEnd::TooMuchFile:
            fail_limit("assimp", "it wrote more than " + std::to_string(limits.file) + " bytes", k_cure);
        case ChildEnd::Crashed:
            fail_format("assimp", "it crashed on this file (signal " + std::to_string(result.code) + ")");
        case ChildEnd::Exited:
            break;
    }
    if (result.code != 0 || !is_file(folder / k_converted))
        fail_format("assimp", "it cannot read this file: " + complaint(folder / k_log));
}

/// Refuses a file of another kind without starting a program.
void check_start(std::string_view text, MeshFormat format)
{
    const std::string_view start = text.substr(0, 4096);
    if (format == MeshFormat::Dae && start.find("<COLLADA") == std::string_view::npos)
        fail_format("byte 0", "a DAE file is XML that starts with <COLLADA>");
    if (format == MeshFormat::ThreeMf && !start.starts_with("PK\x03\x04"))
        fail_format("byte 0", "a 3MF file is a zip archive, which starts with PK");
    if (format == MeshFormat::Fbx && start.find("FBX") == std::string_view::npos)
        fail_format("byte 0", "an FBX file says so in its first line");
}

}  // namespace

PolygonSoup read_through_assimp(std::span<const std::byte> bytes, MeshFormat format, const ReadLimits& limits)
{
    check_start({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, format);
    const std::string program = platform::program_on_path("assimp");
    if (program.empty())
        throw ReadFailure{{"E_FORMAT", "file",
                           std::string(format_name(format)) + " is read through the program assimp, which is not installed",
                           std::string("install it (Debian: apt-get install assimp-utils), or ") + k_cure}};
    const platform::PrivateFolder folder;
    if (folder.path().empty())
        fail_limit("assimp", "no temporary folder can be made for it", "set TMPDIR to a folder that can be written");
    const std::string name = format == MeshFormat::Dae ? "mesh.dae" : format == MeshFormat::ThreeMf ? "mesh.3mf" : "mesh.fbx";
    std::ofstream input(folder.path() / name, std::ios::binary);
    input.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    input.close();
    if (!input) fail_limit("assimp", "its temporary folder is full", "set TMPDIR to a folder with more space");

    const std::uint64_t size = bytes.size();
    const platform::ChildLimits child{limits.max_seconds, (std::uint64_t{1} << 30) + 64 * size,
                                      std::min<std::uint64_t>(limits.max_bytes, (std::uint64_t{64} << 20) + 32 * size)};
    const char* path = std::getenv("PATH");
    // The program applies the nodes' transforms, which hold units and axes: a bound skin's own nodes would not move it.
    const auto result = platform::run({program,
                                       folder.path().string(),
                                       (folder.path() / k_log).string(),
                                       {"assimp", "export", name, k_converted, "-fglb2", "-ptv"},
                                       {std::string("PATH=") + (path != nullptr ? path : ""), "LC_ALL=C",
                                        "HOME=" + folder.path().string(), "TMPDIR=" + folder.path().string()},
                                       child});
    check_result(result, folder.path(), child);

    std::error_code ignored;
    const std::uintmax_t converted = fs::file_size(folder.path() / k_converted, ignored);
    check_byte_limit("assimp", ignored ? 0 : converted, limits);
    const std::string glb = first_bytes(folder.path() / k_converted, ignored ? 0 : converted);
    try {
        return read_gltf(std::as_bytes(std::span(glb)), {}, limits);
    } catch (ReadFailure& failure) {
        failure.error.element += " of what assimp made of it";
        throw;
    }
}

}  // namespace sqmap::io
