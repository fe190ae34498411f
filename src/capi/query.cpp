// Batches of points behind the C interface: contacts, signed distances, closest points.
#include "math/triangle.h"
#include "objects.h"
#include "parallel/for_each.h"
#include "sqmap/query/distance.h"
#include "sqmap/query/point.h"
#include "structs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>

namespace sqmap::capi {
namespace {

constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t k_batch = 4096;          ///< what query::distances shares work among
constexpr std::size_t k_widest_batch = 65536;  ///< what it puts in order first

/// Calls work(slice) for all of count, `batch` at a time, on this thread alone where it is one.
template <class Work>
void for_batches(std::size_t count, unsigned threads, Work&& work, std::size_t batch = k_batch)
{
    if (threads > 1) return parallel::for_slices(count, batch, threads, std::forward<Work>(work));
    for (std::size_t first = 0; first < count; first += batch) work(parallel::Slice{first, std::min(batch, count - first)});
}

template <class T, class Get>
void fill(T* target, parallel::Slice slice, Get&& get)
{
    if (target == nullptr) return;
    for (std::size_t i = 0; i < slice.count; ++i) target[slice.first + i] = static_cast<T>(get(i));
}

template <class Get>
void fill_rows(double* target, parallel::Slice slice, Get&& get)
{
    if (target == nullptr) return;
    for (std::size_t i = 0; i < slice.count; ++i) {
        const Vec3d v = get(i);
        double* const row = target + 3 * (slice.first + i);
        row[0] = v.x;
        row[1] = v.y;
        row[2] = v.z;
    }
}

struct Batch {
    std::span<const Vec3d> points;
    Pose pose;
};

Batch batch_of(const sqmap_points* points)
{
    const sqmap_points in = taken(&needed(points, "points"), "points");
    return {rows(in, "points.xyz"), pose_of(in.pose, "points.pose")};
}

constexpr std::size_t k_few = 256;  // points whose answers stay in the first cache

/// Verdicts of the exact layer that float does not prove become those of exact_distance: contact is where its sign is negative.
/// Returns the number of contacts.
std::size_t settle(const query::Body& body, std::span<const Vec3d> points, std::span<query::PointResult> answers)
{
    std::size_t contacts = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        query::PointResult& r = answers[i];
        if (!r.certain && (r.status & query::k_not_finite) == 0) {
            const query::SignedDistance d = query::exact_distance(body, points[i]);
            const bool is_inside = d.distance < 0;
            if (is_inside != r.contact)
                r = is_inside ? query::PointResult{true, true, d.status, d.part, -d.distance, d.witness, d.gradient}
                              : query::PointResult{false, true, query::k_ok, -1, 0, points[i], {}};
            r.certain = d.known == query::DistanceKind::Exact;
        }
        contacts += r.contact ? 1u : 0u;
    }
    return contacts;
}

/// The exact layer of a solid answers.
bool is_exact(const model::ModelView& model, const query::QueryOptions& options)
{
    return model.header.solid != 0 && model::has_exact(model) && query::chosen_layer(model, options) == query::Layer::Exact &&
           options.margin == 0 && !options.smoothed_map;
}

std::size_t answer(const query::Body& body, const Batch& batch, const sqmap_query_options& o, const sqmap_contacts& out)
{
    const query::QueryOptions options = query_options(o);
    const bool settles = is_exact(*body.model, options);
    std::atomic<std::size_t> contacts{0};
    for_batches(batch.points.size(), threads_of(o.threads), [&](parallel::Slice slice) {
        std::array<query::PointResult, k_few> answers;
        for (std::size_t done = 0; done < slice.count; done += k_few) {
            const parallel::Slice few{slice.first + done, std::min(k_few, slice.count - done)};
            const std::span<const Vec3d> points = batch.points.subspan(few.first, few.count);
            const std::size_t found = query::query_points(body, points, options, answers);
            contacts += settles ? settle(body, points, answers) : found;
            const auto at = [&](std::size_t i) -> const query::PointResult& { return answers[i]; };
            fill(out.contact, few, [&](std::size_t i) { return at(i).contact; });
            fill(out.depth, few, [&](std::size_t i) { return (at(i).status & query::k_not_finite) != 0 ? k_nan : at(i).depth; });
            fill_rows(out.normal, few, [&](std::size_t i) { return at(i).normal; });
            fill_rows(out.closest, few, [&](std::size_t i) { return at(i).witness; });
            fill(out.part, few, [&](std::size_t i) { return at(i).part; });
            fill(out.certain, few, [&](std::size_t i) { return at(i).certain; });
            fill(out.status, few, [&](std::size_t i) { return at(i).status; });
        }
    });
    return contacts;
}

/// how(points, answers): of a batch.
template <class How>
void answer(const Batch& batch, const sqmap_query_options& o, const sqmap_distances& out, How&& how)
{
    const unsigned threads = threads_of(o.threads);
    const std::size_t count = batch.points.size();
    // One thread allocates nothing.
    const std::size_t together = threads > 1 ? std::clamp(count / threads, k_batch, k_widest_batch) : k_batch;
    const auto work = [&](parallel::Slice slice) {
        // Not set to defaults first. Emscripten's standard library lacks make_unique_for_overwrite.
        alignas(query::SignedDistance) std::byte few[k_batch * sizeof(query::SignedDistance)];
        std::unique_ptr<std::byte[]> many;
        if (slice.count > k_batch) many.reset(new std::byte[slice.count * sizeof(query::SignedDistance)]);
        std::byte* const memory = many ? many.get() : few;
        const std::span<query::SignedDistance> answers{reinterpret_cast<query::SignedDistance*>(memory), slice.count};
        how(batch.points.subspan(slice.first, slice.count), answers);
        const auto at = [&](std::size_t i) -> const query::SignedDistance& { return answers[i]; };
        fill(out.distance, slice,
             [&](std::size_t i) { return (at(i).status & query::k_not_finite) != 0 ? k_nan : at(i).distance; });
        fill_rows(out.gradient, slice, [&](std::size_t i) { return at(i).gradient; });
        fill_rows(out.closest, slice, [&](std::size_t i) { return at(i).witness; });
        fill(out.part, slice, [&](std::size_t i) { return at(i).part; });
        fill(out.known, slice, [&](std::size_t i) { return static_cast<std::uint8_t>(at(i).known); });
        fill(out.status, slice, [&](std::size_t i) { return at(i).status; });
        fill(out.triangle, slice, [&](std::size_t i) { return at(i).triangle; });
    };
    for_batches(count, threads, work, together);
}

/// A tie goes to the triangle that faces the point most, then to the first in the input.
mesh::ClosestPoint facing_closest(const Surface& surface, Vec3d p)
{
    constexpr double k_tie = 1e-14, k_alike = 1e-12;  // of squared distances and of cosines
    mesh::ClosestPoint best;
    double best_sq = std::numeric_limits<double>::infinity(), best_facing = -1;
    const auto rank = [&](std::uint32_t t) { return (std::uint64_t{surface.source.empty() ? 0 : surface.source[t]} << 32) | t; };
    surface.bvh.visit_nearest(p, best_sq, [&](std::uint32_t t, double) {
        const mesh::Triangle& tri = surface.mesh.triangles[t];
        const Vec3d a = surface.mesh.vertices[tri[0]], b = surface.mesh.vertices[tri[1]], c = surface.mesh.vertices[tri[2]];
        const Vec3d q = closest_point_on_triangle(p, a, b, c), offset = q - p;
        const double distance_sq = norm_sq(offset);
        if (distance_sq <= best_sq * (1 + k_tie) + std::numeric_limits<double>::min()) {
            const Vec3d across = cross(b - a, c - a);
            const double size = norm(across) * std::sqrt(distance_sq);
            const double facing = size > 0 ? std::abs(dot(across, offset)) / size : 0;
            const bool is_nearer = distance_sq * (1 + k_tie) < best_sq;
            if (is_nearer || facing > best_facing + k_alike ||
                (facing >= best_facing - k_alike && rank(t) < rank(best.triangle))) {
                best_facing = is_nearer ? facing : std::max(best_facing, facing);
                best = {q, t, std::sqrt(distance_sq)};
            }
            best_sq = std::min(best_sq, distance_sq);
        }
        return best_sq * (1 + k_tie) + std::numeric_limits<double>::min();  // what rounds to the same is visited, too
    });
    return best;
}

void answer(const Surface& surface, const Batch& batch, const sqmap_query_options& o, const sqmap_closest& out)
{
    const Pose back = inverse(batch.pose);
    for_batches(batch.points.size(), threads_of(o.threads), [&](parallel::Slice slice) {
        for (std::size_t i = slice.first; i < slice.first + slice.count; ++i) {
            const Vec3d p = batch.points[i];
            mesh::ClosestPoint found{{k_nan, k_nan, k_nan}, 0xffffffff, k_nan};
            if (is_finite(p)) {
                found = facing_closest(surface, apply(back, p));
                found.point = apply(batch.pose, found.point);
            }
            const parallel::Slice one{i, 1};
            fill_rows(out.closest, one, [&](std::size_t) { return found.point; });
            fill(out.distance, one, [&](std::size_t) { return found.distance; });
            fill(out.triangle, one, [&](std::size_t) { return found.triangle; });
        }
    });
}

}  // namespace
}  // namespace sqmap::capi

