#include "along_projection.h"

#include "sqmap/math/box.h"
#include "sqmap/math/random.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sqmap::bake {

namespace {

Distribution summarize(std::vector<double> values)
{
    Distribution d;
    d.count = static_cast<std::uint32_t>(values.size());
    if (values.empty()) return d;
    std::sort(values.begin(), values.end());
    for (const double v : values) d.mean += v;
    d.mean /= static_cast<double>(values.size());
    const auto at = [&](double q) { return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))]; };
    d.median = at(0.5);
    d.p95 = at(0.95);
    d.p99 = at(0.99);
    d.max = values.back();
    return d;
}

/// True where the part's map answers.
bool in_chart(const model::Part& part, Vec3f p)
{
    const Vec3f d = p - model::vec3(part.chart_centre);
    const Vec3f x{dot(model::vec3(part.chart_rows), d), dot(model::vec3(part.chart_rows + 3), d),
                  dot(model::vec3(part.chart_rows + 6), d)};
    const float v[9] = {x.x, x.y, x.z, x.x + x.y, x.x - x.y, x.x + x.z, x.x - x.z, x.y + x.z, x.y - x.z};
    for (int i = 0; i < 9; ++i)
        if (v[i] < part.chart_lo[i] || v[i] > part.chart_hi[i]) return false;
    return true;
}

bool in_superquadric(const model::Part& part, Vec3f p)
{
    const Vec3f offset = p - model::vec3(part.sphere);
    const shape::Superquadricd sq = shape::cast<double>(model::superquadric_of(part));
    return norm_sq(offset) <= part.sphere[3] * part.sphere[3] && shape::implicit(sq, cast<double>(p)) <= 1;
}

/// Signed distance from p to the solid's nearest boundary crossing on the ray from centre through p, within the part's
/// chart. False if there is none.
bool exact_along_ray(const mesh::Solid& solid, const model::Part& part, Vec3d p, double& distance)
{
    const Vec3d centre = cast<double>(model::vec3(part.chart_centre));
    const double length = norm(p - centre);
    if (!(length > 0)) return false;
    const Vec3d direction = (p - centre) / length;
    std::vector<mesh::Bvh::Crossing> crossings;
    if (!solid.bvh().ray_crossings(centre, direction, crossings)) return false;
    int winding = part.centre_winding;
    bool found = false;
    for (const mesh::Bvh::Crossing& c : crossings) {
        const int next = winding - c.sign;
        if ((next > 0) != (winding > 0) && in_chart(part, cast<float>(centre + c.t * direction))) {
            if (!found || std::abs(c.t - length) < std::abs(distance)) distance = c.t - length;
            found = true;
        }
        winding = next;
    }
    return found;
}

/// The map is queried at the mesh's crossing that is nearest to the point, on the same ray: how far off does it put that?
AlongProjection compare_along_ray(const model::ModelView& model, std::uint32_t index, const mesh::Solid& solid, Vec3f p,
                                  query::Layer layer)
{
    const model::Part& part = model.parts[index];
    const Vec3d q = cast<double>(p);
    AlongProjection result;
    double exact = 0;
    result.mesh = exact_along_ray(solid, part, q, exact);
    const Vec3d along = normalized(q - cast<double>(model::vec3(part.chart_centre)));
    const std::optional<double> mapped =
        query::distance_along_projection(model, index, result.mesh ? q + exact * along : q, layer);
    result.map = mapped.has_value();
    result.error = std::abs(mapped.value_or(0));
    return result;
}

}  // namespace

mesh::Mesh model_space(const mesh::Mesh& mesh)
{
    mesh::Mesh out = mesh::normalized(mesh, mesh::normalization_of(mesh));
    for (Vec3d& v : out.vertices) v = cast<double>(cast<float>(v));
    return out;
}

