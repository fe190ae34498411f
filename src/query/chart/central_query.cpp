// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, section 4.2, on the central map.
#include "central_query.h"

#include "model/central_map.h"
#include "query/chart/point_verdict.h"
#include "query/layer.h"
#include "sqmap/math/assert.h"

#include <algorithm>
#include <cmath>

namespace sqmap::query {

namespace {

using namespace model;  // the chart and its cells
using model::ModelView;
using model::Part;

/// Nearest surface found so far.
struct Nearest {
    float distance_sq = INFINITY;
    Vec3f point{};
    Vec3f normal{};
    std::int32_t part = -1;
};

/// Up to which squared distance surface is looked for.
struct Reach {
    float distance_sq = INFINITY;

    float within(const Nearest& best) const { return std::min(distance_sq, best.distance_sq); }
};

float sphere_gap(const Part& part, Vec3f p)
{
    const float gap = norm(p - model::vec3(part.sphere)) - part.sphere[3];
    return gap > 0.f ? gap : 0.f;
}

/// Least squared distance, in model units, from x to the part of the chart where s, t and rho lie in given ranges.
/// a: the axes; sound because the chart frame is orthogonal: offsets scale by a along each axis.
float frustum_distance_sq(int face, const float* a, Vec3f x, float s0, float s1, float t0, float t1, float rho0, float rho1)
{
    const int m = face_axis(face), u = (m + 1) % 3, v = (m + 2) % 3;
    const auto gap = [](float value, float lo, float hi) { return value < lo ? lo - value : (value > hi ? value - hi : 0.f); };
    const float major = face_sign(face) * x[m];
    const float gm = a[m] * gap(major, rho0, rho1);
    const float gu = a[u] * gap(x[u], std::min(s0 * rho0, s0 * rho1), std::max(s1 * rho0, s1 * rho1));
    const float gv = a[v] * gap(x[v], std::min(t0 * rho0, t0 * rho1), std::max(t1 * rho0, t1 * rho1));
    return gm * gm + gu * gu + gv * gv;
}

/// Closest point of a stored sheet to x: a few steps, each to the foot of x on the tangent plane, kept inside the leaf.
/// Returns the squared distance in model units; foot in the chart frame, plane the outward-in-rho plane vector.
float sheet_distance_sq(const Leaf& leaf, int sheet, int face, const float* a, Vec3f x, Vec3f& foot, Vec3f& plane)
{
    const int m = face_axis(face), iu = (m + 1) % 3, iv = (m + 2) % 3;
    const float sign = face_sign(face);
    const float major = sign * x[m];
    float s = leaf.s0 + 0.5f * leaf.size, t = leaf.t0 + 0.5f * leaf.size;
    if (major > 1e-6f) {
        s = x[iu] / major;
        t = x[iv] / major;
    }
    keep_in_leaf(leaf, s, t);
    SheetValue value{};
    for (int step = 0; step < 3; ++step) {
        value = sheet_value(leaf, sheet, s, t);
        const Vec3f n = plane = plane_vector(face, s, t, value);
        const Vec3f scaled{n.x / (a[0] * a[0]), n.y / (a[1] * a[1]), n.z / (a[2] * a[2])};
        const float length_sq = dot(n, scaled);
        if (!(length_sq > 0.f)) break;
        const Vec3f y = x + ((1.f - dot(n, x)) / length_sq) * scaled;
        const float y_major = sign * y[m];
        if (!(y_major > 1e-6f)) break;
        s = y[iu] / y_major;
        t = y[iv] / y_major;
        keep_in_leaf(leaf, s, t);
    }
    value = sheet_value(leaf, sheet, s, t);
    const float rho = 1.f / std::max(value.w, 1e-6f);
    foot = rho * face_direction(face, s, t);
    const Vec3f d{a[0] * (foot.x - x.x), a[1] * (foot.y - x.y), a[2] * (foot.z - x.z)};
    return norm_sq(d);
}

constexpr float k_slack = 1e-5f;  ///< far above rounding: what is passed over cannot be the nearest

/// True where the rays through a square of a face are proven to come no nearer than a distance: the rays through one of its sides
/// lie in a plane, and all others beyond it.
bool rays_miss(int face, const float* a, Vec3f x, const Square& square, float distance_sq)
{
    const int m = face_axis(face), u = (m + 1) % 3, v = (m + 2) % 3;
    const float major = face_sign(face) * x[m];
    const auto is_beyond = [&](float side, float slope, int axis) {
        const float off = side * (slope * major - x[axis]) - k_slack * (std::abs(slope * major) + std::abs(x[axis]));
        const float steep = slope / a[m], flat = 1.f / a[axis];
        return off > 0.f && off * off >= (1.f + k_slack) * distance_sq * (steep * steep + flat * flat);
    };
    return is_beyond(1.f, square.s0, u) || is_beyond(-1.f, square.s0 + square.size, u) || is_beyond(1.f, square.t0, v) ||
           is_beyond(-1.f, square.t0 + square.size, v);
}

/// True where a sheet is proven to come no nearer than a distance. Cells on silhouettes have bands from here to the far side of
/// the part, in which each sheet is a small piece somewhere.
bool sheet_misses(const Leaf& leaf, int sheet, int face, const float* a, Vec3f x, float distance_sq)
{
    if (leaf.kind == CellKind::Single) return false;  // the leaf's band is the sheet's own
    float lo, hi;
    if (leaf.bilinear) {
        const std::uint16_t* r = bilinear_sheet(leaf.record, sheet);
        const auto [least, largest] = std::minmax({r[0], r[1], r[2], r[3]});
        lo = leaf.range.decode(least);
        hi = leaf.range.decode(largest);
    } else {
        const float s = leaf.s0 + 0.5f * leaf.size, t = leaf.t0 + 0.5f * leaf.size;
        const SheetValue value = sheet_value(leaf, sheet, s, t);
        const float half = 0.5f * leaf.size * (std::abs(value.ws) + std::abs(value.wt));
        lo = value.w - half;
        hi = value.w + half;
        // The sheet is flat: no point of it is nearer than its plane.
        const Vec3f n = plane_vector(face, s, t, value), over{n.x / a[0], n.y / a[1], n.z / a[2]};
        const float rounding = k_slack * (1.f + std::abs(n.x * x.x) + std::abs(n.y * x.y) + std::abs(n.z * x.z));
        const float off = std::abs(1.f - dot(n, x)) - rounding;
        if (off > 0.f && off * off >= (1.f + k_slack) * distance_sq * norm_sq(over)) return true;
    }
    if (!(hi > 1e-6f)) return false;
    return frustum_distance_sq(face, a, x, leaf.s0, leaf.s0 + leaf.size, leaf.t0, leaf.t0 + leaf.size, (1.f - k_slack) / hi,
                               (1.f + k_slack) / std::max(lo, 1e-6f)) >= (1.f + k_slack) * distance_sq;
}

/// Offers a stored sheet as nearest surface.
void offer_sheet(const CentralMap& map, const Part& part, std::int32_t index, const Leaf& leaf, int sheet, int face, Vec3f x,
                 Nearest& best)
{
    if (sheet_misses(leaf, sheet, face, part.a, x, best.distance_sq)) return;
    Vec3f foot, plane;
    const float distance_sq = sheet_distance_sq(leaf, sheet, face, part.a, x, foot, plane);
    if (!(distance_sq < best.distance_sq)) return;
    const bool exits = leaf.centre_inside == ((sheet & 1) == 0);
    const Vec3f n = normalized(map.direction_from_chart_frame(plane));
    best = {distance_sq, map.from_chart_frame(foot), exits ? n : -n, index};
}

/// Least squared distance, model units, from x to the part's domain, which holds all of its own surface.
float domain_distance_sq(const Part& part, Vec3f x)
{
    float sum = 0.f;
    for (int k = 0; k < 3; ++k) {
        const float gap = part.a[k] * std::max(std::max(part.chart_lo[k] - x[k], x[k] - part.chart_hi[k]), 0.f);
        sum += gap * gap;
    }
    return sum;
}

/// A bound before the search: from the cell on the point's own ray to the cell around what was found there, while that
/// comes nearer. offer_cell(face, column, row) offers what a cell holds.
template <class Offer>
void descend(const CentralMap& map, Vec3f x, const Nearest& best, Offer&& offer_cell)
{
    ChartPoint q = to_chart(x);
    for (int step = 0; step < 6; ++step) {
        const float before = best.distance_sq;
        offer_cell(q.face, map.column_of(q.s), map.column_of(q.t));
        if (!(best.distance_sq < before)) return;
        q = to_chart(map.to_chart_frame(best.point));
        // The foot of the point on the plane there, which may lie over another cell.
        const Leaf leaf = map.leaf_at(q.face, q.s, q.t);
        if (leaf.sheets == 0) return;
        const SheetValue value = sheet_value(leaf, 0, q.s, q.t);
        const Vec3f n = plane_vector(q.face, q.s, q.t, value);
        const Vec3f scaled = map.over_axes_sq(n);
        const float length_sq = dot(n, scaled);
        if (!(length_sq > 0.f)) return;
        q = to_chart(x + ((1.f - dot(n, x)) / length_sq) * scaled);
    }
}

/// Visits every base cell that may hold a surface nearer than best, pyramid blocks first.
template <class Visit>
void each_near_cell(const CentralMap& map, const Part& part, Vec3f x, const Reach& reach, const Nearest& best, Visit&& visit)
{
    const int blocks = map.base() / model::k_block;
    const float block_size = map.cell_size() * static_cast<float>(model::k_block);
    for (int face = 0; face < model::k_faces; ++face)
        for (int row = 0; row < blocks; ++row)
            for (int column = 0; column < blocks; ++column) {
                const model::Block block = map.block(face, column, row);
                if (block.lo > block.hi) continue;
                const float s0 = -1.f + block_size * static_cast<float>(column), t0 = -1.f + block_size * static_cast<float>(row);
                const float rho0 = 1.f / map.decode(block.hi), rho1 = 1.f / std::max(map.decode(block.lo), 1e-6f);
                if (!(frustum_distance_sq(face, part.a, x, s0, s0 + block_size, t0, t0 + block_size, rho0, rho1) <
                      reach.within(best)))
                    continue;
                for (int r = row * model::k_block; r < (row + 1) * model::k_block; ++r)
                    for (int c = column * model::k_block; c < (column + 1) * model::k_block; ++c) visit(face, c, r);
            }
}

bool leaf_is_near(const Leaf& leaf, int face, const float* a, Vec3f x, float distance_sq)
{
    if (leaf.sheets == 0 || leaf.foreign) return false;
    float lo, hi;
    leaf_band(leaf, lo, hi);
    if (!(hi > 0.f)) return false;
    return frustum_distance_sq(face, a, x, leaf.s0, leaf.s0 + leaf.size, leaf.t0, leaf.t0 + leaf.size, 1.f / hi,
                               1.f / std::max(lo, 1e-6f)) < distance_sq;
}

/// Nearest stored surface of one part. refined: Layer 3; else Layer 2 reads the base samples. reach: what is found nearer is the
/// nearest; what is farther may not be.
void nearest_on_map(const ModelView& model, std::int32_t index, Vec3f p, bool refined, const Reach& reach, Nearest& best)
{
    const Part& part = model.parts[static_cast<std::size_t>(index)];
    const CentralMap map(model, part);
    const Vec3f x = map.to_chart_frame(p);
    if (!(domain_distance_sq(part, x) < reach.within(best))) return;
    const auto offer_cell = [&](const Reach& limit, int face, int column, int row) {
        if (!refined && map.base_cell(face, column, row).kind() != model::CellKind::Uniform) {
            Leaf leaf = map.base_leaf(map.base_cell(face, column, row), face, column, row);
            leaf.kind = model::CellKind::Single;
            leaf.divided = false;
            leaf.centre_inside = map.centre_inside();
            leaf.sheets = 1;
            if (leaf.foreign) return;
            if (map.base_corners(face, column, row, leaf.corner)) {
                offer_sheet(map, part, index, leaf, 0, face, x, best);
                return;
            }
        }
        map.each_leaf(
            face, column, row,
            [&](const Leaf& leaf) {
                if (!leaf_is_near(leaf, face, part.a, x, limit.within(best))) return;
                for (int sheet = 0; sheet < leaf.sheets; ++sheet) offer_sheet(map, part, index, leaf, sheet, face, x, best);
            },
            [&](const Square& square) { return !rays_miss(face, part.a, x, square, limit.within(best)); });
    };
    descend(map, x, best, [&](int face, int column, int row) { offer_cell(Reach{}, face, column, row); });
    each_near_cell(map, part, x, reach, best, [&](int face, int column, int row) { offer_cell(reach, face, column, row); });
}

/// Nearest stored surface of all parts, the answering one first.
Nearest nearest_on_maps(const ModelView& model, Vec3f point, Layer layer, std::int32_t answering, const Reach& reach)
{
    Nearest best;
    const auto search = [&](std::int32_t i) { nearest_on_map(model, i, point, layer != Layer::Two, reach, best); };
    search(answering);
    for (std::size_t i = 0; i < model.parts.size(); ++i) {
        if (static_cast<std::int32_t>(i) == answering) continue;
        const float gap = sphere_gap(model.parts[i], point);
        if (gap * gap < reach.within(best)) search(static_cast<std::int32_t>(i));
    }
    return best;
}

ModelContact contact_with_maps(const ModelView& model, Vec3f point, Layer layer, std::uint32_t gate, const Reach& reach)
{
    SQMAP_ASSERT(is_finite(point) && model::has_central_maps(model));
    const PointVerdict verdict = verdict_by_charts(model, point, layer, gate);
    const std::int32_t answering = verdict.part;
    ModelContact contact = free_at(point, verdict.certain);
    if (!verdict.inside) return contact;

    Nearest best = nearest_on_maps(model, point, layer, answering, reach);
    if (!(best.distance_sq < reach.distance_sq)) best = nearest_on_maps(model, point, layer, answering, {});
    contact.contact = true;
    contact.part = best.part >= 0 ? best.part : answering;
    contact.depth = best.part >= 0 ? std::sqrt(best.distance_sq) : 0.f;
    contact.witness = best.part >= 0 ? best.point : point;
    // Away from the surface the way out is the way to the nearest point; on it, the surface's own normal.
    contact.normal = contact.depth > 1e-4f * model.header.sphere[3] ? normalized(contact.witness - point) : best.normal;
    return contact;
}

}  // namespace

ModelContact query_central(const ModelView& model, Vec3f point, Layer layer, std::uint32_t gate) noexcept
{
    return contact_with_maps(model, point, layer, gate, {});
}

ModelContact query_central_near(const ModelView& model, Vec3f point, Layer layer, float near) noexcept
{
    const float reach = 1.05f * near + 2e-3f * model.header.sphere[3];
    return contact_with_maps(model, point, layer, k_gate, {reach * reach});
}

void apply_offset(const ModelView& model, Vec3f point, Layer layer, const Offset& move, ModelContact& contact) noexcept
{
    // How far out any part moves its surface.
    float reach = move.least;
    if (move.stored)
        for (const Part& part : model.parts) reach = std::max(reach, 255.f * part.offset_step);
    Nearest best;
    if (contact.contact) {
        best = {contact.depth * contact.depth, contact.witness, contact.normal, contact.part};
    } else {
        best.distance_sq = reach * reach;
        for (std::size_t i = 0; i < model.parts.size(); ++i) {
            const float gap = sphere_gap(model.parts[i], point);
            if (gap * gap < best.distance_sq)
                nearest_on_map(model, static_cast<std::int32_t>(i), point, layer != Layer::Two, {}, best);
        }
    }
    if (best.part < 0) return;
    const CentralMap map(model, model.parts[static_cast<std::size_t>(best.part)]);
    const ChartPoint q = to_chart(map.to_chart_frame(best.point));
    const float offset = move.stored ? std::max(move.least, map.offset_at(q.face, q.s, q.t)) : move.least;
    const float outside = contact.contact ? -contact.depth : std::sqrt(best.distance_sq);
    if (!(outside < offset)) return;
    contact.contact = true;
    contact.depth = offset - outside;
    contact.normal = best.normal;
    contact.part = best.part;
    contact.witness = best.point + offset * best.normal;
}

void apply_smoothing(const ModelView& model, Vec3f point, ModelContact& contact) noexcept
{
    if (!contact.contact || contact.part < 0) return;
    const Part& part = model.parts[static_cast<std::size_t>(contact.part)];
    const CentralMap map(model, part);
    const Vec3f x = map.to_chart_frame(point);
    const ChartPoint q = to_chart(map.to_chart_frame(contact.witness));
    const Leaf leaf = map.leaf_at(q.face, q.s, q.t);
    if (leaf.sheets != 1) return;  // between silhouettes there is no one surface to smooth
    const SheetValue value = sheet_value(leaf, 0, q.s, q.t), change = map.smoothing_at(q.face, q.s, q.t);
    const SheetValue smooth{value.w + change.w, value.ws + change.ws, value.wt + change.wt};
    const Vec3f n = plane_vector(q.face, q.s, q.t, smooth);
    const float length_sq = dot(n, map.over_axes_sq(n));
    if (!(length_sq > 0.f)) return;
    contact.depth = std::max((1.f - dot(n, x)) / std::sqrt(length_sq), 0.f);
    contact.normal = normalized(map.direction_from_chart_frame(n));
    contact.witness = point + contact.depth * contact.normal;
}

bool distance_along_central(const ModelView& model, std::uint32_t part_index, Vec3f point, Layer layer, float& distance) noexcept
{
    const Part& part = model.parts[part_index];
    const CentralMap map(model, part);
    const Vec3f x = map.to_chart_frame(point);
    if (!map.in_domain(x)) return false;
    const ChartPoint q = to_chart(x);
    const float length = norm(point - model::vec3(part.chart_centre));
    Leaf leaf = map.leaf_at(q.face, q.s, q.t);
    if (layer == Layer::Two) {
        leaf = map.base_leaf(map.base_cell(q.face, map.column_of(q.s), map.column_of(q.t)), q.face, map.column_of(q.s),
                             map.column_of(q.t));
        leaf.kind = model::CellKind::Single;
        leaf.sheets = map.base_corners(q.face, map.column_of(q.s), map.column_of(q.t), leaf.corner) ? 1 : 0;
    }
    bool found = false;
    for (int j = 0; j < leaf.sheets; ++j) {
        const float reach = q.w / std::max(sheet_value(leaf, j, q.s, q.t).w, 1e-6f);
        if (!map.in_domain(reach * x)) continue;
        const float d = (reach - 1.f) * length;
        if (!found || std::abs(d) < std::abs(distance)) distance = d;
        found = true;
    }
    return found;
}

}  // namespace sqmap::query
