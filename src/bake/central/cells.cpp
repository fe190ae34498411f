#include "cells.h"

#include "sqmap/mesh/error.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sqmap::bake {

using model::CellKind;
using model::CentralCell;
using model::LayeredHead;

namespace {

constexpr int k_max_bilinear = 3;  // surfaces over one cell that are worth corner samples of their own

[[noreturn]] void too_large(const char* what)
{
    throw mesh::RefusedMesh({mesh::Refusal::Limit, "part", what,
                             mesh::Words("reduce the mesh")
                                 .with(", allow more parts with ", mesh::Setting::MaxParts)
                                 .with(", or a larger ", mesh::Setting::TargetError)});
}

/// Largest |w - b| over a polygon, b the bilinear form of four corner values on the cell. The difference is a saddle, so its
/// extremes lie on the polygon's edges, where it is a parabola.
double deviation(const Polygon& p, const double c[4], const CellSquare& square)
{
    const double k = c[0] - c[1] - c[2] + c[3], size = square.size;
    const auto difference = [&](double s, double t, double w) {
        const double u = (s - square.s) / size, v = (t - square.t) / size;
        return w - (c[0] + u * (c[1] - c[0]) + v * (c[2] - c[0]) + u * v * k);
    };
    double worst = 0;
    for (int i = 0; i < p.count; ++i) {
        const Stw& a = p.corner[static_cast<std::size_t>(i)];
        const Stw& b = p.corner[static_cast<std::size_t>((i + 1) % p.count)];
        const double d0 = difference(a.s, a.t, a.w), d1 = difference(b.s, b.t, b.w);
        worst = std::max(worst, std::abs(d0));
        // Along the edge: d(f) = d0 + (d1 - d0 + q) f - q f^2 with q = k du dv.
        const double q = k * (b.s - a.s) * (b.t - a.t) / (size * size);
        if (q != 0) {
            const double f = (d1 - d0 + q) / (2 * q);
            if (f > 0 && f < 1) worst = std::max(worst, std::abs(d0 + (d1 - d0 + q) * f - q * f * f));
        }
    }
    return worst;
}

}  // namespace

/// Bilinear surfaces through the corner crossings of a cell, with their certified deviations: every surface over the cell lies in
/// one of the disjoint bands.
struct CentralCellBaker::Sheets {
    int count = 0;
    double deviation = 0;  ///< the widest band, as a length in model units
    std::uint16_t stored[k_max_bilinear][4];
    std::uint16_t code[k_max_bilinear];
};

std::uint16_t stored_sample(const RaySample& ray, const model::SampleRange& range)
{
    return ray.valid && ray.count > 0 ? range.encode(ray.w[0]) : model::k_no_surface;
}

CentralCell CentralCellBaker::bake(const Cell& cell)
{
    bool any = false, own = false;
    double least_w = std::numeric_limits<double>::infinity();
    for (const Polygon& p : cell.footprints) {
        any = any || !projection_.is_buried(p.triangle);
        own = own || projection_.is_own(p.triangle);
        for (int i = 0; i < p.count; ++i) least_w = std::min(least_w, p.corner[static_cast<std::size_t>(i)].w);
    }
    if (!any) return CentralCell::uniform(map_.centre_winding > 0);
    const double tolerance = (own ? options_.tolerance : options_.foreign_tolerance) * options_.r_max;
    const double extent = projection_.metric_size(cell.square.face, cell.square.size, least_w) / options_.r_max;
    const bool has_depth = cell.depth < options_.max_depth && fits_another(cell);
    map_.is_full = map_.is_full || (cell.depth < options_.max_depth && !has_depth);
    const std::optional<Sheets> sheets = measure_sheets(cell);
    // A band much wider than a crease makes is a hidden fold: as much a silhouette as a missing crossing.
    const bool folded = !sheets || sheets->deviation > options_.silhouette * options_.r_max;
    const bool may_split = has_depth && extent > (folded ? options_.silhouette : options_.finest);
    if (sheets && (sheets->deviation <= tolerance || !may_split)) {
        if (sheets->deviation > tolerance) ++map_.rough_cells;
        if (const std::optional<CentralCell> stored = store_sheets(*sheets, !own)) return *stored;
    }
    if (may_split)
        if (const std::optional<CentralCell> stored = split(cell)) return *stored;
    ++map_.rough_cells;
    return store_mixed(mixed_.at(cell), cell.square, !own);
}

