// The charts' verdict on one point: the kernel of probe queries with one lane.
#pragma once

#include "sqmap/model/model.h"
#include "sqmap/query/options.h"

#include <cstdint>

namespace sqmap::query {

/// The side of a point.
struct PointVerdict {
    bool inside = false, certain = true;
    std::int32_t part = -1;  ///< the part that decided; -1: no chart holds the point, so it is free
};

/// The side of a finite point, model space, by the charts of all parts; gate: k_L of Layer::Gate. Cost: a look-up for each part
/// whose sphere holds the point, until one has a proof. @pre the model's parts have central maps
[[nodiscard]] PointVerdict verdict_by_charts(const model::ModelView& model, Vec3f point, Layer layer,
                                             std::uint32_t gate) noexcept;

}  // namespace sqmap::query
