// Signed distances in the caller's frame and units. See docs/algorithms/distance.md.
#include "sqmap/query/distance.h"

#include "model/bound_tree.h"
#include "model/flags.h"
#include "query/distance/distance_kernels.h"
#include "query/distance/double_search.h"
#include "query/distance/mapped_surface.h"
#include "query/distance/nearby_order.h"
#include "query/exact/exact_layer.h"
#include "query/probe/probe_job.h"

#include <hwy/cache_control.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <type_traits>

namespace sqmap::query {

namespace {

using model::ModelView;

constexpr std::size_t k_ahead = 16;  // answers and points are fetched so many earlier where they are out of order
constexpr std::size_t k_least_ordered = k_searched_at_once;  // fewer are searched at once as they are
constexpr double k_widest = 1e15;                            // model units: squares of floats do not overflow

/// Exact distances are sought in double where the model has doubles, of a size whose fourth powers are doubles too.
bool has_doubles(const ModelView& model)
{
    return model::has_input(model) && model.header.unit > 1e-50 && model.header.unit < 1e50;
}

Vec3d origin_of(const ModelView& model) { return {model.header.origin[0], model.header.origin[1], model.header.origin[2]}; }

/// Lower bound of the distance of a point outside the root of the tree, by the object's sphere; the point is in the mesh's frame.
/// Computed in double, so that nothing overflows.
double away_from_sphere(const ModelView& model, Vec3d point)
{
    const float* sphere = model.header.sphere;
    const Vec3d centre = origin_of(model) + model.header.unit * cast<double>(model::vec3(sphere));
    const Vec3d d = point - centre;
    const double largest = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
    if (!(largest > 0)) return 0;
    if (largest > std::numeric_limits<double>::max()) return std::numeric_limits<double>::max();
    const Vec3d scaled{d.x / largest, d.y / largest, d.z / largest};  // squares of distances may overflow
    const double away = largest * norm(scaled) * (1 - 1e-9) - model.header.unit * static_cast<double>(sphere[3]) * (1 + 1e-6);
    return std::clamp(away, 0.0, std::numeric_limits<double>::max());
}

/// The cube of the tree of bounds, less what rounding takes.
struct Root {
    Vec3d centre;
    double half;

    explicit Root(const model::DistanceHeader& h)
        : centre(cast<double>(model::vec3(h.root))), half(static_cast<double>(h.half) * (1 - 1e-6))
    {
    }
    bool holds(Vec3d in_model) const
    {
        const Vec3d d = in_model - centre;
        return std::abs(d.x) < half && std::abs(d.y) < half && std::abs(d.z) < half;
    }
};

/// Memory without initial values: a query of a few points need not pay for clearing all of it.
template <class T, std::size_t size>
class Scratch {
public:
    T* data() { return reinterpret_cast<T*>(bytes_); }

private:
    static_assert(std::is_trivially_copyable_v<T>);
    alignas(T) std::byte bytes_[size * sizeof(T)];
};

/// Points in model space on their way to their answers.
template <std::size_t size>
struct WaitingPoints {
    std::size_t count = 0;
    Scratch<Vec3f, size> memory;
    std::size_t index[size];  ///< of the answer

    void add(Vec3f point, std::size_t answer)
    {
        memory.data()[count] = point;
        index[count++] = answer;
    }
    std::span<const Vec3f> points() { return {memory.data(), count}; }
};

/// Answers what the tree of bounds knows a few hundred points at a time, and searches for the rest by thousands.
class Batch {
public:
    /// In double where the model has what that takes.
    struct InDouble {};

    /// pose: of the model, in the frame of points and answers.
    Batch(const ModelView& model, const Pose& pose, InDouble, std::span<SignedDistance> answers)
        : Batch(model, pose, k_everywhere, answers)
    {
        exact_kind_ = has_doubles(model) ? DistanceKind::Exact : DistanceKind::ExactInFloat;
        in_double_ = has_doubles(model);
    }
    /// pose: of the model, in the frame of points and answers.
    Batch(const ModelView& model, const Pose& pose, double band, std::span<SignedDistance> answers)
        : model_(model),
          pose_(pose),
          to_mesh_(inverse(pose)),
          finite_(is_finite(pose)),
          has_tree_(model::has_distance(model)),
          root_(model.distance.header),
          origin_(origin_of(model)),
          per_unit_(1 / model.header.unit),
          answers_(answers)
    {
        const auto baked = static_cast<double>(model.distance.header.band);
        within_ = static_cast<float>(band >= 0 ? std::min(band / model.header.unit, k_widest) : baked);
        is_everywhere_ = has_tree_ && model::has_exact(model) && within_ >= static_cast<float>(k_widest);
    }

