#include "refinement.h"

#include "bake/parts/fit.h"
#include "parallel/for_each.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <utility>

namespace sqmap::bake {

namespace {

constexpr double k_min_cost = 0.005;   ///< no cut is tried for a part that costs less
constexpr double k_split_gain = 0.07;  ///< a split stays if it saves this share of the part's cost

/// Fits the parts of one mesh's partitions, and keeps every fit: the same patch comes back while cuts are tried.
class PartFitter {
public:
    PartFitter(const PartsInput& input, const BakeOptions& options)
        : input_(input), solid_(input.solid), canonical_(input.canonical), options_(options)
    {
    }

    /// The parts of a partition. hopeless(known parts): the partition is not worth having, whatever the parts that are still to
    /// be fitted cost; called after each fit. Nothing is returned then. Several threads fit ahead, but what is kept does not
    /// depend on it.
    template <class Hopeless>
    std::optional<std::vector<MeasuredPart>> parts_of(const decompose::Partition& partition, Hopeless&& hopeless)
    {
        std::vector<Patch> patches = patches_of(solid_.mesh(), partition);
        std::vector<MeasuredPart> parts(patches.size());
        std::vector<std::uint8_t> is_known(patches.size(), 0);
        parallel::for_each(patches.size(), options_.threads, [&](std::size_t i) {
            if (std::optional<MeasuredPart> part = kept(patches[i])) {
                parts[i] = std::move(*part);
                is_known[i] = 1;
            }
        });
        std::vector<std::size_t> unknown;
        for (std::size_t i = 0; i < parts.size(); ++i)
            if (is_known[i] == 0) unknown.push_back(i);
        const auto give_up = [&] {
            std::vector<const MeasuredPart*> known;
            for (std::size_t i = 0; i < parts.size(); ++i)
                if (is_known[i] != 0) known.push_back(&parts[i]);
            return hopeless(known);
        };
        if (give_up()) return std::nullopt;
        const std::size_t ahead = parallel::thread_count(options_.threads);
        for (std::size_t first = 0; first < unknown.size(); first += ahead) {
            const std::size_t end = std::min(first + ahead, unknown.size());
            parallel::for_each(end - first, options_.threads, [&](std::size_t i) {
                const std::size_t part = unknown[first + i];
                parts[part].fitted = fit_patch(solid_, canonical_, std::move(patches[part]), options_.fit);
                parts[part].quality = quality_of(input_, parts[part].fitted);
            });
            for (std::size_t i = first; i < end; ++i) {
                history_.push_back(parts[unknown[i]]);
                is_known[unknown[i]] = 1;
                if (give_up()) return std::nullopt;
            }
        }
        return parts;
    }

    /// All parts of a partition.
    std::vector<MeasuredPart> parts_of(const decompose::Partition& partition)
    {
        return *parts_of(partition, [](const auto&) { return false; });
    }

    const BakeOptions& options() const { return options_; }

private:
    /// The same surface may have been fitted with other caps: the tightest that holds today's caps will do.
    std::optional<MeasuredPart> kept(const Patch& patch) const
    {
        std::vector<const MeasuredPart*> same;
        for (const MeasuredPart& o : history_)
            if (o.fitted.patch.triangles == patch.triangles) same.push_back(&o);
        std::stable_sort(same.begin(), same.end(), [](const MeasuredPart* l, const MeasuredPart* r) {
            return l->fitted.fit.volume < r->fitted.fit.volume;
        });
        HeldSurface held;
        for (const MeasuredPart* o : same) {
            if (o->fitted.patch.caps == patch.caps) return *o;
            if (held.points.empty()) held = held_by(solid_.mesh(), patch);
            const shape::Superquadricd& sq = o->fitted.fit.superquadric;
            const fit::Certificate certificate = fit::certify(sq, held.points, held.triangles);
            if (certificate.largest_f > 1 - fit::float_margin(sq)) continue;
            MeasuredPart part = *o;
            part.fitted.patch.caps = patch.caps;
            part.fitted.fit.certificate = certificate;
            part.quality.solid_volume = enclosed_volume(solid_.mesh(), patch);
            return part;
        }
        return std::nullopt;
    }