std::vector<Vec3d> sample_points(const mesh::Mesh& mesh, double r_max, const EvaluateOptions& options)
{
    SplitMix64 random(options.seed);
    std::vector<double> cumulative;
    double area = 0;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) cumulative.push_back(area += mesh::triangle_area(mesh, t));
    const auto [lo, hi] = box_of(mesh.vertices);
    std::vector<Vec3d> points;
    for (std::uint32_t i = 0; i < options.points; ++i) {
        if (i % 4 == 3) {
            points.push_back({random.between(lo.x, hi.x), random.between(lo.y, hi.y), random.between(lo.z, hi.z)});
            continue;
        }
        const auto it = std::upper_bound(cumulative.begin(), cumulative.end(), random.uniform() * area);
        const auto t = static_cast<std::size_t>(std::min<std::ptrdiff_t>(it - cumulative.begin(), std::ssize(cumulative) - 1));
        const mesh::Triangle& tri = mesh.triangles[t];
        double u = random.uniform(), v = random.uniform();
        if (u + v > 1) {
            u = 1 - u;
            v = 1 - v;
        }
        const Vec3d a = mesh.vertices[tri[0]];
        const Vec3d ab = mesh.vertices[tri[1]] - a, ac = mesh.vertices[tri[2]] - a;
        const Vec3d n = normalized(cross(ab, ac));
        points.push_back(a + u * ab + v * ac + random.between(-1, 1) * options.near_band * r_max * n);
    }
    return points;
}

Containment check_containment(const model::ModelView& model, const mesh::Mesh& mesh)
{
    Containment result;
    struct Bounds {
        shape::Superquadricd superquadric;
        std::vector<HalfSpaced> sides;
    };
    std::vector<Bounds> bounds;
    for (std::size_t i = 0; i < model.parts.size(); ++i) {
        const model::Part& p = model.parts[i];
        if (p.largest_f <= 1.f) ++result.certified;
        Bounds& b = bounds.emplace_back(Bounds{shape::cast<double>(model::superquadric_of(p)), {}});
        for (const HalfSpacef& side : model::polytope_of(model, i)) b.sides.push_back(cast<double>(side));
    }
    for (const mesh::Triangle& t : mesh.triangles) {
        const Vec3d a = mesh.vertices[t[0]], b = mesh.vertices[t[1]], c = mesh.vertices[t[2]];
        const Vec3d points[] = {a, b, c, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a), (a + b + c) / 3.0};
        const bool held = std::any_of(bounds.begin(), bounds.end(), [&](const Bounds& held_in) {
            return std::all_of(std::begin(points), std::end(points),
                               [&](Vec3d p) { return holds(held_in.sides, p) && shape::implicit(held_in.superquadric, p) <= 1; });
        });
        result.outside += held ? 0u : 1u;
    }
    return result;
}

namespace {

/// normal: of unit length.
double degrees_between(Vec3d direction, Vec3d normal)
{
    return std::acos(std::clamp(dot(normalized(direction), normal), -1.0, 1.0)) * 180 / std::numbers::pi;
}

}  // namespace

LayerErrors layer_errors(const model::ModelView& baked, const mesh::Solid& solid, const EvaluateOptions& options)
{
    const model::ModelView model = model::normalized(baked);
    constexpr query::Layer k_layers[] = {query::Layer::One, query::Layer::Two, query::Layer::Three};
    const double r_max = model.header.r_max;
    LayerErrors errors;
    std::vector<double> depth[3], normal;
    for (const Vec3d& exact_point : sample_points(solid.mesh(), r_max, options)) {
        const Vec3f p = cast<float>(exact_point);
        const bool inside = solid.inside(cast<double>(p));
        const mesh::ClosestPoint nearest = solid.closest_boundary(cast<double>(p));
        const double distance = nearest.distance;
        ++errors.points;
        for (std::size_t k = 0; k < 3; ++k) {
            const query::PointResult c = query::query_point(model, cast<double>(p), {.layer = k_layers[k]});
            if (inside && c.contact && (c.status & query::k_no_surface) == 0) {
                depth[k].push_back(100 * std::abs(c.depth - distance) / r_max);
                if (k_layers[k] == query::Layer::Three && distance > 1e-4 * r_max)
                    normal.push_back(degrees_between(nearest.point - cast<double>(p), c.normal));
            }
            if (k_layers[k] != query::Layer::Three || distance <= options.verdict_band * r_max) continue;
            errors.missed += inside && !c.contact ? 1u : 0u;
            errors.false_contacts += !inside && c.contact ? 1u : 0u;
        }
    }
    for (std::size_t k = 0; k < 3; ++k) errors.depth[k] = summarize(std::move(depth[k]));
    errors.normal = summarize(std::move(normal));
    return errors;
}

