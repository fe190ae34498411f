// How good a model is, against an exact oracle in double precision.
#pragma once

#include "sqmap/mesh/solid.h"
#include "sqmap/model/model.h"
#include "sqmap/model/model_data.h"
#include "sqmap/query/point.h"

#include <cstdint>
#include <vector>

namespace sqmap::bake {

/// Which points are compared with the truth, and by which layer.
struct EvaluateOptions {
    std::uint32_t points = 20000;
    std::uint64_t seed = 1;
    double near_band = 0.04;  ///< three quarters of the points lie within this share of R_max of the surface
    query::Layer layer = query::Layer::Three;
    double verdict_band = 0.005;  ///< verdicts nearer to the surface than this share of R_max are not judged
};

/// Distribution of an error; lengths in percent of R_max, angles in degrees.
struct Distribution {
    std::uint32_t count = 0;
    double mean = 0, median = 0, p95 = 0, p99 = 0, max = 0;
};

/// Errors of a model against its own mesh: verdicts, depths and normals.
struct Evaluation {
    std::uint32_t points = 0;
    std::uint32_t inside = 0;
    std::uint32_t missed = 0, false_contacts = 0;  ///< farther than verdict_band from the surface
    std::uint32_t missed_any = 0, false_any = 0;   ///< at any distance
    std::uint32_t certain = 0, certain_wrong = 0;  ///< answers called certain; wrong beyond 0.001 % of R_max
    std::uint32_t contradictions = 0;              ///< certain verdicts that layer 2 or 3 answers otherwise
    std::uint32_t layer1_missed = 0;               ///< points of the solid that layer 1 calls free
    Distribution eq35;                             ///< along the projection
    double eq35_left_out = 0;   ///< percent of the points inside a superquadric whose ray does not meet map and mesh both
    double eq35_one_sided = 0;  ///< percent of these points whose ray meets just one of the two: wrong, but without a length
    double no_surface = 0;      ///< percent of the true contacts below no surface of the maps (k_no_surface): no depth, no normal
    Distribution depth;         ///< against the true distance, over the other true contacts
    Distribution normal;        ///< against the direction of the true nearest point, over the same
    std::vector<Vec3d> worst;   ///< model space: the points of greatest depth error
};

/// The mesh in model space with every coordinate as the float runtime sees it: what maps and certificates are about. mesh: in
/// mesh units, not empty. Linear.
[[nodiscard]] mesh::Mesh model_space(const mesh::Mesh& mesh);

/// Measures a model on pseudo-random points: 3/4 near the surface, 1/4 in the bounding box. solid: of model_space of the mesh
/// that was baked. The same result for the same seed. @throw mesh::InvalidInput for a paper model, which paper::evaluate takes.
/// Cost: about 10 microseconds per point. Thread-safe.
[[nodiscard]] Evaluation evaluate(const model::ModelView& model, const mesh::Solid& solid, const EvaluateOptions& options);

/// Depth errors of the layers, measured as probes compute.
struct LayerErrors {
    std::uint32_t points = 0, missed = 0, false_contacts = 0;  ///< of layer 3, as in Evaluation
    Distribution depth[3];                                     ///< of layers 1 to 3, as Evaluation::depth
    Distribution normal;                                       ///< of layer 3, as Evaluation::normal
};
/// model, solid and points as for evaluate. Cost: one probe query per layer and the exact distances. Thread-safe.
[[nodiscard]] LayerErrors layer_errors(const model::ModelView& model, const mesh::Solid& solid, const EvaluateOptions& options);

/// Containment, checked afresh from the stored parameters.
struct Containment {
    std::uint32_t certified = 0;  ///< parts whose stored certificate says that patch and caps are held
    std::uint32_t outside =
        0;  ///< triangles with a corner, edge middle or centroid outside every part's superquadric or polytope
};
/// mesh: model_space of the mesh that was baked. Cost: grows with triangles times parts. Thread-safe.
[[nodiscard]] Containment check_containment(const model::ModelView& model, const mesh::Mesh& mesh);

/// The sample points alone, model space. mesh: in model space, not empty; r_max: its largest vertex distance.
[[nodiscard]] std::vector<Vec3d> sample_points(const mesh::Mesh& mesh, double r_max, const EvaluateOptions& options);

}  // namespace sqmap::bake
