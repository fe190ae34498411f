// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, section 4.2: the layers, for one point.
#include "query/dispatch/model_point.h"

#include "query/locator/locate_point.h"
#include "sqmap/math/assert.h"

#include "query/chart/central_query.h"
#include "query/dispatch/run_probe.h"
#include "query/exact/exact_layer.h"
#include "query/layer.h"
#include "query/probe/probe_job.h"
#include "query/superquadric/layer_one.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sqmap::query {

namespace {

using model::ModelView;

/// By the kernels of probe queries. options.layer: chosen. @pre is_located, and the points are finite and not far off
void query_located(const ModelView& model, std::span<const Vec3f> points, const QueryOptions& options,
                   std::span<ModelContact> contacts)
{
    for (std::size_t first = 0; first < points.size(); first += PointBatch::k_size) {
        PointBatch batch(points.subspan(first));
        std::array<Contact, PointBatch::k_size> found;
        const ProbeJob job(model, batch, options, found);
        const std::size_t count = (job.layer == Layer::Exact ? run_probe_exact(job) : run_probe(job)).contacts;
        for (std::size_t i = 0; i < batch.count; ++i) contacts[first + i] = free_at(points[first + i], batch.unproven[i] == 0);
        for (const Contact& c : std::span(found).first(count))
            contacts[first + c.index] = {c.witness, c.normal, c.depth, c.part, true, c.certain, c.status};
    }
}

/// Without a locator. options.layer: chosen
ModelContact query_unlocated(const ModelView& model, Vec3f point, const QueryOptions& options)
{
    if (options.layer == Layer::One) return query_layer_one(model, point);
    const Vec3f offset = point - model::vec3(model.header.sphere);
    // A moved surface reaches past the object's sphere; the offset is at most 2 % of R_max.
    const float margin = margin_in_model(model, options);
    const float radius = model.header.sphere[3] * (options.offset ? 1.1f : 1.f) + margin;
    if (norm_sq(offset) > radius * radius) return free_at(point);
    if (options.layer == Layer::Exact) return query_exact(model, point);
    return query_central(model, point, options.layer, options.gate);
}

ModelContact answer(const ModelView& model, Vec3f point, QueryOptions options)
{
    if (!is_finite(point)) {
        ModelContact contact;
        contact.status = k_not_finite;
        return contact;
    }
    const bool no_exact = lacks_exact(model, options);
    options.layer = chosen_layer(model, options);
    ModelContact contact = free_at(point);
    const bool far_off = is_far_off(model, point), located = options.layer != Layer::One && model::has_locator(model);
    if (!far_off && located)
        query_located(model, {&point, 1}, options, {&contact, 1});
    else if (!far_off)
        contact = query_unlocated(model, point, options);
    const bool marked = located || options.layer == Layer::One || options.layer == Layer::Exact || model.made_up_cells.empty();
    if (contact.contact && !marked && is_made_up_at(model, point)) contact.status |= k_made_up;
    if (no_exact) contact.status |= k_no_exact;
    if (far_off || options.layer == Layer::One) return contact;
    if (options.smoothed_map && options.layer != Layer::Exact) apply_smoothing(model, point, contact);
    const float margin = margin_in_model(model, options);
    // A free point's margin counts from the triangles, where there are any: src/query/margin.h.
    if (options.offset || (margin > 0.f && (contact.contact || !is_margin_proven(model, options))))
        apply_offset(model, point, options.layer, {.stored = options.offset, .least = margin}, contact);
    return contact;
}

}  // namespace

bool is_far_off(const ModelView& model, Vec3f point) noexcept
{
    const Vec3f offset = point - model::vec3(model.header.sphere);
    return std::max({std::abs(offset.x), std::abs(offset.y), std::abs(offset.z)}) > 1e6f * model.header.sphere[3];
}

ModelContact query_triangles(const ModelView& model, Vec3f point, const QueryOptions& options) noexcept
{
    SQMAP_ASSERT(model::has_exact(model) && is_finite(point));
    ModelContact contact = free_at(point);
    if (is_far_off(model, point)) return contact;
    if (!model::has_locator(model)) return query_unlocated(model, point, options);
    query_located(model, {&point, 1}, options, {&contact, 1});
    return contact;
}

ModelContact query_unlocated_near(const ModelView& model, Vec3f point, float near) noexcept
{
    SQMAP_ASSERT(is_finite(point) && model::has_central_maps(model));
    const Vec3f offset = point - model::vec3(model.header.sphere);
    const float radius = model.header.sphere[3];
    if (norm_sq(offset) > radius * radius) return free_at(point);
    return query_central_near(model, point, Layer::Three, near);
}

ModelContact query_in_model(const ModelView& model, Vec3f point, const QueryOptions& options) noexcept
{
    if (model.answers != nullptr) return model.answers->point(model, point, options);
    ModelContact contact = answer(model, point, options);
    // Proofs are about a closed solid, and about its surface where it is.
    if (model.header.solid == 0 || options.offset || options.margin > 0 || options.smoothed_map) contact.certain = false;
    return contact;
}

}  // namespace sqmap::query
