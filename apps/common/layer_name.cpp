#include "common/layer_name.h"

#include <algorithm>

namespace sqmap::app {

std::optional<query::Layer> layer_named(std::string_view name)
{
    const auto at = std::find_if(k_layer_names.begin(), k_layer_names.end(), [&](const LayerName& n) { return n.name == name; });
    return at == k_layer_names.end() ? std::nullopt : std::optional(at->layer);
}

std::string_view layer_name(query::Layer layer)
{
    const auto at =
        std::find_if(k_layer_names.begin(), k_layer_names.end(), [&](const LayerName& n) { return n.layer == layer; });
    return at == k_layer_names.end() ? std::string_view() : at->name;
}

std::map<std::string, query::Layer> layers_by_name(std::initializer_list<query::Layer> layers)
{
    std::map<std::string, query::Layer> out;
    for (const query::Layer layer : layers) out.emplace(layer_name(layer), layer);
    return out;
}

}  // namespace sqmap::app