    const PartsInput& input_;
    const mesh::Solid& solid_;
    const CanonicalMesh& canonical_;
    const BakeOptions& options_;
    std::vector<MeasuredPart> history_;
};

/// Cost of the parts, as shares of the whole object, so that a badly served finger does not outweigh a badly served torso.
class Cost {
public:
    explicit Cost(const std::vector<MeasuredPart>& parts)
    {
        for (const MeasuredPart& part : parts) {
            area_ += part.quality.area;
            volume_ += part.quality.solid_volume;
        }
        if (!(volume_ > 0)) volume_ = 1;
    }

    /// The volume that the superquadric adds to the solid's own, and the area that its projection cannot see.
    double operator()(const MeasuredPart& part) const
    {
        const PartQuality& q = part.quality;
        const double loose = std::max(0.0, part.fitted.fit.volume - std::max(0.0, q.solid_volume)) / volume_;
        return loose + 2 * q.q2_share * q.area / area_;
    }
    double operator()(const std::vector<const MeasuredPart*>& parts) const
    {
        double sum = 0;
        for (const MeasuredPart* part : parts) sum += (*this)(*part);
        return sum;
    }
    double operator()(const std::vector<MeasuredPart>& parts) const
    {
        double sum = 0;
        for (const MeasuredPart& part : parts) sum += (*this)(part);
        return sum;
    }

private:
    double area_ = 0, volume_ = 0;  ///< of the whole object
};

/// Volume of a part's superquadric over that of its own solid: a box in a box-like superquadric has about 1.2, a bent or forked
/// part well above 2.
double looseness(const MeasuredPart& part)
{
    const double volume = part.fitted.fit.volume;
    return volume / std::max(part.quality.solid_volume, 1e-3 * volume);
}

const std::vector<std::uint32_t>& surface_of(const MeasuredPart& part) { return part.fitted.patch.triangles; }

using Surfaces = std::vector<std::vector<std::uint32_t>>;

/// The costliest part among those that are served badly and not given up; parts.size() if there is none.
std::size_t worst_part(const std::vector<MeasuredPart>& parts, const Cost& cost, const Surfaces& given_up,
                       const BakeOptions& options)
{
    std::size_t worst = parts.size();
    double worst_cost = k_min_cost;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const bool needs = looseness(parts[i]) > options.max_looseness || parts[i].quality.q2_share > options.max_q2_share;
        if (!needs || std::find(given_up.begin(), given_up.end(), surface_of(parts[i])) != given_up.end()) continue;
        if (const double c = cost(parts[i]); c > worst_cost) {
            worst_cost = c;
            worst = i;
        }
    }
    return worst;
}

/// Splits parts while that pays.
void split_parts(const decompose::Cutter& cutter, const Cost& cost, PartFitter& fitter, FittedPartition& now)
{
    const BakeOptions& options = fitter.options();
    Surfaces given_up;
    while (now.parts.size() < options.max_parts) {
        const std::size_t worst = worst_part(now.parts, cost, given_up, options);
        if (worst == now.parts.size()) return;
        decompose::Split split = cutter.split(now.partition, static_cast<std::uint32_t>(worst), options.decompose);
        std::optional<std::vector<MeasuredPart>> next;
        if (split.found && split.partition.part_count <= options.max_parts) {
            // Slivers of surface whose superquadrics are mostly air are no parts, even where the sum looks better.
            const double limit = std::max(options.max_looseness, 1.2 * looseness(now.parts[worst]));
            const auto is_sliver = [&](const MeasuredPart* p) {
                return looseness(*p) > limit && std::none_of(now.parts.begin(), now.parts.end(), [&](const MeasuredPart& o) {
                           return surface_of(o) == surface_of(*p);
                       });
            };
            const double least = cost(now.parts) - k_split_gain * cost(now.parts[worst]);
            next = fitter.parts_of(split.partition, [&](const std::vector<const MeasuredPart*>& known) {
                return !(cost(known) < least) || std::any_of(known.begin(), known.end(), is_sliver);
            });
        }
        if (next)
            now = {std::move(split.partition), std::move(*next)};
        else
            given_up.push_back(surface_of(now.parts[worst]));
    }
}

/// Area of the parts' Q2.
template <class Parts>
double hidden_area(const Parts& parts)
{
    double area = 0;
    for (const MeasuredPart* part : parts) area += part->quality.q2_share * part->quality.area;
    return area;
}

std::vector<const MeasuredPart*> pointers_to(const std::vector<MeasuredPart>& parts)
{
    std::vector<const MeasuredPart*> all;
    for (const MeasuredPart& part : parts) all.push_back(&part);
    return all;
}

/// Splits the part with the largest hidden area of those above options.max_q2_share, however little it costs, while that shows a
/// fifth of that area.
void split_hidden(const decompose::Cutter& cutter, PartFitter& fitter, FittedPartition& now)
{
    constexpr double k_shown = 0.2;
    const BakeOptions& options = fitter.options();
    Surfaces given_up;
    while (now.parts.size() < options.max_parts) {
        const MeasuredPart* worst = nullptr;
        for (const MeasuredPart& part : now.parts) {
            if (part.quality.q2_share <= options.max_q2_share) continue;
            if (std::find(given_up.begin(), given_up.end(), surface_of(part)) != given_up.end()) continue;
            if (worst == nullptr || hidden_area(std::array{&part}) > hidden_area(std::array{worst})) worst = &part;
        }
        if (worst == nullptr) return;
        const auto index = static_cast<std::uint32_t>(worst - now.parts.data());
        decompose::Split split = cutter.split(now.partition, index, options.decompose);
        std::optional<std::vector<MeasuredPart>> next;
        if (split.found && split.partition.part_count <= options.max_parts) {
            const double largest = hidden_area(pointers_to(now.parts)) - k_shown * hidden_area(std::array{worst});
            next = fitter.parts_of(split.partition,
                                   [&](const std::vector<const MeasuredPart*>& known) { return hidden_area(known) > largest; });
        }
        if (next)
            now = {std::move(split.partition), std::move(*next)};
        else
            given_up.push_back(surface_of(*worst));
    }
}

/// Undoes a cut of split_parts' kind that one superquadric serves as well. False if there is none.
bool undo_cut(const decompose::Cutter& cutter, const Cost& cost, PartFitter& fitter, FittedPartition& now)
{
    for (const decompose::Boundary& b : now.partition.boundaries) {
        if (b.kind != decompose::CutKind::Error) continue;
        decompose::Partition merged = cutter.merge(now.partition, b.part_a, b.part_b);
        const double limit = cost(now.parts);
        std::optional<std::vector<MeasuredPart>> next =
            fitter.parts_of(merged, [&](const std::vector<const MeasuredPart*>& known) { return cost(known) > limit; });
        if (!next) continue;
        now = {std::move(merged), std::move(*next)};
        return true;
    }
    return false;
}

}  // namespace

FittedPartition fit_partition(const PartsInput& input, const decompose::Partition& partition, const BakeOptions& options)
{
    return {partition, PartFitter(input, options).parts_of(partition)};
}

FittedPartition refine_partition(const PartsInput& input, const decompose::Partition& partition, const BakeOptions& options)
{
    PartFitter fitter(input, options);
    FittedPartition now{partition, fitter.parts_of(partition)};
    const Cost cost(now.parts);
    const decompose::Cutter cutter(input.solid.mesh());
    split_parts(cutter, cost, fitter, now);
    while (undo_cut(cutter, cost, fitter, now)) {
    }
    if (input.hidden) split_hidden(cutter, fitter, now);
    now.partition = cutter.ordered_by_area(now.partition);
    now.parts = fitter.parts_of(now.partition);
    return now;
}

}  // namespace sqmap::bake
