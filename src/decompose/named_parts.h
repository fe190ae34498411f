// Named parts: the parts of a mesh as a person would name them, each made of one or several parts of a partition.
#pragma once

#include "sqmap/decompose/decompose.h"

#include <cstdint>
#include <vector>

namespace sqmap::decompose {

struct Mirror;

/// Thresholds of named_parts(), free of scale: parts are joined across a border where the surface turns inwards by less on
/// average; radians.
struct NamedPartOptions {
    double least_bend = 0.12;    ///< of a border that was cut for curvature or for the fit
    double salient_bend = 0.04;  ///< of a border that was cut because a part protrudes, which speaks for the border already
};

/// Joins parts whose border a person would not cut, because the surface hardly turns inwards across it. partition: of the mesh's
/// triangles.
/// mirror: of the mesh, or null; parts at mirror images are joined alike. Any units and frame. Returns the number of each part's
/// named part (#parts), counted from zero in the order of their first part. Cost: O(n log n) in the mesh. Thread-safe. @throw
/// std::bad_alloc Source: the minima rule (D. D. Hoffman, W. A. Richards, "Parts of recognition", Cognition 18, 1984).
[[nodiscard]] std::vector<std::uint32_t> named_parts(const mesh::Mesh& mesh, const Partition& partition,
                                                     const NamedPartOptions& options = {}, const Mirror* mirror = nullptr);

/// Thresholds of cut_creases(), free of scale.
struct CreaseOptions {
    double least_bend = 0.4;    ///< radians, by which the surface turns inwards across the new border on average
    double slight_bend = 0.12;  ///< is enough where the cut gains more than that:
    double least_gain = 0.55;   ///< share of the volume of the part's ellipsoid of inertia
    double least_area = 0.03;   ///< of each piece, of the surface area
    std::uint32_t max_parts = 24;
};

/// Cuts parts where a person would though no test of section 3 does: where a neck or a step of a shaft runs through one, or where
/// arms meet that lie in no common ellipsoid. Of the candidates of Cutter::split the most concave is cut, while there is one.
/// partition: of the mesh's triangles. Any units and frame. Cost: that of Cutter::split for each large part. Thread-safe.
/// @throw std::bad_alloc
[[nodiscard]] Partition cut_creases(const mesh::Mesh& mesh, Partition partition, const CreaseOptions& options);

/// The label that most of the triangles of each part have (#parts), numbered anew from zero in the order of their first part.
/// label_of_triangle: #triangles.
[[nodiscard]] std::vector<std::uint32_t> labels_of_parts(const Partition& partition,
                                                         const std::vector<std::uint32_t>& label_of_triangle);

}  // namespace sqmap::decompose
