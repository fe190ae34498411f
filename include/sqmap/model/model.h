// The baked model as the runtime sees it: plain structs over one immutable blob that the caller owns.
#pragma once

#include "sqmap/math/vec.h"
#include "sqmap/model/normal_map.h"
#include "sqmap/shape/superquadric.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace sqmap::model {

inline constexpr std::uint32_t k_format_version = 6;
inline constexpr int k_faces = 6;            ///< faces of the central chart's cube: +x -x +y -y +z -z of the part frame
inline constexpr int k_block = 2;            ///< base cells along the side of a block of the pyramid
inline constexpr int k_max_split_depth = 4;  ///< a base cell is halved at most this often
inline constexpr int k_max_sheets = 7;       ///< surfaces along one ray that a layered cell tells apart

/// How a part's surface is projected (fixed at bake).
enum class Projection : std::uint32_t { Central = 0, Normal = 1 };

/// One part: its superquadric, certificate, central chart and where its data lies in the model's arrays.
/// Model space throughout. Layout equals the FlatBuffers struct Part of sqmap.fbs.
struct Part {
    // Superquadric: 15 parameters, the rotation as matrix rows too.
    float a[3];
    float eps[2];
    float rotation[9];
    float translation[3];
    float euler[3];  ///< phi, theta, chi of eq. 2 (ZYZ), radians
    float taper[2];
    float bend, bend_angle;
    // Proof that it holds its triangles and the caps that close them (see fit/fit.h).
    float largest_f, tolerance;
    float sphere[4];  ///< bounding sphere of the superquadric: centre, radius
    // Central chart: x' = scale * rotation' * (p - centre) with chart rows = diag(1/a) rotation.
    float chart_rows[9];
    float chart_centre[3];
    float chart_lo[9], chart_hi[9];  ///< where the chart answers: bounds of x', y', z', x'+y', x'-y', x'+z', x'-z', y'+z', y'-z'
    float offset_step, smoothing_step;  ///< what one step of offsets (model units) and of smoothing (in w) means
    float w_min, w_step;                ///< a stored value v means w = 1/rho = w_min + w_step v, rho the largest coordinate
    std::uint32_t base;                 ///< cells along a face's side, a multiple of k_block; 0: no central map
    std::uint32_t flags;                ///< PartFlag bits
    std::int32_t centre_winding;        ///< winding number of the mesh about the chart's centre
    std::uint32_t triangle_count, vertex_count;  ///< of the surface that belongs to the part
    float area;                                  ///< of that surface
    // First entries in the model's arrays, and how many.
    std::uint32_t first_sample, sample_count;
    std::uint32_t first_cell, cell_count;
    std::uint32_t first_block, block_count;
    std::uint32_t first_split, split_count;  ///< records of k_split_size values
    std::uint32_t first_special, special_count;
    std::uint32_t first_pool, pool_count;
};

enum PartFlag : std::uint32_t {
    k_centre_inside = 1u,  ///< the chart's centre lies in the solid
    k_fit_fallback = 2u,   ///< the closed-form ellipsoid bounds the part
    k_interior_part = 4u,
};

/// Facts of the whole model. Layout equals the FlatBuffers struct Header.
struct Header {
    double origin[3];  ///< mesh units; model = (mesh - origin) / unit
    double unit;
    double r_max;         ///< largest distance between two vertices, model units
    double quantisation;  ///< largest error that 16-bit storage added to a radius, model units
    float sphere[4];      ///< bounding sphere of the object, model units
    std::uint32_t solid;  ///< 1 a closed solid, 0 a surface
    std::uint32_t projection;
    std::uint32_t triangle_count, vertex_count;
    std::uint32_t self_intersecting;  ///< 1 if some exact triangles cross each other
    std::uint32_t reserved;
};

/// How a stored cell of the central chart is read: two bits of kind, fourteen of payload.
/// Uniform: no surface; payload bit 0 is the verdict (1 inside).
/// Single: one surface over the four corner samples; payload is the code of its certified deviation in w, and k_foreign.
/// Split: payload is an index of splits.
/// Layered: payload is an index of specials, which points at a layered record in the pool.
enum class CellKind : std::uint32_t { Uniform = 0, Single = 1, Split = 2, Layered = 3 };

constexpr CellKind cell_kind(std::uint16_t cell) { return static_cast<CellKind>(cell >> 14); }
constexpr std::uint32_t cell_payload(std::uint16_t cell) { return cell & 0x3fffu; }

