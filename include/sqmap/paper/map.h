// The paper's own map of one part, along the normals of its superquadric (section 4.1, steps 2 and 3): spans over arrays that
// someone else owns.
#pragma once

#include "sqmap/shape/superellipse.h"
#include "sqmap/shape/superquadric.h"

#include <cstdint>
#include <span>

namespace sqmap::paper {

/// The ray of a sample, on its way in, meets one of these.
enum class MapRay {
    Surface,  ///< the surface, at the stored distance
    Cap,      ///< none: it starts inside the solid, which is solid from depth 0
    Miss,     ///< none: all of it is free
};
/// Says what a value of MapView::distance stands for. Any thread.
[[nodiscard]] MapRay ray_of(std::uint16_t stored) noexcept;

/// A mesh vertex seen by step 3, as a correction of the interpolated map: a pyramid over its cell, 1 at the vertex and 0
/// on the border, times correction. Sorted by row (correction_rows) and column.
struct VertexCorrection {
    std::uint16_t column;     ///< of the cell
    std::uint8_t eta, omega;  ///< position in the cell, in 1/256
    std::int16_t correction;  ///< times distance_scale
    friend constexpr bool operator==(const VertexCorrection&, const VertexCorrection&) = default;
};

/// Beyond the paper: an opening behind the first surface on a sample's ray, from where the ray leaves the solid to where it
/// enters again (as a miss is stored: never). Sorted by row (gap_rows), column and distance. Only openings that some point with
/// its foot at this sample can lie in are kept. They lift the limit of Q2 regions (section 5).
struct MapGap {
    std::uint16_t column;
    std::uint16_t leave, enter;  ///< times distance_scale
    friend constexpr bool operator==(const MapGap&, const MapGap&) = default;
};

/// The smoothed map at a base sample: what smoothing adds to the distance, times distance_scale, and the normal of the
/// smoothed surface, octahedral. Beside a jump, a cap or a miss there is no one surface to smooth: see is_smoothed.
struct SmoothedSample {
    std::int16_t change;
    std::uint16_t normal;
    friend constexpr bool operator==(const SmoothedSample&, const SmoothedSample&) = default;
};
/// Any thread.
[[nodiscard]] bool is_smoothed(const SmoothedSample& sample) noexcept;

/// A coarse table of starts for the foot search: equal-spaced angles in 1/256 of their ranges.
struct FootSeed {
    std::uint8_t eta, omega;
    friend constexpr bool operator==(const FootSeed&, const FootSeed&) = default;
};
/// MapView::surface_seeds has so many seeds along each axis.
inline constexpr std::uint32_t k_surface_seeds = 12;

/// The finest level has at most so many rows and columns.
inline constexpr std::uint32_t k_max_map_rows = 4097, k_max_map_columns = 8192;

/// The place of one part's map in the arrays of a model; see MapView for what each holds. Layout equals the FlatBuffers struct
/// MapRecord.
struct MapRecord {
    std::uint32_t eta_count, omega_count, subdivisions, vertex_count;
    float distance_scale, offset_scale, quantization_error;
    std::uint32_t first_sample;  ///< of distance: eta_count * omega_count
    std::uint32_t first_cut, cut_count;
    std::uint32_t first_correction_row, correction_row_count, first_correction, correction_count;
    std::uint32_t first_gap_row, gap_row_count, first_gap, gap_count;
    std::uint32_t first_base, base_count;  ///< of normal and smoothed: samples of the base grid
    std::uint32_t first_offset;            ///< bytes, two samples each
    std::uint32_t seeds_along, seeds_mirrored, first_seed, seed_count;
};

/// The maps of all parts. each(visit, of...) calls visit(name, array of every of...) for the arrays, in the file's order.
template <template <class> class Array>
struct MapArrays {
    Array<MapRecord> records;  ///< #parts
    Array<std::uint16_t> distance, normal;
    Array<std::uint8_t> cuts, offset;
    Array<std::uint32_t> correction_rows, gap_rows;
    Array<VertexCorrection> corrections;
    Array<MapGap> gaps;
    Array<FootSeed> seeds;
    Array<SmoothedSample> smoothed;  ///< beside offset
    template <class Visit, class... Of>
    static constexpr void each(Visit&& visit, Of&... of)
    {
        visit("records", of.records...);
        visit("distance", of.distance...);
        visit("normal", of.normal...);
        visit("cuts", of.cuts...);
        visit("offset", of.offset...);
        visit("correction_rows", of.correction_rows...);
        visit("gap_rows", of.gap_rows...);
        visit("corrections", of.corrections...);
        visit("gaps", of.gaps...);
        visit("seeds", of.seeds...);
        visit("smoothed", of.smoothed...);
    }
};

/// One part's paper map. Grids are row-major, #eta_count by #omega_count, omega fastest; eta_i = pi (i / (eta_count - 1)
/// - 1/2), omega_j = 2 pi j / omega_count - pi are equal-spaced angles (eqs. 9 and 10). The grid is the finest level;
/// the base grid of Layer 2 is every 2^subdivisions-th row and column. Lengths in model units, frame of the model.
struct MapView {
    shape::Superquadricf superquadric;
    std::uint32_t eta_count = 0, omega_count = 0;  ///< multiples of 2^subdivisions: eta_count - 1 and omega_count
    std::uint32_t subdivisions = 0;                ///< A_S of section 4.2.3
    std::uint32_t vertex_count = 0;                ///< N_m: mesh vertices of the part, for the gate of layer 3
    float distance_scale = 0;                      ///< length of one step of distance and correction
    float offset_scale = 0;                        ///< length of an offset whose root is 1
    float quantization_error = 0;                  ///< largest measured error of a stored distance
    std::span<const std::uint16_t> distance;       ///< finest grid
    std::span<const std::uint16_t> normal;         ///< base grid: surface normals by eq. 26, octahedral, 8 + 8 bits
    /// Finest grid, two bits a node, four nodes a byte: 1 = the surface jumps towards the next row, 2 = next column.
    std::span<const std::uint8_t> cuts;
    std::span<const std::uint32_t> correction_rows;  ///< #eta_count: cells of row i have corrections [rows[i], rows[i+1])
    std::span<const VertexCorrection> corrections;
    std::span<const std::uint32_t> gap_rows;  ///< #eta_count + 1: samples of row i have gaps [rows[i], rows[i+1])
    std::span<const MapGap> gaps;
    std::span<const std::uint8_t> offset;      ///< delta of eq. 12 on the base grid, rounded up: roots, two samples a byte
    std::span<const SmoothedSample> smoothed;  ///< base grid, for force; empty or as long as normal
    std::uint32_t seed_count = 0;              ///< seeds along each axis
    bool seeds_mirrored = false;               ///< seeds cover the octant x, y, z >= 0 only
    std::span<const FootSeed> seeds;           ///< #seed_count^3, z fastest, over the undeformed bounding box
    /// Over the same box, #k_surface_seeds^3 or none: the sample that shows the surface nearest to the middle of a cell. Below
    /// caps the search for a surface starts from it.
    std::span<const FootSeed> surface_seeds;
};

/// True where no query can read outside the view's arrays and every number is finite and in its range: to be checked once
/// for a view over untrusted bytes. Cost: linear in corrections and gaps.
[[nodiscard]] bool is_consistent(const MapView& map) noexcept;

}  // namespace sqmap::paper
