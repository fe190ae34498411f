// sqmap behind FCL's broad phase (FCL 0.7): a callback that answers pairs of objects by sqmap's contacts, and all others by FCL.
//
//   sqmap_fcl::Solid solid{&view, &probe};              // of the mesh in the object's frame
//   object.setUserData(&solid);
//   sqmap_fcl::Collision collision(workspace);          // one a thread; the workspace grows where a pair has more contacts
//   manager.collide(&collision, sqmap_fcl::collide);    // then collision.result
//
// For contacts of edges and faces too, make the probes with triangles and set collision.surfaces = &contact_workspace.
//
// FCL does not set the user data of new objects: set that of others to null. The geometry of an object bounds it in the broad
// phase.
#pragma once

#include <sqmap/query/contacts.h>
#include <sqmap/query/pair.h>

#include <fcl/broadphase/broadphase_collision_manager.h>
#include <fcl/narrowphase/collision.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sqmap_fcl {

/// Target of an object's user data; outlives the object.
struct Solid {
    const sqmap::model::ModelView* model = nullptr;  ///< from model::parse
    const sqmap::query::Probe* probe = nullptr;      ///< the mesh's vertices, for complete contacts its triangles too
};

/// How pairs are answered, and what is found.
struct Collision {
    explicit Collision(sqmap::query::PairWorkspace& space) : workspace(space) {}

    sqmap::query::PairWorkspace& workspace;
    sqmap::query::PairOptions options{};
    /// Null: vertices alone are tested. Else query_contacts answers, which misses no edge and no face; `options` is not read.
    sqmap::query::ContactWorkspace* surfaces = nullptr;
    sqmap::query::ContactOptions surface_options{};
    fcl::CollisionRequest<double> request{};  ///< num_max_contacts: of all pairs together; enable_contact
    fcl::CollisionResult<double> result{};
    /// Bits of Status and ContactStatus of all pairs: k_no_triangles, where `surfaces` is set and a probe has none, so that only
    /// vertices were tested.
    std::uint16_t status = sqmap::query::k_ok;
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

/// One contact in FCL's terms, halfway between its two points.
inline fcl::Contact<double> contact_of(const fcl::CollisionObject<double>& first, const fcl::CollisionObject<double>& second,
                                       const sqmap::query::WitnessPair& witness, const sqmap::Vec3f& normal, float depth)
{
    const sqmap::Vec3d middle = 0.5 * (witness.on_a + witness.on_b);
    return {first.collisionGeometry().get(),
            second.collisionGeometry().get(),
            fcl::Contact<double>::NONE,
            fcl::Contact<double>::NONE,
            fcl::Vector3d(middle.x, middle.y, middle.z),
            fcl::Vector3d(static_cast<double>(normal.x), static_cast<double>(normal.y), static_cast<double>(normal.z)),
            static_cast<double>(depth)};
}

/// An element in FCL's b1 or b2: a vertex's number where the other side is NONE, else the number of the face or of a triangle at
/// the edge.
inline int element_of(sqmap::query::Feature feature, std::uint32_t index)
{
    if (index == sqmap::query::k_unnamed) return fcl::Contact<double>::NONE;
    return static_cast<int>(feature == sqmap::query::Feature::Edge ? index / 3 : index);
}

/// The answer of a query, with all its contacts: while they are more than the workspace holds, the query is repeated with a
/// larger workspace, which allocates.
template <typename Workspace, typename Query>
auto whole_answer(Workspace& workspace, const Query& query)
{
    constexpr std::size_t least = 4096, most = std::size_t{1} << 28;
    auto found = query(workspace);
    for (std::size_t contacts = least; (found.status & sqmap::query::k_full) != 0 && contacts <= most; contacts *= 4) {
        workspace = Workspace(contacts);
        found = query(workspace);
    }
    return found;
}

/// Vertices of each body in the other.
inline void add_vertices(Collision& c, const fcl::CollisionObject<double>& first, const fcl::CollisionObject<double>& second)
{
    const auto &a = *static_cast<const Solid*>(first.getUserData()), &b = *static_cast<const Solid*>(second.getUserData());
    sqmap::query::PairOptions options = c.options;
    options.query.first_only |= !c.request.enable_contact;
    const auto found = whole_answer(c.workspace, [&](sqmap::query::PairWorkspace& space) {
        return sqmap::query::query_pair({a.model, a.probe, pose_of(first)}, {b.model, b.probe, pose_of(second)}, options, space);
    });
    c.status |= found.status;
    for (const sqmap::query::PairContact& p : found.contacts) {
        if (c.result.numContacts() >= c.request.num_max_contacts) break;
        fcl::Contact<double> contact = contact_of(first, second, p.witness, p.normal, p.depth);
        (p.vertex_of == sqmap::query::Side::A ? contact.b1 : contact.b2) = static_cast<int>(p.index);
        c.result.addContact(contact);
    }
}

/// At most so many contacts, the deepest, in the order in which they are found.
inline std::vector<const sqmap::query::SurfaceContact*> deepest(std::span<const sqmap::query::SurfaceContact> contacts,
                                                                std::size_t count)
{
    std::vector<const sqmap::query::SurfaceContact*> out;
    for (const sqmap::query::SurfaceContact& contact : contacts) out.push_back(&contact);
    if (out.size() <= count) return out;
    const auto is_deeper = [](const auto* a, const auto* b) { return a->depth != b->depth ? a->depth > b->depth : a < b; };
    std::nth_element(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(count), out.end(), is_deeper);
    out.resize(count);
    std::sort(out.begin(), out.end());
    return out;
}

/// Vertices, edges and faces. Of more contacts than the request takes the deepest are kept.
inline void add_surfaces(Collision& c, const fcl::CollisionObject<double>& first, const fcl::CollisionObject<double>& second)
{
    const auto &a = *static_cast<const Solid*>(first.getUserData()), &b = *static_cast<const Solid*>(second.getUserData());
    if (c.result.numContacts() >= c.request.num_max_contacts) return;
    sqmap::query::ContactOptions options = c.surface_options;
    options.first_only |= !c.request.enable_contact;
    const auto found = whole_answer(*c.surfaces, [&](sqmap::query::ContactWorkspace& space) {
        return sqmap::query::query_contacts({a.model, a.probe, pose_of(first)}, {b.model, b.probe, pose_of(second)}, options,
                                            space);
    });
    c.status |= found.status;
    for (const sqmap::query::SurfaceContact* p : deepest(found.contacts, c.request.num_max_contacts - c.result.numContacts())) {
        fcl::Contact<double> contact = contact_of(first, second, p->witness, p->normal, p->depth);
        contact.b1 = element_of(p->feature_a, p->index_a);
        contact.b2 = element_of(p->feature_b, p->index_b);
        c.result.addContact(contact);
    }
}

/// FCL's CollisionCallBack; data: a Collision. True, which ends the query, where the request has what it wanted. FCL's normals
/// point from the first object to the second.
inline bool collide(fcl::CollisionObject<double>* first, fcl::CollisionObject<double>* second, void* data)
{
    Collision& c = *static_cast<Collision*>(data);
    if (first->getUserData() == nullptr || second->getUserData() == nullptr) {
        fcl::collide(first, second, c.request, c.result);
        return c.request.isSatisfied(c.result);
    }
    if (c.surfaces != nullptr)
        add_surfaces(c, *first, *second);
    else
        add_vertices(c, *first, *second);
    return c.request.isSatisfied(c.result);
}

}  // namespace sqmap_fcl
