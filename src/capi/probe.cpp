// Probes and pairs behind the C interface: the library's own structs cross it, so that nothing is copied in a tick.
#include "sqmap/query/probe.h"
#include "objects.h"
#include "query/probe/triangle_tree.h"
#include "sqmap/query/clearance.h"
#include "sqmap/query/contacts.h"
#include "sqmap/query/first_touch.h"
#include "structs.h"

#include <cmath>
#include <cstddef>
#include <string>
#include <type_traits>

namespace sqmap::capi {
namespace {

using query::Contact;
using query::PairContact;
static_assert(sizeof(sqmap_contact) == sizeof(Contact) && offsetof(sqmap_contact, normal) == offsetof(Contact, normal) &&
              offsetof(sqmap_contact, depth) == offsetof(Contact, depth) &&
              offsetof(sqmap_contact, index) == offsetof(Contact, index) &&
              offsetof(sqmap_contact, part) == offsetof(Contact, part) &&
              offsetof(sqmap_contact, certain) == offsetof(Contact, certain) &&
              offsetof(sqmap_contact, status) == offsetof(Contact, status) && sizeof(bool) == 1);
static_assert(sizeof(sqmap_pair_contact) == sizeof(PairContact) &&
              offsetof(sqmap_pair_contact, on_a) == offsetof(PairContact, witness) + offsetof(query::WitnessPair, on_a) &&
              offsetof(sqmap_pair_contact, on_b) == offsetof(PairContact, witness) + offsetof(query::WitnessPair, on_b) &&
              offsetof(sqmap_pair_contact, normal) == offsetof(PairContact, normal) &&
              offsetof(sqmap_pair_contact, depth) == offsetof(PairContact, depth) &&
              offsetof(sqmap_pair_contact, index) == offsetof(PairContact, index) &&
              offsetof(sqmap_pair_contact, part) == offsetof(PairContact, part) &&
              offsetof(sqmap_pair_contact, vertex_of) == offsetof(PairContact, vertex_of) &&
              offsetof(sqmap_pair_contact, certain) == offsetof(PairContact, certain) &&
              offsetof(sqmap_pair_contact, is_mutual) == offsetof(PairContact, mutual) &&
              offsetof(sqmap_pair_contact, status) == offsetof(PairContact, status));

/// The names of a body's members in failures.
struct BodyNames {
    const char *model, *probe, *pose;
};
constexpr BodyNames k_a{"bodies.a.model", "bodies.a.probe", "bodies.a.pose"};
constexpr BodyNames k_b{"bodies.b.model", "bodies.b.probe", "bodies.b.pose"};

/// A body of handles that are open; {0} stands for none.
query::Body body_of(const sqmap_body& body, const BodyNames& names)
{
    query::Body out;
    if (body.model.id != 0) out.model = &model_of(body.model, names.model)->view();
    if (body.probe.id != 0) out.probe = probes().find(body.probe.id, names.probe).get();
    out.pose = pose_of(body.pose, names.pose);
    return out;
}

using query::SurfaceContact;
static_assert(sizeof(sqmap_surface_contact) == sizeof(SurfaceContact) &&
              offsetof(sqmap_surface_contact, on_a) == offsetof(SurfaceContact, witness) + offsetof(query::WitnessPair, on_a) &&
              offsetof(sqmap_surface_contact, on_b) == offsetof(SurfaceContact, witness) + offsetof(query::WitnessPair, on_b) &&
              offsetof(sqmap_surface_contact, normal) == offsetof(SurfaceContact, normal) &&
              offsetof(sqmap_surface_contact, depth) == offsetof(SurfaceContact, depth) &&
              offsetof(sqmap_surface_contact, feature_a) == offsetof(SurfaceContact, feature_a) &&
              offsetof(sqmap_surface_contact, feature_b) == offsetof(SurfaceContact, feature_b) &&
              offsetof(sqmap_surface_contact, index_a) == offsetof(SurfaceContact, index_a) &&
              offsetof(sqmap_surface_contact, index_b) == offsetof(SurfaceContact, index_b) &&
              offsetof(sqmap_surface_contact, region) == offsetof(SurfaceContact, region) &&
              offsetof(sqmap_surface_contact, part_a) == offsetof(SurfaceContact, part_a) &&
              offsetof(sqmap_surface_contact, part_b) == offsetof(SurfaceContact, part_b) &&
              offsetof(sqmap_surface_contact, certain) == offsetof(SurfaceContact, certain) &&
              offsetof(sqmap_surface_contact, status) == offsetof(SurfaceContact, status));
static_assert(static_cast<int>(query::Feature::Vertex) == SQMAP_VERTEX && static_cast<int>(query::Feature::Edge) == SQMAP_EDGE &&
              static_cast<int>(query::Feature::Face) == SQMAP_FACE);

/// Bodies whose probes both have triangles.
struct SolidBodies {
    query::Body a, b;

