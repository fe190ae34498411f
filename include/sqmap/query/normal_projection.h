// The paper's own map: distance along the superquadric's normal, looked up at the foot point (section 4.2).
#pragma once

#include "sqmap/shape/foot_point.h"
#include "sqmap/shape/superquadric.h"

#include <cstdint>
#include <span>

namespace sqmap::query {

/// Values of NormalMapView::distance above k_map_largest are not distances.
inline constexpr std::uint16_t k_map_largest = 65533;
inline constexpr std::uint16_t k_map_cap = 65534;   ///< the ray starts inside the solid: solid from depth 0, no surface
inline constexpr std::uint16_t k_map_miss = 65535;  ///< the ray meets no surface: free along all of it

/// A mesh vertex seen by step 3, as a correction of the interpolated map: a pyramid over its cell, 1 at the vertex and 0
/// on the border, times correction. Sorted by row (normal map: correction_rows) and column.
struct VertexCorrection {
    std::uint16_t column;            ///< of the cell
    std::uint8_t eta, omega;         ///< place in the cell, in 1/256
    std::int16_t correction;         ///< times distance_scale
    friend constexpr bool operator==(const VertexCorrection&, const VertexCorrection&) = default;
};

/// A coarse table of starts for the foot search: equal-spaced angles in 1/256 of their ranges.
struct FootSeed {
    std::uint8_t eta, omega;
    friend constexpr bool operator==(const FootSeed&, const FootSeed&) = default;
};

/// One part's normal map. Grids are row-major, #eta_count by #omega_count, omega fastest; eta_i = pi (i / (eta_count - 1)
/// - 1/2), omega_j = 2 pi j / omega_count - pi are equal-spaced angles (eqs. 9 and 10). The grid is the finest level;
/// the base grid of Layer 2 is every 2^subdivisions-th row and column. Lengths in model units, frame of the model.
struct NormalMapView {
    shape::Superquadricf superquadric;
    std::uint32_t eta_count = 0, omega_count = 0;  ///< multiples of 2^subdivisions: eta_count - 1 and omega_count
    std::uint32_t subdivisions = 0;                ///< A_S of section 4.2.3
    float distance_scale = 0;                      ///< length of one step of distance and correction
    float offset_scale = 0;                        ///< length of one step of offset
    float quantization_error = 0;                  ///< largest measured error of a stored distance
    std::span<const std::uint16_t> distance;       ///< finest grid
    std::span<const std::uint16_t> normal;         ///< finest grid: surface normals by eq. 26, octahedral, 8 + 8 bits
    /// Finest grid, two bits a node, four nodes a byte: 1 = the surface jumps towards the next row, 2 = next column.
    std::span<const std::uint8_t> cuts;
    std::span<const std::uint32_t> correction_rows;  ///< #eta_count: cells of row i have corrections [rows[i], rows[i+1])
    std::span<const VertexCorrection> corrections;
    std::span<const std::uint8_t> offset;  ///< delta of eq. 12 on the base grid, rounded up
    std::uint32_t seed_count = 0;          ///< seeds along each axis
    bool seeds_mirrored = false;           ///< seeds cover the octant x, y, z >= 0 only
    std::span<const FootSeed> seeds;       ///< #seed_count^3, z fastest, over the undeformed bounding box
    std::span<const shape::Arc<float>> rows, columns;  ///< #eta_count, #omega_count: powers of the grid's angles
};

/// How the foot point is found. Both are kept so that they can be compared.
enum class Projector : std::uint8_t {
    Pyramid,  ///< the multiresolution search of eqs. 16 to 19, corrected (errata 5 to 7): a sample of the grid
    Newton,   ///< polish_foot from a table of starts: the exact foot
};

/// Layers of section 4.2. Layer 2 reads the nearest base sample; layer 3 the finest level and the vertices of step 3.
enum class Layer : std::uint8_t { One = 1, Two = 2, Three = 3 };

struct ProjectionOptions {
    Layer layer = Layer::Three;
    Projector projector = Projector::Newton;
    bool use_offset = false;       ///< subtract delta of eq. 12: for probes made of triangles, not for points
    bool use_corrections = true;   ///< step 3 data in layer 3
};

enum ProjectionFlags : std::uint8_t {
    k_projection_cap = 1,        ///< contact without a surface to push to
    k_projection_miss = 2,       ///< free because the ray meets nothing
    k_projection_wide = 4,       ///< the pyramid's window did not hold the foot: the whole surface was searched
    k_projection_unproven = 8,   ///< the foot search did not converge: the verdict is a guess and no witness
    k_projection_silhouette = 16 ///< the cell holds a jump of the surface: values of one sheet only were used
};

enum class Verdict : std::uint8_t {
    Outside,  ///< of this superquadric: says nothing about the solid
    Free,     ///< inside the superquadric, in front of the surface: proves that the point is free
    Contact,  ///< inside the superquadric and not in front of the surface
};

/// What one part says about one point.
struct PartAnswer {
    Verdict verdict = Verdict::Outside;
    std::uint8_t flags = 0;
    float foot_distance = 0;   ///< |p - P_M|, S_SQ^M of eq. 21
    float map_distance = 0;    ///< D_SQ(P_M); 0 for a cap, infinity for a miss
    float depth_along = 0;     ///< foot_distance - map_distance: depth along the superquadric's normal, negative in front
    float depth = 0;           ///< distance to the tangent plane at the surface point: first-order nearest depth
    shape::SurfaceAnglesf angles;  ///< of the foot
    Vec3f foot;                ///< P_M
    Vec3f foot_normal;         ///< outward normal of the superquadric
    Vec3f surface;             ///< the surface point along the normal; the foot for caps and misses
    Vec3f normal;              ///< unit outward surface normal; that of the superquadric for caps, misses and layer 1
};

/// Layer 1, then the asked-for layer for points inside the superquadric. Layer One answers Contact for all of those.
/// Total: a point that is not finite is Outside. Cost: about 3 ns a part outside its box, see docs for the rest.
[[nodiscard]] PartAnswer project(const NormalMapView& map, Vec3f p, const ProjectionOptions& options = {}) noexcept;

/// What all parts together say about one point.
struct CombinedAnswer {
    bool contact = false;
    bool has_surface = false;   ///< false where only caps claim the point: no depth, no normal
    std::int32_t part = -1;     ///< index into answers of the part that depth and normal come from
};

/// The witness rule for overlapping parts (errata 15): a point is in contact if a part claims it and no part that holds it
/// proves it free; a proof is a Free verdict whose foot converged. Depth and normal come from the claim with the least
/// depth among true surface samples.
[[nodiscard]] CombinedAnswer combine(std::span<const PartAnswer> answers) noexcept;

/// The foot point alone.
[[nodiscard]] shape::Foot<float> find_foot(const NormalMapView& map, Vec3f p, Projector projector,
                                           std::uint8_t* flags = nullptr) noexcept;

struct PyramidOptions {
    bool both_directions = true;   ///< false: the one direction of eq. 16
    bool compare_distance = true;  ///< false: I_S of eq. 19 alone decides
    bool wide_fallback = true;     ///< false: whatever the window holds
};

struct GridFoot {
    std::uint32_t row = 0, column = 0;  ///< of the base grid
    float collinearity = 0;             ///< I_S of eq. 19
    int evaluations = 0;                ///< of I_S or distance
    bool wide = false;
};

/// The pyramid search on the base grid (eqs. 17 to 19, Fig. 7) around the sample on p's own ray; with all options false
/// it is the paper's. p in the model frame, inside the superquadric.
[[nodiscard]] GridFoot pyramid_search(const NormalMapView& map, Vec3f p, const PyramidOptions& options = {}) noexcept;

/// Layer 3's map at given angles; also what the bake measures itself with.
struct MapSample {
    float distance = 0;  ///< infinity for a miss, 0 for a cap
    Vec3f normal;        ///< unit, outward, model frame; zero for caps and misses
    std::uint8_t flags = 0;
};
[[nodiscard]] MapSample sample_map(const NormalMapView& map, shape::SurfaceAnglesf angles, const ProjectionOptions& options) noexcept;

/// Unit vectors in 16 bits: octahedral, 8 + 8 bits, error below 1 degree.
[[nodiscard]] std::uint16_t encode_normal(Vec3f unit) noexcept;
[[nodiscard]] Vec3f decode_normal(std::uint16_t code) noexcept;

}  // namespace sqmap::query
