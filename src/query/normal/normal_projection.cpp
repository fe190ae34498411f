// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, section 4.2: one part's answer, and that of all.
#include "sqmap/query/normal_projection.h"

#include "foot_search.h"
#include "map_sample.h"
#include "witness_rule.h"

#include <cmath>
#include <limits>

namespace sqmap::query {

using shape::Foot;
using shape::SurfacePoint;

namespace {

// Closest-point steps on the map: the surface looked up again at the projection of p on the tangent plane of the surface
// point found. A step is kept while it leads to a nearer surface point.
void seek_nearest(const NormalMapView& map, Vec3f p, const ProjectionOptions& options, PartAnswer& answer)
{
    float nearest = norm(answer.surface - p);
    for (int step = 0; step < options.nearest_steps; ++step) {
        const Vec3f target = p + dot(answer.surface - p, answer.normal) * answer.normal;
        std::uint8_t flags = 0;
        const Foot<float> foot = find_foot(map, target, Projector::Newton, &flags);
        if ((flags & k_projection_unproven) != 0) return;
        const MapSample sample = sample_map(map, shape::angles_of(foot.position), options);
        if ((sample.flags & (k_projection_miss | k_projection_cap)) != 0 || !(norm_sq(sample.normal) > 0.5f)) return;
        const Vec3f surface = foot.point - sample.distance * foot.normal;
        const float distance = norm(surface - p);
        if (!(distance < nearest)) return;
        nearest = distance;
        answer.surface = surface;
        answer.normal = sample.normal;
        answer.depth = dot(surface - p, sample.normal);
    }
}

}  // namespace

PartAnswer project(const NormalMapView& map, Vec3f p, const ProjectionOptions& options) noexcept
{
    PartAnswer answer;
    FootQuery query;
    if (!enters(map, p, query)) return answer;
    if (options.layer == Layer::One) {
        answer.verdict = Verdict::Contact;
        const SurfacePoint<float> s = shape::surface_point(map.superquadric, query.own);
        answer.angles = shape::angles_of(query.own);
        answer.foot = answer.surface = s.point;
        answer.foot_normal = answer.normal = s.normal;
        answer.foot_distance = answer.depth_along = norm(s.point - p);
        answer.depth = dot(s.point - p, s.normal);
        return answer;
    }
    const Foot<float> foot = options.projector == Projector::Pyramid
                                 ? pyramid_foot(map, p, query, !reads_base_grid(map, options), answer.flags)
                                 : newton_foot(map, p, query, answer.flags);
    answer.angles = shape::angles_of(foot.position);
    answer.foot = foot.point;
    answer.foot_normal = foot.normal;
    answer.foot_distance = norm(foot.point - p);
    MapSample sample = sample_map(map, answer.angles, options);
    if (options.use_gaps && answer.foot_distance > sample.distance && !reads_base_grid(map, options) &&
        behind_first_surface(map, answer.angles, answer.foot_distance, sample.distance)) {
        sample.flags = k_projection_behind | (sample.distance < std::numeric_limits<float>::infinity() ? 0 : k_projection_miss);
        sample.normal = {};
    }
    answer.flags |= sample.flags;
    answer.map_distance = sample.distance;
    answer.verdict = answer.foot_distance >= sample.distance ? Verdict::Contact : Verdict::Free;
    const bool surface = (sample.flags & (k_projection_miss | k_projection_cap)) == 0;
    answer.surface = surface ? foot.point - sample.distance * foot.normal : foot.point;
    answer.normal = surface && norm_sq(sample.normal) > 0.5f ? sample.normal : foot.normal;
    answer.depth_along = answer.foot_distance - sample.distance;
    answer.depth = surface ? dot(answer.surface - p, answer.normal) : answer.depth_along;
    if (surface && answer.verdict == Verdict::Contact && norm_sq(sample.normal) > 0.5f && !reads_base_grid(map, options))
        seek_nearest(map, p, options, answer);
    return answer;
}

bool WitnessRule::add(std::int32_t part, const PartAnswer& answer) noexcept
{
    if (answer.verdict == Verdict::Outside) return true;
    is_held = true;
    if (is_witness(answer)) {
        combined = {};
        return false;
    }
    if (answer.verdict != Verdict::Contact) return true;
    combined.contact = true;
    const bool surface = (answer.flags & (k_projection_cap | k_projection_miss)) == 0;
    if (surface && (!combined.has_surface || std::abs(answer.depth) < std::abs(nearest.depth))) {
        combined.has_surface = true;
        combined.part = part;
        nearest = answer;
    } else if (combined.part < 0) {
        combined.part = part;
    }
    return true;
}

CombinedAnswer combine(std::span<const PartAnswer> answers) noexcept
{
    WitnessRule rule;
    for (std::size_t i = 0; i < answers.size(); ++i)
        if (!rule.add(static_cast<std::int32_t>(i), answers[i])) break;
    return rule.combined;
}

}  // namespace sqmap::query