    /// From then on an answer is written once: points are those of add, by their index.
    void keep(std::span<const Vec3d> points) { points_ = points; }

    void add(Vec3d point, std::size_t index)
    {
        if (!is_finite(point) || !finite_) {
            SignedDistance& answer = answers_[index];
            answer = {};
            answer.witness = point;
            answer.status = k_not_finite;
            return;
        }
        if (points_.empty()) answers_[index].witness = point;
        const Vec3d in_mesh = apply(to_mesh_, point), in_model = per_unit_ * (in_mesh - origin_);
        if (is_everywhere_ && std::max({std::abs(in_model.x), std::abs(in_model.y), std::abs(in_model.z)}) < 0.1 * k_widest) {
            near_.add(cast<float>(in_model), index);
            if (near_.count == k_searched_at_once) search();
            return;
        }
        if ((!has_tree_ || !root_.holds(in_model)) && !is_sought(in_mesh)) return finish_beyond(in_mesh, point, index);
        new_.add(cast<float>(in_model), index);
        if (new_.count == k_bounded_at_once) bound();
    }

    void flush()
    {
        bound();
        search();
    }

    /// A point outside the root: whether the hierarchy is searched for it all the same, as the band is so wide.
    bool is_sought(Vec3d in_mesh) const
    {
        return has_tree_ && model::has_exact(model_) &&
               away_from_sphere(model_, in_mesh) <= static_cast<double>(within_) * model_.header.unit;
    }

    /// Moves a point from model space to the caller's frame.
    Vec3d position_in_frame(Vec3f p) const { return apply(pose_, origin_of(model_) + model_.header.unit * cast<double>(p)); }

private:
    /// Beyond the band the object's sphere bounds the distance from below.
    void finish_beyond(Vec3d in_mesh, Vec3d point, std::size_t index)
    {
        SignedDistance& answer = answers_[index];
        answer = {};
        answer.witness = point;
        answer.distance = away_from_sphere(model_, in_mesh);
        if (model_.answers != nullptr && !has_tree_) answer.status = model_.answers->no_distance;
    }

    /// The point of an answer that is not finished yet.
    Vec3d queried(std::size_t index) const { return points_.empty() ? answers_[index].witness : points_[index]; }

    /// Fetches a point and its answer ahead, and puts the point where its answer is finished.
    SignedDistance& begin(const std::size_t* index, std::size_t i, std::size_t count)
    {
        const std::size_t later = index[std::min(i + k_ahead, count - 1)];
        hwy::Prefetch(&answers_[later]);
        hwy::Prefetch(&answers_[later].triangle);
        SignedDistance& answer = answers_[index[i]];
        if (!points_.empty()) {
            hwy::Prefetch(&points_[later]);
            answer.witness = points_[index[i]];
        }
        return answer;
    }

    void bound()
    {
        const std::span<const Vec3f> points = new_.points();
        const std::span found(surfaces.data(), points.size());
        std::uint16_t near[k_bounded_at_once];
        const std::size_t count = bound_surfaces(model_, within_, points, found, near);
        std::size_t k = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            if (k < count && near[k] == i) {
                ++k;
                continue;
            }
            finish_bound(found[i], begin(new_.index, i, points.size()));
        }
        if (near_.count + count > k_searched_at_once) search();
        for (std::size_t i = 0; i < count; ++i) near_.add(points[near[i]], new_.index[near[i]]);
        new_.count = 0;
    }
    void search()
    {
        if (in_double_) return search_in_double();
        const std::span<const Vec3f> points = near_.points();
        const std::span found(surfaces.data(), points.size());
        search_surfaces(model_, points, found);
        answer_near([&](std::size_t i, SignedDistance& answer) {
            if (model::has_exact(model_))
                finish_exact(points[i], found[i], answer);
            else
                finish_approximate(points[i], answer);
        });
    }

    /// finish(i, answer): completes the answer of near point i.
    template <class Finish>
    void answer_near(Finish finish)
    {
        for (std::size_t i = 0; i < near_.count; ++i) {
            finish(i, begin(near_.index, i, near_.count));
        }
        near_.count = 0;
    }
    void search_in_double()
    {
        const std::span<const Vec3f> points = near_.points();
        const std::span near(near_triangles.data(), points.size());
        search_near_triangles(model_, points, near);
        constexpr std::size_t k_together = 128;
        Vec3d in_mesh[k_together];
        NearestInDouble found[k_together];
        answer_near([&](std::size_t i, SignedDistance& answer) {
            if (i % k_together == 0) {
                const std::size_t count = std::min(k_together, near_.count - i);
                for (std::size_t k = 0; k < count; ++k) {
                    if (!points_.empty()) hwy::Prefetch(&points_[near_.index[std::min(i + k + k_ahead, near_.count - 1)]]);
                    in_mesh[k] = apply(to_mesh_, queried(near_.index[i + k]));
                }
                nearest_in_double(model_, {in_mesh, count}, near.subspan(i, count), found);
            }
            if (near[i].entry >= 0)
                finish_in_double(points[i], found[i % k_together], answer);
            else if (model::has_exact(model_))
                finish_exact(points[i], {}, answer);
            else
                finish_approximate(points[i], answer);
        });
    }

