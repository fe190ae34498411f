// Baking a paper model: the core's parts and superquadrics, and distances along the superquadrics' inward normals (section 4.1,
// steps 2 and 3).
#pragma once

#include "sqmap/bake/bake_types.h"
#include "sqmap/bake/evaluate.h"
#include "sqmap/mesh/bvh.h"
#include "sqmap/mesh/mesh.h"
#include "sqmap/paper/model.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace sqmap::paper {

/// The smoothed map shows one of these.
enum class Smoothing {
    Surface,    ///< the smoothed mesh: one surface for all parts, up to jumps (beyond the paper)
    Distances,  ///< each part's own distances, convolved (section 6); not beside jumps
};
/// How distances are smoothed, weights over samples within the radius: binomial coefficients, all alike, or a Gaussian whose
/// standard deviation is half the radius.
enum class SmoothingKernel { Binomial, Box, Gaussian };

/// Samples of layer 2 a part, along eta and along omega.
struct GridSize {
    int rows = 0, columns = 0;  ///< eta_d and omega_d; 0: as many as the target error needs

    /// False: the grid follows from the target error.
    [[nodiscard]] constexpr bool is_chosen() const { return rows > 0; }
};

/// Lengths are relative to the superquadric's largest semi-axis.
struct MapOptions {
    double target_error = 2e-3;  ///< bounds the 99th percentile of what linear interpolation misses within one sheet
    int min_level = 4;           ///< finest grid at least 2^level + 1 by 2^(level + 1)
    int max_level = 7;           ///< and at most
    GridSize grid{};             ///< instead of levels; see is_storable
    /// A_S of section 4.2: layer 2 is coarser than layer 3 by 2^A_S along each axis. Maps of few samples, whose grid is
    /// not chosen, take less: the base grid keeps 5 rows at least.
    int subdivisions = 1;
    double offset_constant = 1.5;  ///< a_N of eq. 12
    /// Eq. 12 takes the greatest gradient within so many samples of a minimum; 0: its own, as printed: next to nothing.
    int offset_radius = 1;
    Smoothing smoothing = Smoothing::Surface;
    double smoothing_length = 0.015;  ///< Surface: diffused over this share of the largest vertex distance
    /// Distances: of the kernel, in base samples, 0 to greatest_smoothing_radius; 0: no smoothed map of either kind.
    int smoothing_radius = 1;
    SmoothingKernel smoothing_kernel = SmoothingKernel::Binomial;
    bool corrections = true;            ///< step 3
    bool gaps = true;                   ///< openings behind the first surface (beyond the paper)
    double correction_threshold = 0.1;  ///< vertices closer to the map than this share of target_error add nothing
    double jump_slope = 1.5;            ///< samples whose distances differ by more than this per length are probed for a jump
};

/// Its numbers that doors set, which bake() checks; those of a chosen grid are k_grid_numbers. The smoothing radius has a closer
/// limit, too: greatest_smoothing_radius.
inline constexpr NumberOption<MapOptions> k_map_numbers[] = {{"subdivisions", &MapOptions::subdivisions, {0, 5}},
                                                             {"offset_constant", &MapOptions::offset_constant, {0, 100}},
                                                             {"offset_radius", &MapOptions::offset_radius, {0, 8}},
                                                             {"smoothing_length", &MapOptions::smoothing_length, {1e-3, 0.1}},
                                                             {"smoothing_radius", &MapOptions::smoothing_radius, {0, 8}}};
inline constexpr NumberOption<GridSize> k_grid_numbers[] = {{"rows", &GridSize::rows, {5, k_max_map_rows}},
                                                            {"columns", &GridSize::columns, {8, k_max_map_columns}}};

/// A chosen grid, subdivided, is within the format's limits.
[[nodiscard]] constexpr bool is_storable(const MapOptions& options)
{
    const std::int64_t rows = options.grid.rows, columns = options.grid.columns;
    return ((rows - 1) << options.subdivisions) < k_max_map_rows && (columns << options.subdivisions) <= k_max_map_columns;
}

/// Radius of the widest kernel that smooths some sample of a chosen grid: those nearer to a pole than a kernel reaches stay as
/// they are.
[[nodiscard]] constexpr int greatest_smoothing_radius(const MapOptions& options)
{
    const bool is_limited = options.smoothing == Smoothing::Distances && options.grid.is_chosen();
    return is_limited && options.grid.rows < 19 ? (options.grid.rows - 3) / 2
                                                : static_cast<int>(option_named(k_map_numbers, "smoothing_radius").range.max);
}

/// The first option of smoothing that is not its default and that this smoothing does not read.
[[nodiscard]] constexpr std::optional<IdleOption> idle_smoothing(const MapOptions& options)
{
    constexpr MapOptions k_plain{};
    const bool none = options.smoothing_radius == 0, surface = options.smoothing == Smoothing::Surface;
    const char* const cure = none      ? "set 'smoothing_radius' to 1 or more"
                             : surface ? "set 'smoothing' to distances"
                                       : "set 'smoothing' to surface";
    const auto idle = [&](const char* name) {
        return IdleOption{name,
                          none      ? "counts with a smoothed map"
                          : surface ? "is of smoothed distances"
                                    : "is of the smoothed surface",
                          cure};
    };
    if (options.smoothing_length != k_plain.smoothing_length && (none || !surface)) return idle("smoothing_length");
    if (options.smoothing_kernel != k_plain.smoothing_kernel && (none || surface)) return idle("smoothing_kernel");
    if (options.smoothing_radius > k_plain.smoothing_radius && surface) return idle("smoothing_radius");
    return std::nullopt;
}

