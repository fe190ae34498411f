// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, sections 4.1 and 5: the paper's maps in the core's
// pipeline.
#include "sqmap/paper/bake.h"

#include "bake/evaluate/along_projection.h"
#include "bake/exact/candidate_lists.h"
#include "bake/pipeline.h"
#include "paper/bake/cells.h"
#include "sqmap/mesh/error.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/paper/projection.h"
#include "sqmap/parallel/for_each.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace sqmap::paper {

namespace {

void check(const MapOptions& map)
{
    bake::check_range("subdivisions", map.subdivisions, 0, 5);
    bake::check_range("the offset constant", map.offset_constant, 0, 100);
    bake::check_range("the offset radius", map.offset_radius, 0, 8);
    bake::check_range("the smoothing radius", map.smoothing_radius, 0, 8);
    if (map.grid.rows == 0 && map.grid.columns == 0) return;
    bake::check_range("rows of the grid", map.grid.rows, 5, k_max_map_rows);
    bake::check_range("columns of the grid", map.grid.columns, 8, k_max_map_columns);
    if (!is_storable(map))
        throw mesh::InvalidInput("the grid, subdivided, must have at most " + std::to_string(k_max_map_rows) + " rows and " +
                                 std::to_string(k_max_map_columns) + " columns");
}

/// |D^ - D| at the foot of p, D the first surface below it along the normal. Layer 2 too is compared at
/// the foot itself, not at the sample that it reads.
bake::AlongProjection compare_along_normal(const MapView& map, const mesh::Solid& solid, double r_max, Vec3f p,
                                           query::Layer layer)
{
    bake::AlongProjection result;
    ProjectionOptions options;
    PartAnswer answer = project(map, p, options);
    if (layer == query::Layer::Two) {
        options.layer = layer;
        const MapSample sample = sample_map(map, answer.angles, options);
        answer.map_distance = sample.distance;
        answer.flags = static_cast<std::uint8_t>((answer.flags & k_projection_unproven) | sample.flags);
    }
    constexpr unsigned k_no_distance = k_projection_cap | k_projection_miss | k_projection_behind | k_projection_unproven;
    if (answer.verdict == Verdict::Outside) return result;
    result.map = (answer.flags & k_no_distance) == 0;
    // From a little outside, so that a surface that touches the superquadric is met.
    const double lift = 1e-5 * r_max;
    const Vec3d n = cast<double>(answer.foot_normal), origin = cast<double>(answer.foot) + lift * n;
    std::vector<mesh::Bvh::Crossing> crossings;
    if (!solid.bvh().ray_crossings(origin, -n, crossings)) return result;
    int winding = solid.bvh().winding_number(origin);
    for (const mesh::Bvh::Crossing& c : crossings) {
        const int next = winding - c.sign;
        if ((next > 0) != (winding > 0)) {
            result.error = std::abs(c.t - lift - static_cast<double>(answer.map_distance));
            result.mesh = next > 0;
            break;
        }
        winding = next;
    }
    return result;
}

/// A map of each part. target_error: of linear interpolation within one sheet, 99th percentile, model units.
MapArrays<model::ArrayData> maps_of(const bake::Subject& subject, double target_error, const MapOptions& options)
{
    const std::vector<bake::MeasuredPart>& parts = subject.fitted.parts;
    const MapRays rays(subject.solid.mesh());
    std::vector<Map> maps(parts.size());
    parallel::for_each(parts.size(), subject.options.threads, [&](std::size_t i) {
        const shape::Superquadricd& sq = parts[i].fitted.fit.superquadric;
        MapOptions own = options;
        own.target_error = target_error / std::max({sq.a.x, sq.a.y, sq.a.z});
        maps[i] = bake_map(rays, parts[i].fitted.patch.triangles, sq, own);
    });
    MapArrays<model::ArrayData> all;
    for (const Map& map : maps) append_map(map, all);
    return all;
}

class PaperSteps final : public bake::MapSteps {
public:
    explicit PaperSteps(const MapOptions& options) : options_(options) {}

    bake::Draft draft(const bake::Subject& subject, const bake::CentralOptions& central, const bake::Draft*) override
    {
        bake::Draft out;
        out.maps.resize(subject.fitted.parts.size());
        out.model = bake::assembled(subject, out.maps);
        out.model.header.projection = 1;
        latest_ = maps_of(subject, 2.5 * central.tolerance * out.model.header.r_max, options_);
        const Reading reading(view_of(out.model, latest_));
        out.measured = bake::measured(
            [&](const bake::EvaluateOptions& options) { return paper::evaluate(reading.view(), subject.solid, options); },
            [&](const model::Measured& m) { return shortfall(m, subject.options); });
        return out;
    }
    void accept() override { accepted_ = std::move(latest_); }
    /// A surface that a first hit hides, no resolution shows.
    double shortfall(const model::Measured& m, const bake::BakeOptions& options) const override
    {
        return m.depth_p99 / options.target_error;
    }
    double max_hidden() const override { return std::numeric_limits<double>::infinity(); }
    void locate(const bake::Subject& subject, bake::Draft& draft) override
    {
        if (subject.options.exact && subject.header.solid != 0) {
            // Charts lead to the cells and are dropped, planes and seeds with them.
            const double r_max = mesh::largest_vertex_distance(subject.solid.mesh());
            model::ModelData led = bake::assembled(
                subject, bake::bake_central_maps(subject, bake::central_options(subject.options.target_error, r_max), {}));
            bake::bake_locator(subject.surface(), subject.locator(), led);
            bake::bake_candidate_lists(subject.solid, subject.locator(), led);
            take_cells(led, draft.model);
        }
        const Reading reading(view_of(draft.model, accepted_));
        bake::measure_layers(reading.view(), subject.solid, draft.measured);
    }
    std::size_t bytes_beside() const override { return model::bytes_of(accepted_); }
    MapArrays<model::ArrayData> take_maps() { return std::move(accepted_); }

private:
    static ModelView view_of(const model::ModelData& common, const MapArrays<model::ArrayData>& maps)
    {
        ModelView view{common.view(), {}};
        const auto look = [](const char*, auto& span, const auto& array) { span = array; };
        MapArrays<model::ArrayView>::each(look, view.maps, maps);
        return view;
    }

    const MapOptions& options_;
    MapArrays<model::ArrayData> latest_, accepted_;
};

}  // namespace

BakeResult bake(const mesh::Mesh& mesh, bool solid, const bake::BakeOptions& options, const std::optional<MapOptions>& maps)
{
    if (!maps) {
        bake::BakeResult central = bake::bake(mesh, solid, options);
        return {{std::move(central.model), {}}, std::move(central.report)};
    }
    check(*maps);
    PaperSteps steps(*maps);
    bake::BakeResult baked = bake::run_pipeline(mesh, solid, options, steps);
    return {{std::move(baked.model), steps.take_maps()}, std::move(baked.report)};
}

bake::Evaluation evaluate(const model::ModelView& model, const mesh::Solid& solid, const bake::EvaluateOptions& options)
{
    if (!is_paper(model)) return bake::evaluate(model, solid, options);
    const ModelView& paper = Reading::of(model).model();
    return bake::evaluate_along(model::normalized(model), solid, options, [&](std::uint32_t part, Vec3f p, query::Layer layer) {
        return compare_along_normal(map_of(paper, part), solid, model.header.r_max, p, layer);
    });
}

}  // namespace sqmap::paper
