// The paper's own projection, a layer and a foot search a name: distances along the superquadrics' normals.
#include "normal_maps.h"

#include <array>
#include <map>

namespace sqmap::bench {

std::unique_ptr<Method> make_sqmap_normal(const Setting& setting, int which)
{
    // Made once a setting, however many layers ask.
    static std::map<const Setting*, std::weak_ptr<const NormalMaps>> made;
    std::shared_ptr<const NormalMaps> maps = made[&setting].lock();
    if (maps == nullptr) {
        maps = std::make_shared<const NormalMaps>(std::make_shared<const NormalParts>(setting), Density{});
        made[&setting] = maps;
    }
    struct Query {
        query::Layer layer;
        query::Projector projector;
    };
    constexpr std::array k_queries{
        Query{query::Layer::Two, query::Projector::Printed}, Query{query::Layer::One, query::Projector::Newton},
        Query{query::Layer::Two, query::Projector::Newton},  Query{query::Layer::Three, query::Projector::Newton},
        Query{query::Layer::Two, query::Projector::Pyramid}, Query{query::Layer::Three, query::Projector::Pyramid}};
    const auto [layer, projector] = k_queries[static_cast<std::size_t>(which)];
    return make_normal_query(setting, std::move(maps), layer, projector);
}

}  // namespace sqmap::bench
