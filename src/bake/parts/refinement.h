// The error-driven pass: splits parts that one superquadric and one projection serve badly, joins parts that it split without
// need.
#pragma once

#include "bake/parts/part.h"
#include "sqmap/bake/bake_types.h"
#include "sqmap/decompose/decompose.h"
#include "sqmap/mesh/solid.h"

#include <vector>

namespace sqmap::bake {

/// A partition and the fits of its parts, in the order of its labels.
struct FittedPartition {
    decompose::Partition partition;
    std::vector<MeasuredPart> parts;
};

/// Fits every part of a partition, caps included.
/// Cost: some 25 ms a part, on options.threads threads; the result does not depend on how many.
[[nodiscard]] FittedPartition fit_partition(const PartsInput& input, const decompose::Partition& partition,
                                            const BakeOptions& options);

/// The same, and then splits the part that is served worst while that pays, up to options.max_parts, and undoes cuts of its own
/// kind that one superquadric serves as well. Cuts of other kinds stay. With input.hidden, parts that are hidden
/// by more than options.max_q2_share are split on while that shows more of the surface. Parts come in order of area.
[[nodiscard]] FittedPartition refine_partition(const PartsInput& input, const decompose::Partition& partition,
                                               const BakeOptions& options);

}  // namespace sqmap::bake
