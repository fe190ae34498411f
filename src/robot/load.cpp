#include "sqmap/robot/rewrite.h"

#include "sqmap/io/read.h"
#include "sqmap/mesh/error.h"

#include <algorithm>
#include <fstream>
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

/// Fans of the polygons whose corners are there. Convex shapes that hold the corners hold the polygons, whatever the fans.
mesh::Mesh fans_of(const io::PolygonSoup& soup)
{
    mesh::Mesh out{.vertices = soup.positions, .triangles = {}};
    const auto is_corner = [&](std::int64_t i) { return i >= 0 && static_cast<std::size_t>(i) < soup.positions.size(); };
    for (std::size_t i = 0; i + 1 < soup.polygon_offsets.size(); ++i)
        for (std::size_t k = soup.polygon_offsets[i] + 1; k + 1 < soup.polygon_offsets[i + 1]; ++k) {
            const std::int64_t a = soup.indices[soup.polygon_offsets[i]], b = soup.indices[k], c = soup.indices[k + 1];
            if (is_corner(a) && is_corner(b) && is_corner(c))
                out.triangles.push_back(
                    {static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b), static_cast<std::uint32_t>(c)});
        }
    return out;
}

}  // namespace

LinkMesh load_mesh(const fs::path& path, const CollisionMesh& as, const MeshOptions& options)
{
    const auto refuse = [&](mesh::Refusal code, const std::string& message, mesh::Words cure) {
        throw mesh::RefusedMesh({code, path.string(), message, std::move(cure)});
    };
    std::error_code ignored;
    if (!fs::is_regular_file(path, ignored))
        refuse(mesh::Refusal::Format, "there is no such file",
               mesh::Words("correct the name").with(", or give its package's folder: ", mesh::Setting::Packages, "NAME=DIR"));
    io::ReadResult read = io::read_mesh_file(path, options.limits);
    if (read.error) {  // the front door has its code and its cure
        mesh::Diagnosis diagnosis = admit_mesh(path, options).diagnosis;
        diagnosis.element = path.string() + (diagnosis.element.empty() ? "" : ", " + diagnosis.element);
        throw mesh::RefusedMesh(std::move(diagnosis));
    }
    io::PolygonSoup& soup = read.soup;
    const bool z_up = has_z_up(path);
    // Admission would scale its result alone, and after the pose: metres come first, for the soup too.
    MeshOptions in_metres = options;
    in_metres.admit.unit.reset();
    const Vec3d scale = options.admit.unit.value_or(1.) * as.scale;
    for (Vec3d& p : soup.positions) {
        if (z_up) p = {p.x, -p.z, p.y};
        p = apply(as.pose, Vec3d{scale.x * p.x, scale.y * p.y, scale.z * p.z});
        if (!is_finite(p)) refuse(mesh::Refusal::NonFinite, "a coordinate is not finite", "repair the file");
    }
    if (as.scale.x * as.scale.y * as.scale.z < 0) reverse_polygons(soup);
    LinkMesh out{.soup = fans_of(soup), .admitted = {}};
    if (out.soup.triangles.empty()) refuse(mesh::Refusal::Empty, "it has no faces", "export the mesh again");
    out.admitted = admit_mesh(mesh::PolygonView{soup.positions, soup.polygon_offsets, soup.indices}, in_metres);
    return out;
}

}  // namespace sqmap::robot
