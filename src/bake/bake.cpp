// Baking central models: their own steps of the pipeline.
#include "bake/bake.h"

#include "pipeline.h"
#include "sqmap/model/model.h"

#include <algorithm>
#include <optional>

namespace sqmap::bake {

namespace {

// A locator that gives wrong verdicts may grow to this many times its share of bytes.
constexpr double k_max_locator = 8;
// Eq. 35's mean and 99th percentile are held to these shares of the target too, where that is not less than what is promised at
// the default; the percentile, which few points make, with room to spare.
constexpr double k_eq35_share = 0.1, k_eq35_least = 0.05;
constexpr double k_eq35_p99_share = 0.9, k_eq35_p99_least = 0.45;

class CentralBake final : public Bake {
public:
    using Bake::Bake;

private:
    Draft draft(const CentralOptions& central, const Draft* coarser) override
    {
        Draft out;
        out.maps = central_maps(central, coarser != nullptr ? std::span(coarser->maps) : std::span<CentralMapData>());
        out.model = assembled(out.maps);
        if (!evaluator_) evaluator_.emplace(samples(out.model.view()));
        evaluator_->begin(out.model.view());
        out.model.measured = measured([&](const EvaluateOptions& options) { return evaluator_->first(options.points); });
        return out;
    }
    double shortfall(const model::Measured& m) const override
    {
        const double target = options_.target_error;
        return std::max({m.depth_p99 / target, m.eq35_mean / std::max(k_eq35_share * target, k_eq35_least),
                         m.eq35_p99 / std::max(k_eq35_p99_share * target, k_eq35_p99_least)});
    }
    double max_hidden() const override { return 50; }

    bool is_located() const { return header_.solid != 0 && options_.locator; }
    /// Doubles the locator's bytes until layer 3 has no wrong verdicts or the locator is as large as it may be.
    void locator() override
    {
        if (!is_located()) return;
        GrowingLocator locator(surface(), locator_, model_);
        for (double more = 1; more <= k_max_locator; more *= 2) {
            if (!locator.bake(more) && more > 1) continue;
            measure_layers(model_.view(), model_.measured);
            if (!model::has_wrong_verdicts(model_.measured)) return;
        }
    }
    void measure() override
    {
        if (!is_located()) measure_layers(model_.view(), model_.measured);
    }

    std::optional<DraftEvaluator> evaluator_;
};

}  // namespace

BakeResult bake(const mesh::Mesh& mesh, bool solid, const BakeOptions& options)
{
    return CentralBake(mesh, solid, options).run();
}

}  // namespace sqmap::bake
