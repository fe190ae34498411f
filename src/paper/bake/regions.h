// The share of a part's surface that its projection along the superquadric's normals can show (section 5), in double.
#pragma once

#include "sqmap/mesh/bvh.h"
#include "sqmap/mesh/mesh.h"
#include "sqmap/paper/model.h"
#include "sqmap/shape/superquadric.h"
#include "sqmap/shape/surface.h"

#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::paper {

/// Feet of points on one superquadric. A search and then Newton's method start at the nearest sample of each sector between
/// possible edges, as far as it may lie beside the nearest point.
class ExactFeet {
public:
    explicit ExactFeet(const shape::Superquadricd& superquadric);
    /// The nearest of the feet that are found. Cost: some 50 us.
    [[nodiscard]] shape::Foot<double> of(Vec3d p) const;
    [[nodiscard]] const shape::Superquadricd& superquadric() const { return superquadric_; }

private:
    [[nodiscard]] shape::Foot<double> foot_from(Vec3d p, std::size_t sample) const;

    shape::Superquadricd superquadric_;
    std::vector<Vec3d> points_;
    std::vector<shape::SurfaceAngles<double>> angles_;
    double cell_ = 0;  ///< the longest diagonal of a cell
};

/// A part's triangles in the mesh that may hide them.
struct PartSurface {
    const mesh::Bvh& bvh;
    const mesh::Mesh& mesh;
    std::span<const std::uint32_t> triangles;
};

/// True where the mesh crosses the segment from a surface point to its foot (point W of Fig. 5a), or no foot is found.
[[nodiscard]] bool is_hidden(const mesh::Bvh& bvh, const ExactFeet& feet, const shape::Foot<double>& foot);

/// The share of a part's area whose triangles' middles are hidden from their feet. At most max_samples triangles are looked at,
/// evenly in their order; 0: all.
[[nodiscard]] double hidden_from_feet(const PartSurface& part, const ExactFeet& feet, std::size_t max_samples = 0);

/// Gives the hidden triangles of a part Region::Q2, and returns their share of its area. labels: #triangles of the mesh.
double label_hidden(const PartSurface& part, const ExactFeet& feet, std::span<TriangleLabel> labels);
/// Gives Region::Q1 to every triangle that is concave at an edge by more than a degree, whatever the projection.
void label_concave(const mesh::Mesh& mesh, std::span<TriangleLabel> labels);

}  // namespace sqmap::paper