/// A mesh's vertices, smoothed, and their unit outward normals.
struct SmoothSurface {
    std::vector<Vec3d> points, normals;
};

/// Rays against a closed mesh, and the solid it bounds (winding number above 0). Kept between the parts of one mesh,
/// which must outlive it. Const members are thread-safe.
class MapRays {
public:
    /// mesh: closed, model space; outlives it.
    explicit MapRays(const mesh::Mesh& mesh);
    ~MapRays();
    MapRays(MapRays&&) noexcept;
    MapRays& operator=(MapRays&&) noexcept;

    /// A point where a ray meets the mesh.
    struct Hit {
        double distance = 0;
        std::uint32_t triangle = 0;
        bool entering = false;  ///< the ray meets the triangle's outer side
    };
    /// First triangle within (from, to) along a unit direction, model units. Nothing where there is none.
    [[nodiscard]] std::optional<Hit> first_hit(Vec3d origin, Vec3d direction, double from, double to) const;

    /// A ray shows one of these: a surface, nothing, or (Cap) that it starts inside the solid.
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
    /// Follows a ray along a unit direction to where it first enters the solid: Cap if it starts inside. Buried surfaces (solid
    /// on both sides) do not count. Crossings are counted along the whole ray; where they contradict each other (a grazed edge)
    /// the exact winding number decides. gaps: appended to, nearest first, also for a Cap; null where they are not wanted.
    [[nodiscard]] Surface surface_along(Vec3d origin, Vec3d direction, Reach reach, std::vector<Gap>* gaps = nullptr) const;

    /// The mesh that it was made of.
    [[nodiscard]] const mesh::Mesh& mesh() const;
    /// A tree over its triangles.
    [[nodiscard]] const mesh::Bvh& bvh() const;
    /// The mesh smoothed over a share of its largest vertex distance: made by the first call with that share, and kept.
    [[nodiscard]] const SmoothSurface& smoothed(double share) const;

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

/// Figures that the bake of a map measured. Shares are of grid samples unless said otherwise.
struct MapReport {
    int level = 0;
    bool target_met = false;
    double hit_share = 0, cap_share = 0, miss_share = 0;
    double cut_share = 0;                                  ///< of cells that hold a jump of the surface
    double interpolation_mean = 0, interpolation_p99 = 0;  ///< model units, at centres of cells without a jump
    double quantization_error = 0;                         ///< largest, model units
    std::uint32_t vertices = 0, occluded_vertices = 0, corrections = 0, gaps = 0;
};

/// A baked map that owns its arrays; see MapView for what they hold.
struct Map : MapGrid, MapArrays<model::ArrayData> {
    shape::Superquadricf superquadric;
    MapReport report;

    /// Valid while this lives and does not change.
    [[nodiscard]] MapView view() const;
    /// Bytes that a file needs: all arrays.
    [[nodiscard]] std::size_t stored_bytes() const;
};

/// Bakes one part. The superquadric's parameters are narrowed to float first; rays meet the whole mesh, triangles are the
/// part's own and serve step 3. Thread-safe. Cost: about 3 rays per sample, 1 per vertex.
/// @pre the superquadric bounds the triangles and, if bent, bend a.z < pi (not checked)
[[nodiscard]] Map bake_map(const MapRays& rays, std::span<const std::uint32_t> triangles,
                           const shape::Superquadricd& superquadric, const MapOptions& options = {});

/// Puts a map behind those of a model's parts so far: it is that of the part of that number. Linear.
void append_map(const Map& map, ModelMaps<model::ArrayData>& maps);

/// A model of either kind, and how it was made.
struct BakeResult {
    ModelData model;  ///< a central one has no paper maps
    bake::BakeReport report;
};

/// bake::bake without options of maps. Else decomposes and fits as that does, bakes a paper map of each part, and refines until
/// the target error is met or nothing more is gained; exact: the triangles are stored, and a solid's cells with them, there being
/// no other locator. maps: its target_error follows from that of the model.
/// @throw as bake::bake, and mesh::InvalidInput for options of the maps out of range
/// Cost and threads: as bake::bake.
[[nodiscard]] BakeResult bake(const mesh::Mesh& mesh, bool solid, const bake::BakeOptions& options,
                              const std::optional<MapOptions>& maps);

/// bake::evaluate of either kind: eq. 35 of a paper model is |D^ - D| at the foot of a point, D the first surface below it along
/// the normal.
[[nodiscard]] bake::Evaluation evaluate(const model::ModelView& model, const mesh::Solid& solid,
                                        const bake::EvaluateOptions& options);

}  // namespace sqmap::paper
