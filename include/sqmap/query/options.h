// Options of a query: the layer that answers, and where the surface is.
// Plain data: any number of threads may read it.
#pragma once

#include "sqmap/model/model.h"

#include <cstdint>

namespace sqmap::query {

/// The layer that answers a query: each is slower than the one before it, and errs less.
enum class Layer : std::uint8_t {
    One,    ///< superquadrics and polytopes: errs towards contact, except where the locator proves points of a probe to be free
    Two,    ///< one plane of the locator; in a model without a locator the base map
    Three,  ///< the locator's planes where they are the surface, else the refined map
    Exact,  ///< the mesh's own triangles
    Auto,   ///< the cheapest of the four whose stored error is within QueryOptions::tolerance, else Exact
    Gate,   ///< section 4.2 step 4, for each part: Three where its base map is sparse, else Two
};

/// k_L of section 4.2, its default: Layer 3 is worth its time while a part has fewer base samples than k_L times its
/// vertices.
inline constexpr std::uint32_t k_gate = 10;

/// Options of every query: points, probes, pairs, scenes, skins, swept motion. offset and margin are for probes made of
/// triangles, smoothed_map is for force. What only paper models answer is in paper::QueryOptions.
struct QueryOptions {
    Layer layer = Layer::Three;
    double tolerance = 0;         ///< of Layer::Auto: a depth error, the mesh's units; 0: always Exact
    std::uint32_t gate = k_gate;  ///< k_L of Layer::Gate; 0: never Layer 3
    bool first_only = false;      ///< stop at the first contact, a yes or no; points ignore it
    /// Move the surface out by the stored offset (eq. 12), so that faces do not tunnel (not layer One). Central models then
    /// answer a probe point by point, ten times slower; paper models keep their speed.
    bool offset = false;
    /// Length in the mesh's units by which the surface is moved out everywhere, or by the offset where that is more. Not above
    /// zero, or NaN: none. Central models alone, as slow as with offset. Points outside are measured from the triangles, where
    /// the model has them: PairResult::edge_length says what that finds.
    double margin = 0;
    /// Points, and probes against paper models, all layers but One and Exact: depth and normal of the smoothed map.
    bool smoothed_map = false;
};

/// The layer that options stand for: Auto is resolved by the errors that bake measured (ModelView::measured), Exact of a model
/// without it is Three. Gate stays.
[[nodiscard]] Layer chosen_layer(const model::ModelView& model, const QueryOptions& options) noexcept;

}  // namespace sqmap::query
