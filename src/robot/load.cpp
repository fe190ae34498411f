#include "sqmap/robot/rewrite.h"

#include "sqmap/io/read.h"
#include "sqmap/mesh/error.h"

#include <algorithm>
#include <fstream>
#include <functional>
#include <utility>

namespace sqmap::robot {
namespace {

namespace fs = std::filesystem;

/// True for a DAE file whose up axis is z. The reader turns such a file to y up; robots want it as it stands.
bool has_z_up(const fs::path& path)
{
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (extension != ".dae") return false;
    constexpr std::size_t k_head = 1 << 20;
    std::string head(k_head, '\0');
    std::ifstream file(path, std::ios::binary);
    file.read(head.data(), static_cast<std::streamsize>(k_head));
    head.resize(static_cast<std::size_t>(file.gcount()));
    return head.find("<up_axis>Z_UP</up_axis>") != std::string::npos;
}

/// Polygons turned round, for a scale that mirrors.
void reverse_polygons(io::PolygonSoup& soup)
{
    for (std::size_t i = 0; i + 1 < soup.polygon_offsets.size(); ++i)
        std::reverse(soup.indices.begin() + soup.polygon_offsets[i], soup.indices.begin() + soup.polygon_offsets[i + 1]);
}

/// Fans of the polygons. Convex shapes that hold the corners hold the polygons, whatever the fans. @pre each corner is there
mesh::Mesh fans_of(const io::PolygonSoup& soup)
{
    mesh::Mesh out{.vertices = soup.positions, .triangles = {}};
    const auto corner = [&](std::size_t i) { return static_cast<std::uint32_t>(soup.indices[i]); };
    for (std::size_t i = 0; i + 1 < soup.polygon_offsets.size(); ++i)
        for (std::size_t k = soup.polygon_offsets[i] + 1; k + 1 < soup.polygon_offsets[i + 1]; ++k)
            out.triangles.push_back({corner(soup.polygon_offsets[i]), corner(k), corner(k + 1)});
    return out;
}

/// True where admission found the corners of all polygons there and finite.
bool has_all_corners(const AdmittedMesh& mesh)
{
    return !mesh.refused() || (mesh.diagnosis.code != mesh::Refusal::Index && mesh.diagnosis.code != mesh::Refusal::NonFinite);
}

}  // namespace

LinkMesh load_mesh(const fs::path& path, const CollisionMesh& as, const MeshOptions& options)
{
    std::error_code ignored;
    if (!fs::is_regular_file(path, ignored))
        throw mesh::RefusedMesh(
            {mesh::Refusal::File, path.string(), io::k_no_file,
             mesh::Words("correct the name").with(", or give its package's folder: ", mesh::Setting::Packages, "NAME=DIR")});
    // Admission would scale its result alone, and after the pose: metres come first, for the soup too.
    MeshOptions in_metres = options;
    in_metres.admit.unit.reset();
    const Vec3d scale = options.admit.unit.value_or(1.) * as.scale;
    io::PolygonSoup soup;
    const std::function<void(io::PolygonSoup&)> move = [&, z_up = has_z_up(path)](io::PolygonSoup& read) {
        for (Vec3d& p : read.positions) {
            if (z_up) p = {p.x, -p.z, p.y};
            p = apply(as.pose, Vec3d{scale.x * p.x, scale.y * p.y, scale.z * p.z});
        }
        if (as.scale.x * as.scale.y * as.scale.z < 0) reverse_polygons(read);
        soup = read;
    };
    in_metres.as_read = &move;
    LinkMesh out{.soup = {}, .admitted = admit_mesh(path, in_metres)};
    if (has_all_corners(out.admitted)) out.soup = fans_of(soup);
    if (!out.soup.triangles.empty()) return out;
    mesh::Diagnosis& diagnosis = out.admitted.diagnosis;
    diagnosis.element = path.string() + (diagnosis.element.empty() ? "" : ", " + diagnosis.element);
    throw mesh::RefusedMesh(std::move(diagnosis));
}

}  // namespace sqmap::robot
