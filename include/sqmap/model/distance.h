// The arrays from which signed distances outside a model's locator are answered: a hierarchy of boxes over its triangles, and a
// tree of bounds about it. Plain data: any number of threads may read it.
#pragma once

#include <cstdint>

namespace sqmap::model {

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

}  // namespace sqmap::model
