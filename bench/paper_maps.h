// The paper's own maps of an object, at any sampling density: what its evaluation sweeps (sections 4 and 7).
#pragma once

#include "method.h"
#include "setting.h"
#include "sqmap/paper/bake.h"
#include "sqmap/paper/projection.h"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace sqmap::bench {

/// Decomposition and superquadrics of an object, found once and sampled at many densities. Model space, which is the
/// setting's less origin, over unit.
struct PaperParts {
    explicit PaperParts(const Setting& setting);
    PaperParts(const PaperParts&) = delete;
    PaperParts& operator=(const PaperParts&) = delete;

    const mesh::Mesh mesh;
    const paper::MapRays rays;
    model::ModelData model;                             ///< without maps
    std::vector<std::vector<std::uint32_t>> triangles;  ///< of parts
    double build_s;                                     ///< CPU seconds of decomposition and fit
};

/// How densely every part's superquadric is sampled: the base grid that layer 2 reads has 2^level + 1 rows and 2^(level+1)
/// columns (eta_d and omega_d); layer 3's is finer by 2^subdivisions (A_S) along each.
struct Density {
    int level = 6;
    int subdivisions = 1;
};

/// The maps at one density, and the layered query of section 4.2 on them.
class PaperMaps {
public:
    PaperMaps(std::shared_ptr<const PaperParts> parts, Density density);

    /// Bytes of the maps: 16-bit distances and normals of the finest grid, offsets, vertices of step 3, starts of the search;
    /// without the smoothed map, which serves force alone.
    std::size_t bytes = 0;
    std::size_t samples = 0;  ///< of the finest grids
    double spacing = 0;       ///< mean over the maps' surface: sqrt(area / samples), model units
    double build_s = 0;       ///< CPU seconds of the maps and of the parts

    [[nodiscard]] const PaperParts& parts() const { return *parts_; }
    [[nodiscard]] const paper::ModelView& model() const { return view_; }

private:
    std::shared_ptr<const PaperParts> parts_;
    paper::ModelData model_;
    paper::ModelView view_;
};

/// As the paper asks: the pyramid search, and nothing behind the first surface.
[[nodiscard]] paper::ProjectionOptions paper_projection(query::Layer layer);

struct PaperMethod {
    query::Layer layer;
    paper::Projector projector;
    bool one_lane = false;  ///< the kernel's reference
};
/// A probe query of the maps.
[[nodiscard]] std::unique_ptr<Method> make_paper_query(const Setting& setting, std::shared_ptr<const PaperMaps> maps,
                                                       const PaperMethod& method);

/// Eq. 35 as a mean: |D^ - D| along the superquadric's normal, over the points that lie inside a superquadric and whose line
/// meets both the mesh and the map's surface; percent of R_max.
struct ProjectionError {
    double mean = 0, p99 = 0;
    double one_sided_pct = 0;  ///< share of the points where only one of the two is met
    std::size_t points = 0;
};
/// points: units of the setting.
[[nodiscard]] ProjectionError projection_error(const PaperMaps& maps, std::span<const Vec3d> points, query::Layer layer);

}  // namespace sqmap::bench
