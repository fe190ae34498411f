// The query of section 4.2 with one lane: one point, or one part's answer.
#undef HWY_COMPILE_ONLY_STATIC
#define HWY_COMPILE_ONLY_SCALAR
#include "job.h"
#include "sqmap/math/assert.h"
#include "sqmap/paper/projection.h"

#include <hwy/highway.h>

#include "one_point-inl.h"
#include "probe-inl.h"

namespace sqmap::paper {

namespace {

Vec3f vector(const V3& v) { return {hn::GetLane(v.x), hn::GetLane(v.y), hn::GetLane(v.z)}; }
shape::Arc<float> arc_of(const ArcLanes& arc)
{
    return {hn::GetLane(arc.c), hn::GetLane(arc.s), hn::GetLane(arc.nc), hn::GetLane(arc.ns), 1};
}

}  // namespace

ProbeResult run_one_lane(const PaperJob& job) noexcept { return PaperKernel(job).run(); }

PartAnswer project(const MapView& map, Vec3f p, const ProjectionOptions& options) noexcept
{
    SQMAP_ASSERT(is_consistent(map));
    PartAnswer answer;
    const OnePoint point(map, p, options);
    if (!point.is_held) return answer;
    const PartAnswerLanes a =
        options.layer == Layer::One ? point.part.layer_one(point.p, point.held) : point.part.answer(point.p, point.held, all());
    answer.verdict = any(a.contact) ? Verdict::Contact : Verdict::Free;
    answer.flags = static_cast<std::uint8_t>(hn::GetLane(a.flags));
    answer.foot_distance = hn::GetLane(a.foot_distance);
    answer.map_distance = hn::GetLane(a.map_distance);
    answer.depth_along = hn::GetLane(a.depth_along);
    answer.depth = hn::GetLane(a.depth);
    answer.angles = {hn::GetLane(a.angles.eta), hn::GetLane(a.angles.omega)};
    answer.foot = vector(a.foot);
    answer.foot_normal = vector(a.foot_normal);
    answer.surface = vector(a.surface);
    answer.normal = vector(a.normal);
    return answer;
}

shape::Foot<float> find_foot(const MapView& map, Vec3f p, Projector projector, std::uint8_t* flags) noexcept
{
    const OnePoint point(map, p, {.projector = projector});
    I found = hn::Zero(di);
    FootLanes foot;
    if (point.is_held) {
        foot = point.part.foot(point.held, all(), found);
    } else {
        // Outside or on the surface to rounding: the foot nearest to where its own ray leaves.
        F gauge;
        foot = point.part.foot_from(point.part.shape().through(point.part.shape().to_unit(point.held.q), gauge), point.held.q,
                                    all());
        found = flag(hn::Not(hn::Le(foot.miss, point.part.proven())), k_projection_unproven);
    }
    if (flags != nullptr) *flags = static_cast<std::uint8_t>(hn::GetLane(found));
    shape::Foot<float> out;
    out.position = {arc_of(foot.position.latitude), arc_of(foot.position.longitude)};
    out.point = vector(point.part.shape().to_model(foot.at.point));
    out.normal = vector(point.part.shape().direction_to_model(foot.at.normal));
    out.depth = -dot(p - out.point, out.normal);
    out.miss = hn::GetLane(foot.miss);
    out.converged = out.miss <= hn::GetLane(point.part.proven());
    return out;
}

GridFoot pyramid_search(const MapView& map, Vec3f p, const PyramidOptions& options) noexcept
{
    const OnePoint point(map, p, {});
    if (!point.is_held) return {};
    const Searched found = point.part.searched(point.held, all(), options);
    return {static_cast<std::uint32_t>(hn::GetLane(found.node.row)), static_cast<std::uint32_t>(hn::GetLane(found.node.column)),
            hn::GetLane(found.collinearity), found.evaluations, any(found.wide)};
}

namespace {

MapSample sample_of(const SampleLanes& s)
{
    return {hn::GetLane(s.distance), vector(s.normal), static_cast<std::uint8_t>(hn::GetLane(s.flags))};
}

}  // namespace

MapSample sample_map(const MapView& map, shape::SurfaceAnglesf angles, const ProjectionOptions& options) noexcept
{
    return sample_of(PartLanes(map, options, nullptr).sample_at({set(angles.eta), set(angles.omega)}));
}

MapSample sample_smoothed(const MapView& map, shape::SurfaceAnglesf angles, Layer layer) noexcept
{
    ProjectionOptions options;
    options.layer = layer;
    const PartLanes part(map, options, nullptr);
    const AngleLanes at{set(angles.eta), set(angles.omega)};
    if (layer == Layer::Two) return sample_of(part.map().smoothed_base(at, part.sample_at(at)));
    return sample_of(part.map().smoothed(at, part.sample_at(at)));
}

}  // namespace sqmap::paper
