// sqmap behind FCL's broad phase (FCL 0.7): a callback that answers pairs of objects by sqmap's contacts, and all others by FCL.
//
//   sqmap_fcl::Solid solid{&view, &probe};              // of the mesh in the object's frame
//   object.setUserData(&solid);
//   sqmap_fcl::Collision collision(workspace);          // one a thread
//   manager.collide(&collision, sqmap_fcl::collide);    // then collision.result
//
// FCL does not set the user data of new objects: set that of others to null. The geometry of an object bounds it in the broad
// phase.
#pragma once

#include <sqmap/query/pair.h>

#include <fcl/broadphase/broadphase_collision_manager.h>
#include <fcl/narrowphase/collision.h>

namespace sqmap_fcl {

/// Target of an object's user data; outlives the object.
struct Solid {
    const sqmap::model::ModelView* model = nullptr;  ///< from model::parse
    const sqmap::query::Probe* probe = nullptr;      ///< the mesh's vertices
};

/// How pairs are answered, and what is found.
struct Collision {
    explicit Collision(sqmap::query::PairWorkspace& space) : workspace(space) {}

    sqmap::query::PairWorkspace& workspace;
    sqmap::query::PairOptions options{};
    fcl::CollisionRequest<double> request{};  ///< num_max_contacts: of all pairs together; enable_contact
    fcl::CollisionResult<double> result{};
};

/// Pose of an object.
inline sqmap::Pose pose_of(const fcl::CollisionObject<double>& object)
{
    const auto& r = object.getRotation();
    const auto& t = object.getTranslation();
    sqmap::Pose pose;
    for (int i = 0; i < 3; ++i) pose.rotation.row[i] = {r(i, 0), r(i, 1), r(i, 2)};
    pose.translation = {t[0], t[1], t[2]};
    return pose;
}

/// FCL's CollisionCallBack; data: a Collision. True, which ends the query, where the request has what it wanted. FCL's normals
/// point from the first object to the second.
inline bool collide(fcl::CollisionObject<double>* first, fcl::CollisionObject<double>* second, void* data)
{
    Collision& c = *static_cast<Collision*>(data);
    const auto *a = static_cast<const Solid*>(first->getUserData()), *b = static_cast<const Solid*>(second->getUserData());
    if (a == nullptr || b == nullptr) {
        fcl::collide(first, second, c.request, c.result);
        return c.request.isSatisfied(c.result);
    }
    sqmap::query::PairOptions options = c.options;
    options.query.first_only |= !c.request.enable_contact;
    const auto found = sqmap::query::query_pair({a->model, a->probe, pose_of(*first)}, {b->model, b->probe, pose_of(*second)},
                                                options, c.workspace);
    for (const sqmap::query::PairContact& p : found.contacts) {
        if (c.result.numContacts() >= c.request.num_max_contacts) break;
        const sqmap::Vec3d middle = 0.5 * (p.witness.on_a + p.witness.on_b);
        const int one = p.vertex_of == sqmap::query::Side::A ? static_cast<int>(p.index) : fcl::Contact<double>::NONE;
        const int other = p.vertex_of == sqmap::query::Side::A ? fcl::Contact<double>::NONE : static_cast<int>(p.index);
        c.result.addContact(
            {first->collisionGeometry().get(), second->collisionGeometry().get(), one, other,
             fcl::Vector3d(middle.x, middle.y, middle.z),
             fcl::Vector3d(static_cast<double>(p.normal.x), static_cast<double>(p.normal.y), static_cast<double>(p.normal.z)),
             static_cast<double>(p.depth)});
    }
    return c.request.isSatisfied(c.result);
}

}  // namespace sqmap_fcl
