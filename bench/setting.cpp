#include "setting.h"

#include "error.h"
#include "sqmap/io/read.h"
#include "sqmap/mesh/admit.h"

#include <algorithm>
#include <utility>

namespace sqmap::bench {

mesh::Mesh centred(mesh::Mesh mesh, double diagonal)
{
    const Box box = box_of(mesh.vertices);
    const double scale = diagonal / norm(size(box));
    for (Vec3d& v : mesh.vertices) v = scale * (v - centre(box));
    return mesh;
}

Setting::Setting(mesh::Mesh object_mesh, mesh::Mesh probe_mesh, std::vector<std::uint8_t> crossed)
    : object(centred(std::move(object_mesh), k_object_diagonal)),
      probe(centred(std::move(probe_mesh), k_probe_diagonal)),
      solid(object, crossed),
      r_max(mesh::largest_vertex_distance(object))
{
}

std::unique_ptr<Setting> load_setting(const Files& files)
{
    const auto load = [](const std::filesystem::path& path, bool surface) {
        const auto refuse = [&](const std::string& code, const auto& why) {
            throw BenchError(path.string() + ": " + code + " at " + why.element + ": " + why.message + "\n  cure: " + why.cure);
        };
        const io::ReadResult read = io::read_mesh_file(path);
        if (read.error) refuse(read.error->code, *read.error);
        mesh::AdmitResult gate = mesh::admit({read.soup.positions, read.soup.polygon_offsets, read.soup.indices},
                                             {.repair = mesh::Repair::Safe, .accept_surface = surface});
        if (gate.admission == mesh::Admission::Refused) refuse(mesh::name_of(gate.diagnosis.code), gate.diagnosis);
        return gate;
    };
    mesh::AdmitResult object = load(files.object, false);
    return std::make_unique<Setting>(std::move(object.mesh), load(files.probe, true).mesh, std::move(object.crossed));
}

}  // namespace sqmap::bench
