// Baking as a pipeline of named steps, which central models and paper models share: validate, parts, maps, locator, exact,
// finish. Each kind of map has steps of its own.
#pragma once

#include "bake/central/central_map.h"
#include "bake/central/central_options.h"
#include "bake/locator/locator.h"
#include "bake/parts/refinement.h"
#include "sqmap/bake/bake.h"
#include "sqmap/bake/evaluate.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace sqmap::bake {

/// A mesh with its parts, of which maps are baked.
struct Subject {
    const mesh::Solid& solid;  ///< of the mesh in model space
    const FittedPartition& fitted;
    model::Header header;  ///< as assemble takes it
    const BakeOptions& options;

    [[nodiscard]] PartedSolid surface() const { return {solid, fitted.partition.part_of_triangle}; }
    [[nodiscard]] LocatorOptions locator() const { return {options.target_error, options.threads}; }
};

/// A model with its maps, and what it was made with.
struct Draft {
    std::vector<CentralMapData> maps;  ///< #parts; without samples where the maps are not central
    model::ModelData model;
    model::Measured measured;
};

/// The steps that each kind of map takes its own way.
class MapSteps {
public:
    virtual ~MapSteps() = default;
    /// Maps of all parts, assembled and measured. central: the cells that central maps would have. coarser: a draft with larger
    /// ones, or null.
    [[nodiscard]] virtual Draft draft(const Subject& subject, const CentralOptions& central, const Draft* coarser) = 0;
    /// The pipeline goes on with the draft that was made last.
    virtual void accept() {}
    /// By which factor a model misses its targets; up to 1 it meets them.
    [[nodiscard]] virtual double shortfall(const model::Measured& m, const BakeOptions& options) const = 0;
    /// Maps that do not see more than so much of the surface are not made finer; percent.
    [[nodiscard]] virtual double max_hidden() const = 0;
    /// Bytes of maps that are not in the draft's model.
    [[nodiscard]] virtual std::size_t bytes_beside() const { return 0; }
    /// The locator and the lists of the exact layer, and what layers 1 to 3 err with them.
    virtual void locate(const Subject& subject, Draft& draft) = 0;
};

/// Bakes with the steps of a kind of map. @throw as bake
[[nodiscard]] BakeResult run_pipeline(const mesh::Mesh& input, bool solid, const BakeOptions& options, MapSteps& steps);

/// coarser: the maps of a draft with larger cells, or none. A base that was beaten there is not tried again.
[[nodiscard]] std::vector<CentralMapData> bake_central_maps(const Subject& subject, const CentralOptions& central,
                                                            std::span<const CentralMapData> coarser);
/// Parts, maps and triangles without a locator.
[[nodiscard]] model::ModelData assembled(const Subject& subject, const std::vector<CentralMapData>& maps);

/// The figures stored in a model: a quick evaluation of layer 3, a longer one where it misses by little enough that a few rays
/// with large errors may have made the mean of eq. 35.
[[nodiscard]] model::Measured measured(const std::function<Evaluation(const EvaluateOptions&)>& evaluate,
                                       const std::function<double(const model::Measured&)>& shortfall);
/// The same as probes compute: with the locator, which answers where its planes are the surface. Wrong verdicts are rare but
/// where most of the surface is hidden: there they are looked for at more points.
void measure_layers(const model::ModelView& view, const mesh::Solid& solid, model::Measured& m);

/// @throw mesh::InvalidInput that names the option
void check_range(const char* name, double value, double least, double max);

}  // namespace sqmap::bake
