// The layer that answers a query, and the code that runs it.
#pragma once

#include "model/chart.h"
#include "sqmap/query/options.h"

namespace sqmap::query {

/// Section 4.2, step 4: the part's base map is so sparse that layer 3 is worth its time.
[[nodiscard]] constexpr bool passes_gate(const model::Part& part, std::uint32_t gate)
{
    return part.base * part.base * model::k_faces < std::uint64_t{gate} * part.vertex_count;
}

/// The exact layer is what options stand for, and the model has none.
[[nodiscard]] bool lacks_exact(const model::ModelView& model, const QueryOptions& options) noexcept;

/// QueryOptions::margin in model units; zero where there is none.
[[nodiscard]] inline float margin_in_model(const model::ModelView& model, const QueryOptions& options)
{
    return options.margin > 0 ? static_cast<float>(options.margin / model.header.unit) : 0.f;
}

/// A margin counts from the triangles, not from maps. options.layer: chosen
[[nodiscard]] inline bool is_margin_proven(const model::ModelView& model, const QueryOptions& options)
{
    return options.margin > 0 && !options.offset && options.layer != Layer::One && model.answers == nullptr &&
           model::has_exact(model) && model::has_distance(model);
}

}  // namespace sqmap::query
