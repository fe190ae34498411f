// Evaluation of the drafts of one model, which differ in the fineness of their maps.
#pragma once

#include "sqmap/bake/evaluate.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace sqmap::bake {

/// A sample point and the mesh's answer.
struct Sampled {
    Vec3d q;  ///< representable as float
    bool inside = false;
    mesh::ClosestPoint nearest;  ///< of the boundary
};

/// The sample points of a solid. The mesh is queried as they are needed, in their order, and once for all that measure a model of
/// it. Not thread-safe.
class SampledSolid {
public:
    /// solid: outlives it; in model space, as r_max.
    SampledSolid(const mesh::Solid& solid, double r_max, const EvaluateOptions& options = {});

    [[nodiscard]] const mesh::Solid& solid() const { return solid_; }
    /// i: below the options' points.
    [[nodiscard]] const Sampled& at(std::size_t i);

private:
    const mesh::Solid& solid_;
    std::vector<Vec3d> positions_;
    std::vector<Sampled> points_;  ///< the first of them
};

/// The errors that layer_errors() gives for so many of a solid's points.
[[nodiscard]] LayerErrors layer_errors(const model::ModelView& baked, SampledSolid& samples, const EvaluateOptions& options);

/// Measures drafts of central maps without a locator. Drafts of one mesh have their charts and sample points in common, so that
/// each point is compared with the mesh once. Not thread-safe.
class DraftEvaluator {
public:
    /// samples: outlives it.
    explicit DraftEvaluator(SampledSolid& samples);
    ~DraftEvaluator();
    DraftEvaluator(const DraftEvaluator&) = delete;
    DraftEvaluator& operator=(const DraftEvaluator&) = delete;

    /// Goes on with another draft, which outlives the calls that follow. Its parts have the charts of the drafts before.
    void begin(const model::ModelView& draft);
    /// The figures of layer 3 that evaluate() gives for so many points; those about certain verdicts and layer 1 are left out.
    /// Depths and normals differ where a map shows surface that the mesh has not, nearer than the mesh's (16 of 6,000 points on a
    /// block with crossing holes in 23 parts): the search ends before it.
    /// points: no fewer than since begin, at most the samples'.
    [[nodiscard]] Evaluation first(std::uint32_t points);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace sqmap::bake