    explicit SolidBodies(const sqmap_bodies& in) : a(body_of(in.a, k_a)), b(body_of(in.b, k_b))
    {
        check(a, k_a);
        check(b, k_b);
    }

private:
    static void check(const query::Body& body, const BodyNames& names)
    {
        if (body.probe == nullptr) refuse_handle(0, 2, names.probe);
        check_triangles(*body.probe, names.probe);
    }
};

/// The mesh's triangles by numbers of its vertices. @throw Failure for a number that is none
std::vector<query::ProbeTriangle> triangles_of(const sqmap_mesh& mesh)
{
    std::vector<query::ProbeTriangle> triangles(mesh.triangle_count);
    for (std::size_t t = 0; t < triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::int64_t v = mesh.triangles[3 * t + k];
            if (v < 0 || static_cast<std::size_t>(v) >= std::min<std::size_t>(mesh.vertex_count, 0xffffffffu))
                throw Failure{SQMAP_E_ARGUMENT, "mesh.triangles[" + std::to_string(t) + "]",
                              "has corner " + std::to_string(v) + ", of " + std::to_string(mesh.vertex_count) + " vertices",
                              "count vertices from zero"};
            triangles[t][k] = static_cast<std::uint32_t>(v);
        }
    return triangles;
}

void refuse_fault(const query::TriangleFault& fault)
{
    using Kind = query::TriangleFault::Kind;
    const std::string element = "mesh.triangles[" + std::to_string(fault.triangle) + "]", side = std::to_string(fault.side);
    switch (fault.kind) {
        case Kind::Open:
            throw Failure{SQMAP_E_MESH, element, "has no neighbour at the side that begins at its corner " + side,
                          mesh::Words("close the mesh")
                              .with(": ", mesh::Setting::Bake, "", " does")
                              .with(", and ", mesh::Setting::BakedMesh, "", " gives what it closed")};
        case Kind::TurnedRound:
            throw Failure{SQMAP_E_MESH, element, "runs as its neighbour does along the side that begins at its corner " + side,
                          "turn one of both round, so that all are counter-clockwise seen from outside"};
        case Kind::Inverted:
            throw Failure{SQMAP_E_MESH, element, "is clockwise seen from outside, as all that hang together with it are",
                          "swap two corners of each of them"};
        case Kind::TooMany:
            throw Failure{SQMAP_E_MESH, "mesh.triangle_count", "is above " + std::to_string(query::TriangleTree::k_max),
                          "give a coarser mesh"};
        case Kind::OutOfScale:
            throw Failure{SQMAP_E_MESH, "mesh.vertices", "have a box whose diagonal is not from 1e-9 to 1e12",
                          "scale them, and all that they meet"};
        case Kind::None:
        case Kind::OutOfRange:
        case Kind::NotFinite:
            break;  // found before
    }
}

/// Refuses two bodies of which neither's probe meets the other's model: their query would find nothing at any pose.
void check_pair(const sqmap_body& a, const sqmap_body& b)
{
    if ((a.model.id != 0 && b.probe.id != 0) || (b.model.id != 0 && a.probe.id != 0)) return;
    const char* const missing = a.model.id != 0 ? k_b.probe : b.model.id != 0 ? k_a.probe : k_a.model;
    throw Failure{SQMAP_E_HANDLE, missing, "is {0}, so that neither body's probe meets the other's model",
                  "give one body a model and the other a probe, or each both"};
}

}  // namespace

void check_triangles(const query::Probe& probe, const char* element)
{
    if (probe.triangle_count() == 0)
        throw Failure{SQMAP_E_MISSING, element, "has no triangles",
                      mesh::Words("take a probe with triangles").with(": ", mesh::Setting::SolidProbe)};
}

}  // namespace sqmap::capi

