#include "setting.h"

#include "error.h"
#include "sqmap/bake_mesh.h"

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
        AdmittedMesh mesh = admit_mesh(path, {.admit = {.repair = mesh::Repair::Safe, .accept_surface = surface}});
        const mesh::Diagnosis& d = mesh.diagnosis;
        if (mesh.refused())
            throw BenchError(path.string() + ": " + mesh::name_of(d.code) + " at " + d.element + ": " + d.message +
                             "\n  cure: " + d.cure.text());
        return mesh;
    };
    AdmittedMesh object = load(files.object, false);
    return std::make_unique<Setting>(std::move(object.mesh), load(files.probe, true).mesh, std::move(object.crossed));
}

}  // namespace sqmap::bench
