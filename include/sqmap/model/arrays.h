// The arrays of a model, each described once: a query sees them as spans, bake fills them as vectors, and the file, the parser
// and the hash visit them by name. A new array is a member here, a line in its group's each(), and a field of src/model/sqmap.fbs
// with the same name and type; a new group is listed at the end of this file too. What the words mean is known to the library
// alone: queries read them.
// Plain data: any number of threads may read it.
#pragma once

#include "sqmap/math/half_space.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace sqmap::model {

/// An array of a model that lies in memory or in a mapped file.
template <class T>
using ArrayView = std::span<const T>;

/// A part's records in an array that holds those of all parts.
struct Slice {
    std::uint32_t first, count;
};

/// Least and greatest stored w of a part's own surface over two by two base cells; lo > hi: none.
struct Block {
    std::uint16_t lo, hi;
};

inline constexpr std::uint32_t k_hierarchy_width = 16;  ///< children of a node
inline constexpr std::uint32_t k_hierarchy_leaf = 8;    ///< entries of a leaf

/// Boxes of a node's children: origin + step code, rounded outwards. Layout equals the FlatBuffers struct HierarchyNode.
struct HierarchyNode {
    float origin[3];
    float step;
    std::uint8_t lo[3][k_hierarchy_width], hi[3][k_hierarchy_width];
};

/// Sixteen leaves, each a box that holds its triangles: centre at origin + step code, height along a normal, widths along axes
/// turned about it, half widths and half height in steps of their own, rounded outwards. Layout equals the FlatBuffers struct
/// HierarchyGroup.
struct HierarchyGroup {
    float origin[3];
    float step, width_step, height_step;
    std::uint8_t centre[3][k_hierarchy_width];
    std::uint8_t width[2][k_hierarchy_width], height[k_hierarchy_width];
    std::uint8_t normal[2][k_hierarchy_width];  ///< octahedral, 8 + 8 bits
    std::uint8_t turn[k_hierarchy_width];       ///< tangent of half the angle, 255 a right angle
};

/// A point of the surface, in steps of the root's side from its lowest corner, and the outward normal there, octahedral, 8 + 8
/// bits. Layout equals the FlatBuffers struct SurfaceSample.
struct SurfaceSample {
    std::uint16_t point[3];
    std::uint8_t normal[2];
};

/// Layout equals the FlatBuffers struct Distance.
struct DistanceHeader {
    float root[3];          ///< centre of the tree of bounds, model space
    float half;             ///< half of its side; 0: the model has none
    float band;             ///< how far on either side of the surface distances are exact, model units
    std::uint32_t entries;  ///< of the hierarchy, without padding
};

/// The grid of the locator's cells. Layout equals the FlatBuffers struct Locator.
struct Locator {
    float origin[3];          ///< lowest corner, model space
    float cell;               ///< side of a cell, model units
    std::uint32_t bricks[3];  ///< of four by four by four cells, along x, y, z; 0: the model has no locator
    float plane_reach;        ///< greatest distance that a plane can have, and one, in cells
};

/// A plane that touches the surface where it is nearest to some point of a locator cell, and the part whose chart shows it: the
/// start of the search for the nearest surface where the cell has no planes. Layout equals the FlatBuffers struct Seed.
struct Seed {
    std::uint32_t direction;  ///< part and outward normal
    std::uint32_t extent;     ///< distance and reach
};

/// The superquadric, the polytope, and what both hold.
enum class Bound : std::uint8_t { Superquadric, Polytope, Both };

/// How tightly a part's bounds hold it, or their union the whole; model units. Layout equals the FlatBuffers struct BoundFigures.
struct BoundFigures {
    float solid_volume;    ///< enclosed by the part's surface and its caps; of the whole by its surface; 0 of what is no solid
    float volume[3];       ///< of each Bound; for the whole of the parts' union
    float excess[3];       ///< support excess of each Bound, max over directions u of h_bound(u) - h_surface(u)
    float standard_error;  ///< of volume[Both] and of the volumes of the whole, had the sample points been random
};

/// Values of a split cell's record.
inline constexpr std::uint32_t k_split_size = 9;

// Each group's each(visit, of...) calls visit(name, array of every of...) for its arrays, in the file's order.

