#include "seeds.h"

#include "bake/locator/approach.h"
#include "bake/locator/domains.h"
#include "bake/locator/gaps.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sqmap::bake {

using model::Seed;

namespace {

// By how much of R_max a sample may miss its nearest surface before it gets a seed of its own.
constexpr double k_tolerance = 0.0005;

double tolerance_of(const SurfaceCell& cell) { return k_tolerance * cell.subject.model.header.r_max; }

/// The plane that touches the surface at the point nearest to a sample, relative to the cell's centre, for a part's chart.
Seed seed_at(const SurfaceCell& cell, const Sample& sample, std::uint32_t part)
{
    const LocatorSubject& subject = cell.subject;
    const Seed seed = model::make_seed(part, normal_at(subject.solid, sample, subject.cell()));
    // With the direction as stored.
    const double distance = dot(cast<double>(model::seed_normal(seed)), sample.nearest.point - cell.cube.centre);
    return model::with_distance(seed, distance, subject.cell());
}

/// Distance that the runtime finds from a seed of the cell.
double reach_from(const SurfaceCell& cell, Seed seed, Vec3d p)
{
    const model::ModelView& view = cell.subject.model;
    const model::Part& part = view.parts[model::seed_part(seed)];
    const model::CentralMap map(view, part);
    const Vec3f point = cast<float>(p), n = model::seed_normal(seed);
    const float gap = seed_gap(view.locator, seed, cast<float>(p - cell.cube.centre));
    return std::sqrt(approach(map, part, map.to_chart_frame(point), map.to_chart_frame(point + gap * n)).distance_sq);
}

struct SeedReach {
    Seed seed;
    double distance;
};

/// The owner's chart as a rule; another's where that one does not see the surface.
SeedReach best_seed(const SurfaceCell& cell, const Sample& sample)
{
    const LocatorSubject& subject = cell.subject;
    const std::uint32_t owner = subject.part_of_triangle[sample.nearest.triangle];
    const double enough = sample.nearest.distance + tolerance_of(cell);
    const auto from_part = [&](std::uint32_t part) {
        const Seed seed = seed_at(cell, {sample.point, sample.nearest, true}, part);
        return SeedReach{seed, reach_from(cell, seed, sample.point)};
    };
    SeedReach best = from_part(owner);
    for (std::uint32_t i = 0; i < subject.model.parts.size() && best.distance > enough; ++i) {
        if (i == owner || !domain_holds(subject.model.parts[i], sample.nearest.point)) continue;
        if (const SeedReach other = from_part(i); other.distance < best.distance) best = other;
    }
    return best;
}

/// A point on a cell's border belongs to the octants on both sides.
bool is_in_octant(Vec3d offset, int octant)
{
    for (int axis = 0; axis < 3; ++axis) {
        const double v = (octant >> axis & 1) != 0 ? offset[axis] : -offset[axis];
        if (!(v > -1e-9)) return false;
    }
    return true;
}

/// Distances that are found from each seed of a chain, sample after sample; each once, when it is first needed.
class Reaches {
public:
    Reaches(const SurfaceCell& cell, const std::vector<Sample>& samples) : cell_(cell), samples_(samples) {}

    double operator()(const SeedChain& chain, std::size_t seed, std::size_t sample)
    {
        std::vector<double>& of_seed = found_[seed];
        if (of_seed.empty()) of_seed.assign(samples_.size(), -1);
        double& found = of_seed[sample];
        if (found < 0) found = reach_from(cell_, chain.seeds[seed], samples_[sample].point);
        return found;
    }
    /// The least of a sample.
    double best(const SeedChain& chain, std::size_t sample)
    {
        double best = INFINITY;
        for (std::size_t k = 0; k < chain.seeds.size(); ++k) best = std::min(best, (*this)(chain, k, sample));
        return best;
    }

private:
    const SurfaceCell& cell_;
    const std::vector<Sample>& samples_;
    std::array<std::vector<double>, model::k_max_seeds> found_;
};

/// Which seed comes first in which octant, and how near a surface found from it must be to end the search.
void rank(const SurfaceCell& cell, const std::vector<Sample>& samples, Reaches& found, SeedChain& chain)
{
    const double tolerance = tolerance_of(cell);
    std::vector<double> best;
    for (std::size_t i = 0; i < samples.size(); ++i) best.push_back(found.best(chain, i));
    double miss[8][model::k_max_seeds] = {};
    for (std::size_t k = 0; k < chain.seeds.size(); ++k) {
        double reach = INFINITY;
        for (std::size_t i = 0; i < samples.size(); ++i) {
            const double here = found(chain, k, i);
            if (here > best[i] + tolerance) reach = std::min(reach, here);
            for (int octant = 0; octant < 8; ++octant)
                if (is_in_octant(samples[i].point - cell.cube.centre, octant))
                    miss[octant][k] += std::min(here, 1e3) - std::min(best[i], 1e3);
        }
        // Between samples it may come half a sample's spacing earlier.
        chain.seeds[k] = model::with_reach(chain.seeds[k], reach / cell.subject.cell() - 0.25);
    }
    for (std::uint32_t octant = 0; octant < 8; ++octant) {
        const double* m = miss[octant];
        const auto first = static_cast<std::uint32_t>(std::min_element(m, m + chain.seeds.size()) - m);
        chain.choices = model::with_seed_choice(chain.choices, octant, first);
    }
}

}  // namespace

SeedChain seed_chain(const SurfaceCell& cell, const std::vector<Sample>& samples)
{
    const double tolerance = tolerance_of(cell);
    SeedChain chain;
    Reaches found(cell, samples);
    chain.seeds = {seed_at(cell, cell.centre, cell.subject.part_of_triangle[cell.centre.nearest.triangle])};
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const Sample& sample = samples[i];
        const double best = found.best(chain, i);
        if (best <= sample.nearest.distance + tolerance || chain.seeds.size() == model::k_max_seeds) continue;
        const SeedReach own = best_seed(cell, sample);
        if (own.distance < best - tolerance) chain.seeds.push_back(own.seed);
    }
    if (chain.seeds.size() > 1) rank(cell, samples, found, chain);
    for (std::size_t i = 0; i < samples.size(); ++i)
        if (samples[i].inside) chain.miss = std::max(chain.miss, std::abs(found.best(chain, i) - samples[i].nearest.distance));
    return chain;
}

}  // namespace sqmap::bake
