// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, section 4.2: the layers.
#include "sqmap/query/query.h"

#include "query/exact/exact_layer.h"
#include "query/normal/normal_query.h"
#include "query/point/central_query.h"

#include <algorithm>
#include <cmath>

namespace sqmap::query {

namespace {

using model::ModelView;
using model::Part;

/// Layer 1: distance to the superquadric's surface along the ray from its centre, and its normal by differences.
Contact layer_one(const ModelView& model, Vec3f p)
{
    Contact contact;
    for (std::size_t i = 0; i < model.parts.size(); ++i) {
        const Part& part = model.parts[i];
        if (norm_sq(p - model::vec3(part.sphere)) > part.sphere[3] * part.sphere[3]) continue;
        const shape::Superquadricf sq = model::superquadric_of(part);
        float f = shape::implicit(sq, p);
        if (!(f <= 1.f)) continue;
        Vec3f d = p - sq.translation;
        if (f < 1e-12f) {
            // The centre has no direction: out along the shortest axis.
            const int k = sq.a.x <= sq.a.y && sq.a.x <= sq.a.z ? 0 : (sq.a.y <= sq.a.z ? 1 : 2);
            d = (1e-3f * sq.a[k]) * sq.rotation.row[k];
            f = shape::implicit(sq, sq.translation + d);
        }
        const float scale = 1.f / std::sqrt(std::max(f, 1e-12f));
        const Vec3f surface = sq.translation + scale * d;
        const float depth = norm(surface - p);
        if (contact.contact && depth <= contact.depth) continue;
        // The deepest part speaks: the union's surface is outside every part that holds the point.
        const float h = 1e-3f * part.sphere[3];
        Vec3f gradient{};
        for (int k = 0; k < 3; ++k) {
            Vec3f lo = surface, hi = surface;
            lo[k] -= h;
            hi[k] += h;
            gradient[k] = shape::implicit(sq, hi) - shape::implicit(sq, lo);
        }
        contact = {surface, normalized(gradient), depth, static_cast<std::int32_t>(i), true, false, k_ok};
    }
    contact.certain = !contact.contact;
    return contact;
}

Contact answer(const ModelView& model, Vec3f point, const QueryOptions& options)
{
    const Layer layer = options.layer;
    Contact contact;
    contact.point = point;
    if (!is_finite(point)) {
        contact.point = {};
        contact.status = k_not_finite;
        return contact;
    }
    const Vec3f offset = point - model::vec3(model.header.sphere);
    contact.certain = true;
    // A moved surface reaches past the object's sphere; the offset is at most 2 % of R_max.
    const float margin = options.margin > 0.f ? options.margin * static_cast<float>(model.header.r_max) : 0.f;
    const float radius = model.header.sphere[3] * (options.offset ? 1.1f : 1.f) + margin;
    // The box first: squares of far coordinates overflow.
    if (std::max({std::abs(offset.x), std::abs(offset.y), std::abs(offset.z)}) > radius || norm_sq(offset) > radius * radius)
        return contact;
    if (layer == Layer::One) {
        const Contact c = layer_one(model, point);
        return c.contact ? c : contact;
    }
    const bool exact = layer == Layer::Exact && model::has_exact(model);
    if (!exact && model.header.projection == static_cast<std::uint32_t>(model::Projection::Normal)) {
        Contact answer = query_normal(model, point, options);
        if (layer == Layer::Exact) answer.status |= k_no_exact;
        return answer;
    }
    Contact answer = exact ? query_exact(model, point) : query_central(model, point, layer, options.layer3_gate);
    if (layer == Layer::Exact && !exact) answer.status |= k_no_exact;
    if (options.smoothing && layer != Layer::Exact) apply_smoothing(model, point, answer);
    if (options.offset || margin > 0.f) apply_offset(model, point, layer, {.stored = options.offset, .least = margin}, answer);
    return answer;
}

}  // namespace

Contact query_point(const ModelView& model, Vec3f point, const QueryOptions& options) noexcept
{
    Contact contact = answer(model, point, options);
    // Proofs are about a closed solid, and about its surface where it is.
    if (model.header.solid == 0 || options.offset || options.margin > 0.f || options.smoothing) contact.certain = false;
    return contact;
}

Contact query_point(const ModelView& model, Vec3f point, Layer layer) noexcept
{
    return query_point(model, point, QueryOptions{.layer = layer});
}

std::size_t query_points(const ModelView& model, std::span<const Vec3f> points, Layer layer, std::span<Contact> contacts) noexcept
{
    std::size_t count = 0;
    for (std::size_t i = 0; i < points.size() && i < contacts.size(); ++i) {
        contacts[i] = query_point(model, points[i], layer);
        count += contacts[i].contact ? 1u : 0u;
    }
    return count;
}

bool distance_along_projection(const ModelView& model, std::uint32_t part, Vec3f point, Layer layer, float& distance) noexcept
{
    return model.header.projection == static_cast<std::uint32_t>(model::Projection::Normal)
               ? distance_along_normal(model, part, point, layer, distance)
               : distance_along_central(model, part, point, layer, distance);
}

}  // namespace sqmap::query
