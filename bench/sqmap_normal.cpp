// The paper's own projection, a layer a name: distances along the superquadrics' normals, found by the pyramid search.
#include "normal_maps.h"

#include <array>
#include <map>

namespace sqmap::bench {

std::unique_ptr<Method> make_sqmap_normal(const Setting& setting, int layer)
{
    // Made once a setting, however many layers ask.
    static std::map<const Setting*, std::weak_ptr<const NormalMaps>> made;
    std::shared_ptr<const NormalMaps> maps = made[&setting].lock();
    if (maps == nullptr) {
        maps = std::make_shared<const NormalMaps>(std::make_shared<const NormalParts>(setting), Density{});
        made[&setting] = maps;
    }
    if (layer == 0) return make_normal_query(setting, std::move(maps), query::Layer::Two, Search::Printed);
    constexpr std::array k_layers{query::Layer::One, query::Layer::Two, query::Layer::Three};
    return make_normal_query(setting, std::move(maps), k_layers[static_cast<std::size_t>(layer - 1)]);
}

}  // namespace sqmap::bench
