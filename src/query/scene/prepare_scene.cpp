// Constructors of pairs and scenes, which allocate: they run outside the frame.
#include "sqmap/query/scene.h"

#include <algorithm>
#include <bit>

namespace sqmap::query {

PairWorkspace::PairWorkspace(std::size_t contacts)
    : found_(contacts), head_(std::bit_ceil(contacts)), next_(contacts), contacts_(2 * contacts)
{
}

Scene::Scene(std::size_t contacts_in_a_direction) : workspace_(contacts_in_a_direction) {}

BodyId Scene::add(const model::ModelView* model, const Probe* probe, const Pose& pose)
{
    BodyId id = static_cast<BodyId>(bodies_.size());
    if (free_.empty()) {
        bodies_.emplace_back();
        spheres_.emplace_back();
        // As many as there are bodies, so that removing them allocates nothing.
        free_.reserve(bodies_.capacity());
    } else {
        id = free_.back();
        free_.pop_back();
    }
    bodies_[id] = {model, probe, {}};
    order_.push_back({0, id});
    sorted_.resize(order_.size());
    for (auto* v : {&x_, &y_, &z_, &radius_}) v->resize(order_.size() + k_block);
    (void)set_pose(id, pose);
    return id;
}

void Scene::remove(BodyId id)
{
    const auto at = std::find_if(order_.begin(), order_.end(), [&](const Entry& e) { return e.id == id; });
    if (at == order_.end()) return;
    order_.erase(at);
    bodies_[id] = {};
    free_.push_back(id);
    stale_ = true;
}

}  // namespace sqmap::query