using namespace sqmap;
using capi::guarded;
using capi::needed;

sqmap_code sqmap_make_probe(const sqmap_points* points, sqmap_probe* probe)
{
    return capi::opened(probe, "probe", capi::probes(), [&] {
        const std::span<const Vec3d> rows = capi::rows(capi::taken(&needed(points, "points"), "points"), "points.xyz");
        if (rows.empty()) throw capi::Failure{SQMAP_E_ARGUMENT, "points.count", "is 0", "give at least one point"};
        capi::check_finite(rows, "points.xyz");
        return std::make_shared<query::Probe>(rows);
    });
}

sqmap_code sqmap_close_probe(sqmap_probe probe)
{
    return guarded([&] { capi::probes().close(probe.id, "probe"); });
}

sqmap_code sqmap_query_probe(const sqmap_bodies* bodies, const sqmap_query_options* options, sqmap_contact_list* contacts)
{
    return guarded([&] {
        const sqmap_bodies in = capi::taken(&needed(bodies, "bodies"), "bodies");
        sqmap_contact_list out = capi::taken(&needed(contacts, "contacts"), "contacts");
        if (out.capacity > 0) (void)needed(out.contacts, "contacts.contacts");
        query::Body touched = capi::body_of(in.a, capi::k_a);
        const query::Body collider = capi::body_of(in.b, capi::k_b);
        if (touched.model == nullptr) capi::refuse_handle(0, 1, capi::k_a.model);
        if (collider.probe == nullptr) capi::refuse_handle(0, 2, capi::k_b.probe);
        const sqmap_query_options o = capi::taken(options, "options");
        const query::QueryOptions how = capi::query_options(o);
        const capi::Opened read = capi::read_paper(capi::model_of(in.a.model)->opened(), capi::paper_options(o), how);
        touched.model = &read.view;
        const query::ProbeResult result =
            query::query_probe(touched, collider, how, {reinterpret_cast<query::Contact*>(out.contacts), out.capacity});
        out.found = result.contacts;
        for (int i = 0; i < 3; ++i) out.anchor[i] = result.anchor[i];
        out.status = result.status;
        capi::give(contacts, out);
    });
}

sqmap_code sqmap_make_workspace(size_t contacts, sqmap_workspace* workspace)
{
    return capi::opened(workspace, "workspace", capi::workspaces(), [&] {
        if (contacts < 1 || contacts > 100'000'000)
            throw capi::Failure{SQMAP_E_ARGUMENT, "contacts", "is " + std::to_string(contacts),
                                "give a number from 1 to 100,000,000"};
        return std::make_shared<capi::Workspace>(contacts);
    });
}

sqmap_code sqmap_close_workspace(sqmap_workspace workspace)
{
    return guarded([&] { capi::workspaces().close(workspace.id, "workspace"); });
}

sqmap_code sqmap_query_pair(const sqmap_bodies* bodies, const sqmap_query_options* options, sqmap_workspace workspace,
                            sqmap_pair_list* contacts)
{
    return guarded([&] {
        const sqmap_bodies in = capi::taken(&needed(bodies, "bodies"), "bodies");
        sqmap_pair_list out = capi::taken(&needed(contacts, "contacts"), "contacts");
        query::PairWorkspace& space = capi::workspaces().find(workspace.id, "workspace")->pair();
        query::PairOptions how;
        const sqmap_query_options o = capi::taken(options, "options");
        how.query = capi::query_options(o);
        if (capi::paper_options(o) != paper::QueryOptions{})
            throw capi::Failure{SQMAP_E_ARGUMENT, "options", "have how a paper model is read, which counts for points and probes",
                                "leave projector, nearest_steps, without_gaps and without_pruning at zero"};
        const query::Body a = capi::body_of(in.a, capi::k_a), b = capi::body_of(in.b, capi::k_b);
        capi::check_pair(in.a, in.b);
        const query::PairResult result = query::query_pair(a, b, how, space);
        out.contacts = reinterpret_cast<const sqmap_pair_contact*>(result.contacts.data());
        out.count = result.contacts.size();
        out.found = result.found;
        out.status = result.status;
        out.edge_length = result.edge_length;
        capi::give(contacts, out);
    });
}

