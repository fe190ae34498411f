// A mesh as something to touch: 0.3 m large, with its model, its exact solid and both reference forces.
#pragma once

#include "sqmap/haptic/step.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/model/model.h"
#include "sqmap/paper/bake.h"
#include "sqmap/paper/model_file.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <vector>

namespace sqmap::bench {

inline constexpr double k_object_size = 0.3;  ///< R_max, m

class TouchObject {
public:
    /// Which models of it are baked.
    enum class Models { Central, Paper, Both };
    /// Reads, scales and bakes. @throw BenchError where the mesh is refused
    explicit TouchObject(const std::filesystem::path& file, Models models = Models::Central, const paper::MapOptions& maps = {});
    TouchObject(const TouchObject&) = delete;
    TouchObject& operator=(const TouchObject&) = delete;

    /// The exact nearest triangle: distance from the surface, negative inside, its face normal, and the normal that force
    /// shading (Ruspini, Kolarov, Khatib 1997) interpolates from its vertices.
    struct Exact {
        double distance = 0;
        Vec3d face_normal{}, shaded_normal{}, point{};
        std::uint32_t triangle = 0;
    };
    [[nodiscard]] Exact exact(Vec3d p) const;
    /// The greatest turn of any edge within `reach` of p is at least 45 degrees.
    [[nodiscard]] bool near_sharp_edge(Vec3d p, double reach) const;

    mesh::Mesh mesh;  ///< m
    std::vector<Vec3d> face_normals, vertex_normals;
    std::unique_ptr<mesh::Solid> solid;
    model::ModelView central, paper;  ///< m; of those that are baked

private:
    mesh::Mesh sharp_;  ///< slivers along the edges that turn by 45 degrees or more
    std::unique_ptr<mesh::Bvh> sharp_bvh_;
    struct Opened {
        std::vector<std::byte> bytes;
        paper::AnyModel model;
    };
    Opened central_, paper_;
};

/// Positions of a point that slides along the outline of a plane section, 0.1 mm a step, `depth` below the surface along a
/// normal that is smoothed over 3 mm: a hand does not follow facets. Centimetres and more away from nothing: one closed way.
[[nodiscard]] std::vector<Vec3d> slide_path(const TouchObject& object, Vec3d plane_normal, double plane_offset, double depth);

}  // namespace sqmap::bench