/// Set in a Single cell's payload or a layered record's header where no surface over the cell is the part's own: good
/// for verdicts, while depth and normal are the business of the part that owns the surface.
inline constexpr std::uint32_t k_foreign = 0x100;
/// Set in the header of a mixed (layered, not bilinear) record: a silhouette divides the cell. The word after the band
/// holds the codes of two points on the cell's border; left of the way from the first to the second (low byte) the first
/// planes hold, right of it the second ones, counted by header bits 5 to 7.
inline constexpr std::uint32_t k_divided = 0x10;

/// Values of a layered record in the pool, told from its first.
constexpr std::uint32_t layered_record_size(std::uint16_t header)
{
    const std::uint32_t sheets = header & 7u;
    if ((header & 8u) != 0) return 1 + 5 * sheets;
    return (header & k_divided) == 0 ? 3 + 3 * sheets : 4 + 3 * (sheets + ((header >> 5) & 7u));
}

/// A place on the border of a cell: 64 steps a side, from the corner of least s and t towards greater s and around.
struct BorderPoint {
    float u, v;  ///< in the cell, from 0 to 1
};
constexpr BorderPoint border_point(std::uint32_t code)
{
    const float f = static_cast<float>(code & 63u) / 64.f;
    switch ((code >> 6) & 3u) {
        case 0:
            return {f, 0.f};
        case 1:
            return {1.f, f};
        case 2:
            return {1.f - f, 1.f};
        default:
            return {0.f, 1.f - f};
    }
}

/// A split cell's record: of three by three samples the five that are not the cell's own corners, row by row, and the four cells
/// between them.
inline constexpr std::uint32_t k_split_cells = 5;
inline constexpr std::uint32_t k_split_size = k_split_cells + 4;

/// A block of k_block x k_block base cells: the least and greatest stored w of the part's own surface over it; lo > hi:
/// none.
struct Block {
    std::uint16_t lo, hi;
};

inline constexpr std::uint16_t k_no_surface = 0xffff;  ///< a base sample whose ray meets no surface

/// High bits of triangle_part.
enum SurfaceFlag : std::uint16_t {
    k_part_mask = 0x3fff,
    k_buried = 0x4000,   ///< both sides are inside the solid: no boundary
    k_crossed = 0x8000,  ///< another triangle cuts it: of it only its pieces are boundary
};

/// Where one part's normal map lies in the model's arrays; see NormalMapView for what each holds. Layout equals the
/// FlatBuffers struct NormalPart.
struct NormalPart {
    std::uint32_t eta_count, omega_count, subdivisions, vertex_count;
    float distance_scale, offset_scale, quantization_error;
    std::uint32_t first_sample;  ///< of distance and normal: eta_count * omega_count
    std::uint32_t first_cut, cut_count;
    std::uint32_t first_correction_row, correction_row_count, first_correction, correction_count;
    std::uint32_t first_gap_row, gap_row_count, first_gap, gap_count;
    std::uint32_t first_offset, offset_count;
    std::uint32_t seeds_along, seeds_mirrored, first_seed, seed_count;
};

/// A uniform grid over the object that says, for a place in space, which part's chart answers there and on which chart
/// the nearest surface lies. Four by four by four cells are a brick; one that is free as a whole is not stored, one that
/// lies deep inside is a single place.
/// Layout equals the FlatBuffers struct Locator.
struct Locator {
    float origin[3];          ///< lowest corner, model space
    float cell;               ///< side of a cell, model units
    std::uint32_t bricks[3];  ///< along x, y, z; 0: the model has no locator
    float plane_reach;        ///< how far the planes' distances go, and one, in cells; see plane_distance
};
inline constexpr int k_brick = 4;                        ///< cells along a brick's side
inline constexpr std::uint32_t k_free_brick = 1u << 31;  ///< set in a brick that is free; the rest is its gap
inline constexpr std::uint32_t k_deep_brick = 1u << 30;  ///< set in a brick that is one place; the rest is its index
inline constexpr float k_gap_step = 1.f / 64;            ///< of a cell's side: unit of stored gaps
inline constexpr std::uint32_t k_list_length = 4;        ///< parts in a list, one byte each; k_no_part ends a shorter one
inline constexpr std::uint32_t k_no_part = 0xff;
inline constexpr std::uint32_t k_divided_place = 0x1ff;      ///< in place of a list: see is_divided
inline constexpr int k_max_divisions = 1;                    ///< of a cell
inline constexpr std::uint32_t k_max_place_index = 0x3ffff;  ///< greatest index of planes or seeds that a place can hold
inline constexpr std::uint32_t k_max_planes = 7;             ///< of a place

