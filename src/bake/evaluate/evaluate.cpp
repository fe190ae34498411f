#include "along_projection.h"
#include "drafts.h"
#include "query/dispatch/model_point.h"

#include "math/random.h"
#include "sqmap/math/assert.h"
#include "sqmap/math/box.h"
#include "sqmap/mesh/error.h"

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

/// The crossing of a ray from a part's centre through a point with the mesh that lies nearest to the point.
struct MeshOnRay {
    bool found = false;
    double distance = 0;  ///< from the point, outwards
};
MeshOnRay mesh_on_ray(const mesh::Solid& solid, const model::Part& part, Vec3d p)
{
    MeshOnRay ray;
    ray.found = exact_along_ray(solid, part, p, ray.distance);
    return ray;
}

/// The map is queried at the mesh's crossing that is nearest to the point, on the same ray: how far off does it put that?
AlongProjection compare_along_ray(const model::ModelView& model, std::uint32_t index, const MeshOnRay& mesh, Vec3f p,
                                  query::Layer layer)
{
    const Vec3d q = cast<double>(p);
    AlongProjection result;
    result.mesh = mesh.found;
    const Vec3d along = normalized(q - cast<double>(model::vec3(model.parts[index].chart_centre)));
    const std::optional<double> mapped =
        query::distance_along_projection(model, index, result.mesh ? q + mesh.distance * along : q, layer);
    result.map = mapped.has_value();
    result.error = std::abs(mapped.value_or(0));
    return result;
}

/// normal: of unit length.
double degrees_between(Vec3d direction, Vec3d normal)
{
    return std::acos(std::clamp(dot(normalized(direction), normal), -1.0, 1.0)) * 180 / std::numbers::pi;
}

Sampled sampled(const mesh::Solid& solid, const Vec3d& exact_point)
{
    const Vec3d q = cast<double>(cast<float>(exact_point));
    return {q, solid.inside(q), solid.closest_boundary(q)};
}

/// The errors at the points that were judged so far.
class Tally {
public:
    Tally(double r_max, double verdict_band) : r_max_(r_max), verdict_band_(verdict_band) {}

    bool is_beyond_rounding(const Sampled& at) const { return at.nearest.distance > 1e-5 * r_max_; }

    /// c: the model's answer.
    void add(const Sampled& at, const query::PointResult& c)
    {
        const bool far = at.nearest.distance > verdict_band_ * r_max_;
        ++e_.points;
        e_.inside += at.inside ? 1u : 0u;
        if (at.inside && !c.contact) {
            ++e_.missed_any;
            e_.missed += far ? 1u : 0u;
        }
        if (!at.inside && c.contact) {
            ++e_.false_any;
            e_.false_contacts += far ? 1u : 0u;
        }
        const bool open = (c.status & query::k_no_surface) != 0;
        contacts_ += at.inside && c.contact ? 1u : 0u;
        no_surface_ += at.inside && c.contact && open ? 1u : 0u;
        if (!at.inside || !c.contact || open) return;
        const double error = 100 * std::abs(c.depth - at.nearest.distance) / r_max_;
        depth_.push_back(error);
        worst_.emplace_back(error, at.q);
        if (at.nearest.distance > 1e-4 * r_max_) normal_.push_back(degrees_between(at.nearest.point - at.q, c.normal));
    }

    /// Eq. 35 at a point in a part's superquadric.
    void add(const AlongProjection& along)
    {
        ++in_some_;
        if (along.map && along.mesh)
            eq35_.push_back(100 * along.error / r_max_);
        else
            ++left_out_;
        one_sided_ += along.map != along.mesh ? 1u : 0u;
    }

    /// The errors of the points so far.
    Evaluation summary() const
    {
        Evaluation e = e_;
        e.no_surface = contacts_ > 0 ? 100.0 * no_surface_ / contacts_ : 0;
        e.eq35 = summarize(eq35_);
        e.eq35_left_out = in_some_ > 0 ? 100.0 * left_out_ / in_some_ : 0;
        e.eq35_one_sided = in_some_ > 0 ? 100.0 * one_sided_ / in_some_ : 0;
        e.depth = summarize(depth_);
        e.normal = summarize(normal_);
        std::vector<std::pair<double, Vec3d>> worst = worst_;
        std::sort(worst.begin(), worst.end(), [](const auto& l, const auto& r) { return l.first > r.first; });
        for (std::size_t i = 0; i < worst.size() && i < 50; ++i) e.worst.push_back(worst[i].second);
        return e;
    }

private:
    double r_max_, verdict_band_;
    Evaluation e_;
    std::vector<double> eq35_, depth_, normal_;
    std::vector<std::pair<double, Vec3d>> worst_;
    std::uint32_t in_some_ = 0, left_out_ = 0, one_sided_ = 0, contacts_ = 0, no_surface_ = 0;
};

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

SampledSolid::SampledSolid(const mesh::Solid& solid, double r_max, const EvaluateOptions& options)
    : solid_(solid), positions_(sample_points(solid.mesh(), r_max, options))
{
}

const Sampled& SampledSolid::at(std::size_t i)
{
    SQMAP_ASSERT(i < positions_.size());
    while (points_.size() <= i) points_.push_back(sampled(solid_, positions_[points_.size()]));
    return points_[i];
}

LayerErrors layer_errors(const model::ModelView& baked, const mesh::Solid& solid, const EvaluateOptions& options)
{
    SampledSolid samples(solid, model::normalized(baked).header.r_max, options);
    return layer_errors(baked, samples, options);
}

