// J. A. Baerentzen, H. Aanaes, "Signed distance computation using the angle weighted pseudonormal", IEEE TVCG 11(3), 2005: of all
// triangles that share the nearest point, the normals weighted by their angles there say on which side the point is.
#include "query/distance/double_search.h"

#include "math/triangle.h"
#include "math/trigonometry.h"
#include "model/flags.h"
#include "query/distance/distance_kernels.h"

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

/// Writes the corners of an entry of the hierarchy, in mesh units, to where the tie keeps them, because copying them from a
/// return value costs as much as finding the nearest point. The function carries a piece over from the stored triangle to the
/// caller's by its barycentric coordinates.
void put_corners(const ModelView& model, std::uint32_t entry, Corners& corners)
{
    const std::uint32_t triangle = triangle_of(model, entry);
    put_input_corners(model, triangle, corners);
    if (triangle == entry) return;
    const Corners whole = corners, stored = stored_corners(model, triangle);
    const float* piece = &model.pieces[9 * std::size_t{entry - model.triangle_part.size()}];
    for (std::size_t k = 0; k < 3; ++k) corners[k] = carried_over(cast<double>(model::vec3(piece + 3 * k)), stored, whole);
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

/// The triangles that are as near as double tells.
class Ties {
public:
    /// entry: is measured first.
    Ties(const ModelView& model, Vec3d point, std::uint32_t entry) : model_(model), point_(point), first_(entry)
    {
        const model::Header& h = model.header;
        origin_ = {h.origin[0], h.origin[1], h.origin[2]};
        object_ = sum_of(cast<double>(model::vec3(h.sphere))) + static_cast<double>(h.sphere[3]);
        tolerance_ = 1e-15 * (sum_of(point) + sum_of(origin_) + h.unit * object_);
        measure(entry);
    }

    /// The nearest of these triangles, in the order in which a search visits them.
    [[nodiscard]] NearestInDouble nearest_of(const NearTriangles& near)
    {
        std::uint32_t leaves[NearTriangles::k_capacity];
        const auto group = [](std::uint32_t word) { return word >> 8 >> k_group_bits; };
        for (std::uint32_t i = 0; i < near.count; ++i) {
            const std::uint32_t word = near.leaves[i];
            std::uint32_t k = i;
            for (; k > 0 && (group(leaves[k - 1]) < group(word) || (group(leaves[k - 1]) == group(word) && leaves[k - 1] > word));
                 --k)
                leaves[k] = leaves[k - 1];
            leaves[k] = word;
        }
        for (const std::uint32_t word : std::span(leaves, near.count)) measure_leaf(word >> 8, word & 0xffu);
        return answer();
    }
    [[nodiscard]] NearestInDouble nearest()
    {
        const double unit = model_.header.unit;
        const Vec3d in_model = (point_ - origin_) / unit;
        // Pieces are carried over from where they are stored, which rounding moves by as much as vertices.
        slack_ = static_cast<double>(k_box_rounding) * (sum_of(in_model) + object_) + tolerance_ / unit;
        const auto visit = [](void* ties, std::uint32_t leaf) {
            static_cast<Ties*>(ties)->measure_leaf(leaf, 0xff);
            return static_cast<Ties*>(ties)->reach();
        };
        visit_leaves(model_, cast<float>(in_model), reach(), visit, this);
        return answer();
    }

private:
    struct Tie {
        std::uint32_t entry;
        unsigned corners;
        Vec3d offset;
        double distance_sq;
        Corners at;
    };
    /// A triangle's normal, zero without an area, and the point's height above it.
    struct Side {
        Vec3d normal;
        double height;
    };
    static Side side_of(const Tie& tie)
    {
        const Vec3d across = cross(tie.at[1] - tie.at[0], tie.at[2] - tie.at[0]);
        const double area = norm(across);
        const Vec3d normal = area > 0 ? across / area : Vec3d{};
        return {normal, -dot(tie.offset, normal)};
    }
    static double sum_of(Vec3d v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }

    Tie* ties() { return reinterpret_cast<Tie*>(memory_); }
    const Tie* ties() const { return reinterpret_cast<const Tie*>(memory_); }

    float reach() const { return static_cast<float>((std::sqrt(best_sq_) / model_.header.unit + slack_) * (1 + 1e-6)); }

    /// triangles: a bit for each.
    void measure_leaf(std::uint32_t leaf, std::uint32_t triangles)
    {
        const model::DistanceArrays<model::ArrayView>& d = model_.distance;
        const std::size_t first = std::size_t{leaf} * model::k_hierarchy_leaf;
        for (; triangles != 0; triangles &= triangles - 1) {
            const std::size_t i = first + static_cast<std::size_t>(std::countr_zero(triangles));
            if (i >= d.header.entries) break;
            const std::uint32_t entry = d.entries16.empty() ? d.entries32[i] : d.entries16[i];
            if (entry != first_) measure(entry);
        }
    }

    void measure(std::uint32_t entry)
    {
        Tie& trial = ties()[count_];
        put_corners(model_, entry, trial.at);
        const TriangleFoot foot = foot_on_triangle(point_, trial.at[0], trial.at[1], trial.at[2]);
        const Vec3d offset = foot.point - point_;
        const double distance_sq = norm_sq(offset);
        if (!(distance_sq <= limit_sq_)) return;
        trial.entry = entry;
        trial.corners = foot.corners;
        trial.offset = offset;
        trial.distance_sq = distance_sq;
        if (distance_sq < best_sq_) {
            best_sq_ = distance_sq;
            const double limit = std::sqrt(distance_sq) + tolerance_;
            limit_sq_ = limit * limit;
            const auto is_farther = [this](const Tie& tie) { return tie.distance_sq > limit_sq_; };
            count_ = static_cast<std::size_t>(std::remove_if(ties(), ties() + count_, is_farther) - ties());
            if (&ties()[count_] != &trial) ties()[count_] = trial;
        }
        if (count_ < k_max_ties)
            ++count_;
        else
            is_full_ = true;
    }

    /// The triangle's number in the input, and where that has none its own behind them.
    std::uint64_t rank(std::uint32_t triangle) const
    {
        return (std::uint64_t{model_.input.source_triangle[triangle]} << 32) | triangle;
    }

    NearestInDouble answer() const
    {
        constexpr double k_alike = 1e-12, k_clear = 1e-9;
        NearestInDouble out;
        out.distance = std::sqrt(best_sq_);
        const Tie* named = nullptr;
        bool is_on_faces = true, is_above = true, is_below = true;
        double best_facing = -1;
        for (const Tie& tie : std::span(ties(), count_)) {
            const double height = side_of(tie).height, away = std::sqrt(tie.distance_sq);
            is_on_faces = is_on_faces && tie.corners == 7;
            is_above = is_above && height > 2 * k_clear * away;
            is_below = is_below && height < -2 * k_clear * away;
            const double facing = away > 0 ? std::abs(height) / away : 0;
            const std::uint32_t triangle = triangle_of(model_, tie.entry);
            if (named != nullptr &&
                (facing < best_facing - k_alike || (facing <= best_facing + k_alike && rank(triangle) > rank(out.triangle))))
                continue;
            best_facing = std::max(best_facing, facing);
            named = &tie;
            out.triangle = triangle;
        }
        if (named == nullptr) return out;  // coordinates that overflow
        out.offset = named->offset;
        // If all see the point from one side, any weighted mean of them does.
        const double share = is_above ? 1 : is_below ? -1 : weigh(out.normal);
        if ((is_above || is_below) && out.distance <= k_near * static_cast<double>(model_.header.sphere[3]) * model_.header.unit)
            (void)weigh(out.normal);
        // Pieces meet where float stores their corners, so that of those about an edge one alone may tie.
        const bool is_whole = model_.piece_triangle.empty() || is_on_faces;
        const bool says = !is_full_ && is_whole && std::abs(share) > k_clear && out.distance > 4 * tolerance_;
        if (says) out.side = share > 0 ? 1 : -1;
        return out;
    }

    /// The unit mean of the normals, weighted by angles; returns the point's height by them as a share of its distance.
    double weigh(Vec3d& normal) const
    {
        normal = {};
        double sum = 0, sizes = 0;
        for (const Tie& tie : std::span(ties(), count_)) {
            const Side side = side_of(tie);
            const double weight = weight_of(tie.at, tie.corners);
            normal += weight * side.normal;
            sum += weight * side.height;
            sizes += weight * std::sqrt(tie.distance_sq);
        }
        if (const double length = norm(normal); length > 0) normal = normal / length;
        return sizes > 0 ? sum / sizes : 0;
    }

    static_assert(model::k_hierarchy_leaf == 8 && model::k_hierarchy_width == 16);
    static constexpr int k_group_bits = 4;
    static constexpr double k_near = 2e-9;          ///< of the object's radius: up to there the normal is wanted
    static constexpr std::size_t k_max_ties = 256;  ///< at more the exact layer says on which side the point is

    const ModelView& model_;
    Vec3d point_;
    std::uint32_t first_;
    Vec3d origin_{};
    double object_ = 0;     ///< model units: the size of its coordinates
    double tolerance_ = 0;  ///< mesh units: what double tells of distances
    double slack_ = 0;      ///< model units: by how much boxes may be farther than they seem
    double best_sq_ = INFINITY, limit_sq_ = INFINITY;
    bool is_full_ = false;
    std::size_t count_ = 0;
    alignas(Tie)
        std::byte memory_[(k_max_ties + 1) * sizeof(Tie)];  ///< that nobody clears: most points have one. The last is for trials
};

}  // namespace

NearestInDouble nearest_in_double(const ModelView& model, Vec3d point, const NearTriangles& near) noexcept
{
    Ties ties(model, point, static_cast<std::uint32_t>(near.entry));
    return near.count == NearTriangles::k_too_many ? ties.nearest() : ties.nearest_of(near);
}

}  // namespace sqmap::query
