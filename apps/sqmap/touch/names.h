// The words that options and traces have for modes, shadings, frictions, kernels and layers.
#pragma once

#include "common/layer_name.h"
#include "sqmap/haptic/step.h"
#include "sqmap/paper/model.h"

#include <algorithm>
#include <map>
#include <string>

namespace sqmap::app {

inline const std::map<std::string, haptic::Mode> k_modes{
    {"direct", haptic::Mode::Direct}, {"proxy", haptic::Mode::Proxy}, {"coupled", haptic::Mode::Coupled}};
inline const std::map<std::string, haptic::Shading> k_shadings{
    {"levelled", haptic::Shading::Levelled}, {"consistent", haptic::Shading::Consistent}, {"mean", haptic::Shading::Mean}};
inline const std::map<std::string, bool> k_forces{{"full", false}, {"paper", true}};
inline const std::map<std::string, paper::Projector> k_projectors{
    {"newton", paper::Projector::Newton}, {"pyramid", paper::Projector::Pyramid}, {"printed", paper::Projector::Printed}};
inline const std::map<std::string, Friction> k_frictions{
    {"none", Friction::None}, {"coulomb", Friction::Coulomb}, {"paper", Friction::Paper}};
inline const std::map<std::string, haptic::Kernel> k_kernels{{"ball", haptic::Kernel::Ball}, {"shell", haptic::Kernel::Shell}};
inline const std::map<std::string, query::Layer> k_touch_layers =
    layers_by_name({query::Layer::Auto, query::Layer::Two, query::Layer::Three, query::Layer::Exact, query::Layer::Gate});

template <class Value>
std::string name_of(const std::map<std::string, Value>& names, Value value)
{
    const auto at = std::find_if(names.begin(), names.end(), [&](const auto& entry) { return entry.second == value; });
    return at == names.end() ? "?" : at->first;
}

}  // namespace sqmap::app