using namespace sqmap;
using capi::guarded;
using capi::needed;

sqmap_code sqmap_query_points(sqmap_model model, const sqmap_points* points, const sqmap_query_options* options,
                              sqmap_contacts* contacts)
{
    return guarded([&] {
        const capi::Model& m = *capi::model_of(model);
        const capi::Batch batch = capi::batch_of(points);
        sqmap_contacts out = capi::taken(&needed(contacts, "contacts"), "contacts");
        const sqmap_query_options o = capi::taken(options, "options");
        const capi::Opened read = capi::read_paper(m.opened(), capi::paper_options(o), capi::query_options(o));
        out.contacts = capi::answer({&read.view, nullptr, batch.pose}, batch, o, out);
        capi::give(contacts, out);
    });
}

sqmap_code sqmap_exact_distances(sqmap_model model, const sqmap_points* points, const sqmap_query_options* options,
                                 sqmap_distances* distances)
{
    return guarded([&] {
        const capi::Model& m = *capi::model_of(model);
        const capi::Batch batch = capi::batch_of(points);
        const sqmap_distances out = capi::taken(&needed(distances, "distances"), "distances");
        const query::Body body{&m.view(), nullptr, batch.pose};
        capi::answer(batch, capi::taken(options, "options"), out,
                     [&](std::span<const Vec3d> some, std::span<query::SignedDistance> answers) {
                         query::exact_distances(body, some, answers);
                     });
    });
}

