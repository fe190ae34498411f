#include "viewer/server/scene/meetings.h"

#include "sqmap/query/contacts.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace sqmap::viewer {
namespace {

using nlohmann::ordered_json;

constexpr std::uint32_t k_shown_per_region = 4096;
constexpr std::size_t k_contacts = 65536;  // of vertices in a direction, and of edges

int kind_of(const query::SurfaceContact& contact)
{
    const auto has = [&](query::Feature f) { return contact.feature_a == f || contact.feature_b == f; };
    return has(query::Feature::Vertex) ? 0 : has(query::Feature::Face) ? 2 : 1;
}

ordered_json contact_json(const query::SurfaceContact& c)
{
    const auto& [a, b] = std::pair{c.witness.on_a, c.witness.on_b};
    return {kind_of(c), c.region == query::k_unnamed ? -1 : static_cast<int>(c.region), a.x, a.y, a.z, b.x, b.y, b.z, c.depth};
}

bool are_near(const Object& a, const Object& b) { return norm(a.position - b.position) <= norm(a.half) + norm(b.half); }

}  // namespace

std::optional<query::Probe> solid_of(const Object& object)
{
    const auto& [to_mesh, unit] = std::pair{object.frame(), object.metres_per_unit};
    std::vector<Vec3d> points;
    for (const Vec3d& v : object.mesh.vertices) points.push_back(unit * (to_mesh.unit * v + to_mesh.origin));
    const std::vector<query::ProbeTriangle> triangles(object.mesh.triangles.begin(), object.mesh.triangles.end());
    if (triangles.empty() || query::find_fault(points, triangles).kind != query::TriangleFault::Kind::None) return std::nullopt;
    return query::Probe(points, triangles);
}

ordered_json meetings_json(std::span<const ObjectPtr> objects)
{
    ordered_json out{{"pairs", ordered_json::array()}, {"open", ordered_json::array()}};
    std::vector<std::optional<query::Probe>> solids(objects.size());
    for (std::size_t i = 0; i < objects.size(); ++i) {
        if (objects[i] == nullptr) continue;
        solids[i] = solid_of(*objects[i]);
        if (!solids[i]) out["open"].push_back(i);
    }
    query::ContactWorkspace workspace(k_contacts);
    const auto body = [&](std::size_t i) { return query::Body{&objects[i]->metres, &*solids[i], objects[i]->pose()}; };
    for (std::size_t a = 0; a < objects.size(); ++a)
        for (std::size_t b = a + 1; b < objects.size(); ++b) {
            if (!solids[a] || !solids[b] || !are_near(*objects[a], *objects[b])) continue;
            const query::ContactResult found =
                query::query_contacts(body(a), body(b), {.per_region = k_shown_per_region}, workspace);
            if (found.contacts.empty()) continue;
            ordered_json contacts = ordered_json::array();
            for (const query::SurfaceContact& c : found.contacts) contacts.push_back(contact_json(c));
            out["pairs"].push_back(
                {{"a", a}, {"b", b}, {"meetings", found.meetings}, {"found", found.found}, {"contacts", std::move(contacts)}});
        }
    return out;
}

}  // namespace sqmap::viewer
