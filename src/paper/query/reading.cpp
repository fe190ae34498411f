// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, section 4.2: points and probes on the paper's maps,
// beside what superquadrics and triangles answer in every model.
#include "job.h"
#include "paper/model/codes.h"
#include "query/layer.h"
#include "query/locator/locate_point.h"
#include "query/probe_pointwise.h"
#include "sqmap/math/assert.h"

#include <algorithm>
#include <array>

namespace sqmap::paper {

namespace {

/// Newton's foot leads on to the nearest surface; the paper's searches do not.
ProjectionOptions projection_options(const ProbeJob& job, const query::QueryOptions& o, const QueryOptions& own)
{
    ProjectionOptions options;
    options.layer = job.layer;
    options.gate = job.gate;
    options.projector = own.projector;
    options.offset = o.offset;
    options.nearest_steps = own.projector == Projector::Newton ? own.nearest_steps : 0;
    options.gaps = own.gaps;
    return options;
}

/// k_not_given where options name what neither the maps nor the triangles give.
std::uint8_t lacking(const model::ModelView& model, const query::QueryOptions& options)
{
    const bool lacks = options.margin > 0 || (options.offset && query::chosen_layer(model, options) == Layer::Exact) ||
                       (options.smoothed_map && !has_smoothed_map(Reading::of(model).model()));
    const std::uint8_t exact = query::lacks_exact(model, options) ? query::k_no_exact : k_ok;
    return static_cast<std::uint8_t>(exact | (lacks ? k_not_given : 0));
}

/// By the maps, layers One to Gate.
ModelContact query_maps(const model::ModelView& model, Vec3f point, const query::QueryOptions& options)
{
    query::PointBatch batch({&point, 1});
    std::array<Contact, 1> found;
    const ProbeJob job(model, batch, options, found);
    // The superquadrics cover the solid, so a point that no part holds is proven free.
    if (run_one_lane({job, options}).contacts == 0) return query::free_at(point, batch.unproven[0] == 0);
    const Contact& c = found[0];
    return {c.witness, c.normal, c.depth, c.part, true, false, c.status};
}

/// No surface that options move reaches the point.
bool is_beyond(const model::ModelView& model, Vec3f point, const query::QueryOptions& options)
{
    // A moved surface reaches past the object's sphere; the offset is at most 2 % of R_max.
    const float margin = query::margin_in_model(model, options);
    const float radius = model.header.sphere[3] * (options.offset ? 1.1f : 1.f) + margin;
    return norm_sq(point - model::vec3(model.header.sphere)) > radius * radius;
}

ModelContact answer_point(const model::ModelView& model, Vec3f point, const query::QueryOptions& options) noexcept
{
    ModelContact contact;
    if (!is_finite(point)) {
        contact.status = query::k_not_finite;
        return contact;
    }
    query::QueryOptions chosen = options;
    chosen.layer = query::chosen_layer(model, options);
    if (chosen.layer == Layer::Exact) {
        contact = query::query_triangles(model, point, chosen);
    } else if (query::is_far_off(model, point) || is_beyond(model, point, chosen)) {
        contact = query::free_at(point);
    } else {
        contact = query_maps(model, point, chosen);
        if (contact.contact && chosen.layer != Layer::One && !model.made_up_cells.empty() && query::is_made_up_at(model, point))
            contact.status |= query::k_made_up;
    }
    contact.status |= lacking(model, options);
    // Proofs are about a closed solid, and about its surface where it is.
    if (model.header.solid == 0 || options.offset || options.margin > 0 || options.smoothed_map) contact.certain = false;
    return contact;
}

ProbeResult answer_probe(const query::Body& touched, const query::Body& collider, const query::QueryOptions& options,
                         std::span<Contact> contacts) noexcept
{
    const ProbeJob job(touched, collider, options, contacts);
    if (!job.finite) return {0, query::k_not_finite, 0, {}};
    ProbeResult result = job.layer == Layer::Exact ? query::run_exact_layer(job, options) : run_paper({job, options});
    result.status |= lacking(job.model, options);
    return result;
}

bool answer_along(const model::ModelView& model, std::uint32_t part, Vec3f point, Layer layer, float& distance) noexcept
{
    ProjectionOptions options;
    options.layer = layer;
    const PartAnswer answer = project(map_of(Reading::of(model).model(), part), point, options);
    if (answer.verdict == Verdict::Outside || (answer.flags & (k_projection_cap | k_projection_miss)) != 0) return false;
    distance = answer.depth_along;
    return true;
}

float reach_of(const model::ModelView& model, const query::QueryOptions& options) noexcept
{
    float reach = query::margin_in_model(model, options);
    if (!options.offset) return reach;
    for (const MapRecord& map : Reading::of(model).model().maps.records)
        reach = std::max(reach, static_cast<float>(k_largest_offset) * map.grid.offset_scale);
    return reach;
}

}  // namespace

Reading::Reading(const ModelView& model, const QueryOptions& options) noexcept
    : query::Answers{answer_probe, answer_point, answer_along, reach_of, k_not_given},
      model_(model),
      view_(model.common),
      options_(options)
{
    view_.answers = this;
}

PaperJob::PaperJob(const ProbeJob& job, const query::QueryOptions& o) noexcept
    : probe(job),
      model(Reading::of(job.model).model()),
      options(projection_options(job, o, Reading::of(job.model).options())),
      smoothed_map(o.smoothed_map && job.layer != Layer::One),
      pruning(Reading::of(job.model).options().pruning)
{
}

bool reads_base_grid(const MapView& map, const ProjectionOptions& options) noexcept
{
    if (options.layer != Layer::Gate) return options.layer == Layer::Two;
    const std::uint64_t base =
        std::uint64_t{((map.eta_count - 1) >> map.subdivisions) + 1} * (map.omega_count >> map.subdivisions);
    return base >= std::uint64_t{options.gate} * map.vertex_count;
}

}  // namespace sqmap::paper