LayerErrors layer_errors(const model::ModelView& baked, SampledSolid& samples, const EvaluateOptions& options)
{
    const model::ModelView model = model::normalized(baked);
    constexpr query::Layer k_layers[] = {query::Layer::One, query::Layer::Two, query::Layer::Three};
    const double r_max = model.header.r_max;
    LayerErrors errors;
    std::vector<double> depth[3], normal;
    for (std::size_t i = 0; i < options.points; ++i) {
        const auto& [q, inside, nearest] = samples.at(i);
        const double distance = nearest.distance;
        ++errors.points;
        for (std::size_t k = 0; k < 3; ++k) {
            const query::PointResult c = query::query_point(model, q, {.layer = k_layers[k]});
            if (inside && c.contact && (c.status & query::k_no_surface) == 0) {
                depth[k].push_back(100 * std::abs(c.depth - distance) / r_max);
                if (k_layers[k] == query::Layer::Three && distance > 1e-4 * r_max)
                    normal.push_back(degrees_between(nearest.point - q, c.normal));
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
    if (baked.header.projection != 0)
        throw mesh::InvalidInput("bake::evaluate needs central maps, and this is a paper model: paper::evaluate measures both");
    const model::ModelView model = model::normalized(baked);
    return evaluate_along(model, solid, options, [&](std::uint32_t i, Vec3f p, query::Layer layer) {
        const model::Part& part = model.parts[i];
        return in_chart(part, p) ? std::optional(compare_along_ray(model, i, mesh_on_ray(solid, part, cast<double>(p)), p, layer))
                                 : std::nullopt;
    });
}

Evaluation evaluate_along(const model::ModelView& model, const mesh::Solid& solid, const EvaluateOptions& options,
                          const CompareAlong& compare)
{
    const double r_max = model.header.r_max;
    Tally tally(r_max, options.verdict_band);
    std::uint32_t certain = 0, certain_wrong = 0, contradictions = 0, layer1_missed = 0;
    for (const Vec3d& exact_point : sample_points(solid.mesh(), r_max, options)) {
        const Sampled at = sampled(solid, exact_point);
        const query::PointResult c = query::query_point(model, at.q, {.layer = options.layer});
        tally.add(at, c);
        const bool beyond_rounding = tally.is_beyond_rounding(at);
        if (c.certain) {
            ++certain;
            certain_wrong += at.inside != c.contact && beyond_rounding ? 1u : 0u;
            for (const query::Layer layer : {query::Layer::Two, query::Layer::Three})
                if (const query::PointResult other = query::query_point(model, at.q, {.layer = layer});
                    other.certain && other.contact != c.contact)
                    ++contradictions;
        }
        if (at.inside && beyond_rounding && !query::query_point(model, at.q, {.layer = query::Layer::One}).contact)
            ++layer1_missed;
        const Vec3f p = cast<float>(at.q);
        for (std::uint32_t i = 0; i < model.parts.size(); ++i) {
            if (!in_superquadric(model.parts[i], p)) continue;
            const query::Layer layer = options.layer == query::Layer::Two ? query::Layer::Two : query::Layer::Three;
            const std::optional<AlongProjection> along = compare(i, p, layer);
            if (!along) continue;
            tally.add(*along);
            break;
        }
    }
    Evaluation e = tally.summary();
    e.certain = certain;
    e.certain_wrong = certain_wrong;
    e.contradictions = contradictions;
    e.layer1_missed = layer1_missed;
    return e;
}

struct DraftEvaluator::State {
    /// The part whose map is compared along a ray, and where the mesh meets that.
    struct Ray {
        std::uint32_t part;
        MeshOnRay mesh;
    };

    SampledSolid& samples;
    EvaluateOptions options;
    std::vector<std::optional<Ray>> rays;  ///< of the first points
    model::ModelView draft;
    std::optional<Tally> tally;
    std::uint32_t judged = 0;  ///< points of the draft

    void find_another()
    {
        const Vec3d q = samples.at(rays.size()).q;
        const Vec3f p = cast<float>(q);
        std::optional<Ray>& ray = rays.emplace_back();
        for (std::uint32_t i = 0; i < draft.parts.size() && !ray; ++i) {
            const model::Part& part = draft.parts[i];
            if (in_superquadric(part, p) && in_chart(part, p)) ray = Ray{i, mesh_on_ray(samples.solid(), part, q)};
        }
    }
    void judge(const Sampled& at, const std::optional<Ray>& ray)
    {
        const auto near = static_cast<float>(at.nearest.distance);
        const Vec3f p = cast<float>(at.q);
        const query::ModelContact c = query::query_unlocated_near(draft, p, near);
        query::PointResult result;
        result.contact = c.contact;
        result.status = c.status;
        result.depth = static_cast<double>(c.depth);
        result.normal = cast<double>(c.normal);
        tally->add(at, result);
        if (ray) tally->add(compare_along_ray(draft, ray->part, ray->mesh, p, query::Layer::Three));
    }
};

DraftEvaluator::DraftEvaluator(SampledSolid& samples) : state_(new State{samples, {}, {}, {}, {}}) {}
DraftEvaluator::~DraftEvaluator() = default;

void DraftEvaluator::begin(const model::ModelView& draft)
{
    state_->draft = model::normalized(draft);
    state_->tally.emplace(state_->draft.header.r_max, state_->options.verdict_band);
    state_->judged = 0;
}

Evaluation DraftEvaluator::first(std::uint32_t points)
{
    State& s = *state_;
    SQMAP_ASSERT(s.judged <= points);
    for (; s.judged < points; ++s.judged) {
        if (s.judged == s.rays.size()) s.find_another();
        s.judge(s.samples.at(s.judged), s.rays[s.judged]);
    }
    return s.tally->summary();
}

}  // namespace sqmap::bake
