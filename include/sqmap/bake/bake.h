// From a validated mesh to a baked model: decompose, fit, map, and refine until the error is met.
#pragma once

#include "sqmap/decompose/decompose.h"
#include "sqmap/fit/fit.h"
#include "sqmap/mesh/mesh.h"
#include "sqmap/model/model_data.h"

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace sqmap::bake {

struct BakeOptions {
    double target_error = 0.5;      ///< percent of R_max: layer-3 depth error, 99th percentile
    std::uint32_t max_parts = 24;
    bool exact = true;              ///< store the exact layer
    unsigned threads = 0;           ///< 0: one a core; the result does not depend on it
    decompose::DecomposeOptions decompose{};
    fit::FitOptions fit{};
    /// Called with a stage's name and how much of it is done, in [0, 1]; from the calling thread.
    std::function<void(const char* stage, double done)> progress;
};

struct PartReport {
    fit::Certificate certificate;
    double volume = 0, area = 0;
    double q2_share = 0;            ///< of the part's area: not the first surface its projection meets
    bool fallback = false;
    std::uint32_t base = 0;
    std::size_t map_bytes = 0, exact_bytes = 0;
};

struct BakeReport {
    std::vector<PartReport> parts;
    decompose::Partition partition;
    std::vector<std::pair<std::string, double>> seconds;  ///< CPU time a stage
};

struct BakeResult {
    model::ModelData model;
    BakeReport report;
};

/// mesh: validated, in mesh units. crossed: #triangles, true where triangles of a self-intersecting mesh cut each other.
/// @throw std::invalid_argument for options out of range; std::length_error where a part exceeds the format's limits.
[[nodiscard]] BakeResult bake(const mesh::Mesh& mesh, std::span<const std::uint8_t> crossed, bool solid, const BakeOptions& options);

}  // namespace sqmap::bake