/// True while every cell still to come, and the quadrants of one more split a level, can have a record of its own.
bool CentralCellBaker::fits_another(const Cell& cell) const
{
    return map_.specials.size() + cell.base_cells_left + 4 * model::k_max_split_depth < model::k_max_payload;
}

/// A layered cell of the record that comes next in the pool; none where there is no room for another.
std::optional<CentralCell> CentralCellBaker::add_special()
{
    if (map_.specials.size() >= model::k_max_payload) return std::nullopt;
    const CentralCell cell = CentralCell::of(CellKind::Layered, map_.specials.size());
    map_.specials.push_back(static_cast<std::uint32_t>(map_.pool.size()));
    return cell;
}

std::optional<CentralCellBaker::Sheets> CentralCellBaker::measure_sheets(const Cell& cell) const
{
    const auto& corner = cell.corner;
    const double size = cell.square.size;
    Sheets out;
    out.count = corner[0].count;
    const bool same =
        std::all_of(corner.begin(), corner.end(), [&](const RaySample& ray) { return ray.valid && ray.count == out.count; });
    if (!same || out.count < 1 || out.count > k_max_bilinear) return std::nullopt;
    double c[k_max_bilinear][4];
    for (int j = 0; j < out.count; ++j)
        for (std::size_t i = 0; i < 4; ++i) {
            out.stored[j][i] = map_.range.encode(corner[i].w[static_cast<std::size_t>(j)]);
            c[j][i] = static_cast<double>(map_.range.decode(out.stored[j][i]));
        }
    double e[k_max_bilinear] = {};
    for (const Polygon& p : cell.footprints) {
        if (projection_.is_buried(p.triangle)) continue;
        int best = 0;
        double least = std::numeric_limits<double>::infinity();
        for (int j = 0; j < out.count; ++j)
            if (const double d = deviation(p, c[j], cell.square); d < least) {
                least = d;
                best = j;
            }
        e[best] = std::max(e[best], least);
    }
    for (int j = 0; j < out.count; ++j) {
        // The runtime evaluates in float: a few parts in 10^7 of w on top.
        const double largest = std::max(std::max(c[j][0], c[j][1]), std::max(c[j][2], c[j][3]));
        const std::optional<std::uint16_t> code = deviations_.at_least(e[j] + 3e-6 * largest);
        if (!code) return std::nullopt;
        out.code[j] = *code;
        e[j] = deviations_[*code];
        const double w = 0.25 * (c[j][0] + c[j][1] + c[j][2] + c[j][3]);
        const double ws = 0.5 * (c[j][1] - c[j][0] + c[j][3] - c[j][2]) / size,
                     wt = 0.5 * (c[j][2] - c[j][0] + c[j][3] - c[j][1]) / size;
        out.deviation = std::max(out.deviation, projection_.metric_deviation(cell.square.middle(), {w, ws, wt}, e[j]));
    }
    for (int j = 0; j + 1 < out.count; ++j)
        for (int i = 0; i < 4; ++i)
            if (!(c[j][i] - c[j + 1][i] > e[j] + e[j + 1])) return std::nullopt;
    return out;
}

std::optional<CentralCell> CentralCellBaker::store_sheets(const Sheets& sheets, bool foreign)
{
    if (sheets.count == 1) return CentralCell::single(sheets.code[0], foreign);  // its corners are shared samples
    const std::optional<CentralCell> cell = add_special();
    if (!cell) return cell;
    map_.pool.push_back(LayeredHead::of_bilinear(sheets.count, foreign).word);
    for (int j = 0; j < sheets.count; ++j) {
        map_.pool.insert(map_.pool.end(), sheets.stored[j], sheets.stored[j] + 4);
        map_.pool.push_back(sheets.code[j]);
    }
    return cell;
}

