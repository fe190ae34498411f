// J. A. Baerentzen, H. Aanaes, "Signed distance computation using the angle weighted pseudonormal", IEEE TVCG 11(3), 2005: of all
// triangles that share the nearest point, the normals weighted by their angles there say on which side the point is.
#include "query/distance/double_search.h"

#include "math/triangle.h"
#include "math/trigonometry.h"
#include "model/flags.h"
#include "query/distance/distance_kernels.h"
#include "query/distance/double_feet.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>

namespace sqmap::query {

namespace {

using model::ModelView;

using Corners = std::array<Vec3d, 3>;

Corners stored_corners(const ModelView& model, std::uint32_t triangle)
{
    const auto corner = [&](std::uint32_t k) {
        return cast<double>(model::vec3(&model.vertices[3 * std::size_t{model::triangle_vertex(model, triangle, k)}]));
    };
    return {corner(0), corner(1), corner(2)};
}

void put_input_corners(const ModelView& model, std::uint32_t triangle, Corners& corners)
{
    for (std::uint32_t k = 0; k < 3; ++k) corners[k] = model::input_vertex(model, model::triangle_vertex(model, triangle, k));
}

/// The point of triangle `to` that has the barycentric coordinates of the point of triangle `from` nearest to p.
Vec3d carried_over(Vec3d p, const Corners& from, const Corners& to)
{
    const Vec3d e = from[1] - from[0], f = from[2] - from[0];
    const Vec3d g = closest_point_on_triangle(p, from[0], from[1], from[2]) - from[0];
    const double ee = dot(e, e), ef = dot(e, f), ff = dot(f, f), ge = dot(g, e), gf = dot(g, f), area = ee * ff - ef * ef;
    double v = 0, w = 0;
    if (area > 0) {
        v = (ff * ge - ef * gf) / area;
        w = (ee * gf - ef * ge) / area;
    } else if (ee >= ff && ee > 0) {
        v = ge / ee;
    } else if (ff > 0) {
        w = gf / ff;
    }
    v = std::clamp(v, 0.0, 1.0);
    w = std::clamp(w, 0.0, 1.0 - v);
    return to[0] + v * (to[1] - to[0]) + w * (to[2] - to[0]);
}

std::uint32_t triangle_of(const ModelView& model, std::uint32_t entry)
{
    const auto triangles = static_cast<std::uint32_t>(model.triangle_part.size());
    return entry < triangles ? entry : model.piece_triangle[entry - triangles];
}

/// The corners of an entry of the hierarchy, in mesh units. A piece is carried over from the stored triangle to the caller's by
/// its barycentric coordinates.
void put_corners(const ModelView& model, std::uint32_t entry, Corners& corners)
{
    const std::uint32_t triangle = triangle_of(model, entry);
    put_input_corners(model, triangle, corners);
    if (triangle == entry) return;
    const Corners whole = corners, stored = stored_corners(model, triangle);
    const float* piece = &model.pieces[9 * std::size_t{entry - model.triangle_part.size()}];
    for (std::size_t k = 0; k < 3; ++k) corners[k] = carried_over(cast<double>(model::vec3(piece + 3 * k)), stored, whole);
}

std::uint32_t entry_at(const ModelView& model, std::size_t i)
{
    const model::DistanceArrays<model::ArrayView>& d = model.distance;
    return d.entries16.empty() ? d.entries32[i] : d.entries16[i];
}

double angle_at(const Corners& t, std::size_t corner)
{
    const Vec3d u = t[(corner + 1) % 3] - t[corner], v = t[(corner + 2) % 3] - t[corner];
    return angle_of(norm(cross(u, v)), dot(u, v));
}

/// The angle that a triangle takes up about a point of its face, of an edge, or a corner.
double weight_of(const Corners& t, unsigned corners)
{
    if (corners == 7) return 2 * std::numbers::pi;
    if (std::popcount(corners) == 2) return std::numbers::pi;
    return angle_at(t, static_cast<std::size_t>(std::countr_zero(corners)));
}

double sum_of(Vec3d v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }

/// A point's leaves in the order in which a search visits them.
class Visited {
public:
    explicit Visited(const NearTriangles& near) : count_(near.count)
    {
        const auto group = [](std::uint32_t word) { return word >> 8 >> k_group_bits; };
        for (std::uint32_t i = 0; i < near.count; ++i) {
            const std::uint32_t word = near.leaves[i];
            std::uint32_t k = i;
            for (; k > 0 &&
                   (group(leaves_[k - 1]) < group(word) || (group(leaves_[k - 1]) == group(word) && leaves_[k - 1] > word));
                 --k)
                leaves_[k] = leaves_[k - 1];
            leaves_[k] = word;
        }
    }
    [[nodiscard]] const std::uint32_t* begin() const { return leaves_; }
    [[nodiscard]] const std::uint32_t* end() const { return leaves_ + count_; }

private:
    static_assert(model::k_hierarchy_leaf == 8 && model::k_hierarchy_width == 16);
    static constexpr int k_group_bits = 4;

