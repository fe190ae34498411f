// Evaluation of models whose projections differ: each kind of map compares itself with the mesh along its own.
#pragma once

#include "sqmap/bake/evaluate.h"

#include <cstdint>
#include <functional>
#include <optional>

namespace sqmap::bake {

/// Eq. 35 at one point: map and mesh have a crossing on the point's ray, or one of them does, and how far apart they are.
struct AlongProjection {
    bool map = false, mesh = false;
    double error = 0;  ///< model units
};

/// Compares a part's map with the mesh at a point in its superquadric, model space. Nothing where the map does not answer there.
using CompareAlong = std::function<std::optional<AlongProjection>(std::uint32_t part, Vec3f point, query::Layer layer)>;

/// Evaluates as evaluate() does. model: in model space (model::normalized).
[[nodiscard]] Evaluation evaluate_along(const model::ModelView& model, const mesh::Solid& solid, const EvaluateOptions& options,
                                        const CompareAlong& compare);

}  // namespace sqmap::bake
