// Cuts: the shortest concave one near a locale, the moment-ellipsoid volume that ranks cuts, and the cuts as printed.
#pragma once

#include "geodesic.h"
#include "sqmap/decompose/decompose.h"
#include "sqmap/mesh/mesh.h"

#include <numeric>
#include <span>
#include <vector>

namespace sqmap::decompose {

/// Data of the mesh that every cut needs, computed once.
struct CutSurface {
    explicit CutSurface(const mesh::Mesh& m);
    /// A part of a surface. m: its triangles, see PartSurface.
    CutSurface(const mesh::Mesh& m, const CutSurface& whole, std::span<const std::uint32_t> triangles);
    [[nodiscard]] double area_of(std::span<const std::uint32_t> triangles) const
    {
        return std::accumulate(triangles.begin(), triangles.end(), 0.0,
                               [&](double sum, std::uint32_t t) { return sum + area[t]; });
    }

    const mesh::Mesh& mesh;
    mesh::DualGraph graph;
    std::vector<double> area;
    double total_area = 0;
    /// Length and concave bending (angle over distance, 1 / mesh units, >= 0) of the edge e of each triangle.
    std::vector<std::array<double, 3>> edge_length, edge_concavity;
};

/// A part as a surface of its own, its triangles and vertices in the order of the whole: cuts and borders inside the part are the
/// same, and cost what the part's size costs, not the whole's.
class PartSurface {
public:
    /// triangles: in increasing order.
    PartSurface(const CutSurface& whole, std::span<const std::uint32_t> triangles);
    PartSurface(const PartSurface&) = delete;
    PartSurface& operator=(const PartSurface&) = delete;
    PartSurface(PartSurface&&) = delete;
    PartSurface& operator=(PartSurface&&) = delete;
    ~PartSurface() = default;

    [[nodiscard]] const CutSurface& surface() const { return surface_; }

private:
    mesh::Mesh mesh_;
    CutSurface surface_;
};

/// The place of a cut, in the units of a field over the triangles.
struct CutBand {
    double level;   ///< of the field, where the cut is expected
    double band;    ///< triangles whose field differs from level by less may go to either side
    double radius;  ///< of the part there, mesh units: what concavity is measured against
};

/// One byte per entry of triangles: 1 on the near side (field below the level), 0 on the far side. The cut within the band is
/// the one of least weight, each edge weighing its length over 1 + radius * concavity, so that it is short and keeps to concave
/// creases. field: #triangles of the mesh.
[[nodiscard]] std::vector<std::uint8_t> best_cut(const CutSurface& surface, std::span<const std::uint32_t> triangles,
                                                 std::span<const double> field, const CutBand& at);

/// Mean of min(1, radius * concavity) along the cut between near and far triangles, by length: 0 where it runs over a
/// convex or flat surface, 1 in a crease as sharp as the part is thick. 0 without a cut.
[[nodiscard]] double mean_concavity(const CutSurface& surface, std::span<const std::uint32_t> triangles,
                                    const std::vector<std::uint8_t>& near, double radius);

/// Volume (up to a constant factor) of the ellipsoid with the axes of inertia of the triangles that encloses them.
[[nodiscard]] double ellipsoid_volume(const CutSurface& surface, std::span<const std::uint32_t> triangles);

[[nodiscard]] std::vector<std::uint32_t> all_triangles(const CutSurface& surface);

/// The input of the printed cuts.
struct PrintedCuts {
    const CutSurface& surface;
    GeodesicSolver& geodesics;
    std::span<const double> curvature;        ///< #triangles
    std::span<const std::uint32_t> features;  ///< salient vertices, the most protruding first
    double least_area, width;                 ///< of a piece; of a locale
};

/// Cuts the partition wherever a locale passes one of the tests.
void cut_as_printed(const PrintedCuts& input, const DecomposeOptions& options, Partition& partition);

}  // namespace sqmap::decompose