sqmap_code sqmap_signed_distances(sqmap_model model, const sqmap_points* points, const sqmap_query_options* options,
                                  sqmap_distances* distances)
{
    return guarded([&] {
        const capi::Model& m = *capi::model_of(model);
        const capi::Batch batch = capi::batch_of(points);
        const sqmap_distances out = capi::taken(&needed(distances, "distances"), "distances");
        const sqmap_query_options o = capi::taken(options, "options");
        const double band =
            o.band == 0 ? query::k_baked_band : capi::checked(o.band, 0, std::numeric_limits<double>::infinity(), "options.band");
        const query::Body body{&m.view(), nullptr, batch.pose};
        capi::answer(batch, o, out, [&](std::span<const Vec3d> some, std::span<query::SignedDistance> answers) {
            query::distances(body, some, answers, band);
        });
    });
}

sqmap_code sqmap_closest_points(sqmap_model model, const sqmap_points* points, const sqmap_query_options* options,
                                sqmap_closest* closest)
{
    return guarded([&] {
        const capi::Model& m = *capi::model_of(model);
        const capi::Batch batch = capi::batch_of(points);
        const sqmap_closest out = capi::taken(&needed(closest, "closest"), "closest");
        capi::answer(m.surface(), batch, capi::taken(options, "options"), out);
    });
}

sqmap_code sqmap_implicit(sqmap_model model, uint32_t part, const sqmap_points* points, double* values)
{
    return guarded([&] {
        const model::ModelView& view = capi::model_of(model)->view();
        if (part >= view.parts.size())
            throw capi::Failure{SQMAP_E_ARGUMENT, "part", "is " + std::to_string(part),
                                "give a number below " + std::to_string(view.parts.size()) + ", the number of parts"};
        const capi::Batch batch = capi::batch_of(points);
        if (!batch.points.empty()) (void)needed(values, "values");
        const auto superquadric = shape::cast<double>(model::superquadric_of(view.parts[part]));
        const Pose to_mesh = inverse(batch.pose);
        const Vec3d origin{view.header.origin[0], view.header.origin[1], view.header.origin[2]};
        for (std::size_t i = 0; i < batch.points.size(); ++i) {
            const Vec3d p = batch.points[i];
            values[i] =
                is_finite(p) ? shape::implicit(superquadric, (apply(to_mesh, p) - origin) / view.header.unit) : capi::k_nan;
        }
    });
}
