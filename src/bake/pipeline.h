// Baking as a pipeline of named steps. A bake of central maps, a bake of the paper's maps and a rebake share its order and most
// of its steps; each has some of its own.
#pragma once

#include "bake/central/central_map.h"
#include "bake/central/central_options.h"
#include "bake/evaluate/drafts.h"
#include "bake/exact/candidate_lists.h"
#include "bake/locator/locator.h"
#include "bake/parts/refinement.h"
#include "sqmap/bake/bake_types.h"
#include "sqmap/bake/evaluate.h"
#include "sqmap/mesh/error.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace sqmap::bake {

/// One model on its way through the steps.
class Pipeline {
public:
    virtual ~Pipeline() = default;
    Pipeline(const Pipeline&) = delete;
    Pipeline& operator=(const Pipeline&) = delete;

protected:
    explicit Pipeline(const LocatorOptions& locator) : locator_(locator) {}

    /// All steps, in the order in which they stand here. Returns the model; throws what the steps throw.
    [[nodiscard]] model::ModelData run_steps();

    /// Checks the input and sets the mesh, its hash and what was made up of it.
    virtual void validate() = 0;
    /// Finds the parts and fits their superquadrics.
    virtual void parts() = 0;
    /// Fits the parts' polytopes.
    virtual void polytopes() = 0;
    /// Bakes the maps and sets the model: header, parts, maps and triangles.
    virtual void maps() = 0;
    /// Gives the model its locator.
    virtual void locator() = 0;
    /// Gives the model the candidate lists of the exact layer.
    virtual void exact();
    /// Gives the model the figures of its layers.
    virtual void measure() {}

    /// The parts' surfaces and caps, for the figures of their bounds.
    [[nodiscard]] virtual std::vector<Patch> patches() const = 0;

    /// Bytes of maps that are not in the model.
    [[nodiscard]] virtual std::size_t bytes_beside() const { return 0; }

    /// mesh: in model space.
    void set_mesh(mesh::Mesh mesh, std::span<const std::uint8_t> crossed);
    /// Ends a stage: says what CPU time went by since the last one ended.
    void lap(const char* stage);

    LocatorOptions locator_;
    mesh::Mesh mesh_;                        ///< model space
    std::optional<mesh::Solid> solid_;       ///< of the mesh
    std::vector<std::uint8_t> made_up_;      ///< #triangles, non-zero where nothing of the input stood; empty for none
    std::vector<Vec3d> input_vertices_;      ///< #vertices, mesh units, that the model is to keep; empty for none
    SourceNumbers source_;                   ///< beside them
    std::uint64_t mesh_hash_ = 0;            ///< of the mesh in its own units
    double band_ = 5;                        ///< of signed distances, percent of R_max
    std::optional<ListsBefore> kept_lists_;  ///< candidate lists that are taken over where nothing reaches them
    model::ModelData model_;
    std::vector<std::pair<std::string, double>> seconds_;  ///< CPU time a stage

private:
    void finish();

    double last_lap_ = 0;
};

/// A model with its maps.
struct Draft {
    std::vector<CentralMapData> maps;  ///< #parts; without samples where the maps are not central
    model::ModelData model;            ///< measured
};

/// The pipeline from a mesh to a model whose maps meet a target error. Each kind of map drafts and measures in its own way.
class Bake : public Pipeline {
public:
    /// input, options: outlive this.
    Bake(const mesh::Mesh& input, bool is_solid, const BakeOptions& options);

    /// @throw as bake
    [[nodiscard]] BakeResult run();

protected:
    /// Maps of all parts, assembled and measured. central: the cells that central maps would have. coarser: a draft with larger
    /// ones, or null.
    [[nodiscard]] virtual Draft draft(const CentralOptions& central, const Draft* coarser) = 0;
    /// The pipeline goes on with the draft that was made last.
    virtual void accept() {}
    /// By which factor a model misses its targets; up to 1 it meets them.
    [[nodiscard]] virtual double shortfall(const model::Measured& m) const = 0;
    /// The share of a part that its projection does not see first; empty: that of the central projection.
    [[nodiscard]] virtual HiddenShare hidden_share() const { return {}; }
    /// Maps that do not see more than so much of the surface are not made finer; percent.
    [[nodiscard]] virtual double max_hidden() const = 0;

    /// coarser: the maps of a draft with larger cells, or none. A base that was beaten there is not tried again.
    [[nodiscard]] std::vector<CentralMapData> central_maps(const CentralOptions& central,
                                                           std::span<const CentralMapData> coarser) const;
    /// Parts, maps and triangles without a locator.
    [[nodiscard]] model::ModelData assembled(const std::vector<CentralMapData>& maps) const;
    /// The figures stored in a model: a quick evaluation of layer 3, a longer one where it misses by little enough that a few
    /// rays with large errors may have made the mean of eq. 35.
    [[nodiscard]] model::Measured measured(const std::function<Evaluation(const EvaluateOptions&)>& evaluate) const;
    /// The same as probes compute: with the locator, which answers where its planes are the surface. Wrong verdicts are rare but
    /// where most of the surface is hidden: there they are looked for at more points.
    void measure_layers(const model::ModelView& view, model::Measured& m);
    /// The points at which models of the solid are measured. view: of one.
    [[nodiscard]] SampledSolid& samples(const model::ModelView& view);
    [[nodiscard]] PartedSolid surface() const { return {*solid_, fitted_.partition.part_of_triangle}; }

    void validate() override;
    void parts() override;
    void polytopes() override;
    void maps() override;
    [[nodiscard]] std::vector<Patch> patches() const override;

    const BakeOptions& options_;
    model::Header header_{};  ///< as assemble takes it
    FittedPartition fitted_;

private:
    void progress(const char* stage, double done) const;
    void name_parts(model::ModelData& model) const;
    [[nodiscard]] decompose::Partition named_partition(const mesh::Mesh& mesh);
    [[nodiscard]] decompose::Partition coarse_partition();
    [[nodiscard]] Draft meet_target();
    [[nodiscard]] std::vector<PartReport> part_reports() const;

    const mesh::Mesh& input_;
    std::vector<std::uint32_t> name_of_triangle_;  ///< a named part each; empty: a person has cut
    double fineness_ = 1;
    std::vector<CentralMapData> maps_;
    std::optional<SampledSolid> samples_;
};

/// The input from which a part's central map is baked.
struct MapSource {
    const FittedPart& part;
    CentralOptions options;
    std::optional<KnownMap> known{};  ///< in the chart that it had: cells that no changed triangle reaches are taken over
};
/// Maps of several parts, in their order.
[[nodiscard]] std::vector<CentralMapData> bake_central_maps(const mesh::Solid& solid, std::span<const MapSource> sources,
                                                            unsigned threads);

/// @throw mesh::InvalidInput that names the first option of a table that is out of its range
template <class Options, std::size_t n>
void check_numbers(const NumberOption<Options> (&table)[n], const Options& options)
{
    if (const std::string why = out_of_range(table, options); !why.empty()) throw mesh::InvalidInput(why);
}

}  // namespace sqmap::bake
