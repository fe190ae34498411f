// A bake takes these options and gives these reports and this result.
// Plain data: any number of threads may read it.
#pragma once

#include "sqmap/decompose/decompose.h"
#include "sqmap/fit/fit.h"
#include "sqmap/mesh/mesh.h"
#include "sqmap/mesh/words.h"
#include "sqmap/mesh/wrap.h"
#include "sqmap/model/model_data.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace sqmap::bake {

/// The cure of the mesh, for the model to keep: bake_mesh fills it in.
struct Cured {
    model::Rung rung = model::Rung::AsItIs;
    std::span<const std::uint8_t> made_up{};  ///< #triangles, non-zero where nothing of the input stood; empty for none
    mesh::Deviation deviation{};
};

/// Numbers of the mesh's triangles and vertices in the caller's input, for the model to keep: bake_mesh fills them in.
struct SourceNumbers {
    std::span<const std::uint32_t> triangle{};  ///< #triangles, model::k_no_source where nothing of the input stood
    std::span<const std::uint32_t> vertex{};    ///< #vertices, the same; both empty: the mesh's own numbers
};

/// How bake() works. The defaults are those of `sqmap bake`.
struct BakeOptions {
    double target_error = 0.5;  ///< percent of R_max: layer-3 depth error, 99th percentile
    std::uint32_t max_parts = 24;
    double max_looseness = 1.3;  ///< a part is split while its superquadric has more than this times its solid's volume
    double max_q2_share = 0.1;   ///< or while more than this share of its area is hidden from its projection
    bool exact = true;           ///< store the exact layer
    bool locator = true;         ///< store the locator, which the exact layer needs; without it charts alone answer
    /// With the exact layer: store the mesh's own coordinates and numbers, so that query::exact_distances answers in double and
    /// answers name the caller's triangles. Up to 18 bytes a triangle.
    bool keep_input = true;
    double band = 5;       ///< percent of R_max: how far on either side signed distances are exact; 0: at the surface alone
    unsigned threads = 0;  ///< 0: one a core; the result does not depend on it
    decompose::DecomposeOptions decompose{};
    /// Parts that are taken as they are, edited by hand: neither cut, split nor joined. Of the mesh's own triangles, labels below
    /// part_count, none empty; outlives the call. Null: found as section 3 says.
    const decompose::Partition* partition = nullptr;
    fit::FitOptions fit{};
    Cured cured{};           ///< outlives the call
    SourceNumbers source{};  ///< outlives the call
    /// Called with a stage's name and how much of it is done, in [0, 1]; from the calling thread.
    std::function<void(const char* stage, double done)> progress{};
};
/// Its numbers, which bake() checks; those of `decompose` are decompose::k_thresholds.
inline constexpr NumberOption<BakeOptions> k_bake_numbers[] = {{"target_error", &BakeOptions::target_error, {1e-3, 100}},
                                                               {"max_parts", &BakeOptions::max_parts, {1, 1000}},
                                                               {"max_looseness", &BakeOptions::max_looseness, {1, 1e6}},
                                                               {"max_q2", &BakeOptions::max_q2_share, {0, 1}},
                                                               {"band", &BakeOptions::band, {0, 100}}};

/// How a part came out.
struct PartReport {
    fit::Certificate certificate;
    double volume = 0;        ///< of the superquadric, model units cubed
    double solid_volume = 0;  ///< of the solid that is the part's, caps and all
    double area = 0;
    double q2_share = 0;  ///< of the part's area: not the first surface its projection meets
    bool fallback = false;
    std::uint32_t base = 0;
    std::size_t map_bytes = 0;
};

/// How a bake went, part by part and stage by stage.
struct BakeReport {
    std::vector<PartReport> parts;
    decompose::Partition partition;
    double fineness = 1;      ///< what the map's cell sizes were multiplied by until the target was met
    bool target_met = false;  ///< the measured 99th percentile of the depth error is within target_error, and no verdict is wrong
    std::vector<std::pair<std::string, double>> seconds;  ///< CPU time a stage
};

/// A model, and how it was made.
struct BakeResult {
    model::ModelData model;
    BakeReport report;
};

}  // namespace sqmap::bake
