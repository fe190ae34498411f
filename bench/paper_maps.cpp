// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, sections 4.1 and 4.2.
#include "paper_maps.h"
#include "clock.h"

#include "math/percentile.h"
#include "paper/query/job.h"
#include "sqmap/bake_mesh.h"
#include "sqmap/query/probe.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace sqmap::bench {
namespace {

/// Area of the superquadric's surface, by a grid of triangles.
double surface_area(const shape::Superquadricd& sq)
{
    constexpr int k_rows = 64, k_columns = 128;
    const auto at = [&](int i, int j) {
        return shape::surface_point(sq, shape::SurfaceAngles<double>{std::numbers::pi * (static_cast<double>(i) / k_rows - 0.5),
                                                                     std::numbers::pi * (2.0 * j / k_columns - 1)})
            .point;
    };
    double area = 0;
    for (int i = 0; i < k_rows; ++i)
        for (int j = 0; j < k_columns; ++j) {
            const Vec3d p = at(i, j), q = at(i, j + 1), r = at(i + 1, j), s = at(i + 1, j + 1);
            area += 0.5 * (norm(cross(q - p, r - p)) + norm(cross(q - s, r - s)));
        }
    return area;
}

class NormalQuery final : public Method {
public:
    NormalQuery(const Setting& setting, std::shared_ptr<const PaperMaps> maps, const PaperMethod& method)
        : maps_(std::move(maps)),
          reading_(maps_->model(), {.projector = method.projector}),
          options_{.layer = method.layer},
          one_lane_(method.one_lane),
          probe_(setting.probe.vertices),
          contacts_(probe_.size())
    {
        bytes = maps_->bytes;
        build_s = maps_->build_s;
        probe_bytes = probe_.bytes();
    }

    void run(const Pose& pose) override
    {
        const query::Body touched{.model = &reading_.view()},
            collider{.probe = &probe_, .pose = {pose.rotation, pose.translation}};
        result_ = one_lane_ ? paper::run_one_lane({query::ProbeJob(touched, collider, options_, contacts_), options_})
                            : query::query_probe(touched, collider, options_, contacts_);
    }

    void read(FrameAnswer& out) const override
    {
        for (const query::Contact& c : result_.written(contacts_)) out.vertices.push_back({c.index, c.depth});
        std::sort(out.vertices.begin(), out.vertices.end(),
                  [](const VertexContact& a, const VertexContact& b) { return a.vertex < b.vertex; });
    }

private:
    std::shared_ptr<const PaperMaps> maps_;
    paper::Reading reading_;
    query::QueryOptions options_;
    bool one_lane_;
    query::Probe probe_;
    std::vector<query::Contact> contacts_;
    query::ProbeResult result_;
};

}  // namespace

PaperParts::PaperParts(const Setting& setting) : mesh(bake::model_space(setting.object)), rays(mesh)
{
    const double start = process_seconds();
    bake::BakeOptions options;
    options.exact = false;
    options.target_error = 100;  // its maps are thrown away: the coarsest will do
    options.threads = setting.threads;
    BakedModel baked = bake_mesh(setting.object, {.bake = options, .paper_maps = paper::MapOptions{}});
    model = std::move(baked.model.common);
    triangles.resize(model.parts.size());
    const std::vector<std::uint32_t>& part_of = baked.report.partition.part_of_triangle;
    for (std::uint32_t t = 0; t < part_of.size(); ++t) triangles[part_of[t]].push_back(t);
    build_s = process_seconds() - start;
}

PaperMaps::PaperMaps(std::shared_ptr<const PaperParts> parts, Density density) : parts_(std::move(parts))
{
    const double start = process_seconds();
    paper::MapOptions options;
    options.min_level = options.max_level = density.level + density.subdivisions;
    options.subdivisions = density.subdivisions;
    options.smoothing_radius = 0;
    options.gaps = false;
    model_.common = parts_->model;
    double area = 0;
    for (std::size_t i = 0; i < model_.common.parts.size(); ++i) {
        const shape::Superquadricd sq = shape::cast<double>(model::superquadric_of(model_.common.parts[i]));
        const paper::Map map = paper::bake_map(parts_->rays, parts_->triangles[i], sq, options);
        bytes += map.stored_bytes();
        samples += std::size_t{map.eta_count} * map.omega_count;
        area += surface_area(sq);
        paper::append_map(map, model_.maps);
    }
    view_ = model_.view();
    spacing = std::sqrt(area / static_cast<double>(samples));
    build_s = parts_->build_s + process_seconds() - start;
}

paper::ProjectionOptions paper_projection(query::Layer layer)
{
    paper::ProjectionOptions options;
    options.layer = layer;
    options.projector = paper::Projector::Pyramid;
    options.nearest_steps = 0;
    options.gaps = false;
    return options;
}

std::unique_ptr<Method> make_paper_query(const Setting& setting, std::shared_ptr<const PaperMaps> maps, const PaperMethod& method)
{
    return std::make_unique<NormalQuery>(setting, std::move(maps), method);
}

ProjectionError projection_error(const PaperMaps& maps, std::span<const Vec3d> points, query::Layer layer)
{
    constexpr unsigned k_no_distance = paper::k_projection_cap | paper::k_projection_miss | paper::k_projection_unproven;
    const PaperParts& parts = maps.parts();
    const paper::ProjectionOptions options = paper_projection(layer);
    const model::ModelView& model = maps.model().common;
    const double r_max = model.header.r_max;
    const double lift = 1e-5 * r_max;  // a surface that touches the superquadric is met too
    std::vector<double> errors;
    std::size_t inside = 0, one_sided = 0;
    for (const Vec3d& point : points) {
        const Vec3f p = model::to_model_space(model.header, point);
        for (std::size_t k = 0; k < model.parts.size(); ++k) {
            const float* sphere = model.parts[k].sphere;
            if (norm_sq(p - model::vec3(sphere)) > sphere[3] * sphere[3]) continue;
            const paper::MapView map = paper::map_of(maps.model(), k);
            const paper::PartAnswer answer = paper::project(map, p, options);
            if (answer.verdict == paper::Verdict::Outside) continue;
            ++inside;
            // D at the exact foot, D^ at what the search took for it.
            std::uint8_t flags = 0;
            const shape::Foot<float> foot = paper::find_foot(map, p, paper::Projector::Newton, &flags);
            if ((flags & paper::k_projection_unproven) != 0) continue;
            const Vec3d n = cast<double>(foot.normal);
            const paper::MapRays::Surface met = parts.rays.surface_along(cast<double>(foot.point) + lift * n, -n,
                                                                         {std::numeric_limits<double>::infinity(), lift});
            const bool on_mesh = met.kind == paper::MapRays::Kind::Hit, on_map = (answer.flags & k_no_distance) == 0;
            one_sided += on_mesh != on_map ? 1 : 0;
            if (on_mesh && on_map)
                errors.push_back(100 * std::abs(met.distance - lift - static_cast<double>(answer.map_distance)) / r_max);
        }
    }
    ProjectionError result{.points = inside};
    if (inside > 0) result.one_sided_pct = 100 * static_cast<double>(one_sided) / static_cast<double>(inside);
    if (errors.empty()) return result;
    for (const double e : errors) result.mean += e / static_cast<double>(errors.size());
    result.p99 = sqmap::percentile(errors, 99);
    return result;
}

}  // namespace sqmap::bench
