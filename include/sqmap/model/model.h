// The baked model as the runtime sees it: plain structs over one immutable blob that the caller owns.
#pragma once

#include "sqmap/math/vec.h"
#include "sqmap/model/normal_map.h"
#include "sqmap/shape/superquadric.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace sqmap::model {

inline constexpr std::uint32_t k_format_version = 6;

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
    std::uint32_t flags;                ///< see centre_inside and is_fallback
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

/// A block of two by two base cells: the least and greatest stored w of the part's own surface over it; lo > hi:
/// none.
struct Block {
    std::uint16_t lo, hi;
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
/// A plane that touches the surface where it is nearest to some point of a place, and the part whose chart shows it: the start
/// of the search for the nearest surface where the place is not flat. A place may have a chain of several, up to and with the
/// one that has k_last_seed; then the words before the chain say which comes first in an octant of the place.
struct Seed {
    std::uint32_t direction;  ///< 8 bits part, 12 + 12 bits outward unit normal, octahedral
    std::uint32_t extent;     ///< 16 bits signed distance of the centre below the plane, 8 bits reach, flag
};
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
    double layer1_depth_p99 = 0, layer2_depth_p99 = 0;  ///< as depth_p99, of those layers; 0: not measured
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
    std::span<const std::uint16_t> triangle_part;   ///< #triangles: see part_of_triangle
    std::span<const std::uint32_t> piece_triangle;  ///< #pieces, ascending: the crossed triangle of which each is visible
    std::span<const float> pieces;                  ///< nine a piece: its corners, turned as the triangle is
    NormalArrays normal;
    Locator locator{};
    std::span<const std::uint32_t> bricks;      ///< x fastest
    std::span<const std::uint32_t> places;      ///< 64 a stored brick, x fastest
    std::span<const std::uint32_t> part_lists;  ///< four parts each, lowest byte first
    std::span<const std::uint32_t> planes;      ///< of flat places
    std::span<const Seed> seeds;
    std::span<const std::uint32_t> near_bricks;  ///< with the exact layer: where a brick's record is in near
    std::span<const std::uint16_t> near;         ///< records of candidate lists
    std::span<const std::uint8_t> rises;         ///< with near: beside places
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
[[nodiscard]] constexpr Vec3f vec3(const float* v) { return {v[0], v[1], v[2]}; }
[[nodiscard]] shape::Superquadricf superquadric_of(const Part& part) noexcept;
/// True where the chart's centre lies in the solid.
[[nodiscard]] bool centre_inside(const Part& part) noexcept;
/// True where a closed-form ellipsoid bounds the part: no superquadric was found that does.
[[nodiscard]] bool is_fallback(const Part& part) noexcept;
/// Part that a triangle's surface belongs to. @pre has_exact(view) and the triangle exists
[[nodiscard]] std::uint32_t part_of_triangle(const ModelView& view, std::size_t triangle) noexcept;
/// Surface point, model space, of the i-th sample of a part's central map; nothing where its ray meets no surface.
/// @pre i < part.sample_count
[[nodiscard]] std::optional<Vec3f> sample_point(const ModelView& view, const Part& part, std::uint32_t i) noexcept;
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
