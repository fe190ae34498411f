#include "sqmap/mesh/skin.h"

#include "sqmap/mesh/admission.h"

namespace sqmap::mesh {

std::vector<Vec3d> skinned(std::span<const Vec3d> vertices, const Influences& influences, std::span<const Affine> maps)
{
    std::vector<Vec3d> out(vertices.size());
    for (std::size_t v = 0; v < vertices.size(); ++v)
        for (std::size_t k = 0; k < 4; ++k) {
            const double weight = influences.weights[v][k];
            if (!(weight > 0)) continue;
            out[v] += weight * apply(maps[influences.joints[v][k]], vertices[v]);
        }
    return out;
}

std::optional<Mesh> joint_solid(const Mesh& mesh, const Influences& influences, std::uint16_t joint, double least_weight)
{
    std::vector<bool> moved(mesh.vertices.size());
    for (std::size_t v = 0; v < moved.size(); ++v) {
        double weight = 0;
        for (std::size_t k = 0; k < 4; ++k)
            if (influences.joints[v][k] == joint) weight += influences.weights[v][k];
        moved[v] = weight >= least_weight;
    }
    std::vector<std::int64_t> indices;
    std::vector<std::uint32_t> offsets{0};
    for (const Triangle& t : mesh.triangles) {
        if (!moved[t[0]] && !moved[t[1]] && !moved[t[2]]) continue;
        for (const std::uint32_t v : t) indices.push_back(v);
        offsets.push_back(static_cast<std::uint32_t>(indices.size()));
    }
    if (indices.empty()) return std::nullopt;
    const AdmitResult admitted =
        admit({mesh.vertices, offsets, indices}, {.repair = Repair::Close, .max_filled = 1, .refine_fillings = false});
    if (admitted.admission == Admission::Refused || !admitted.solid) return std::nullopt;
    return admitted.mesh;
}

}  // namespace sqmap::mesh