    bool is_inside(Vec3f p, std::uint32_t sides) const
    {
        if (model_.header.solid == 0 || sides == k_seen_outside) return false;
        return sides == k_seen_inside || query_exact(model_, p).contact;
    }

    /// answer.witness is the queried point.
    void finish_bound(const NearestSurface& found, SignedDistance& answer) const
    {
        const auto away = static_cast<double>(found.distance) * model_.header.unit;
        answer.distance = found.sides == k_seen_inside ? -away : away;
        answer.gradient = {};
        answer.part = answer.triangle = -1;
        answer.known = DistanceKind::LowerBound;
        answer.status = k_ok;
    }

    void finish_exact(Vec3f p, const NearestSurface& found, SignedDistance& answer) const
    {
        const bool inside = is_inside(p, found.sides);
        const double sign = inside ? -1 : 1, unit = model_.header.unit;
        const Vec3d point = answer.witness;
        if (found.entry < 0) {
            answer = {};
            answer.witness = point;
            answer.status = k_no_exact;
            return;
        }
        const std::uint32_t triangle = triangle_of(found.entry);
        const Vec3d offset = in_frame(found.offset);
        answer.distance = sign * static_cast<double>(found.distance) * unit + 0.0;  // not -0
        // On the surface, its own normal.
        const bool touching = !(found.distance > 1e-5f * model_.header.sphere[3]);
        answer.gradient = touching ? pose_.rotation * normal_of(triangle) : -sign * normalized(offset);
        answer.witness = point + unit * offset;
        answer.known = exact_kind_;
        name_triangle(triangle, answer);
    }

    /// answer.witness is the queried point.
    void finish_in_double(Vec3f in_model, const NearestInDouble& found, SignedDistance& answer) const
    {
        const Vec3d point = answer.witness;
        const bool is_solid = model_.header.solid != 0;
        const bool inside = is_solid && (found.side == 0 ? query_exact(model_, in_model).contact : found.side < 0);
        const double sign = inside ? -1 : 1;
        answer.distance = sign * found.distance + 0.0;  // not -0
        // On the surface, its own normal.
        const bool touching = !(found.distance > 1e-9 * static_cast<double>(model_.header.sphere[3]) * model_.header.unit);
        answer.gradient = pose_.rotation * (touching ? found.normal : -sign / found.distance * found.offset);
        answer.witness = point + pose_.rotation * found.offset;
        answer.known = exact_kind_;
        name_triangle(found.triangle, answer);
    }

    void name_triangle(std::uint32_t triangle, SignedDistance& answer) const
    {
        const std::uint16_t word = model_.triangle_part[triangle];
        answer.triangle = static_cast<std::int32_t>(triangle);
        answer.part = static_cast<std::int32_t>(model::part_of(word));
        answer.status = model::is_made_up(word) ? k_made_up : k_ok;
    }

    /// Turns a direction from model space to the caller's frame.
    Vec3d in_frame(Vec3f direction) const { return pose_.rotation * cast<double>(direction); }

    std::uint32_t triangle_of(std::int32_t entry) const
    {
        const auto e = static_cast<std::uint32_t>(entry), triangles = static_cast<std::uint32_t>(model_.triangle_part.size());
        return e < triangles ? e : model_.piece_triangle[e - triangles];
    }
    Vec3d normal_of(std::uint32_t triangle) const
    {
        const auto corner = [&](std::uint32_t k) {
            return cast<double>(
                model::vec3(model_.vertices.data() + 3 * std::size_t{model::triangle_vertex(model_, triangle, k)}));
        };
        const Vec3d a = corner(0);
        return normalized(cross(corner(1) - a, corner(2) - a));
    }

    void finish_approximate(Vec3f p, SignedDistance& answer) const
    {
        const Vec3d point = answer.witness;
        answer = {0, {}, point, -1, DistanceKind::Approximate, k_no_exact};
        const std::optional<MappedSurface> found = nearest_mapped_surface(model_, p);
        if (!found) return;
        answer.distance = static_cast<double>(found->distance) * model_.header.unit;
        answer.gradient = in_frame(found->gradient);
        answer.witness = position_in_frame(found->point);
        answer.part = found->part;
    }

