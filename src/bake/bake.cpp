// Baking central models: the maps' own steps of the pipeline.
#include "sqmap/bake/bake.h"

#include "bake/exact/candidate_lists.h"
#include "pipeline.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/model/reliability.h"

#include <algorithm>

namespace sqmap::bake {

namespace {

// A locator that gives wrong verdicts may grow to this many times its share of bytes.
constexpr double k_max_locator = 8;
// Eq. 35's mean and 99th percentile are held to these shares of the target too, where that is not less than what is promised at
// the default; the percentile, which few points make, with room to spare.
constexpr double k_eq35_share = 0.1, k_eq35_least = 0.05;
constexpr double k_eq35_p99_share = 0.9, k_eq35_p99_least = 0.45;

class CentralSteps final : public MapSteps {
public:
    Draft draft(const Subject& subject, const CentralOptions& central, const Draft* coarser) override
    {
        Draft out;
        out.maps =
            bake_central_maps(subject, central, coarser != nullptr ? std::span(coarser->maps) : std::span<CentralMapData>());
        out.model = assembled(subject, out.maps);
        out.measured =
            measured([&](const EvaluateOptions& options) { return evaluate(out.model.view(), subject.solid, options); },
                     [&](const model::Measured& m) { return shortfall(m, subject.options); });
        return out;
    }
    double shortfall(const model::Measured& m, const BakeOptions& options) const override
    {
        return std::max({m.depth_p99 / options.target_error,
                         m.eq35_mean / std::max(k_eq35_share * options.target_error, k_eq35_least),
                         m.eq35_p99 / std::max(k_eq35_p99_share * options.target_error, k_eq35_p99_least)});
    }
    double max_hidden() const override { return 50; }
    void locate(const Subject& subject, Draft& draft) override
    {
        if (subject.header.solid != 0 && subject.options.locator)
            bake_measured_locator(subject, draft);
        else
            measure_layers(draft.model.view(), subject.solid, draft.measured);
        if (subject.options.locator) bake_candidate_lists(subject.solid, subject.locator(), draft.model);
    }

private:
    /// Doubles the locator's bytes until layer 3 has no wrong verdicts or the locator is as large as it may be.
    static void bake_measured_locator(const Subject& subject, Draft& draft)
    {
        for (LocatorOptions locator = subject.locator();; locator.more *= 2) {
            bake_locator(subject.surface(), locator, draft.model);
            measure_layers(draft.model.view(), subject.solid, draft.measured);
            if (!model::has_wrong_verdicts(draft.measured) || 2 * locator.more > k_max_locator) return;
        }
    }
};

}  // namespace

BakeResult bake(const mesh::Mesh& mesh, bool solid, const BakeOptions& options)
{
    CentralSteps steps;
    return run_pipeline(mesh, solid, options, steps);
}

}  // namespace sqmap::bake
