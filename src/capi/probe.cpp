// Probes and pairs behind the C interface: the library's own structs cross it, so that nothing is copied in a tick.
#include "sqmap/query/probe.h"
#include "objects.h"
#include "sqmap/query/pair.h"
#include "structs.h"

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

/// Refuses two bodies of which neither's probe meets the other's model: their query would find nothing at any pose.
void check_pair(const sqmap_body& a, const sqmap_body& b)
{
    if ((a.model.id != 0 && b.probe.id != 0) || (b.model.id != 0 && a.probe.id != 0)) return;
    const char* const missing = a.model.id != 0 ? k_b.probe : b.model.id != 0 ? k_a.probe : k_a.model;
    throw Failure{SQMAP_E_HANDLE, missing, "is {0}, so that neither body's probe meets the other's model",
                  "give one body a model and the other a probe, or each both"};
}

}  // namespace

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
        const query::Body touched = capi::body_of(in.a, capi::k_a), collider = capi::body_of(in.b, capi::k_b);
        if (touched.model == nullptr) capi::refuse_handle(0, 1, capi::k_a.model);
        if (collider.probe == nullptr) capi::refuse_handle(0, 2, capi::k_b.probe);
        const query::QueryOptions how = capi::query_options(capi::taken(options, "options"));
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
        return std::make_shared<query::PairWorkspace>(contacts);
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
        query::PairWorkspace& space = *capi::workspaces().find(workspace.id, "workspace");
        query::PairOptions how;
        how.query = capi::query_options(capi::taken(options, "options"));
        const query::Body a = capi::body_of(in.a, capi::k_a), b = capi::body_of(in.b, capi::k_b);
        capi::check_pair(in.a, in.b);
        const query::PairResult result = query::query_pair(a, b, how, space);
        out.contacts = reinterpret_cast<const sqmap_pair_contact*>(result.contacts.data());
        out.count = result.contacts.size();
        out.found = result.found;
        out.status = result.status;
        capi::give(contacts, out);
    });
}
