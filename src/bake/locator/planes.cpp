#include "planes.h"

#include "bake/locator/gaps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace sqmap::bake {

using model::LocatorPlane;

namespace {

constexpr int k_passes = 3;      ///< of balance
constexpr double k_coarse = 10;  ///< tolerance of layer Two over that of layer Three

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

/// The gaps below a cell's planes, which are decoded once for all samples.
class Gaps {
public:
    Gaps(const SurfaceCell& cell, std::span<const PartPlane> planes) : centre_(cell.cube.centre)
    {
        const model::Locator& locator = cell.subject.model.locator;
        for (const PartPlane& p : planes)
            planes_[count_++] = {p.plane.normal(), p.plane.distance(locator.plane_reach) * locator.cell, p.plane.is_joined()};
    }

    FlatGap at(const Sample& sample) const
    {
        const auto offset = cast<float>(sample.point - centre_);
        return flat_gap(
            count_, [&](std::size_t k) { return planes_[k].distance - dot(planes_[k].normal, offset); },
            [&](std::size_t k) { return planes_[k].is_joined; });
    }

private:
    struct Decoded {
        Vec3f normal;
        float distance;
        bool is_joined;
    };
    Vec3d centre_;
    std::array<Decoded, model::k_max_planes> planes_;
    std::size_t count_ = 0;
};

/// The worst misses of planes among the samples, beyond the tolerance.
struct Miss {
    const Sample* worst = nullptr;  ///< null: nowhere
    std::size_t group_end = 0;      ///< the surface is above the planes there: behind which plane another joins the group
    double least = 0;               ///< the least that an inside sample's depth is above the planes'; not above 0
    double share = 0;               ///< the greatest, of the tolerance
};

/// Limits of the misses of planes; model units.
struct Limits {
    double depth;    ///< the depth of an inside sample by
    double missed;   ///< inside samples of that depth, as if they were outside
    double touched;  ///< outside samples of that distance, as if they were inside
};

Limits limits_of(const SurfaceCell& cell)
{
    return {cell.tolerance, 2 * cell.subject.flat_tolerance, cell.subject.flat_tolerance};
}

/// enough: the search for worse samples ends at a greater share.
Miss miss_of(const SurfaceCell& cell, std::span<const PartPlane> planes, const std::vector<Sample>& samples, Limits limits,
             double enough = INFINITY)
{
    const Gaps gaps(cell, planes);
    Miss miss;
    for (const Sample& sample : samples) {
        const FlatGap lowest = gaps.at(sample);
        const double gap = static_cast<double>(lowest.gap);
        // Outside only the side counts.
        const double excess = gap - (sample.inside ? sample.nearest.distance : 0);
        if (sample.inside) miss.least = std::min(miss.least, excess);
        double here = excess > 0 ? excess / limits.depth : (sample.inside ? -excess / (2 * limits.depth) : 0);
        // On the wrong side, and not because it is so near; however loose the tolerance of depths.
        const double clear = sample.inside ? limits.missed : limits.touched;
        if ((gap > 0) != sample.inside && sample.nearest.distance > clear) here += 1;
        if (here > miss.share) {
            miss.share = here;
            miss.worst = here > 1 ? &sample : nullptr;
            miss.group_end = excess > 0 ? 0 : lowest.group_end;
            if (here > enough) break;
        }
    }
    return miss;
}

/// Adds planes where they miss samples. Miss::least in the end, or nothing where planes do not suffice.
std::optional<double> add_planes(const SurfaceCell& cell, const std::vector<Sample>& samples, std::vector<PartPlane>& planes)
{
    for (;;) {
        const Miss miss = miss_of(cell, planes, samples, limits_of(cell));
        if (miss.worst == nullptr) return miss.least;
        if (planes.size() == model::k_max_planes) return std::nullopt;
        std::optional<PartPlane> next = plane_at(cell, *miss.worst);
        if (!next) return std::nullopt;
        const auto end = static_cast<std::ptrdiff_t>(miss.group_end);
        if (end > 0) next->plane = next->plane.joined();
        planes.insert(end > 0 ? planes.begin() + end : planes.end(), *next);
    }
}

/// An inside sample that a plane answers: where it is from the cell's centre, and by how much its depth below the plane is
/// greater than below the surface; model units.
struct Excess {
    Vec3d at;
    double value;
};

/// The samples of each plane.
struct Excesses {
    std::vector<std::vector<Excess>> of_plane;
    double sum = 0;  ///< of absolute values
};

Excesses excesses_of(const SurfaceCell& cell, const std::vector<PartPlane>& planes, const std::vector<Sample>& samples)
{
    const Gaps gaps(cell, planes);
    Excesses excesses;
    excesses.of_plane.resize(planes.size());
    for (const Sample& sample : samples) {
        if (!sample.inside) continue;
        const FlatGap lowest = gaps.at(sample);
        const double value = static_cast<double>(lowest.gap) - sample.nearest.distance;
        excesses.of_plane[lowest.plane].push_back({sample.point - cell.cube.centre, value});
        excesses.sum += std::abs(value);
    }
    return excesses;
}

/// A plane moved by the median of its samples' excesses.
LocatorPlane shifted(const LocatorSubject& subject, LocatorPlane plane, std::vector<Excess> samples)
{
    if (samples.empty()) return plane;
    std::sort(samples.begin(), samples.end(), [](const Excess& a, const Excess& b) { return a.value < b.value; });
    const std::size_t n = samples.size();
    return raised(subject, plane, -0.5 * (samples[(n - 1) / 2].value + samples[n / 2].value));
}

/// A plane tilted by what its samples' excesses grow along it (least squares), and moved by the median of what is left.
LocatorPlane tilted(const LocatorSubject& subject, LocatorPlane plane, std::vector<Excess> samples)
{
    constexpr std::size_t k_enough = 4;
    if (samples.size() < k_enough) return shifted(subject, plane, std::move(samples));
    const Vec3d n = cast<double>(plane.normal());
    const Vec3d u = normalized(cross(n, std::abs(n.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0})), v = cross(n, u);
    Vec3d middle{};
    double mean = 0;
    for (const Excess& s : samples) {
        middle += s.at / double(samples.size());
        mean += s.value / double(samples.size());
    }
    double uu = 0, uv = 0, vv = 0, ue = 0, ve = 0;
    for (const Excess& s : samples) {
        const double x = dot(u, s.at - middle), y = dot(v, s.at - middle), e = s.value - mean;
        uu += x * x;
        uv += x * y;
        vv += y * y;
        ue += x * e;
        ve += y * e;
    }
    const double det = uu * vv - uv * uv;
    if (!(det > 1e-3 * uu * vv)) return shifted(subject, plane, std::move(samples));  // in a row
    const Vec3d to = n + ((ue * vv - ve * uv) / det) * u + ((ve * uu - ue * uv) / det) * v;
    const float reach = subject.model.locator.plane_reach;
    const LocatorPlane turned = LocatorPlane::towards(to);
    const Vec3d turn = cast<double>(turned.normal()) - n;
    const double distance = static_cast<double>(plane.distance(reach)) + dot(turn, middle) / subject.cell();
    if (!LocatorPlane::holds_distance(distance, reach)) return plane;
    const LocatorPlane about_middle = turned.with_distance(distance, reach);
    for (Excess& s : samples) s.value -= dot(turn, s.at - middle);
    return shifted(subject, plane.is_joined() ? about_middle.joined() : about_middle, std::move(samples));
}

/// Tangent planes of a surface that bends away are above it, of one that bends towards the point below: fits each plane to its
/// samples, while that brings them nearer and all stay within the tolerance.
void balance(const SurfaceCell& cell, const std::vector<Sample>& samples, std::vector<PartPlane>& planes)
{
    Excesses now = excesses_of(cell, planes, samples);
    const auto improves = [&](auto&& fit) {
        std::vector<PartPlane> moved = planes;
        for (std::size_t k = 0; k < planes.size(); ++k) moved[k].plane = fit(cell.subject, planes[k].plane, now.of_plane[k]);
        Excesses then = excesses_of(cell, moved, samples);
        if (!(then.sum < now.sum) || miss_of(cell, moved, samples, limits_of(cell), 1).worst != nullptr) return false;
        planes = std::move(moved);
        now = std::move(then);
        return true;
    };
    for (int pass = 0; pass < k_passes && (improves(tilted) || improves(shifted)); ++pass) {
    }
}

/// Moves the plane that by itself misses the fewest samples to the front, and marks it if it answers layer Two within that
/// layer's tolerance.
void put_sufficient_first(const SurfaceCell& cell, const std::vector<Sample>& samples, std::vector<PartPlane>& planes)
{
    std::size_t best = 0;
    double least = 1;
    for (std::size_t i = 0; i < planes.size(); ++i) {
        const double coarse = k_coarse * cell.subject.flat_tolerance;
        const double share =
            miss_of(cell, std::span(&planes[i], 1), samples, {coarse, 2 * coarse, 2 * cell.subject.flat_tolerance}, least).share;
        if (share < least) {
            least = share;
            best = i;
        }
    }
    if (planes.size() == 1 || least == 1) return;
    std::size_t begin = best, end = best + 1;
    while (begin > 0 && planes[begin].plane.is_joined()) --begin;
    while (end < planes.size() && planes[end].plane.is_joined()) ++end;
    // The plane moves to the front of its group, then the group to the front.
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
    const bool deep = cell.cube.side > 1.5 * cell.subject.cell();
    if (least && planes.size() > 1 && (mixed || deep)) {
        // Planes that are right at all of these may still meet at the wrong position between them.
        sampler.add_more(samples);
        least = add_planes(cell, samples, planes);
    }
    if (!least) return std::nullopt;
    // A surface that bends towards the point is met in the middle.
    const double tolerance = cell.tolerance;
    if (*least < -tolerance)
        for (PartPlane& p : planes) p.plane = raised(cell.subject, p.plane, -*least - tolerance);
    balance(cell, samples, planes);
    put_sufficient_first(cell, samples, planes);
    return planes;
}

}  // namespace sqmap::bake
