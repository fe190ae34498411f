// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, section 4.2, beyond its layers: depth to the mesh's
// own triangles. A cell of the locator lists every triangle that can be nearest to a point of it. The ball about a point up to
// the nearest one holds no boundary, so what the point sees there is the side that it is on.
#include "exact_layer.h"

#include "math/triangle.h"
#include "model/candidate_lists.h"
#include "model/flags.h"
#include "query/chart/point_verdict.h"
#include "query/locator/locate_point.h"
#include "query/superquadric/layer_one.h"
#include "sqmap/math/assert.h"

#include <algorithm>
#include <cmath>

namespace sqmap::query {

namespace {

using model::ModelView;

/// A cell's list, or all of the model's triangles.
struct Candidates {
    const ModelView& model;
    model::CandidateList list;  ///< empty: all

    template <class Visit>
    void each(Visit&& visit) const
    {
        if (list.count > 0) return list.each(visit);
        for (std::uint32_t t = 0; t < model.triangle_part.size(); ++t) visit(t);
    }
};

struct Piece {
    Vec3d a, b, c;
};

Piece piece_at(const float* corners)
{
    const auto corner = [&](int k) { return cast<double>(model::vec3(corners + 3 * k)); };
    return {corner(0), corner(1), corner(2)};
}

Piece triangle_at(const ModelView& model, std::uint32_t triangle)
{
    const auto corner = [&](std::uint32_t k) {
        return cast<double>(
            model::vec3(model.vertices.data() + 3 * static_cast<std::size_t>(model::triangle_vertex(model, triangle, k))));
    };
    return {corner(0), corner(1), corner(2)};
}

/// visit(piece, across) for what of a triangle is boundary; across: its normal, not unit.
template <class Visit>
void each_visible(const ModelView& model, std::uint32_t triangle, Visit&& visit)
{
    const std::uint16_t flags = model.triangle_part[triangle];
    if (model::is_buried(flags)) return;
    const Piece whole = triangle_at(model, triangle);
    const Vec3d across = cross(whole.b - whole.a, whole.c - whole.a);
    if (!model::is_crossed(flags)) {
        visit(whole, across);
        return;
    }
    const auto [first, last] = std::equal_range(model.piece_triangle.begin(), model.piece_triangle.end(), triangle);
    for (auto it = first; it != last; ++it)
        visit(piece_at(model.pieces.data() + 9 * (it - model.piece_triangle.begin())), across);
}

/// True where the piece of a triangle is lower than the height. Rounding of its corners may lift such a sliver before its
/// neighbours.
bool is_sliver(const Piece& t, double height)
{
    const Vec3d e[3] = {t.b - t.a, t.c - t.b, t.a - t.c};
    const double longest_sq = std::max({norm_sq(e[0]), norm_sq(e[1]), norm_sq(e[2])});
    return norm_sq(cross(e[0], e[1])) < height * height * longest_sq;
}

struct NearestPiece {
    double distance_sq = INFINITY;
    Vec3d point{}, across{};
    std::uint32_t triangle = 0;
};

NearestPiece nearest_of(const Candidates& candidates, Vec3d p)
{
    NearestPiece best;
    candidates.each([&](std::uint32_t t) {
        each_visible(candidates.model, t, [&](const Piece& piece, Vec3d across) {
            // No point of it is nearer than its plane.
            const double height = dot(across, p - piece.a);
            if (height * height > best.distance_sq * norm_sq(across)) return;
            const Vec3d q = closest_point_on_triangle(p, piece.a, piece.b, piece.c);
            const double distance_sq = norm_sq(q - p);
            // A tie goes to the triangle with the highest number, so the order of the list does not matter.
            if (distance_sq < best.distance_sq || (distance_sq == best.distance_sq && t > best.triangle))
                best = {distance_sq, q, across, t};
        });
    });
    return best;
}

/// The fraction of the segment from p to q at which it meets a triangle, from 0 to 1; above 1: it meets none. Borders count.
double meeting(Vec3d p, Vec3d q, const Piece& t)
{
    constexpr double k_border = 1e-9;
    const Vec3d e1 = t.b - t.a, e2 = t.c - t.a, d = q - p, h = cross(d, e2);
    const double det = dot(e1, h);
    if (det == 0) return 2;
    const Vec3d s = p - t.a, k = cross(s, e1);
    const double u = dot(s, h) / det, v = dot(d, k) / det, along = dot(e2, k) / det;
    return u >= -k_border && v >= -k_border && u + v <= 1 + k_border && along >= 0 ? along : 2;
}

/// True where p is below the face that it sees at the nearest boundary point. Where two triangles meet, the sum of their normals
/// decides. Elsewhere a ray from p aims a hair beside the nearest point, at the triangle that faces p most; the first triangle
/// that the ray meets decides.
bool is_below(const Candidates& candidates, Vec3d p, const NearestPiece& nearest)
{
    const double size = static_cast<double>(candidates.model.header.sphere[3]);
    const double hair = 1e-6 * size, distance = std::sqrt(nearest.distance_sq);
    if (!(distance > 1e-12 * size)) return true;
    const Vec3d to_nearest = nearest.point - p;
    constexpr double k_face_on = 1 - 1e-9;
    if (std::abs(dot(nearest.across, to_nearest)) > k_face_on * norm(nearest.across) * distance)
        return dot(nearest.across, to_nearest) > 0;

    Vec3d aim = nearest.point, across = nearest.across, sum{};
    double largest = -3;
    std::uint32_t triangles = 0, last = 0;  // as near, and the last of them
    const double reach_sq = (distance + hair) * (distance + hair);
    candidates.each([&](std::uint32_t t) {
        each_visible(candidates.model, t, [&](const Piece& piece, Vec3d normal) {
            const double height = dot(normal, p - piece.a);
            if (height * height > reach_sq * norm_sq(normal)) return;
            const Vec3d q = closest_point_on_triangle(p, piece.a, piece.b, piece.c);
            if (!(norm_sq(q - p) <= reach_sq)) return;
            const Vec3d unit = normalized(normal);
            if (triangles == 0 || t != last) {
                ++triangles;
                last = t;
                sum += unit;
            }
            const double facing = std::abs(dot(unit, q - p)) / norm(q - p) - (is_sliver(piece, hair) ? 2 : 0);
            if (!(facing > largest)) return;
            largest = facing;
            const Vec3d inwards = (piece.a + piece.b + piece.c) / 3.0 - q;
            aim = q + std::min(0.1, hair / std::max(norm(inwards), hair)) * inwards;
            across = normal;
        });
    });
    if (triangles == 2) return dot(sum, to_nearest) > 0;
    double first = 1 - 1e-12;
    candidates.each([&](std::uint32_t t) {
        each_visible(candidates.model, t, [&](const Piece& piece, Vec3d normal) {
            const double along = meeting(p, aim, piece);
            if (!(along < first)) return;
            first = along;
            across = normal;
        });
    });
    return dot(across, aim - p) > 0;
}

ModelContact contact_at(const ModelView& model, Vec3f point, const NearestPiece& nearest)
{
    ModelContact contact;
    contact.contact = true;
    contact.certain = true;
    contact.part = static_cast<std::int32_t>(model::part_of(model.triangle_part[nearest.triangle]));
    if (model::is_made_up(model.triangle_part[nearest.triangle])) contact.status |= k_made_up;
    contact.depth = static_cast<float>(std::sqrt(nearest.distance_sq));
    contact.witness = cast<float>(nearest.point);
    // Away from the surface the way out is the way to the nearest point; on it, the surface's own normal.
    const Vec3d direction = contact.depth > 1e-4f * model.header.sphere[3] ? nearest.point - cast<double>(point) : nearest.across;
    contact.normal = cast<float>(normalized(direction));
    return contact;
}

ModelContact answer(const Candidates& candidates, Vec3f point, bool inside)
{
    const Vec3d p = cast<double>(point);
    const NearestPiece nearest = nearest_of(candidates, p);
    if (!(nearest.distance_sq < INFINITY)) return free_at(point);
    const double rounding = static_cast<double>(k_unproven * candidates.model.header.sphere[3]);
    const bool is_certain = nearest.distance_sq > rounding * rounding;
    if (!inside && !is_below(candidates, p, nearest)) return free_at(point, is_certain);
    ModelContact contact = contact_at(candidates.model, point, nearest);
    contact.certain = is_certain;
    return contact;
}

/// Some part may hold the point.
bool is_held(const ModelView& model, Vec3f point)
{
    if (!model::has_central_maps(model)) return query_layer_one(model, point).part >= 0;
    return verdict_by_charts(model, point, Layer::Three, 0).part >= 0;
}

}  // namespace

ModelContact query_exact_in(const ModelView& model, Vec3f point, std::size_t brick, std::uint32_t cell, bool inside) noexcept
{
    return answer({model, model::candidate_list(model, brick, cell)}, point, inside);
}

ModelContact query_exact(const ModelView& model, Vec3f point) noexcept
{
    SQMAP_ASSERT(model::has_exact(model));
    if (!model::has_locator(model)) {
        // Behind a surface that bounds nothing, what no part holds is free.
        if (model.header.solid == 0 && !is_held(model, point)) return free_at(point);
        return answer({model, {}}, point, false);
    }
    const LocatedCell at = locate(model, point);
    const bool inside = at.cell.kind() == model::LocatorCellKind::Inside;
    return at.is_free ? free_at(point) : query_exact_in(model, point, at.brick, at.within, inside);
}

ModelContact nearest_in_model(const ModelView& model, Vec3f point, const ModelContact& from) noexcept
{
    SQMAP_ASSERT(model::has_exact(model));
    const auto finite = [](Vec3f p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); };
    if (!finite(point) || !finite(from.witness) || !finite(from.normal)) return {};
    constexpr int k_rounds = 6;
    // The list of a surface point's cell holds its triangle, so that each round ends no farther away than the one before.
    const float hair = 1e-5f * model.header.sphere[3];  // below the surface: a cell that touches it from outside lists nothing
    const Vec3d p = cast<double>(point);
    NearestPiece best;
    Vec3f at = from.witness - hair * from.normal;
    for (int round = 0; round < k_rounds; ++round) {
        Candidates candidates{model, {}};
        if (model::has_locator(model)) {
            const LocatedCell cell = locate(model, at);
            if (cell.is_free) break;
            candidates.list = model::candidate_list(model, cell.brick, cell.within);
        }
        const NearestPiece found = nearest_of(candidates, p);
        if (!(found.distance_sq < best.distance_sq)) break;
        best = found;
        at = cast<float>(best.point - static_cast<double>(hair) * normalized(best.across));
    }
    if (!(best.distance_sq < INFINITY)) return {};
    ModelContact contact = contact_at(model, point, best);
    contact.normal = cast<float>(normalized(best.across));
    contact.certain = false;
    return contact;
}

}  // namespace sqmap::query
