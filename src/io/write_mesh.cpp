#include "sqmap/io/write_mesh.h"

#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <string>

namespace sqmap::io {

void write_mesh(const std::filesystem::path& path, std::span<const Vec3d> vertices,
                std::span<const std::array<std::uint32_t, 3>> triangles)
{
    const bool is_obj = path.extension() == ".obj";
    if (!is_obj && path.extension() != ".off") throw std::invalid_argument(path.string() + ": the ending must be .obj or .off");

    std::string text = is_obj ? "" : "OFF\n" + std::to_string(vertices.size()) + " " + std::to_string(triangles.size()) + " 0\n";
    char line[128];
    for (const Vec3d& v : vertices) {
        std::snprintf(line, sizeof line, "%s%.17g %.17g %.17g\n", is_obj ? "v " : "", v.x, v.y, v.z);
        text += line;
    }
    const unsigned base = is_obj ? 1 : 0;
    for (const auto& t : triangles) {
        std::snprintf(line, sizeof line, "%s %u %u %u\n", is_obj ? "f" : "3", t[0] + base, t[1] + base, t[2] + base);
        text += line;
    }

    const std::filesystem::path partial = path.string() + ".partial";
    std::ofstream file(partial, std::ios::binary);
    file.write(text.data(), static_cast<std::streamsize>(text.size()));
    file.close();
    std::error_code error;
    if (file) std::filesystem::rename(partial, path, error);
    if (!file || error) {
        std::filesystem::remove(partial, error);
        throw std::runtime_error(path.string() + ": cannot be written");
    }
}

}  // namespace sqmap::io