sqmap_code sqmap_make_solid_probe(const sqmap_mesh* mesh, sqmap_probe* probe)
{
    return capi::opened(probe, "probe", capi::probes(), [&] {
        const sqmap_mesh in = capi::taken(&needed(mesh, "mesh"), "mesh");
        if (in.vertex_count == 0) throw capi::Failure{SQMAP_E_ARGUMENT, "mesh.vertex_count", "is 0", "give a closed mesh"};
        if (in.triangle_count == 0) throw capi::Failure{SQMAP_E_ARGUMENT, "mesh.triangle_count", "is 0", "give a closed mesh"};
        (void)needed(in.triangles, "mesh.triangles");
        const std::span<const Vec3d> vertices =
            capi::rows({sizeof(sqmap_points), in.vertices, in.vertex_count, nullptr}, "mesh.vertices");
        capi::check_finite(vertices, "mesh.vertices");
        const std::vector<query::ProbeTriangle> triangles = capi::triangles_of(in);
        capi::refuse_fault(query::find_fault(vertices, triangles));
        return std::make_shared<query::Probe>(vertices, triangles);
    });
}

sqmap_code sqmap_query_contacts(const sqmap_bodies* bodies, const sqmap_contact_options* options, sqmap_workspace workspace,
                                sqmap_surface_list* contacts)
{
    return guarded([&] {
        const sqmap_bodies in = capi::taken(&needed(bodies, "bodies"), "bodies");
        sqmap_surface_list out = capi::taken(&needed(contacts, "contacts"), "contacts");
        capi::Workspace& space = *capi::workspaces().find(workspace.id, "workspace");
        const sqmap_contact_options how = capi::taken(options, "options");
        const capi::SolidBodies both(in);
        const query::ContactResult result = query::query_contacts(
            both.a, both.b, {.first_only = how.is_first_only != 0, .per_region = how.per_region}, space.contacts());
        out.contacts = reinterpret_cast<const sqmap_surface_contact*>(result.contacts.data());
        out.count = result.contacts.size();
        out.found = result.found;
        out.meetings = result.meetings;
        out.regions = result.regions;
        out.status = result.status;
        capi::give(contacts, out);
    });
}

sqmap_code sqmap_first_touch(const sqmap_bodies* bodies, const sqmap_pose* end_pose, sqmap_touch* touch)
{
    return guarded([&] {
        const sqmap_bodies in = capi::taken(&needed(bodies, "bodies"), "bodies");
        const Pose end = capi::pose_of(&needed(end_pose, "end_pose"), "end_pose");
        sqmap_touch out = capi::taken(&needed(touch, "touch"), "touch");
        const capi::SolidBodies both(in);
        const Pose end_a = out.end_pose_a == nullptr ? both.a.pose : capi::pose_of(out.end_pose_a, "touch.end_pose_a");
        const query::BodyTouch found =
            out.end_pose_a == nullptr ? query::first_touch(both.a, both.b, end) : query::first_touch(both.a, end_a, both.b, end);
        out.time = found.time;
        out.touches = found.touches ? 1 : 0;
        out.status = found.status;
        capi::give(touch, out);
    });
}