/// What a cell of the locator (a place) holds, two bits; then, where it is Free, the gap: a lower bound of the distance
/// from the cell's centre to the solid. Else 9 bits of index into part_lists, how many planes are the surface there (3 bits; the
/// place is flat), and 18 bits of index into planes, or into seeds where there are none.
enum class LocatorCellKind : std::uint32_t {
    Free = 0,    ///< no point of the cell is in the solid
    Inside = 1,  ///< every point of it is
    Mixed = 2,   ///< the first part of the list whose chart holds a point decides; held by none, it is free
    Ask = 3,     ///< too many parts for a list: all are asked
};
constexpr LocatorCellKind place_kind(std::uint32_t place) { return static_cast<LocatorCellKind>(place & 3u); }
constexpr std::uint32_t place_gap(std::uint32_t place) { return place >> 2; }
constexpr std::uint32_t place_list(std::uint32_t place) { return (place >> 2) & 0x1ffu; }
constexpr std::uint32_t place_planes(std::uint32_t place) { return (place >> 11) & 7u; }
constexpr std::uint32_t place_first(std::uint32_t place) { return place >> 14; }
/// True of a place that is divided in eight: what would be its first seed is the first of them in places, x fastest.
constexpr bool is_divided(std::uint32_t place)
{
    return place_kind(place) == LocatorCellKind::Ask && place_list(place) == k_divided_place;
}
/// A plane of a flat place, where planes are the surface to within the map's own error. 9 + 9 bits outward unit normal,
/// octahedral; 11 bits distance of the place's centre below it; 2 bits: which part of the place's list shows that surface; a
/// flag.
inline constexpr int k_plane_normal_bits = 9;
inline constexpr int k_plane_distance_bits = 11;
inline constexpr std::uint32_t k_plane_most_distance = (1u << k_plane_distance_bits) - 1;
inline constexpr std::uint32_t k_joined = 1u << 31;  ///< of this plane and the one before it the higher counts
constexpr std::uint32_t plane_slot(std::uint32_t plane) { return (plane >> 29) & 3u; }
/// In cells, from -1 on; finer the nearer to the surface.
constexpr float plane_distance(std::uint32_t plane, float plane_reach)
{
    const auto code = static_cast<float>((plane >> 2 * k_plane_normal_bits) & k_plane_most_distance);
    return code * code * (plane_reach / (float(k_plane_most_distance) * float(k_plane_most_distance))) - 1.f;
}
/// Of a flat place, with the exact layer: no point of the solid in the place is farther above the lowest plane; k_no_rise says
/// nothing.
inline constexpr float k_rise_step = 1.f / 1024;  ///< of the locator's cell
inline constexpr std::uint8_t k_no_rise = 0xff;
/// Rises of so many places, to whole words.
constexpr std::size_t padded_rises(std::size_t places) { return (places + 3) / 4 * 4; }

/// A plane that touches the surface where it is nearest to some point of a place, and the part whose chart shows it: the start
/// of the search for the nearest surface where the place is not flat. A place may have a chain of several, up to and with the
/// one that has k_last_seed; then the words before the chain say which comes first in an octant of the place.
struct Seed {
    std::uint32_t direction;  ///< 8 bits part, 12 + 12 bits outward unit normal, octahedral
    std::uint32_t extent;     ///< 16 bits signed distance of the centre below the plane, 8 bits reach, flag
};
inline constexpr std::uint32_t k_last_seed = 1u << 31;
inline constexpr int k_seed_normal_bits = 12;
inline constexpr float k_seed_distance_step = 1.f / 512;  ///< of the locator's cell
inline constexpr float k_seed_reach_step = 1.f / 8;       ///< of the locator's cell
inline constexpr std::uint32_t k_max_seeds = 8;
constexpr std::uint32_t seed_part(Seed seed) { return seed.direction & 0xffu; }
constexpr int seed_distance(Seed seed) { return static_cast<int>(seed.extent & 0xffffu) - 0x8000; }
/// A surface found from the seed within this distance is the nearest, whatever the rest of the chain finds.
constexpr std::uint32_t seed_reach(Seed seed) { return (seed.extent >> 16) & 0xffu; }
/// choices: direction of the pair before a chain; octant: 1 upper x, 2 upper y, 4 upper z.
constexpr std::uint32_t seed_choice(std::uint32_t choices, std::uint32_t octant) { return (choices >> (3 * octant)) & 7u; }

