// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, sections 4.1 and 4.2.
#include "normal_maps.h"

#include "sqmap/bake/bake.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace sqmap::bench {
namespace {

shape::Superquadricd widened(const shape::Superquadricf& f)
{
    shape::Superquadricd d;
    d.a = cast<double>(f.a);
    d.eps1 = f.eps1;
    d.eps2 = f.eps2;
    for (int i = 0; i < 3; ++i) d.rotation.row[i] = cast<double>(f.rotation.row[i]);
    d.translation = cast<double>(f.translation);
    d.taper_x = f.taper_x;
    d.taper_y = f.taper_y;
    d.bend = f.bend;
    d.bend_angle = f.bend_angle;
    return d;
}

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

/// Layer 2 as section 4.2.2 has it: eq. 1, the one-way search for the greatest I_S, the map's sample there.
query::PartAnswer printed_layer2(const model::NormalMapView& map, Vec3f p)
{
    query::PartAnswer answer;
    if (!(shape::implicit(map.superquadric, p) <= 1)) return answer;
    const query::GridFoot foot = query::pyramid_search(
        map, p, {.both_directions = false, .compare_distance = false, .wide_fallback = false, .seeded = false});
    const std::size_t row = std::size_t{foot.row} << map.subdivisions, column = std::size_t{foot.column} << map.subdivisions;
    const std::uint16_t code = map.distance[row * map.omega_count + column];
    answer.foot_distance = norm(p - shape::surface_point(map.superquadric, {map.rows[row], map.columns[column]}).point);
    answer.verdict = query::Verdict::Free;
    const model::MapRay ray = model::ray_of(code);
    if (ray == model::MapRay::Miss) return answer;
    if (ray == model::MapRay::Cap)
        answer.flags = query::k_projection_cap;
    else
        answer.map_distance = map.distance_scale * static_cast<float>(code);
    answer.depth = answer.foot_distance - answer.map_distance;
    if (answer.depth > 0) answer.verdict = query::Verdict::Contact;
    return answer;
}

class NormalQuery final : public Method {
public:
    NormalQuery(const Setting& setting, std::shared_ptr<const NormalMaps> maps, query::Layer layer, Search search)
        : maps_(std::move(maps)), options_(paper_projection(layer)), search_(search)
    {
        const NormalParts& parts = maps_->parts();
        for (const Vec3d& v : setting.probe.vertices) vertices_.push_back(cast<float>(v / parts.unit));
        contacts_.reserve(vertices_.size());
        answers_.reserve(parts.parts.size());
        bytes = maps_->bytes;
        build_s = maps_->build_s;
    }

    void run(const Pose& pose) override
    {
        const NormalParts& parts = maps_->parts();
        Mat3f rotation;
        for (int i = 0; i < 3; ++i) rotation.row[i] = cast<float>(pose.rotation.row[i]);
        const Vec3f translation = cast<float>((pose.translation - parts.origin) / parts.unit);
        contacts_.clear();
        for (std::uint32_t i = 0; i < vertices_.size(); ++i) {
            const Vec3f p = rotation * vertices_[i] + translation;
            if (norm_sq(p - parts.centre) > parts.radius_sq) continue;
            answers_.clear();
            for (std::size_t k = 0; k < parts.parts.size(); ++k) {
                if (norm_sq(p - parts.parts[k].centre) > parts.parts[k].radius_sq) continue;
                const model::NormalMapView& map = maps_->views()[k];
                const query::PartAnswer answer =
                    search_ == Search::Printed ? printed_layer2(map, p) : query::project(map, p, options_);
                if (answer.verdict != query::Verdict::Outside) answers_.push_back(answer);
            }
            const query::CombinedAnswer all = query::combine(answers_);
            if (all.contact)
                contacts_.push_back(
                    {i, all.has_surface ? std::max(answers_[static_cast<std::size_t>(all.part)].depth, 0.f) : 0.f});
        }
    }

    void read(FrameAnswer& out) const override
    {
        const auto unit = static_cast<float>(maps_->parts().unit);
        for (const VertexContact& c : contacts_) out.vertices.push_back({c.vertex, unit * c.depth});
    }

private:
    std::shared_ptr<const NormalMaps> maps_;
    query::ProjectionOptions options_;
    Search search_;
    std::vector<Vec3f> vertices_;
    std::vector<query::PartAnswer> answers_;
    std::vector<VertexContact> contacts_;
};

}  // namespace

