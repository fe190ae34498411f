// Baking the paper's own map: distances along the superquadric's inward normals (section 4.1, steps 2 and 3).
#pragma once

#include "sqmap/bake/normal_map_options.h"
#include "sqmap/mesh/bvh.h"
#include "sqmap/mesh/mesh.h"
#include "sqmap/model/model_data.h"
#include "sqmap/model/normal_map.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace sqmap::bake {

/// Rays against a closed mesh, and the solid it bounds (winding number above 0). Kept between the parts of one mesh,
/// which must outlive it. Const members are thread-safe.
class MapRays {
public:
    /// mesh: closed, model space; outlives it.
    explicit MapRays(const mesh::Mesh& mesh);
    ~MapRays();
    MapRays(MapRays&&) noexcept;
    MapRays& operator=(MapRays&&) noexcept;

    /// Where a ray meets the mesh.
    struct Hit {
        double distance = 0;
        std::uint32_t triangle = 0;
        bool entering = false;  ///< the ray meets the triangle's outer side
    };
    /// First triangle within (from, to) along a unit direction, model units. Nothing where there is none.
    [[nodiscard]] std::optional<Hit> first_hit(Vec3d origin, Vec3d direction, double from, double to) const;

    /// What a ray shows: a surface, nothing, or (Cap) that it starts inside the solid.
    enum class Kind : std::uint8_t { Hit, Cap, Miss };
    /// The first surface along a ray; distance and triangle of a hit alone.
    struct Surface {
        Kind kind = Kind::Miss;
        double distance = 0;
        std::uint32_t triangle = 0;
    };
    /// An opening behind the first surface: where the ray leaves the solid and where it enters it again (infinity: never).
    struct Gap {
        double leave = 0, enter = 0;
    };
    /// How far a ray counts, model units.
    struct Reach {
        double to;    ///< where it ends
        double lift;  ///< triangles so far behind the origin count too, at distance 0
    };
    /// Where a ray from origin along a unit direction first enters the solid: Cap if it starts inside. Buried surfaces (the solid
    /// on both sides) do not count. Crossings are counted along the whole ray; where they contradict each other (a grazed edge)
    /// the exact winding number decides. gaps: appended to, nearest first, also for a Cap; null where they are not wanted.
    [[nodiscard]] Surface surface_along(Vec3d origin, Vec3d direction, Reach reach, std::vector<Gap>* gaps = nullptr) const;

    /// The mesh that it was made of.
    [[nodiscard]] const mesh::Mesh& mesh() const;
    /// A tree over its triangles.
    [[nodiscard]] const mesh::Bvh& bvh() const;

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

/// What was measured while baking. Shares are of grid samples unless said otherwise.
struct NormalMapReport {
    int level = 0;
    bool target_met = false;
    double hit_share = 0, cap_share = 0, miss_share = 0;
    double cut_share = 0;                                  ///< of cells that hold a jump of the surface
    double interpolation_mean = 0, interpolation_p99 = 0;  ///< model units, at centres of cells without a jump
    double quantization_error = 0;                         ///< largest, model units
    std::uint32_t vertices = 0, occluded_vertices = 0, corrections = 0, gaps = 0;
    double q2_share = 0;  ///< of the part's area: points whose line to their foot crosses the mesh (section 5)
};

/// A baked map that owns its arrays; see model::NormalMapView for what they hold.
struct NormalMap {
    shape::Superquadricf superquadric;
    std::uint32_t eta_count = 0, omega_count = 0, subdivisions = 0, seed_count = 0, vertex_count = 0;
    bool seeds_mirrored = false;
    float distance_scale = 0, offset_scale = 0, quantization_error = 0;
    std::vector<std::uint16_t> distance, normal;
    std::vector<std::uint8_t> cuts, offset;
    std::vector<std::uint32_t> correction_rows, gap_rows;
    std::vector<model::MapGap> gaps;
    std::vector<model::VertexCorrection> corrections;
    std::vector<model::FootSeed> seeds, surface_seeds;
    std::vector<model::SmoothedSample> smoothed;
    NormalMapReport report;

    /// Valid while this lives and does not change.
    [[nodiscard]] model::NormalMapView view() const;
    /// Bytes that a file needs: all arrays.
    [[nodiscard]] std::size_t stored_bytes() const;
};

/// Bakes one part. The superquadric's parameters are narrowed to float first; rays meet the whole mesh, triangles are the
/// part's own and serve step 3 and the Q2 share. Thread-safe. Cost: about 3 rays per sample, 1 per vertex.
/// @pre the superquadric bounds the triangles and, if bent, bend a.z < pi
[[nodiscard]] NormalMap bake_normal_map(const MapRays& rays, std::span<const std::uint32_t> triangles,
                                        const shape::Superquadricd& superquadric, const NormalMapOptions& options = {});

/// Puts a map behind those of a model's parts so far: the part of that number's. Linear.
void append_normal_map(const NormalMap& map, model::ModelData& data);

}  // namespace sqmap::bake
