// The layers of a query by the names that options, traces, messages and reports give them.
#pragma once

#include "sqmap/query/point.h"

#include <array>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace sqmap::app {

struct LayerName {
    query::Layer layer;
    std::string_view name;
};

/// The one table, in the order of the layers.
inline constexpr std::array<LayerName, 6> k_layer_names{{{query::Layer::One, "1"},
                                                         {query::Layer::Two, "2"},
                                                         {query::Layer::Three, "3"},
                                                         {query::Layer::Exact, "exact"},
                                                         {query::Layer::Auto, "auto"},
                                                         {query::Layer::Gate, "gate"}}};

/// Nothing for a name that is not in the table.
[[nodiscard]] std::optional<query::Layer> layer_named(std::string_view name);
[[nodiscard]] std::string_view layer_name(query::Layer layer);
/// Names and layers of an option that takes these layers alone.
[[nodiscard]] std::map<std::string, query::Layer> layers_by_name(std::initializer_list<query::Layer> layers);

}  // namespace sqmap::app
