// The paper's own projection, a layer and a foot search a name: distances along the superquadrics' normals.
#include "paper_maps.h"
#include "sqmap/paper/model.h"

#include <array>
#include <map>

namespace sqmap::bench {

std::unique_ptr<Method> make_sqmap_normal(const Setting& setting, int which)
{
    // Made once a setting, however many layers ask.
    static std::map<const Setting*, std::weak_ptr<const PaperMaps>> made;
    std::shared_ptr<const PaperMaps> maps = made[&setting].lock();
    if (maps == nullptr) {
        maps = std::make_shared<const PaperMaps>(std::make_shared<const PaperParts>(setting), Density{});
        made[&setting] = maps;
    }
    constexpr std::array k_queries{PaperMethod{query::Layer::Two, paper::Projector::Printed},
                                   PaperMethod{query::Layer::One, paper::Projector::Newton},
                                   PaperMethod{query::Layer::Two, paper::Projector::Newton},
                                   PaperMethod{query::Layer::Three, paper::Projector::Newton},
                                   PaperMethod{query::Layer::Two, paper::Projector::Pyramid},
                                   PaperMethod{query::Layer::Three, paper::Projector::Pyramid},
                                   PaperMethod{query::Layer::Three, paper::Projector::Newton, true}};
    return make_paper_query(setting, std::move(maps), k_queries[static_cast<std::size_t>(which)]);
}

}  // namespace sqmap::bench