/// Where a brick has no record in near.
inline constexpr std::uint32_t k_no_candidates = 0xffffffffu;

/// The arrays of all normal maps; empty in a model of the central projection.
struct NormalArrays {
    std::span<const NormalPart> parts;
    std::span<const std::uint16_t> distance, normal;
    std::span<const std::uint8_t> cuts, offset;
    std::span<const std::uint32_t> correction_rows, gap_rows;
    std::span<const VertexCorrection> corrections;
    std::span<const MapGap> gaps;
    std::span<const FootSeed> seeds;
    std::span<const SmoothedSample> smoothed;  ///< beside offset
};

/// Figures measured on a finished model, lengths in percent of R_max (see bake/evaluate.h for what each means).
struct Measured {
    std::uint32_t points = 0;
    std::uint32_t missed = 0, false_contacts = 0;  ///< layer 3, farther than 0.5 % of R_max from the surface
    double eq35_mean = 0, eq35_p99 = 0, eq35_max = 0;
    double depth_median = 0, depth_p95 = 0, depth_p99 = 0, depth_max = 0;
    double normal_median = 0;  ///< degrees
    double q2_share = 0;       ///< percent of the surface that its part's projection does not see first
};

/// Everything a query reads, and what a reader wants to know. Copyable; valid as long as the blob it was parsed from.
struct ModelView {
    Header header{};
    std::span<const Part> parts;
    std::span<const std::uint16_t> samples;  ///< base samples, a part: face by row by column, (base+1)^2 a face
    std::span<const std::uint8_t> offsets;   ///< beside samples: the triangle-tunnelling offset (eq. 12), outwards
    std::span<const std::int8_t> smoothing;  ///< beside samples: smoothed map less the map
    std::span<const std::uint16_t> cells;    ///< base cells, a part: face by row by column, base^2 a face
    std::span<const Block> blocks;
    std::span<const std::uint16_t> splits;
    std::span<const std::uint32_t> specials;  ///< offsets into a part's pool
    std::span<const std::uint16_t> pool;
    // Exact layer; empty when the model was baked without it.
    std::span<const float> vertices;                ///< #vertices by 3, model space
    std::span<const std::uint16_t> triangles16;     ///< #triangles by 3, where the model has at most 65536 vertices
    std::span<const std::uint32_t> triangles32;     ///< #triangles by 3, where it has more
    std::span<const std::uint16_t> triangle_part;   ///< #triangles: the part each belongs to, and SurfaceFlag bits
    std::span<const std::uint32_t> piece_triangle;  ///< #pieces, ascending: the crossed triangle of which each is visible
    std::span<const float> pieces;                  ///< nine a piece: its corners, turned as the triangle is
    NormalArrays normal;
    Locator locator{};
    std::span<const std::uint32_t> bricks;      ///< first place of a brick, or k_free_brick and its gap; x fastest
    std::span<const std::uint32_t> places;      ///< 64 a stored brick, x fastest
    std::span<const std::uint32_t> part_lists;  ///< four parts each, lowest byte first
    std::span<const std::uint32_t> planes;      ///< of flat places, see plane_slot
    std::span<const Seed> seeds;
    std::span<const std::uint32_t> near_bricks;  ///< with the exact layer: a brick's record in near, or k_no_candidates
    std::span<const std::uint16_t> near;         ///< see NearRecord
    std::span<const std::uint8_t> rises;         ///< with near: beside places, see k_rise_step
    Measured measured{};                         ///< by bake
    std::string_view made_by, source, options;   ///< provenance
    std::uint64_t mesh_hash = 0;                 ///< mesh::content_hash of the mesh that was baked; 0: not known
};

