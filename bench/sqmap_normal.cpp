// The paper's own projection, a layer and a foot search a name: distances along the superquadrics' normals.
#include "normal_maps.h"
#include "sqmap/paper/model.h"

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
    constexpr std::array k_queries{NormalMethod{query::Layer::Two, paper::Projector::Printed},
                                   NormalMethod{query::Layer::One, paper::Projector::Newton},
                                   NormalMethod{query::Layer::Two, paper::Projector::Newton},
                                   NormalMethod{query::Layer::Three, paper::Projector::Newton},
                                   NormalMethod{query::Layer::Two, paper::Projector::Pyramid},
                                   NormalMethod{query::Layer::Three, paper::Projector::Pyramid},
                                   NormalMethod{query::Layer::Three, paper::Projector::Newton, true}};
    return make_normal_query(setting, std::move(maps), k_queries[static_cast<std::size_t>(which)]);
}

}  // namespace sqmap::bench
