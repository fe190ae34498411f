// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, section 4.2, for one point.
#include "normal_query.h"

#include "normal_job.h"
#include "sqmap/math/assert.h"

#include <array>

namespace sqmap::query {

namespace {

/// As the paper asks with the searches; Newton's foot leads on to the nearest surface.
ProjectionOptions projection_options(const ProbeJob& job, const QueryOptions& o)
{
    ProjectionOptions options;
    options.layer = job.layer;
    options.layer3_gate = job.gate;
    options.projector = o.projector;
    options.use_offset = o.offset;
    options.nearest_steps = o.projector == Projector::Newton ? o.nearest_steps : 0;
    options.use_gaps = o.gaps;
    return options;
}

}  // namespace

NormalJob::NormalJob(const ProbeJob& job, const QueryOptions& o) noexcept
    : probe(job), options(projection_options(job, o)), smoothing(o.smoothing && job.layer != Layer::One), pruning(o.pruning)
{
    SQMAP_ASSERT(model::is_normal(job.model));
}

bool reads_base_grid(const NormalMapView& map, const ProjectionOptions& options) noexcept
{
    if (options.layer != Layer::Gate) return options.layer == Layer::Two;
    const std::uint64_t base =
        std::uint64_t{((map.eta_count - 1) >> map.subdivisions) + 1} * (map.omega_count >> map.subdivisions);
    return base >= std::uint64_t{options.layer3_gate} * map.vertex_count;
}

ModelContact query_normal(const model::ModelView& model, Vec3f point, const QueryOptions& options) noexcept
{
    PointBatch batch({&point, 1});
    std::array<Contact, 1> found;
    const ProbeJob job(model, batch, options, found);
    ModelContact contact;
    contact.point = point;
    if (run_normal_one_lane({job, options}).contacts == 0) {
        // Where no part holds the point this is a proof, as the superquadrics cover the solid.
        contact.certain = batch.reached[0] == 0;
        return contact;
    }
    const Contact& c = found[0];
    return {c.point, c.normal, c.depth, c.part, true, false, c.status};
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