NormalParts::NormalParts(const Setting& setting) : mesh(bake::model_space(setting.object)), rays(mesh)
{
    const double start = process_seconds();
    bake::BakeOptions options;
    options.projection = model::Projection::Normal;
    options.exact = false;
    options.target_error = 100;  // its maps are thrown away: the coarsest will do
    options.threads = setting.threads;
    const bake::BakeResult baked = bake::bake(setting.object, true, options);
    const model::Header& header = baked.model.header;
    for (int k = 0; k < 3; ++k) origin[k] = header.origin[k];
    unit = header.unit;
    r_max = header.r_max;
    centre = model::vec3(header.sphere);
    radius_sq = header.sphere[3] * header.sphere[3];
    for (const model::Part& p : baked.model.parts)
        parts.push_back({widened(model::superquadric_of(p)), {}, model::vec3(p.sphere), p.sphere[3] * p.sphere[3]});
    const std::vector<std::uint32_t>& part_of = baked.report.partition.part_of_triangle;
    for (std::uint32_t t = 0; t < part_of.size(); ++t) parts[part_of[t]].triangles.push_back(t);
    build_s = process_seconds() - start;
}

NormalMaps::NormalMaps(std::shared_ptr<const NormalParts> parts, Density density) : parts_(std::move(parts))
{
    const double start = process_seconds();
    bake::NormalMapOptions options;
    options.min_level = options.max_level = density.level + density.subdivisions;
    options.subdivisions = density.subdivisions;
    options.smoothing_radius = 0;
    options.gaps = false;
    double area = 0;
    for (const NormalParts::Part& part : parts_->parts) {
        maps_.push_back(bake::bake_normal_map(parts_->rays, part.triangles, part.superquadric, options));
        const bake::NormalMap& map = maps_.back();
        bytes += map.stored_bytes() - sizeof(model::SmoothedSample) * map.smoothed.size();
        samples += std::size_t{map.eta_count} * map.omega_count;
        area += surface_area(part.superquadric);
    }
    for (const bake::NormalMap& map : maps_) views_.push_back(map.view());
    spacing = std::sqrt(area / static_cast<double>(samples));
    build_s = parts_->build_s + process_seconds() - start;
}

query::ProjectionOptions paper_projection(query::Layer layer)
{
    query::ProjectionOptions options;
    options.layer = layer;
    options.projector = query::Projector::Pyramid;
    options.nearest_steps = 0;
    options.use_gaps = false;
    return options;
}

std::unique_ptr<Method> make_normal_query(const Setting& setting, std::shared_ptr<const NormalMaps> maps, query::Layer layer,
                                          Search search)
{
    return std::make_unique<NormalQuery>(setting, std::move(maps), layer, search);
}

ProjectionError projection_error(const NormalMaps& maps, std::span<const Vec3d> points, query::Layer layer)
{
    constexpr unsigned k_no_distance = query::k_projection_cap | query::k_projection_miss | query::k_projection_unproven;
    const NormalParts& parts = maps.parts();
    const query::ProjectionOptions options = paper_projection(layer);
    const double lift = 1e-5 * parts.r_max;  // a surface that touches the superquadric is met too
    std::vector<double> errors;
    std::size_t inside = 0, one_sided = 0;
    for (const Vec3d& point : points) {
        const Vec3f p = cast<float>((point - parts.origin) / parts.unit);
        for (std::size_t k = 0; k < parts.parts.size(); ++k) {
            if (norm_sq(p - parts.parts[k].centre) > parts.parts[k].radius_sq) continue;
            const query::PartAnswer answer = query::project(maps.views()[k], p, options);
            if (answer.verdict == query::Verdict::Outside) continue;
            ++inside;
            // D at the exact foot, D^ at what the search took for it.
            std::uint8_t flags = 0;
            const shape::Foot<float> foot = query::find_foot(maps.views()[k], p, query::Projector::Newton, &flags);
            if ((flags & query::k_projection_unproven) != 0) continue;
            const Vec3d n = cast<double>(foot.normal);
            const bake::MapRays::Surface met = parts.rays.surface_along(cast<double>(foot.point) + lift * n, -n,
                                                                        {std::numeric_limits<double>::infinity(), lift});
            const bool on_mesh = met.kind == bake::MapRays::Kind::Hit, on_map = (answer.flags & k_no_distance) == 0;
            one_sided += on_mesh != on_map ? 1 : 0;
            if (on_mesh && on_map)
                errors.push_back(100 * std::abs(met.distance - lift - static_cast<double>(answer.map_distance)) / parts.r_max);
        }
    }
    ProjectionError result{.points = inside};
    if (inside > 0) result.one_sided_pct = 100 * static_cast<double>(one_sided) / static_cast<double>(inside);
    if (errors.empty()) return result;
    for (const double e : errors) result.mean += e / static_cast<double>(errors.size());
    const auto at = errors.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(errors.size() - 1));
    std::nth_element(errors.begin(), at, errors.end());
    result.p99 = *at;
    return result;
}

}  // namespace sqmap::bench