/// Central maps of all parts, part after part.
template <template <class> class Array>
struct CentralArrays {
    Array<std::uint16_t> samples;  ///< base samples, a part: face by row by column, (base + 1)^2 a face
    Array<std::uint8_t> offsets;   ///< beside samples: the triangle-tunnelling offset (eq. 12), outwards
    Array<std::int8_t> smoothing;  ///< beside samples: smoothed map less the map
    Array<std::uint16_t> cells;    ///< base cells, a part: face by row by column, base^2 a face
    Array<Block> blocks;
    Array<std::uint16_t> splits;    ///< records of split cells
    Array<std::uint32_t> specials;  ///< offsets into a part's pool
    Array<std::uint16_t> pool;      ///< layered records
    /// In the file's order.
    template <class Visit, class... Of>
    static constexpr void each(Visit&& visit, Of&... of)
    {
        visit("samples", of.samples...);
        visit("offsets", of.offsets...);
        visit("smoothing", of.smoothing...);
        visit("cells", of.cells...);
        visit("blocks", of.blocks...);
        visit("splits", of.splits...);
        visit("specials", of.specials...);
        visit("pool", of.pool...);
    }
    /// Calls visit(a part's slice, values a record, array of every of...) in the same order. part: has the slices of Part.
    template <class Visit, class Part, class... Of>
    static constexpr void each_slice(Visit&& visit, Part& part, Of&... of)
    {
        visit(part.samples, 1u, of.samples...);
        visit(part.samples, 1u, of.offsets...);
        visit(part.samples, 1u, of.smoothing...);
        visit(part.cells, 1u, of.cells...);
        visit(part.blocks, 1u, of.blocks...);
        visit(part.splits, k_split_size, of.splits...);
        visit(part.specials, 1u, of.specials...);
        visit(part.pool, 1u, of.pool...);
    }
};

/// The mesh of the exact layer; empty in a model that was baked without it.
template <template <class> class Array>
struct MeshArrays {
    Array<float> vertices;                ///< #vertices by 3, model space
    Array<std::uint16_t> triangles16;     ///< #triangles by 3, where the model has at most 65536 vertices
    Array<std::uint32_t> triangles32;     ///< #triangles by 3, where it has more
    Array<std::uint16_t> triangle_part;   ///< #triangles: see part_of_triangle
    Array<std::uint32_t> piece_triangle;  ///< #pieces, ascending: the crossed triangle of which each is visible
    Array<float> pieces;                  ///< nine a piece: its corners, turned as the triangle is
    /// In the file's order.
    template <class Visit, class... Of>
    static constexpr void each(Visit&& visit, Of&... of)
    {
        visit("vertices", of.vertices...);
        visit("triangles16", of.triangles16...);
        visit("triangles32", of.triangles32...);
        visit("triangle_part", of.triangle_part...);
        visit("piece_triangle", of.piece_triangle...);
        visit("pieces", of.pieces...);
    }
};

/// The locator; empty in a model without one.
template <template <class> class Array>
struct LocatorArrays {
    Locator locator{};                   ///< the grid; no array
    Array<std::uint32_t> bricks;         ///< x fastest
    Array<std::uint32_t> locator_cells;  ///< 64 a stored brick, x fastest
    Array<std::uint32_t> part_lists;     ///< four parts each, lowest byte first
    Array<std::uint32_t> planes;         ///< of flat cells
    Array<Seed> seeds;
    /// In the file's order.
    template <class Visit, class... Of>
    static constexpr void each(Visit&& visit, Of&... of)
    {
        visit("bricks", of.bricks...);
        visit("locator_cells", of.locator_cells...);
        visit("part_lists", of.part_lists...);
        visit("planes", of.planes...);
        visit("seeds", of.seeds...);
    }
};

/// The exact layer's candidate lists; empty without a locator or a mesh.
template <template <class> class Array>
struct CandidateArrays {
    Array<std::uint32_t> near_bricks;  ///< beside bricks: where a brick's record is in near
    Array<std::uint16_t> near;         ///< records of candidate lists
    Array<std::uint8_t> rises;         ///< beside locator_cells
    /// In the file's order.
    template <class Visit, class... Of>
    static constexpr void each(Visit&& visit, Of&... of)
    {
        visit("near_bricks", of.near_bricks...);
        visit("near", of.near...);
        visit("rises", of.rises...);
    }
};