    const ModelView& model_;
    const Pose pose_, to_mesh_;
    const bool finite_, has_tree_;
    const Root root_;
    const Vec3d origin_;
    const double per_unit_;
    std::span<SignedDistance> answers_;
    std::span<const Vec3d> points_;  ///< where they are kept; empty: a waiting point is its answer's witness
    float within_;
    DistanceKind exact_kind_ = DistanceKind::Exact;
    bool in_double_ = false;
    bool is_everywhere_ = false;  ///< no bound is wanted
    WaitingPoints<k_bounded_at_once> new_;
    WaitingPoints<k_searched_at_once> near_;
    union {  // by turns
        Scratch<NearestSurface, k_searched_at_once> surfaces;
        Scratch<NearTriangles, k_searched_at_once> near_triangles;
    };
};

/// The answer for a body without a model.
SignedDistance of_nothing(Vec3d point)
{
    SignedDistance answer;
    answer.distance = std::numeric_limits<double>::max();
    answer.witness = point;
    return answer;
}

void answer_in_order(std::span<const Vec3d> points, std::span<const std::uint16_t> order, Batch& batch)
{
    batch.keep(points);
    for (std::size_t k = 0; k < points.size(); ++k) {
        hwy::Prefetch(&points[order[std::min(k + k_ahead, points.size() - 1)]]);
        batch.add(points[order[k]], order[k]);
    }
    batch.flush();
}

/// how: the band, or Batch::InDouble.
template <class How>
void answer_batch(const Body& touched, std::span<const Vec3d> points, std::span<SignedDistance> answers, How how)
{
    const std::size_t count = std::min(points.size(), answers.size());
    if (touched.model == nullptr) {
        std::transform(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(count), answers.begin(), of_nothing);
        return;
    }
    if (count >= k_least_ordered) {
        std::uint16_t order[k_ordered_at_once];
        for (std::size_t first = 0; first < count; first += k_ordered_at_once) {
            const std::size_t some = std::min(k_ordered_at_once, count - first);
            Batch batch(*touched.model, touched.pose, how, answers.subspan(first, some));
            put_near_together(touched, points.subspan(first, some), order);
            answer_in_order(points.subspan(first, some), {order, some}, batch);
        }
        return;
    }
    Batch batch(*touched.model, touched.pose, how, answers);
    for (std::size_t i = 0; i < count; ++i) batch.add(points[i], i);
    batch.flush();
}

}  // namespace

SignedDistance distance(const Body& touched, Vec3d point, double band) noexcept
{
    SignedDistance answer;
    distances(touched, {&point, 1}, {&answer, 1}, band);
    return answer;
}

SignedDistance distance(const ModelView& model, Vec3d point, double band) noexcept { return distance(Body{&model}, point, band); }

void distances(const Body& touched, std::span<const Vec3d> points, std::span<SignedDistance> answers, double band) noexcept
{
    answer_batch(touched, points, answers, band);
}

void distances(const ModelView& model, std::span<const Vec3d> points, std::span<SignedDistance> answers, double band) noexcept
{
    distances(Body{&model}, points, answers, band);
}

SignedDistance exact_distance(const Body& touched, Vec3d point) noexcept
{
    SignedDistance answer;
    exact_distances(touched, {&point, 1}, {&answer, 1});
    return answer;
}

SignedDistance exact_distance(const ModelView& model, Vec3d point) noexcept { return exact_distance(Body{&model}, point); }

void exact_distances(const Body& touched, std::span<const Vec3d> points, std::span<SignedDistance> answers) noexcept
{
    answer_batch(touched, points, answers, Batch::InDouble{});
}

void exact_distances(const ModelView& model, std::span<const Vec3d> points, std::span<SignedDistance> answers) noexcept
{
    exact_distances(Body{&model}, points, answers);
}

void distances(const Body& touched, const Body& collider, std::span<SignedDistance> answers) noexcept
{
    if (touched.model == nullptr || collider.probe == nullptr || answers.size() < collider.probe->size()) return;
    const ProbeJob job(touched, collider, {}, {});
    Batch batch(*touched.model, touched.pose, k_baked_band, answers);
    for (std::size_t slot = 0; slot < job.points; ++slot) {
        const Vec3f in_model = job.in_model_space({job.x[slot], job.y[slot], job.z[slot]});
        batch.add(batch.position_in_frame(in_model), job.point[slot]);
    }
    batch.flush();
}

}  // namespace sqmap::query
