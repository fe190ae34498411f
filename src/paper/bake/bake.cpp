// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, sections 4.1 and 5: the paper's maps in the core's
// pipeline.
#include "bake/bake.h"
#include "sqmap/paper/bake.h"

#include "bake/evaluate/along_projection.h"
#include "bake/pipeline.h"
#include "model/flags.h"
#include "paper/bake/cells.h"
#include "paper/bake/regions.h"
#include "parallel/for_each.h"
#include "sqmap/mesh/error.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/paper/projection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>

namespace sqmap::paper {

namespace {

constexpr std::size_t k_q2_samples = 200;  // triangles of a part that refinement looks at
constexpr double k_fine_q2 = 0.05;         // below such a share it looks at all

void check(const MapOptions& map)
{
    bake::check_numbers(k_map_numbers, map);
    if (const int max = greatest_smoothing_radius(map); map.smoothing_radius > max)
        throw mesh::InvalidInput("smoothing_radius must be at most " + std::to_string(max) + " for so few rows");
    if (map.grid.rows == 0 && map.grid.columns == 0) return;
    bake::check_numbers(k_grid_numbers, map.grid);
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

class PaperBake final : public bake::Bake {
public:
    PaperBake(const mesh::Mesh& input, bool is_solid, const bake::BakeOptions& options, const MapOptions& maps)
        : Bake(input, is_solid, options), map_options_(maps)
    {
    }
    ModelMaps<model::ArrayData> take_maps() { return std::move(accepted_); }

private:
    bake::Draft draft(const bake::CentralOptions& central, const bake::Draft*) override
    {
        bake::Draft out;
        out.maps.resize(fitted_.parts.size());
        out.model = assembled(out.maps);
        out.model.header.projection = 1;
        latest_ = paper_maps(2.5 * central.tolerance * out.model.header.r_max);
        const Reading reading(view_of(out.model, latest_));
        out.model.measured =
            measured([&](const bake::EvaluateOptions& options) { return paper::evaluate(reading.view(), *solid_, options); });
        return out;
    }
    /// A map of each part. target_error: of linear interpolation within one sheet, 99th percentile, model units.
    ModelMaps<model::ArrayData> paper_maps(double target_error) const
    {
        const MapRays rays(mesh_);
        std::vector<Map> maps(fitted_.parts.size());
        parallel::for_each(maps.size(), options_.threads, [&](std::size_t i) {
            const bake::FittedPart& part = fitted_.parts[i].fitted;
            const shape::Superquadricd& sq = part.fit.superquadric;
            MapOptions own = map_options_;
            own.target_error = target_error / std::max({sq.a.x, sq.a.y, sq.a.z});
            maps[i] = bake_map(rays, part.patch.triangles, sq, own);
        });
        ModelMaps<model::ArrayData> all;
        for (const Map& map : maps) append_map(map, all);
        return all;
    }
    void accept() override { accepted_ = std::move(latest_); }
    /// A surface that a first hit hides, no resolution shows.
    double shortfall(const model::Measured& m) const override { return m.depth_p99 / options_.target_error; }
    double max_hidden() const override { return std::numeric_limits<double>::infinity(); }

    void polytopes() override {}  // the paper's layer 1 is the superquadrics
    void locator() override {}    // only the exact layer has cells
    /// The exact layer's lists belong to the locator's cells, and the locator is made from central maps: they are baked for it
    /// and dropped, with its planes and seeds, since paper models answer contacts from the paper's maps.
    void exact() override
    {
        if (!options_.exact || header_.solid == 0) return;
        model::ModelData led =
            assembled(central_maps(bake::central_options(options_.target_error, mesh::largest_vertex_distance(mesh_)), {}));
        bake::bake_locator(surface(), locator_, led);
        bake::bake_candidate_lists(*solid_, nullptr, locator_, led);
        take_cells(led, model_);
    }
    bake::HiddenShare hidden_share() const override
    {
        const std::size_t samples = options_.max_q2_share < k_fine_q2 ? 0 : k_q2_samples;
        return [samples](const mesh::Solid& solid, std::span<const std::uint32_t> triangles, const bake::FittedPart& part) {
            return hidden_from_feet({solid.bvh(), solid.mesh(), triangles}, ExactFeet(part.fit.superquadric), samples);
        };
    }
    void measure() override
    {
        label();
        const Reading reading(view_of(model_, accepted_));
        measure_layers(reading.view(), model_.measured);
    }
    /// Gives each triangle its part and region, and each map its share of Q2.
    void label()
    {
        static_assert(model::k_max_parts < 1u << k_label_part_bits);
        std::vector<TriangleLabel> labels(mesh_.triangles.size());
        label_concave(mesh_, labels);
        parallel::for_each(fitted_.parts.size(), options_.threads, [&](std::size_t i) {
            const std::vector<std::uint32_t>& triangles = fitted_.parts[i].fitted.patch.triangles;
            for (const std::uint32_t t : triangles) labels[t].part = static_cast<std::uint32_t>(i);
            const shape::Superquadricf stored = shape::cast<float>(fitted_.parts[i].fitted.fit.superquadric);
            fitted_.parts[i].quality.q2_share =
                label_hidden({solid_->bvh(), mesh_, triangles}, ExactFeet(shape::cast<double>(stored)), labels);
        });
        double hidden = 0, area = 0;
        for (std::size_t i = 0; i < fitted_.parts.size(); ++i) {
            const bake::PartQuality& quality = fitted_.parts[i].quality;
            hidden += 100 * quality.q2_share * quality.area;
            area += quality.area;
            accepted_.records[i].grid.q2_share = static_cast<float>(quality.q2_share);
        }
        model_.measured.q2_share = hidden / area;
        accepted_.labels.clear();
        for (const TriangleLabel& l : labels) accepted_.labels.push_back(encode_label(l));
    }
    std::size_t bytes_beside() const override { return model::bytes_of(accepted_); }

    static ModelView view_of(const model::ModelData& common, const ModelMaps<model::ArrayData>& maps)
    {
        ModelView view{common.view(), {}};
        const auto look = [](const char*, auto& span, const auto& array) { span = array; };
        ModelMaps<model::ArrayView>::each(look, view.maps, maps);
        return view;
    }

    const MapOptions& map_options_;
    ModelMaps<model::ArrayData> latest_, accepted_;
};

}  // namespace

BakeResult bake(const mesh::Mesh& mesh, bool solid, const bake::BakeOptions& options, const std::optional<MapOptions>& maps)
{
    if (!maps) {
        bake::BakeResult central = bake::bake(mesh, solid, options);
        return {{std::move(central.model), {}}, std::move(central.report)};
    }
    check(*maps);
    PaperBake bake(mesh, solid, options, *maps);
    bake::BakeResult baked = bake.run();
    return {{std::move(baked.model), bake.take_maps()}, std::move(baked.report)};
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
