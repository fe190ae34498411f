// Changing a partition: cuts, merges, labels.
#pragma once

#include "cut.h"
#include "sqmap/decompose/decompose.h"

#include <span>
#include <vector>

namespace sqmap::decompose {

[[nodiscard]] std::vector<std::uint32_t> triangles_of(const Partition& partition, std::uint32_t part);

/// Whole mesh, one part per edge-connected component.
[[nodiscard]] Partition components(const CutSurface& surface);

/// A cut through one part.
struct PartCut {
    std::uint32_t part;
    std::span<const std::uint32_t> triangles;  ///< of the part, in triangles_of order
    std::span<const std::uint8_t> near;        ///< #triangles: the side that each is on
    CutKind kind;
    double least_area;  ///< smaller pieces go to the piece around them, mesh units squared
};

/// Cuts the part. The piece with the largest area keeps the label, others get new ones. Returns the number of pieces (1: nothing
/// was cut, the partition is unchanged).
std::uint32_t apply_cut(const CutSurface& surface, Partition& partition, const PartCut& cut);

/// A cut that a surface may have, near a level of a geodesic distance from one of its extremes.
struct CandidateCut {
    double score;                    ///< weighs gain, the depth of the crease and the cut's length; the greatest is the best
    double gain;                     ///< see Split
    std::vector<std::uint8_t> near;  ///< #triangles: the side that each is on
};

/// Some 50 cuts of a part that leave at least least_area on either side. Cost: O(n log n) in the part, 50 times.
[[nodiscard]] std::vector<CandidateCut> candidate_cuts(const CutSurface& part, double least_area);

/// Joins b to a; the last label moves into the gap.
void apply_merge(const CutSurface& surface, Partition& partition, std::uint32_t a, std::uint32_t b);

void order_by_area(const CutSurface& surface, Partition& partition);

/// Labels of which each is connected: the largest piece of each keeps its label, others and triangles without a label
/// (k_no_triangle) go to those around them. former: of each label, those of the partition that it is of; appended to for
/// components without a label.
[[nodiscard]] Partition grown(const CutSurface& surface, const Partition& partition, std::vector<std::uint32_t> labels,
                              std::vector<std::vector<std::uint32_t>> former);

/// The partition of a coarser mesh on this one, by area. labels: #triangles, the coarse part that each lies on; pieces that are
/// apart from the largest of their part go to the parts around them.
[[nodiscard]] Partition carried_over(const mesh::Mesh& mesh, const Partition& coarse, std::vector<std::uint32_t> labels);

}  // namespace sqmap::decompose
