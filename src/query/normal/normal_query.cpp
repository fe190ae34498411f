// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, section 4.2: the layers on the paper's maps,
// joined over parts by the witness rule.
#include "normal_query.h"

#include "sqmap/math/assert.h"
#include "sqmap/query/normal_projection.h"
#include "witness_rule.h"

#include <algorithm>
#include <cmath>

namespace sqmap::query {

namespace {

/// Depth and normal of the smoothed map at the point's own foot, as the tangent plane there has them.
void smooth(const model::NormalMapView& map, Vec3f point, ModelContact& contact)
{
    std::uint8_t flags = 0;
    const shape::Foot<float> foot = find_foot(map, point, Projector::Newton, &flags);
    if ((flags & k_projection_unproven) != 0) return;
    const MapSample sample = sample_smoothed(map, shape::angles_of(foot.position));
    if ((sample.flags & (k_projection_miss | k_projection_cap)) != 0 || !(norm_sq(sample.normal) > 0.5f)) return;
    contact.depth = std::max(dot(foot.point - sample.distance * foot.normal - point, sample.normal), 0.f);
    contact.normal = sample.normal;
    contact.point = point + contact.depth * sample.normal;
}

}  // namespace

ModelContact query_normal(const model::ModelView& model, Vec3f point, const QueryOptions& wanted) noexcept
{
    SQMAP_ASSERT(model::is_normal(model));
    ModelContact contact;
    contact.point = point;
    ProjectionOptions options;
    options.layer = wanted.layer;
    options.layer3_gate = wanted.gate;
    options.use_offset = wanted.offset;
    WitnessRule rule;
    for (std::size_t i = 0; i < model.parts.size(); ++i) {
        const model::Part& part = model.parts[i];
        if (norm_sq(point - model::vec3(part.sphere)) > part.sphere[3] * part.sphere[3]) continue;
        if (!rule.add(static_cast<std::int32_t>(i), project(model::normal_map_of(model, i), point, options))) return contact;
    }
    const auto [claimed, has_surface, nearest_part] = rule.combined;
    contact.part = nearest_part;
    if (has_surface) {
        contact.depth = std::max(rule.nearest.depth, 0.f);
        contact.normal = rule.nearest.normal;
        contact.point = point + contact.depth * contact.normal;
    }
    contact.contact = claimed;
    if (claimed && has_surface && wanted.smoothing)
        smooth(model::normal_map_of(model, static_cast<std::size_t>(contact.part)), point, contact);
    if (claimed && !has_surface) contact.status |= k_no_surface;  // only caps: inside, but below no surface of these maps
    if (!claimed) {
        // Where no part holds the point this is a proof, as the superquadrics cover the solid.
        contact.part = -1;
        contact.certain = !rule.is_held;
    }
    return contact;
}

bool distance_along_normal(const model::ModelView& model, std::uint32_t part, Vec3f point, Layer layer, float& distance) noexcept
{
    ProjectionOptions options;
    options.layer = layer;
    const PartAnswer answer = project(model::normal_map_of(model, part), point, options);
    if (answer.verdict == Verdict::Outside || (answer.flags & (k_projection_cap | k_projection_miss)) != 0) return false;
    distance = answer.depth_along;
    return true;
}

}  // namespace sqmap::query