std::optional<CentralCell> CentralCellBaker::split(const Cell& cell)
{
    const std::size_t record = map_.splits.size();
    if (record / model::k_split_size >= model::k_max_payload) return std::nullopt;
    map_.splits.resize(record + model::k_split_size);
    const auto& [face, s0, t0, size] = cell.square;
    const double half = 0.5 * size;
    RaySample rays[9];
    for (int i = 0; i < 9; ++i)
        rays[i] = i % 2 == 0 && i != 4 ? cell.corner[static_cast<std::size_t>(i % 3 / 2 + 2 * (i / 6))]
                                       : projection_.crossings({face, s0 + half * (i % 3), t0 + half * (i / 3)}, cell.footprints);
    std::uint16_t children[4];
    for (int q = 0; q < 4; ++q) {
        const double s = s0 + half * (q & 1), t = t0 + half * (q >> 1);
        const RaySample* r = rays + (q & 1) + 3 * (q >> 1);
        Cell quadrant{{face, s, t, half}, cell.depth + 1, cell.base_cells_left, spare_footprints(), {r[0], r[1], r[3], r[4]}};
        for (const Polygon& p : cell.footprints) {
            Polygon& c = quadrant.footprints.emplace_back(p);
            clip_to_cell(c, s - k_cell_border, s + half + k_cell_border, t - k_cell_border, t + half + k_cell_border);
            if (c.count == 0) quadrant.footprints.pop_back();
        }
        children[q] = bake(quadrant).word;
        spare_.push_back(std::move(quadrant.footprints));
    }
    auto stored = map_.splits.begin() + static_cast<std::ptrdiff_t>(record);
    for (const int i : model::k_split_samples) *stored++ = stored_sample(rays[i], map_.range);
    std::copy(children, children + 4, stored);
    return CentralCell::of(CellKind::Split, record / model::k_split_size);
}

/// Nothing, in memory that another cell's footprints had.
std::vector<Polygon> CentralCellBaker::spare_footprints()
{
    if (spare_.empty()) return {};
    std::vector<Polygon> footprints = std::move(spare_.back());
    spare_.pop_back();
    footprints.clear();
    return footprints;
}

CentralCell CentralCellBaker::store_mixed(const MixedCell& mixed, const CellSquare& square, bool foreign)
{
    const std::optional<CentralCell> cell = add_special();
    // No room for another record: the verdict of the middle ray's end would be a guess, so say so loudly.
    if (!cell) too_large("its central map needs more than 16384 refined cells");
    const std::optional<Division>& division = mixed.division;
    const LayeredHead head = division ? LayeredHead::of_divided(mixed.first.count, division->second.count, foreign)
                                      : LayeredHead::of_mixed(mixed.first.count, foreign);
    map_.pool.push_back(head.word);
    map_.pool.push_back(map_.range.encode_down(mixed.lo * (1 - 3e-6)));
    map_.pool.push_back(map_.range.encode_up(mixed.hi * (1 + 3e-6)));
    if (division) map_.pool.push_back(model::border_line_word(division->from, division->to));
    store_planes(mixed.first, mixed, square);
    if (division) store_planes(division->second, mixed, square);
    return *cell;
}

/// Planes are stored at the middle of the cell.
void CentralCellBaker::store_planes(const RayPlanes& planes, const MixedCell& mixed, const CellSquare& square)
{
    const double reach = 0.5 * square.size;
    for (int j = 0; j < planes.count; ++j) {
        const model::ChartPlane<double>& plane = planes.plane[static_cast<std::size_t>(j)];
        map_.pool.push_back(map_.range.encode(std::clamp(planes.w_at(j, square.middle()), mixed.lo, mixed.hi)));
        map_.pool.push_back(map_.range.encode_slope(plane.ws * reach));
        map_.pool.push_back(map_.range.encode_slope(plane.wt * reach));
    }
}

}  // namespace sqmap::bake