    std::uint32_t count_, leaves_[NearTriangles::k_capacity];
};

/// Finds the nearest triangles of many points: pairs wait until a vector kernel measures them together.
class DoubleSearch {
public:
    DoubleSearch(const ModelView& model, std::span<const Vec3d> points, std::span<NearestInDouble> found)
        : model_(model), points_(points), found_(found)
    {
        const model::Header& h = model.header;
        origin_ = {h.origin[0], h.origin[1], h.origin[2]};
        object_ = sum_of(cast<double>(model::vec3(h.sphere))) + static_cast<double>(h.sphere[3]);
        origin_size_ = sum_of(origin_);
        object_size_ = h.unit * object_;
        touching_ = k_near * static_cast<double>(h.sphere[3]) * h.unit;
    }

    void add(std::size_t point, const NearTriangles& near)
    {
        if (count_ + k_max_pairs > DoubleFeet::k_capacity || waiting_ == k_points) flush();
        const auto first = static_cast<std::uint32_t>(near.entry);
        put(points_[point], first);
        for (const std::uint32_t word : Visited(near)) put_leaf(points_[point], word >> 8, word & 0xffu, first);
        point_[waiting_] = static_cast<std::uint32_t>(point);
        end_[waiting_++] = static_cast<std::uint32_t>(count_);
    }
    void flush()
    {
        if (waiting_ == 0) return;
        feet_.measure(0, count_);
        std::size_t first = 0;
        for (std::size_t i = 0; i < waiting_; ++i) {
            const std::size_t end = end_[i];
            found_[point_[i]] = answer(points_[point_[i]], first, end);
            first = end;
        }
        count_ = waiting_ = 0;
    }
    /// Measures all triangles within reach of the first. @pre no point waits
    void search(std::size_t point, std::uint32_t first)
    {
        struct Visit {
            DoubleSearch& search;
            Vec3d point;
            std::uint32_t first;
            double slack;

            float reach() const
            {
                const DoubleSearch& s = search;
                const double best_sq = *std::min_element(s.feet_.distance_sq, s.feet_.distance_sq + s.count_);
                return static_cast<float>((std::sqrt(best_sq) / s.model_.header.unit + slack) * (1 + 1e-6));
            }
        };
        const Vec3d p = points_[point];
        const double unit = model_.header.unit;
        const Vec3d in_model = (p - origin_) / unit;
        // Pieces are carried over from where they are stored, which rounding moves by as much as vertices. slack: model units,
        // by how much boxes may be farther than they seem.
        Visit visit{*this, p, first, static_cast<double>(k_box_rounding) * (sum_of(in_model) + object_) + tolerance(p) / unit};
        put(p, first);
        feet_.measure(0, count_);
        const auto each = [](void* context, std::uint32_t leaf) {
            const Visit& v = *static_cast<const Visit*>(context);
            v.search.measure_leaf(v.point, leaf, v.first);
            return v.reach();
        };
        visit_leaves(model_, cast<float>(in_model), visit.reach(), each, &visit);
        found_[point] = answer(p, 0, count_);
        count_ = 0;
    }

private:
    static constexpr std::size_t k_max_pairs = 1 + std::size_t{NearTriangles::k_capacity} * model::k_hierarchy_leaf;
    static constexpr std::size_t k_points = 128;
    static constexpr std::size_t k_max_ties = 256;  ///< at more the exact layer says on which side the point is
    static constexpr double k_near = 2e-9;          ///< of the object's radius: up to there the normal is wanted

    void put(const Vec3d& point, std::uint32_t entry)
    {
        Corners t;
        put_corners(model_, entry, t);
        feet_.put(count_, point, t);
        entry_[count_++] = entry;
    }
    /// triangles: a bit for each.
    void put_leaf(const Vec3d& point, std::uint32_t leaf, std::uint32_t triangles, std::uint32_t first)
    {
        for (; triangles != 0; triangles &= triangles - 1) {
            const std::size_t i =
                std::size_t{leaf} * model::k_hierarchy_leaf + static_cast<std::size_t>(std::countr_zero(triangles));
            if (i >= model_.distance.header.entries) break;
            if (const std::uint32_t entry = entry_at(model_, i); entry != first) put(point, entry);
        }
    }
    void measure_leaf(const Vec3d& point, std::uint32_t leaf, std::uint32_t first)
    {
        if (count_ + model::k_hierarchy_leaf > DoubleFeet::k_capacity) leave_out_far(point);
        const std::size_t before = count_;
        put_leaf(point, leaf, 0xff, first);
        if (count_ > before) feet_.measure(before, count_ - before);
    }
    void leave_out_far(const Vec3d& point)
    {
        const double limit_sq = limit_of(point, 0, count_);
        std::size_t left = 0;
        for (std::size_t i = 0; i < count_ && left < k_max_ties + 1; ++i) {
            if (!(feet_.distance_sq[i] <= limit_sq)) continue;
            feet_.put(left, point, feet_.triangle_of(i));
            entry_[left++] = entry_[i];
        }
        count_ = left;
        feet_.measure(0, count_);
    }