Evaluation evaluate(const model::ModelView& baked, const mesh::Solid& solid, const EvaluateOptions& options)
{
    const model::ModelView model = model::normalized(baked);
    return evaluate_along(model, solid, options, [&](std::uint32_t part, Vec3f p, query::Layer layer) {
        return in_chart(model.parts[part], p) ? std::optional(compare_along_ray(model, part, solid, p, layer)) : std::nullopt;
    });
}

Evaluation evaluate_along(const model::ModelView& model, const mesh::Solid& solid, const EvaluateOptions& options,
                          const CompareAlong& compare)
{
    const double r_max = model.header.r_max;
    Evaluation e;
    std::vector<double> eq35, depth, normal;
    std::vector<std::pair<double, Vec3d>> worst;
    std::uint32_t in_some = 0, left_out = 0, one_sided = 0, contacts = 0, no_surface = 0;
    for (const Vec3d& exact_point : sample_points(solid.mesh(), r_max, options)) {
        const Vec3f p = cast<float>(exact_point);
        const Vec3d q = cast<double>(p);
        const bool inside = solid.inside(q);
        const mesh::ClosestPoint nearest = solid.closest_boundary(q);
        const query::PointResult c = query::query_point(model, q, {.layer = options.layer});
        ++e.points;
        e.inside += inside ? 1u : 0u;
        const bool far = nearest.distance > options.verdict_band * r_max;
        const bool beyond_rounding = nearest.distance > 1e-5 * r_max;
        if (inside && !c.contact) {
            ++e.missed_any;
            e.missed += far ? 1u : 0u;
        }
        if (!inside && c.contact) {
            ++e.false_any;
            e.false_contacts += far ? 1u : 0u;
        }
        if (c.certain) {
            ++e.certain;
            e.certain_wrong += inside != c.contact && beyond_rounding ? 1u : 0u;
            for (const query::Layer layer : {query::Layer::Two, query::Layer::Three})
                if (const query::PointResult other = query::query_point(model, q, {.layer = layer});
                    other.certain && other.contact != c.contact)
                    ++e.contradictions;
        }
        if (inside && beyond_rounding && !query::query_point(model, q, {.layer = query::Layer::One}).contact) ++e.layer1_missed;
        const bool open = (c.status & query::k_no_surface) != 0;
        contacts += inside && c.contact ? 1u : 0u;
        no_surface += inside && c.contact && open ? 1u : 0u;
        if (inside && c.contact && !open) {
            const double error = 100 * std::abs(c.depth - nearest.distance) / r_max;
            depth.push_back(error);
            worst.emplace_back(error, q);
            if (nearest.distance > 1e-4 * r_max) normal.push_back(degrees_between(nearest.point - q, c.normal));
        }
        for (std::uint32_t i = 0; i < model.parts.size(); ++i) {
            if (!in_superquadric(model.parts[i], p)) continue;
            const query::Layer layer = options.layer == query::Layer::Two ? query::Layer::Two : query::Layer::Three;
            const std::optional<AlongProjection> along = compare(i, p, layer);
            if (!along) continue;
            ++in_some;
            if (along->map && along->mesh)
                eq35.push_back(100 * along->error / r_max);
            else
                ++left_out;
            one_sided += along->map != along->mesh ? 1u : 0u;
            break;
        }
    }
    e.no_surface = contacts > 0 ? 100.0 * no_surface / contacts : 0;
    e.eq35 = summarize(std::move(eq35));
    e.eq35_left_out = in_some > 0 ? 100.0 * left_out / in_some : 0;
    e.eq35_one_sided = in_some > 0 ? 100.0 * one_sided / in_some : 0;
    e.depth = summarize(std::move(depth));
    e.normal = summarize(std::move(normal));
    std::sort(worst.begin(), worst.end(), [](const auto& l, const auto& r) { return l.first > r.first; });
    for (std::size_t i = 0; i < worst.size() && i < 50; ++i) e.worst.push_back(worst[i].second);
    return e;
}

}  // namespace sqmap::bake