/// Convex polytopes beside the superquadrics: layer 1 is inside both. Empty in a paper model, which layer 1 of the paper answers,
/// and in models that were baked before there were polytopes.
template <template <class> class Array>
struct BoundArrays {
    Array<std::uint32_t> polytope_ends;  ///< #parts: one past the last of a part's sides
    Array<HalfSpacef> polytope_sides;    ///< part after part; as fit::touching_side makes them
    Array<BoundFigures> bound_figures;   ///< #parts, then the whole
    /// In the file's order.
    template <class Visit, class... Of>
    static constexpr void each(Visit&& visit, Of&... of)
    {
        visit("polytope_ends", of.polytope_ends...);
        visit("polytope_sides", of.polytope_sides...);
        visit("bound_figures", of.bound_figures...);
    }
};

/// The mesh as the caller gave it, for answers in double and in the caller's numbers; in the file a table of its own. Empty in a
/// model without triangles, and where bake left it out (BakeOptions::keep_input).
template <template <class> class Array>
struct InputArrays {
    Array<float> coordinates32;            ///< #vertices by 3, mesh units, where every coordinate is a float
    Array<double> coordinates64;           ///< #vertices by 3, mesh units, where some are not
    Array<std::uint32_t> source_triangle;  ///< #triangles: number in the input, from zero; k_no_source: made up, or not known
    Array<std::uint32_t> source_vertex;    ///< #vertices: the same
    /// In the file's order.
    template <class Visit, class... Of>
    static constexpr void each(Visit&& visit, Of&... of)
    {
        visit("coordinates32", of.coordinates32...);
        visit("coordinates64", of.coordinates64...);
        visit("source_triangle", of.source_triangle...);
        visit("source_vertex", of.source_vertex...);
    }
};
/// The number of what the input does not have.
inline constexpr std::uint32_t k_no_source = 0xffffffffu;

/// The arrays from which signed distances are answered; in the file a table of its own, as the paper maps.
template <template <class> class Array>
struct DistanceArrays {
    DistanceHeader header{};  ///< no array
    /// Level by level, root first. All levels are full but for their last node: children of node i of a level are 16 i to
    /// 16 i + 15 of the next one, those of the last level are groups.
    Array<HierarchyNode> nodes;
    Array<HierarchyGroup> groups;  ///< group i has leaves 16 i to 16 i + 15 of eight entries
    /// Leaf by leaf: triangles that are boundary as a whole, then #triangles + i for piece i; the last leaf repeats its last.
    Array<std::uint16_t> entries16;  ///< where triangles and pieces are at most 65536
    Array<std::uint32_t> entries32;  ///< where they are more
    Array<std::uint16_t> bounds;     ///< nodes of the tree of bounds
    Array<SurfaceSample> samples;    ///< without the exact layer: points spread over the surface

    /// In the file's order.
    template <class Visit, class... Of>
    static constexpr void each(Visit&& visit, Of&... of)
    {
        visit("nodes", of.nodes...);
        visit("groups", of.groups...);
        visit("entries16", of.entries16...);
        visit("entries32", of.entries32...);
        visit("bounds", of.bounds...);
        visit("samples", of.samples...);
    }
};

/// visit(name, array of every of...) for the arrays of parts, maps and mesh.
template <class Visit, class... Of>
constexpr void each_surface_array(Visit&& visit, Of&... of)
{
    visit("parts", of.parts...);
    CentralArrays<ArrayView>::each(visit, of...);
    MeshArrays<ArrayView>::each(visit, of...);
}
/// visit(name, array of every of...) for the arrays of the locator and the exact layer's lists.
template <class Visit, class... Of>
constexpr void each_cell_array(Visit&& visit, Of&... of)
{
    LocatorArrays<ArrayView>::each(visit, of...);
    CandidateArrays<ArrayView>::each(visit, of...);
}

/// Bytes of a group's arrays, say bytes_of<CentralArrays<ArrayView>>(view).
template <class Group>
constexpr std::size_t bytes_of(const Group& group)
{
    std::size_t bytes = 0;
    Group::each([&](const char*, const auto& array) { bytes += array.size() * sizeof(array[0]); }, group);
    return bytes;
}

}  // namespace sqmap::model
