// Wrapping: a solid around a surface that no smaller cure closes; and how far a cured mesh is from the one it was made of, both
// ways. Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/mesh/mesh.h"
#include "sqmap/mesh/words.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace sqmap::mesh {

/// Distances from points of one surface to the nearest of another, in the unit of the meshes. Mean and p99 weigh by area.
struct Distances {
    double mean = 0, p99 = 0, max = 0;
};

/// Effect of a cure on a surface.
struct Deviation {
    Distances input_to_result;                    ///< from all of the input's surface
    std::optional<Distances> bounding_to_result;  ///< from the input's surface that bounds the solid, of a wrapped one
    Distances result_to_input;                    ///< from the result's surface without its made-up part
    double made_up_area = 0;                      ///< unit squared
    double made_up_share = 0;                     ///< of the result's area
};

/// Measured at `samples` points spread evenly over each surface, always the same ones, and, for the greatest distance, at as many
/// of its vertices. input: any triangles, not empty. made_up: #triangles of the result, non-zero where no input stood; empty for
/// none. Cost: n log n in the triangles, samples times the logarithm.
[[nodiscard]] Deviation deviation(const Mesh& input, const Mesh& result, std::span<const std::uint8_t> made_up = {},
                                  std::uint32_t samples = 50'000);

/// Distances from the input's surface where it bounds the solid: where the generalized winding number of the input as it is
/// oriented is above 1/2 on one side and not on the other. Inner walls, and sheets that bound nothing, are left out. Without any
/// such surface all are 0. Arguments and cost as above, and two winding numbers a sample.
[[nodiscard]] Distances bounding_distances(const Mesh& input, const Mesh& result, std::uint32_t samples = 50'000);

/// How closely a mesh is wrapped, and how far that may grow.
struct WrapOptions {
    double tolerance = 0.002;              ///< share of R_max; the grid's cells are as large as it allows
    double thickness = 0.003;              ///< least thickness of shells made of sheets, share of R_max; at most 2 tolerance
    std::uint32_t max_triangles = 60'000;  ///< of the result; wins over the tolerance
    std::uint64_t max_cells = 2'000'000;   ///< of the grid that the input touches: bounds memory (about 400 bytes each) and time
};

/// Its numbers that doors set; wrap() itself takes finer tolerances.
inline constexpr NumberOption<WrapOptions> k_wrap_numbers[] = {
    {"wrap_tolerance", &WrapOptions::tolerance, {1.6e-3, 0.1}},
    {"max_wrapped_faces", &WrapOptions::max_triangles, {100, 1e9}},
    {"max_cells", &WrapOptions::max_cells, {1e4, 1e9}},
};

/// A wrapped mesh, and its distance from the input.
struct WrapResult {
    Mesh mesh;                          ///< canonical, closed, manifold, outward; empty where no solid was found
    std::vector<std::uint8_t> made_up;  ///< #triangles, 1 where the input has no surface within the tolerance
    double cell = 0;                    ///< side of the grid's cells, mesh units
    double thickness = 0;               ///< of the shells, mesh units; 0: none was needed
    double bound = 0;                   ///< largest error that decimation took on, mesh units
    Distances moved;                    ///< of the input's surface that bounds the solid, see bounding_distances; mesh units
};

/// Wraps triangles: the solid where the generalized winding number of the triangles as they are oriented is above 1/2
/// (Jacobson, Kavan, Sorkine-Hornung 2013), and a shell of the least thickness about sheets that bound no such solid. The
/// result is closed, manifold and oriented; its vertices lie on the input wherever that bounds the solid, also on its sharp
/// edges and corners. Parts smaller than two cells are left out. Where more than 1 % of the
/// surface that bounds the solid misses the tolerance, it is wrapped again in smaller cells, once. Thinner walls than the
/// thickness become that thick. points: mesh units, finite; triangles: indices in range, in any order, with or without area.
/// @throw RefusedMesh with E_LIMIT, before any work, where the triangles are more than half of max_cells
/// @throw InvalidInput for an option out of range
/// Cost: cells that the surface touches times the logarithm of #triangles; the same result on every run.
[[nodiscard]] WrapResult wrap(std::span<const Vec3d> points, std::span<const Triangle> triangles,
                              const WrapOptions& options = {});

/// How closely an outer solid stands about its input, and what it closes.
struct OuterOptions {
    double tolerance = 0.002;              ///< share of R_max that its surface may be away from the input
    double gap = 0.01;                     ///< share of R_max: gaps narrower than that are closed
    std::uint32_t max_triangles = 60'000;  ///< of the result; wins over the tolerance
    std::uint64_t max_cells = 2'000'000;   ///< of the grid that the input touches
};

inline constexpr OptionRange k_gap_range{0, 0.2};  ///< of OuterOptions::gap

/// An outer solid.
struct OuterResult {
    Mesh mesh;                          ///< closed, manifold, outward; empty where the input has no area
    std::vector<std::uint8_t> made_up;  ///< #triangles, 1 where it closes a gap
    double cell = 0;                    ///< side of the grid's cells, mesh units
};

/// The solid that cannot be reached from outside through gaps narrower than a width: sheets, screws and inner parts become one
/// body, its cavities are filled. Every input triangle lies in its inside (see first_not_enclosed). Gaps up to three cells wider
/// than the width may be closed, too. points: mesh units, finite; triangles: indices in range, in any order and orientation, with
/// or without area.
/// @throw InvalidInput for an option out of range
/// Cost: corners of a grid over the box, and cells that the surface touches times the logarithm of #triangles; the same result
/// on every run.
[[nodiscard]] OuterResult outer_solid(std::span<const Vec3d> points, std::span<const Triangle> triangles,
                                      const OuterOptions& options = {});

/// The first triangle that is not proven to lie in a solid's inside with a margin about it: one that no plane parts from some
/// triangle of the solid, or whose first corner the solid does not hold. Nothing where all are proven to. solid: closed.
[[nodiscard]] std::optional<std::uint32_t> first_not_enclosed(std::span<const Vec3d> points, std::span<const Triangle> triangles,
                                                              const Mesh& solid, double margin);

}  // namespace sqmap::mesh
