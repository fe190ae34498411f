// Evaluation of the drafts of one model, which differ in the fineness of their maps.
#pragma once

#include "sqmap/bake/evaluate.h"

#include <cstdint>
#include <memory>

namespace sqmap::bake {

/// Measures drafts of central maps without a locator. Drafts of one mesh have their charts and sample points in common, so that
/// each point is compared with the mesh once. Not thread-safe.
class DraftEvaluator {
public:
    /// solid: outlives it; in model space.
    explicit DraftEvaluator(const mesh::Solid& solid);
    ~DraftEvaluator();
    DraftEvaluator(const DraftEvaluator&) = delete;
    DraftEvaluator& operator=(const DraftEvaluator&) = delete;

    /// Goes on with another draft, which outlives the calls that follow. Its parts have the charts of the drafts before.
    void begin(const model::ModelView& draft);
    /// The figures of layer 3 that evaluate() gives for so many points; those about certain verdicts and layer 1 are left out.
    /// points: no fewer than since begin, at most EvaluateOptions' default.
    [[nodiscard]] Evaluation first(std::uint32_t points);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace sqmap::bake
