#include "planes.h"

#include "model/locator.h"

#include <algorithm>

namespace sqmap::bake {

using model::LocatorPlane;

namespace {

constexpr double k_coarse = 5;  ///< tolerance of layer Two over that of layer Three

/// The plane that touches the surface at the point nearest to a sample, relative to the cell's centre; nothing where it is
/// farther than planes can be stored.
std::optional<PartPlane> plane_at(const SurfaceCell& cell, const Sample& sample)
{
    const LocatorSubject& subject = cell.subject;
    const LocatorPlane plane = LocatorPlane::towards(normal_at(subject.solid, sample, subject.cell()));
    // With the direction as stored.
    const double distance = dot(cast<double>(plane.normal()), sample.nearest.point - cell.cube.centre) / subject.cell();
    const float reach = subject.model.locator.plane_reach;
    if (!LocatorPlane::holds_distance(distance, reach)) return std::nullopt;
    return PartPlane{plane.with_distance(distance, reach), subject.part_of_triangle[sample.nearest.triangle]};
}

/// A plane moved outwards by so much.
LocatorPlane raised(const LocatorSubject& subject, LocatorPlane plane, double by)
{
    const float reach = subject.model.locator.plane_reach;
    return plane.with_distance(static_cast<double>(plane.distance(reach)) + by / subject.cell(), reach);
}

/// Where planes miss the samples by more than the tolerance.
struct Miss {
    const Sample* worst = nullptr;  ///< null: nowhere
    std::size_t group_end = 0;      ///< the surface is above the planes there: behind which plane another joins the group
    double least = 0;               ///< the least that an inside sample's depth is above the planes'; not above 0
    double share = 0;               ///< the greatest, of the tolerance
};

Miss miss_of(const SurfaceCell& cell, const std::vector<PartPlane>& planes, const std::vector<Sample>& samples, double tolerance)
{
    std::vector<std::uint32_t> words;
    for (const PartPlane& p : planes) words.push_back(p.plane.word);
    Miss miss;
    for (const Sample& sample : samples) {
        const model::FlatGap lowest =
            model::flat_gap(cell.subject.model.locator, words, cast<float>(sample.point - cell.cube.centre));
        const double gap = static_cast<double>(lowest.gap);
        // Outside only the side counts.
        const double excess = gap - (sample.inside ? sample.nearest.distance : 0);
        if (sample.inside) miss.least = std::min(miss.least, excess);
        double here = excess > 0 ? excess / tolerance : (sample.inside ? -excess / (2 * tolerance) : 0);
        // On the wrong side, and not because it is so near.
        if (excess > 0 && !sample.inside && sample.nearest.distance > cell.subject.flat_tolerance) here += 1;
        if (here > miss.share) {
            miss.share = here;
            miss.worst = here > 1 ? &sample : nullptr;
            miss.group_end = excess > 0 ? 0 : lowest.group_end;
        }
    }
    return miss;
}

/// Adds planes where they miss samples. Miss::least in the end, or nothing where planes do not suffice.
std::optional<double> add_planes(const SurfaceCell& cell, const std::vector<Sample>& samples, std::vector<PartPlane>& planes)
{
    for (;;) {
        const Miss miss = miss_of(cell, planes, samples, cell.subject.flat_tolerance);
        if (miss.worst == nullptr) return miss.least;
        if (planes.size() == model::k_max_planes) return std::nullopt;
        std::optional<PartPlane> next = plane_at(cell, *miss.worst);
        if (!next) return std::nullopt;
        const auto end = static_cast<std::ptrdiff_t>(miss.group_end);
        if (end > 0) next->plane = next->plane.joined();
        planes.insert(end > 0 ? planes.begin() + end : planes.end(), *next);
    }
}

/// Of several planes puts the one first that misses the samples least by itself, marked, where that is within the tolerance of
/// layer Two.
void put_sufficient_first(const SurfaceCell& cell, const std::vector<Sample>& samples, std::vector<PartPlane>& planes)
{
    std::size_t best = 0;
    double least = 1;
    for (std::size_t i = 0; i < planes.size(); ++i) {
        const double share = miss_of(cell, {planes[i]}, samples, k_coarse * cell.subject.flat_tolerance).share;
        if (share < least) {
            least = share;
            best = i;
        }
    }
    if (planes.size() == 1 || least == 1) return;
    std::size_t begin = best, end = best + 1;
    while (begin > 0 && planes[begin].plane.is_joined()) --begin;
    while (end < planes.size() && planes[end].plane.is_joined()) ++end;
    // Its group first, and it the first of its group.
    const auto at = [&](std::size_t i) { return planes.begin() + static_cast<std::ptrdiff_t>(i); };
    if (best > begin) {
        std::rotate(at(begin), at(best), at(best + 1));
        planes[begin + 1].plane = planes[begin + 1].plane.joined();
    }
    planes[begin].plane = planes[begin].plane.sufficient();
    std::rotate(at(0), at(begin), at(end));
}

}  // namespace

std::optional<std::vector<PartPlane>> flat_planes(const SurfaceCell& cell, CellSampler& sampler, std::vector<Sample>& samples)
{
    const bool mixed = cell.kind == model::LocatorCellKind::Mixed;
    if (mixed) sampler.add_surface(samples);
    const std::optional<PartPlane> first = plane_at(cell, cell.centre);
    if (!first) return std::nullopt;
    std::vector<PartPlane> planes{*first};
    std::optional<double> least = add_planes(cell, samples, planes);
    if (least && planes.size() > 1 && mixed) {
        // Planes that are right at all of these may still meet at the wrong position between them.
        sampler.add_more(samples);
        least = add_planes(cell, samples, planes);
    }
    if (!least) return std::nullopt;
    // A surface that bends towards the point is met in the middle.
    const double tolerance = cell.subject.flat_tolerance;
    if (*least < -tolerance)
        for (PartPlane& p : planes) p.plane = raised(cell.subject, p.plane, -*least - tolerance);
    put_sufficient_first(cell, samples, planes);
    return planes;
}

}  // namespace sqmap::bake