sqmap_code sqmap_first_touch_features(const sqmap_moving_features* features, sqmap_touches* touches)
{
    return guarded([&] {
        const sqmap_moving_features in = capi::taken(&needed(features, "features"), "features");
        const sqmap_touches out = capi::taken(&needed(touches, "touches"), "touches");
        const query::TouchOptions how{.separation = in.separation};
        if (!(how.separation >= 0))
            throw capi::Failure{SQMAP_E_ARGUMENT, "features.separation", "is below zero or no number", "give a distance from 0"};
        const double *start = &needed(in.start, "features.start"), *end = &needed(in.end, "features.end");
        for (std::size_t i = 0; i < in.count; ++i, start += 12, end += 12) {
            const auto point = [&](int k) {
                const double *p = start + 3 * k, *q = end + 3 * k;
                return query::MovingPoint{{p[0], p[1], p[2]}, {q[0], q[1], q[2]}};
            };
            const query::Touch found = in.are_edges != 0 ? query::first_touch({point(0), point(1)}, {point(2), point(3)}, how)
                                                         : query::first_touch(point(0), {point(1), point(2), point(3)}, how);
            if (out.time != nullptr) out.time[i] = found.time;
            if (out.touches != nullptr) out.touches[i] = found.touches ? 1 : 0;
        }
    });
}

sqmap_code sqmap_query_clearance(const sqmap_bodies* bodies, sqmap_clearance* clearance)
{
    return guarded([&] {
        const sqmap_bodies in = capi::taken(&needed(bodies, "bodies"), "bodies");
        sqmap_clearance out = capi::taken(&needed(clearance, "clearance"), "clearance");
        if (!(out.within >= 0))
            throw capi::Failure{SQMAP_E_ARGUMENT, "clearance.within", "is below zero or no number",
                                "give a distance, or 0 to have it computed"};
        const capi::SolidBodies both(in);
        if (out.within > 0) {
            out.is_within = query::is_within(both.a, both.b, out.within) ? 1 : 0;
        } else {
            const query::Clearance found = query::clearance(both.a, both.b);
            out.distance = found.distance;
            out.at_least = found.at_least;
            for (int k = 0; k < 3; ++k) {
                out.on_a[k] = found.witness.on_a[k];
                out.on_b[k] = found.witness.on_b[k];
            }
            out.triangle_a = found.triangle_a;
            out.triangle_b = found.triangle_b;
            out.status = found.status;
        }
        capi::give(clearance, out);
    });
}

sqmap_code sqmap_query_overlap(const sqmap_bodies* bodies, sqmap_workspace workspace, sqmap_overlap* overlap)
{
    return guarded([&] {
        const sqmap_bodies in = capi::taken(&needed(bodies, "bodies"), "bodies");
        sqmap_overlap out = capi::taken(&needed(overlap, "overlap"), "overlap");
        capi::Workspace& space = *capi::workspaces().find(workspace.id, "workspace");
        const capi::SolidBodies both(in);
        const query::Overlap found = query::overlap(both.a, both.b, space.overlap(*both.a.probe, *both.b.probe));
        out.volume = found.volume;
        out.error = found.error;
        out.status = found.status;
        capi::give(overlap, out);
    });
}

sqmap_code sqmap_query_separation(const sqmap_bodies* bodies, sqmap_workspace workspace, sqmap_separation* separation)
{
    return guarded([&] {
        const sqmap_bodies in = capi::taken(&needed(bodies, "bodies"), "bodies");
        sqmap_separation out = capi::taken(&needed(separation, "separation"), "separation");
        capi::Workspace& space = *capi::workspaces().find(workspace.id, "workspace");
        Vec3d along;
        for (int k = 0; k < 3; ++k) {
            along[k] = out.along[k];
            if (!std::isfinite(along[k]))
                throw capi::Failure{SQMAP_E_ARGUMENT, "separation.along[" + std::to_string(k) + "]", "is not finite",
                                    "give a direction, or 0, 0, 0 for the shortest translation"};
        }
        const capi::SolidBodies both(in);
        query::SeparatingWorkspace& own = space.separating(*both.a.probe, *both.b.probe);
        const query::SeparatingTranslation found = along == Vec3d{} ? query::least_separating_translation(both.a, both.b, own)
                                                                    : query::separating_translation(both.a, both.b, along, own);
        out.distance = found.distance;
        out.at_least = found.at_least;
        for (int k = 0; k < 3; ++k) out.direction[k] = found.direction[k];
        out.is_exact = found.exact ? 1 : 0;
        out.status = found.status;
        capi::give(separation, out);
    });
}