    /// Mesh units: what double tells of distances.
    double tolerance(Vec3d point) const { return 1e-15 * (sum_of(point) + origin_size_ + object_size_); }
    /// The squared distance up to which triangles tie for the nearest.
    double limit_of(Vec3d point, std::size_t first, std::size_t end) const
    {
        const double limit = std::sqrt(*std::min_element(feet_.distance_sq + first, feet_.distance_sq + end)) + tolerance(point);
        return limit * limit;
    }

    /// The triangle's number in the input, and where that has none its own behind them.
    std::uint64_t rank(std::uint32_t triangle) const
    {
        return (std::uint64_t{model_.input.source_triangle[triangle]} << 32) | triangle;
    }

    /// The nearest of the pairs of one point.
    NearestInDouble answer(const Vec3d& point, std::size_t first, std::size_t end) const
    {
        constexpr double k_alike = 1e-12, k_clear = 1e-9;
        const double limit_sq = limit_of(point, first, end);
        NearestInDouble out;
        std::size_t named = end, ties = 0;
        bool is_on_faces = true, is_above = true, is_below = true;
        double best_facing = -1, least = INFINITY;
        for (std::size_t i = first; i < end; ++i) {
            if (!(feet_.distance_sq[i] <= limit_sq)) continue;
            ++ties;
            const double height = feet_.height[i], away = feet_.distance[i], facing = feet_.facing[i];
            least = std::min(least, away);
            is_on_faces = is_on_faces && feet_.corners[i] == 7;
            is_above = is_above && height > 2 * k_clear * away;
            is_below = is_below && height < -2 * k_clear * away;
            const std::uint32_t triangle = triangle_of(model_, entry_[i]);
            if (named != end &&
                (facing < best_facing - k_alike || (facing <= best_facing + k_alike && rank(triangle) > rank(out.triangle))))
                continue;
            best_facing = std::max(best_facing, facing);
            named = i;
            out.triangle = triangle;
        }
        out.distance = least;
        if (named == end) return out;  // coordinates that overflow
        out.offset = feet_.offset_of(named);
        // If all see the point from one side, any weighted mean of them does.
        const double share = is_above ? 1 : is_below ? -1 : weigh(first, end, limit_sq, out.normal);
        if ((is_above || is_below) && out.distance <= touching_) (void)weigh(first, end, limit_sq, out.normal);
        // Pieces meet where float stores their corners, so that of those about an edge one alone may tie.
        const bool is_whole = model_.piece_triangle.empty() || is_on_faces;
        const bool says = ties <= k_max_ties && is_whole && std::abs(share) > k_clear && out.distance > 4 * tolerance(point);
        if (says) out.side = share > 0 ? 1 : -1;
        return out;
    }

    /// The unit mean of the normals of those within the limit, weighted by angles; returns the point's height by them as a share
    /// of its distance.
    double weigh(std::size_t first, std::size_t end, double limit_sq, Vec3d& normal) const
    {
        normal = {};
        double sum = 0, sizes = 0;
        for (std::size_t i = first; i < end; ++i) {
            if (!(feet_.distance_sq[i] <= limit_sq)) continue;
            const Corners t = feet_.triangle_of(i);
            const double weight = weight_of(t, static_cast<unsigned>(feet_.corners[i]));
            normal += weight * normal_of_triangle(t[0], t[1], t[2]);
            sum += weight * feet_.height[i];
            sizes += weight * feet_.distance[i];
        }
        if (const double length = norm(normal); length > 0) normal = normal / length;
        return sizes > 0 ? sum / sizes : 0;
    }

    const ModelView& model_;
    std::span<const Vec3d> points_;
    std::span<NearestInDouble> found_;
    Vec3d origin_;
    double object_;                     ///< model units: the size of its coordinates
    double origin_size_, object_size_;  ///< mesh units
    double touching_;
    std::size_t count_ = 0, waiting_ = 0;
    std::uint32_t point_[k_points], end_[k_points];  ///< of those that wait, and behind its last pair
    std::uint32_t entry_[DoubleFeet::k_capacity];
    DoubleFeet feet_;
};

}  // namespace

void nearest_in_double(const ModelView& model, std::span<const Vec3d> points, std::span<const NearTriangles> near,
                       std::span<NearestInDouble> found) noexcept
{
    DoubleSearch search(model, points, found);
    for (std::size_t i = 0; i < points.size(); ++i)
        if (near[i].entry >= 0 && near[i].count != NearTriangles::k_too_many) search.add(i, near[i]);
    search.flush();
    for (std::size_t i = 0; i < points.size(); ++i)
        if (near[i].entry >= 0 && near[i].count == NearTriangles::k_too_many)
            search.search(i, static_cast<std::uint32_t>(near[i].entry));
}

}  // namespace sqmap::query