[[nodiscard]] constexpr bool has_locator(const ModelView& view) { return !view.bricks.empty(); }
[[nodiscard]] constexpr bool has_exact(const ModelView& view) { return !view.triangle_part.empty(); }
/// Vertex k (0 to 2) of a triangle.
[[nodiscard]] constexpr std::uint32_t triangle_vertex(const ModelView& view, std::uint32_t triangle, std::uint32_t k)
{
    const std::size_t i = 3 * static_cast<std::size_t>(triangle) + k;
    return view.triangles16.empty() ? view.triangles32[i] : view.triangles16[i];
}
/// Triangles by which an exact answer is found in a place of a brick: one of them is the nearest, for any point of it, and no
/// buried one is among them. Empty where there are too many to list: all of the mesh are tried.
struct CandidateList {
    const std::uint16_t* table;  ///< of the brick's triangles: two values each, the low one first, if wide
    const std::uint16_t* refs;   ///< indices into it: two in a value, the low one first, if narrow; null: all of the table
    std::uint32_t first, count;  ///< of refs
    bool wide, narrow;
    [[nodiscard]] constexpr std::uint32_t operator[](std::uint32_t i) const
    {
        const std::uint32_t at = first + i;
        const std::uint32_t t = refs == nullptr ? at : narrow ? (refs[at >> 1] >> (8 * (at & 1u))) & 0xffu : refs[at];
        return wide ? table[2 * t] | std::uint32_t{table[2 * t + 1]} << 16 : table[t];
    }
    /// n of them from i on.
    constexpr void read(std::uint32_t i, std::uint32_t n, std::int32_t* out) const
    {
        if (wide || refs == nullptr) {
            for (std::uint32_t k = 0; k < n; ++k) out[k] = static_cast<std::int32_t>((*this)[i + k]);
        } else if (narrow) {
            for (std::uint32_t k = 0, at = first + i; k < n; ++k, ++at)
                out[k] = table[(refs[at >> 1] >> (8 * (at & 1u))) & 0xffu];
        } else {
            for (std::uint32_t k = 0, at = first + i; k < n; ++k, ++at) out[k] = table[refs[at]];
        }
    }
};
constexpr bool near_is_wide(const ModelView& view) { return view.triangle_part.size() > 0x10000; }
/// A brick's record in ModelView::near: which of its places are not Free, one bit each; how many triangles it has; where each
/// such place's refs start, and where the last ones end; the triangles; the refs, bytes where there are 256 triangles or fewer. A
/// place without refs has all triangles of the brick.
struct NearRecord {
    std::uint64_t occupied;
    std::uint32_t triangles;
    const std::uint16_t* starts;
    const std::uint16_t* table;
    const std::uint16_t* refs;
};
inline constexpr std::uint32_t k_near_head = 5;  ///< values before the starts
constexpr NearRecord near_record(const std::uint16_t* values, bool wide)
{
    NearRecord r{0, values[4], values + k_near_head, nullptr, nullptr};
    for (std::uint32_t k = 0; k < 4; ++k) r.occupied |= std::uint64_t{values[k]} << 16 * k;
    r.table = r.starts + std::popcount(r.occupied) + 1;
    r.refs = r.table + r.triangles * (wide ? 2u : 1u);
    return r;
}
/// place: from 0 to 63 in its brick, 0 of a deep one. @pre the place is not Free
[[nodiscard]] constexpr CandidateList candidate_list(const ModelView& view, std::size_t brick, std::uint32_t place)
{
    const bool wide = near_is_wide(view);
    const NearRecord r = near_record(view.near.data() + view.near_bricks[brick], wide);
    const std::uint16_t* start = r.starts + std::popcount(r.occupied & ((std::uint64_t{1} << place) - 1));
    if (start[0] == start[1]) return {r.table, nullptr, 0, r.triangles, wide, false};
    return {r.table, r.refs, start[0], static_cast<std::uint32_t>(start[1] - start[0]), wide, r.triangles <= 256};
}
[[nodiscard]] constexpr Vec3f vec3(const float* v) { return {v[0], v[1], v[2]}; }
[[nodiscard]] shape::Superquadricf superquadric_of(const Part& part) noexcept;
/// @pre the model has normal maps.
[[nodiscard]] NormalMapView normal_map_of(const ModelView& view, std::size_t part) noexcept;

/// Mesh units -> model space, where queries live. In double up to the last step: coordinates may be far from zero.
[[nodiscard]] constexpr Vec3f to_model_space(const Header& header, Vec3d p)
{
    return cast<float>((p - Vec3d{header.origin[0], header.origin[1], header.origin[2]}) / header.unit);
}
/// Model space -> mesh units. Lengths: times header.unit; directions stay as they are.
[[nodiscard]] constexpr Vec3d to_mesh_units(const Header& header, Vec3f p)
{
    return header.unit * cast<double>(p) + Vec3d{header.origin[0], header.origin[1], header.origin[2]};
}

}  // namespace sqmap::model
