// Moustakas, Tzovaras, Strintzis, "SQ-Map", section 4.1 steps 2 and 3, eqs. 9 to 12 and 22 to 27, section 5 for Q2.
#include "sqmap/paper/bake.h"

#include "model/octahedral.h"
#include "paper/bake/grid.h"
#include "paper/model/codes.h"

#include "math/percentile.h"
#include "math/trigonometry.h"
#include "sqmap/math/box.h"
#include "sqmap/paper/projection.h"
#include "sqmap/shape/superquadric.h"
#include "sqmap/shape/surface.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

namespace sqmap::paper {

using shape::Superquadricd;
using shape::Superquadricf;

namespace {

// coarser: of half as many samples along each axis, whose rays are not cast again; or null.
Grid cast_grid(const Caster& caster, Grid grid, const Grid* coarser)
{
    for (int i = 0; i < grid.rows; ++i)
        for (int j = 0; j < grid.columns; ++j) {
            Surface& s = grid.samples[grid.index(i, j)];
            const bool pole = i == 0 || i == grid.rows - 1;
            if (pole && j > 0)
                s = grid.at(i, 0);
            else if (coarser && i % 2 == 0 && j % 2 == 0)
                s = coarser->at(i / 2, j / 2);
            else
                s = caster.cast(grid.angles(i, j));
        }
    return grid;
}

// True where the surface jumps between two neighbouring samples, so that nothing may be interpolated across.
bool jumps(const Caster& caster, const Grid& grid, double slope, int i0, int j0, int i1, int j1)
{
    const Surface &a = grid.at(i0, j0), &b = grid.at(i1, j1);
    if (a.kind != b.kind) return true;
    if (a.kind != Kind::Hit) return false;
    const double rise = std::abs(a.distance - b.distance);
    const double length = norm(caster.at(grid.angles(i0, j0)).point - caster.at(grid.angles(i1, j1)).point);
    if (rise <= slope * length) return false;
    // Steep or torn: a steep sheet is still near the mean half way.
    const Surface middle = caster.cast(grid.angles(0.5 * (i0 + i1), 0.5 * (j0 + j1)));
    return middle.kind != Kind::Hit || std::abs(middle.distance - 0.5 * (a.distance + b.distance)) > 0.25 * rise;
}

// Two bits a sample: towards the next row, towards the next column.
std::vector<std::uint8_t> find_cuts(const Caster& caster, const Grid& grid, double slope)
{
    std::vector<std::uint8_t> bits(grid.samples.size());
    for (int i = 0; i < grid.rows; ++i)
        for (int j = 0; j < grid.columns; ++j) {
            unsigned b = 0;
            if (i + 1 < grid.rows && jumps(caster, grid, slope, i, j, i + 1, j)) b |= 1;
            if (i > 0 && i + 1 < grid.rows && jumps(caster, grid, slope, i, j, i, j + 1)) b |= 2;
            bits[grid.index(i, j)] = static_cast<std::uint8_t>(b);
        }
    return bits;
}

bool whole_cell(const Grid& grid, const std::vector<std::uint8_t>& cuts, int i, int j)
{
    return (cuts[grid.index(i, j)] & 3u) == 0 && (cuts[grid.index(i, j + 1)] & 1u) == 0 && (cuts[grid.index(i + 1, j)] & 2u) == 0;
}

struct InterpolationError {
    double mean = 0, p99 = 0, cut_share = 0;
};

// Measures by how much bilinear interpolation misses the surface at cell centres, on a regular subset of the cells.
InterpolationError measure_interpolation(const Caster& caster, const Grid& grid, const std::vector<std::uint8_t>& cuts)
{
    const int every = std::max(1, grid.columns / 64);
    std::vector<double> errors;
    std::size_t cut = 0, cells = 0;
    for (int i = 0; i + 1 < grid.rows; ++i)
        for (int j = 0; j < grid.columns; ++j) {
            ++cells;
            if (!whole_cell(grid, cuts, i, j)) {
                ++cut;
                continue;
            }
            if (grid.at(i, j).kind != Kind::Hit || (i * 7 + j) % every != 0) continue;
            const Surface s = caster.cast(grid.angles(i + 0.5, j + 0.5));
            const double mean = 0.25 * (grid.at(i, j).distance + grid.at(i + 1, j).distance + grid.at(i, j + 1).distance +
                                        grid.at(i + 1, j + 1).distance);
            errors.push_back(s.kind == Kind::Hit ? std::abs(s.distance - mean) : mean);
        }
    InterpolationError out;
    out.cut_share = static_cast<double>(cut) / static_cast<double>(cells);
    if (errors.empty()) return out;
    for (const double e : errors) out.mean += e / static_cast<double>(errors.size());
    out.p99 = percentile(errors, 99);
    return out;
}

// Eq. 26 with eq. 27: derivatives of D by differences that stay on one sheet, those of r and n exact. Where eq. 26 has no
// answer (poles, samples alone on their sheet) the normal of the triangle that was hit.
Vec3d surface_normal(const Caster& caster, const Grid& grid, const std::vector<std::uint8_t>& cuts, int i, int j)
{
    const Surface& here = grid.at(i, j);
    const Vec3d face = face_normal(caster.rays.mesh(), here.triangle);
    if (i == 0 || i == grid.rows - 1) return face;
    const auto slope = [&](bool ahead, bool behind, const Surface& next, const Surface& last, double step, double& out) {
        if (!ahead && !behind) return false;
        const double high = ahead ? next.distance : here.distance, low = behind ? last.distance : here.distance;
        out = (high - low) / (step * (ahead && behind ? 2 : 1));
        return true;
    };
    double d_eta = 0, d_omega = 0;
    const bool eta = slope((cuts[grid.index(i, j)] & 1) == 0, (cuts[grid.index(i - 1, j)] & 1) == 0, grid.at(i + 1, j),
                           grid.at(i - 1, j), k_pi / (grid.rows - 1), d_eta);
    const bool omega = slope((cuts[grid.index(i, j)] & 2) == 0, (cuts[grid.index(i, j - 1)] & 2) == 0, grid.at(i, j + 1),
                             grid.at(i, j - 1), 2 * k_pi / grid.columns, d_omega);
    if (!eta || !omega) return face;
    const auto jet = shape::surface_jet(caster.sq, shape::position_at(caster.sq, grid.angles(i, j)));
    const Vec3d n = normalized(shape::mapped_normal(jet, here.distance, d_eta, d_omega));
    // Beyond a focal point of the superquadric S = r - D n folds over and eq. 26 points in.
    return dot(n, face) > 0 ? n : face;
}

std::vector<std::uint32_t> vertices_of(const mesh::Mesh& m, std::span<const std::uint32_t> triangles)
{
    std::vector<std::uint32_t> out;
    for (const std::uint32_t t : triangles) out.insert(out.end(), m.triangles[t].begin(), m.triangles[t].end());
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
}

// Openings behind the first surface, where some point of them has its foot at this sample: the line of a deeper point
// leads to another foot, and its openings are stored there.
void add_gaps(const Caster& caster, const Grid& grid, Map& map)
{
    const MapView view = map.view();
    const double scale = static_cast<double>(map.distance_scale);
    std::vector<MapRays::Gap> gaps;
    map.gap_rows.assign(static_cast<std::size_t>(grid.rows) + 1, 0);
    for (int i = 0; i < grid.rows; ++i)
        for (int j = 0; j < grid.columns; ++j) {
            if (grid.at(i, j).kind == Kind::Miss) continue;
            const shape::SurfacePoint<double> s = caster.at(grid.angles(i, j));
            gaps.clear();
            static_cast<void>(caster.rays.surface_along(s.point, -s.normal, {caster.reach, caster.lift}, &gaps));
            if (gaps.empty()) continue;
            const double cell = 2 * (norm(s.point - caster.at(grid.angles(i + (i + 1 < grid.rows ? 1 : -1), j)).point) +
                                     norm(s.point - caster.at(grid.angles(i, j + 1)).point));
            for (const MapRays::Gap& gap : gaps) {
                const Vec3d start = s.point - (gap.leave + caster.lift) * s.normal;
                if (gap.leave > scale * k_map_largest || shape::implicit(caster.sq, start) > 1) break;
                const shape::Foot<float> foot = find_foot(view, sqmap::cast<float>(start), Projector::Newton);
                if (norm(sqmap::cast<double>(foot.point) - s.point) > cell) break;
                const double enter = std::round(gap.enter / scale);
                map.gaps.push_back({static_cast<std::uint16_t>(j), static_cast<std::uint16_t>(std::round(gap.leave / scale)),
                                    enter > k_map_largest ? k_map_miss : static_cast<std::uint16_t>(enter)});
                ++map.gap_rows[static_cast<std::size_t>(i) + 1];
            }
        }
    for (std::size_t i = 1; i < map.gap_rows.size(); ++i) map.gap_rows[i] += map.gap_rows[i - 1];
    map.report.gaps = static_cast<std::uint32_t>(map.gaps.size());
}

shape::Foot<double> exact_foot(const Superquadricd& sq, const MapView& view, Vec3d p)
{
    const shape::Foot<float> start = find_foot(view, sqmap::cast<float>(p), Projector::Newton);
    const auto angle = [](const shape::Arc<float>& arc) {
        return angle_of(static_cast<double>(arc.s), static_cast<double>(arc.c));
    };
    const Angles angles{angle(start.position.latitude), angle(start.position.longitude)};
    return shape::polish_foot(sq, p, shape::position_at(sq, angles), {.max_iterations = 20, .tolerance = 1e-9});
}

// True where the segment from a surface point to its foot crosses the mesh (point W of Fig. 5a).
bool occluded(const Caster& caster, const shape::Foot<double>& foot)
{
    const double margin = 1e-4 * largest_axis(caster.sq);
    if (foot.depth <= 2 * margin) return false;
    return caster.rays.first_hit(foot.point, -foot.normal, 0.0, foot.depth - margin).has_value();
}

struct LocatedVertex {
    std::uint32_t row;
    VertexCorrection data;
    double residual;
};

double hat(const VertexCorrection& v, double y, double x)
{
    const double y0 = (v.eta + 0.5) / 256, x0 = (v.omega + 0.5) / 256;
    return std::max(0.0, std::min({x / x0, (1 - x) / (1 - x0), y / y0, (1 - y) / (1 - y0)}));
}

// Heights of the pyramids so that their sum meets every residual of the cell; vertices too close together to be told
// apart are dropped, least residual first.
void solve_cell(std::vector<LocatedVertex>& cell)
{
    std::stable_sort(cell.begin(), cell.end(),
                     [](const LocatedVertex& a, const LocatedVertex& b) { return std::abs(a.residual) > std::abs(b.residual); });
    if (cell.size() > 8) cell.resize(8);
    while (!cell.empty()) {
        const std::size_t n = cell.size();
        std::vector<double> a(n * (n + 1));
        double largest = 0;
        for (std::size_t i = 0; i < n; ++i) {
            const double y = (cell[i].data.eta + 0.5) / 256, x = (cell[i].data.omega + 0.5) / 256;
            for (std::size_t j = 0; j < n; ++j) a[i * (n + 1) + j] = hat(cell[j].data, y, x);
            a[i * (n + 1) + n] = cell[i].residual;
            largest = std::max(largest, std::abs(cell[i].residual));
        }
        bool good = true;
        for (std::size_t k = 0; k < n && good; ++k) {
            std::size_t pivot = k;
            for (std::size_t i = k; i < n; ++i)
                if (std::abs(a[i * (n + 1) + k]) > std::abs(a[pivot * (n + 1) + k])) pivot = i;
            good = std::abs(a[pivot * (n + 1) + k]) > 0.1;
            for (std::size_t j = 0; j <= n; ++j) std::swap(a[k * (n + 1) + j], a[pivot * (n + 1) + j]);
            for (std::size_t i = 0; i < n && good; ++i) {
                if (i == k) continue;
                const double f = a[i * (n + 1) + k] / a[k * (n + 1) + k];
                for (std::size_t j = k; j <= n; ++j) a[i * (n + 1) + j] -= f * a[k * (n + 1) + j];
            }
        }
        const auto height = [&](std::size_t i) { return a[i * (n + 1) + n] / a[i * (n + 1) + i]; };
        for (std::size_t i = 0; i < n && good; ++i) good = std::abs(height(i)) <= 3 * largest;
        if (good) {
            for (std::size_t i = 0; i < n; ++i) cell[i].residual = height(i);
            return;
        }
        cell.pop_back();  // the others' residuals are still those of the map
    }
}

// Step 3: every vertex of the part that its foot can see, as a correction of the interpolated map.
void add_corrections(const Caster& caster, const Grid& grid, const std::vector<std::uint8_t>& cuts,
                     std::span<const std::uint32_t> triangles, double threshold, Map& map)
{
    const mesh::Mesh& m = caster.rays.mesh();
    const MapView view = map.view();
    const double scale = static_cast<double>(map.distance_scale);
    std::vector<LocatedVertex> located;
    for (const std::uint32_t v : vertices_of(m, triangles)) {
        ++map.report.vertices;
        const shape::Foot<double> foot = exact_foot(caster.sq, view, m.vertices[v]);
        if (!foot.converged || foot.depth < 0) continue;
        if (occluded(caster, foot)) {
            ++map.report.occluded_vertices;
            continue;
        }
        const Angles a = shape::angles_of(foot.position);
        const double y = (a.eta / k_pi + 0.5) * (grid.rows - 1), x = (a.omega / (2 * k_pi) + 0.5) * grid.columns;
        const int i = std::clamp(static_cast<int>(y), 0, grid.rows - 2), j = std::clamp(static_cast<int>(x), 0, grid.columns - 1);
        if (!whole_cell(grid, cuts, i, j) || grid.at(i, j).kind != Kind::Hit) continue;
        const auto eighth = [](double f) { return static_cast<std::uint8_t>(std::clamp(f * 256, 0.0, 255.0)); };
        const VertexCorrection data{static_cast<std::uint16_t>(j), eighth(y - i), eighth(x - j), 0};
        // Linear interpolation as the run time will do it, at the position that is stored.
        const double fy = (data.eta + 0.5) / 256, fx = (data.omega + 0.5) / 256;
        const auto value = [&](int r, int c) { return scale * map.distance[grid.index(r, c)]; };
        const double low = value(i, j) + fx * (value(i, j + 1) - value(i, j));
        const double high = value(i + 1, j) + fx * (value(i + 1, j + 1) - value(i + 1, j));
        const double residual = foot.depth - (low + fy * (high - low));
        if (std::abs(residual) < threshold) continue;
        located.push_back({static_cast<std::uint32_t>(i), data, residual});
    }
    const auto cell_key = [](const LocatedVertex& p) { return std::pair(p.row, p.data.column); };
    std::stable_sort(located.begin(), located.end(),
                     [&](const LocatedVertex& a, const LocatedVertex& b) { return cell_key(a) < cell_key(b); });
    map.correction_rows.assign(static_cast<std::size_t>(grid.rows), 0);
    for (std::size_t first = 0; first < located.size();) {
        std::size_t last = first;
        while (last < located.size() && cell_key(located[last]) == cell_key(located[first])) ++last;
        std::vector<LocatedVertex> cell(located.begin() + static_cast<std::ptrdiff_t>(first),
                                        located.begin() + static_cast<std::ptrdiff_t>(last));
        solve_cell(cell);
        for (LocatedVertex& p : cell) {
            // More than half of the map's largest distance cannot be stored; the most that can be is nearer than nothing.
            const double code = std::clamp(std::round(p.residual / scale), -32767.0, 32767.0);
            if (code == 0) continue;
            p.data.correction = static_cast<std::int16_t>(code);
            map.corrections.push_back(p.data);
            ++map.correction_rows[p.row + 1];
        }
        first = last;
    }
    for (std::size_t i = 1; i < map.correction_rows.size(); ++i) map.correction_rows[i] += map.correction_rows[i - 1];
    map.report.corrections = static_cast<std::uint32_t>(map.corrections.size());
}

FootSeed seed_of(double eta_share, double omega_share)
{
    const auto code = [](double share) { return static_cast<std::uint8_t>(std::clamp(share * 256, 0.0, 255.0)); };
    return {code(eta_share), code(omega_share)};
}

// The nearest of some points, the first one of several. Neighbours in a run that starts farther off are passed over.
class NearestPoint {
public:
    explicit NearestPoint(const std::vector<Vec3d>& points) : points_(points)
    {
        for (std::size_t k = 0; k < points.size(); ++k) {
            if (k % k_run == 0) boxes_.emplace_back();
            extend(boxes_.back(), points[k]);
        }
    }
    std::size_t operator()(Vec3d q)
    {
        double least = norm_sq(points_[best_] - q);
        for (std::size_t r = 0; r < boxes_.size(); ++r) {
            // Rounding leaves this at most the squared distance of any point in the box: both are summed in one order.
            Vec3d away;
            for (int k = 0; k < 3; ++k) away[k] = std::max({boxes_[r].lo[k] - q[k], q[k] - boxes_[r].hi[k], 0.0});
            if (norm_sq(away) > least) continue;
            for (std::size_t k = r * k_run; k < std::min((r + 1) * k_run, points_.size()); ++k) {
                const double d = norm_sq(points_[k] - q);
                if (!(d < least || (d == least && k < best_))) continue;
                least = d;
                best_ = k;
            }
        }
        return best_;
    }

private:
    static constexpr std::size_t k_run = 16;
    const std::vector<Vec3d>& points_;
    std::vector<Box> boxes_;
    std::size_t best_ = 0;  // of the last query, which is near the next one
};

// Numbers the hits of the base grid, for the arrays that hold these alone.
void rank_hits(Map& map)
{
    const MapView view = map.view();
    std::uint32_t before = 0;
    for (std::size_t k = 0; k < rank_count(base_rows(map) * base_columns(map)); ++k) {
        map.hits.push_back(hits_in(view, k, before));
        before += static_cast<std::uint32_t>(std::popcount(map.hits.back().bits));
    }
}

// Eq. 12 at the base samples that have one.
void store_offsets(const std::vector<double>& delta, Map& map)
{
    const double largest = *std::max_element(delta.begin(), delta.end());
    map.offset_scale = static_cast<float>(largest > 0 ? largest / k_largest_offset * (1 + 1e-6) : 1.0);
    for (std::size_t i = 0; i < delta.size(); ++i)
        if (delta[i] > 0)
            map.offset.push_back(static_cast<std::uint32_t>(i) << k_offset_bits |
                                 offset_code(delta[i] / static_cast<double>(map.offset_scale)));
    if (!map.offset.empty()) map.offset.resize(map.offset.size() + k_hit_padding, k_no_offset);
}

// The sample nearest to the middle of every seed cell, on a grid of 33 by 64.
void make_seeds(const Superquadricd& sq, Map& map)
{
    Superquadricd local = sq;
    local.rotation = {};
    local.translation = {};
    const Grid grid(5);
    std::vector<Vec3d> points;
    for (int i = 0; i < grid.rows; ++i)
        for (int j = 0; j < grid.columns; ++j) points.push_back(shape::surface_point(local, grid.angles(i, j)).point);
    NearestPoint nearest(points);
    map.seeds_mirrored = sq.is_deformed() ? 0 : 1;
    map.seed_count = map.seeds_mirrored != 0 ? 8 : 12;
    const int n = static_cast<int>(map.seed_count);
    const auto middle = [&](int i) { return map.seeds_mirrored != 0 ? (i + 0.5) / n : 2 * (i + 0.5) / n - 1; };
    for (int x = 0; x < n; ++x)
        for (int y = 0; y < n; ++y)
            for (int z = 0; z < n; ++z) {
                const Vec3d q = shape::deform(local, Vec3d{sq.a.x * middle(x), sq.a.y * middle(y), sq.a.z * middle(z)});
                const std::size_t best = nearest(q);
                const int i = static_cast<int>(best) / grid.columns, j = static_cast<int>(best) % grid.columns;
                map.seeds.push_back(seed_of(static_cast<double>(i) / (grid.rows - 1), static_cast<double>(j) / grid.columns));
            }
}

// The sample whose surface is nearest to the middle of every cell, of at most 65 by 128.
void make_surface_seeds(const Superquadricd& sq, const Grid& grid, Map& map)
{
    Superquadricd local = sq;
    local.rotation = {};
    local.translation = {};
    const int every = std::max(1, (grid.rows - 1) / 64);
    std::vector<Vec3d> points;
    std::vector<FootSeed> codes;
    for (int i = 0; i < grid.rows; i += every)
        for (int j = 0; j < grid.columns; j += every) {
            if (grid.at(i, j).kind != Kind::Hit) continue;
            const shape::SurfacePoint<double> s = shape::surface_point(local, grid.angles(i, j));
            points.push_back(s.point - grid.at(i, j).distance * s.normal);
            // Read in 1/255 and 1/256 of their ranges.
            codes.push_back(seed_of((255. * i / (grid.rows - 1) + 0.5) / 256, static_cast<double>(j) / grid.columns + 0.5 / 256));
        }
    if (points.empty()) return;
    NearestPoint nearest(points);
    constexpr int k_along = static_cast<int>(k_surface_seeds);
    const auto middle = [](int i) { return 2 * (i + 0.5) / k_along - 1; };
    for (int x = 0; x < k_along; ++x)
        for (int y = 0; y < k_along; ++y)
            for (int z = 0; z < k_along; ++z)
                map.surface_seeds.push_back(
                    codes[nearest(shape::deform(local, Vec3d{sq.a.x * middle(x), sq.a.y * middle(y), sq.a.z * middle(z)}))]);
}

}  // namespace

Map bake_map(const MapRays& rays, std::span<const std::uint32_t> triangles, const Superquadricd& superquadric,
             const MapOptions& options)
{
    Map map;
    map.superquadric = shape::cast<float>(superquadric);
    const Superquadricd sq = shape::cast<double>(map.superquadric);
    const Caster caster(rays, sq);
    const double target = options.target_error * largest_axis(sq);

    int level = options.min_level;
    const GridSize base = options.grid;
    Grid grid =
        cast_grid(caster,
                  base.is_chosen() ? Grid(((base.rows - 1) << options.subdivisions) + 1, base.columns << options.subdivisions)
                                   : Grid(level),
                  nullptr);
    std::vector<std::uint8_t> cuts = find_cuts(caster, grid, options.jump_slope);
    InterpolationError error = measure_interpolation(caster, grid, cuts);
    while (!base.is_chosen() && error.p99 > target && level < options.max_level) {
        ++level;
        grid = cast_grid(caster, Grid(level), &grid);
        cuts = find_cuts(caster, grid, options.jump_slope);
        error = measure_interpolation(caster, grid, cuts);
    }
    map.report.level = level;
    map.report.target_met = error.p99 <= target;
    map.report.interpolation_mean = error.mean;
    map.report.interpolation_p99 = error.p99;
    map.report.cut_share = error.cut_share;

    map.eta_count = static_cast<std::uint32_t>(grid.rows);
    map.omega_count = static_cast<std::uint32_t>(grid.columns);
    const int max = base.is_chosen() ? options.subdivisions : level - 2;
    map.subdivisions = static_cast<std::uint32_t>(std::clamp(options.subdivisions, 0, max));
    make_seeds(sq, map);
    make_surface_seeds(sq, grid, map);

    double largest = 0;
    for (const Surface& s : grid.samples)
        if (s.kind == Kind::Hit) largest = std::max(largest, s.distance);
    map.distance_scale = largest > 0 ? static_cast<float>(largest / k_map_largest) : 1.0f;
    const double scale = static_cast<double>(map.distance_scale);
    const double share = 1.0 / static_cast<double>(grid.samples.size());
    for (int i = 0; i < grid.rows; ++i)
        for (int j = 0; j < grid.columns; ++j) {
            const Surface& s = grid.at(i, j);
            const bool is_base = i % (1 << map.subdivisions) == 0 && j % (1 << map.subdivisions) == 0;
            std::uint16_t code = s.kind == Kind::Cap ? k_map_cap : k_map_miss;
            if (s.kind == Kind::Hit) {
                code = static_cast<std::uint16_t>(std::min(std::round(s.distance / scale), double(k_map_largest)));
                map.report.quantization_error = std::max(map.report.quantization_error, std::abs(code * scale - s.distance));
                if (is_base)
                    map.normal.push_back(model::encode_normal(sqmap::cast<float>(surface_normal(caster, grid, cuts, i, j))));
            }
            (s.kind == Kind::Hit ? map.report.hit_share : (s.kind == Kind::Cap ? map.report.cap_share : map.report.miss_share)) +=
                share;
            map.distance.push_back(code);
        }
    map.normal.resize(map.normal.size() + k_hit_padding);
    rank_hits(map);
    map.quantization_error = static_cast<float>(map.report.quantization_error);
    map.cuts.assign((grid.samples.size() + 3) / 4, 0);
    for (std::size_t k = 0; k < cuts.size(); ++k)
        map.cuts[k / 4] = static_cast<std::uint8_t>(map.cuts[k / 4] | cuts[k] << (2 * (k % 4)));

    store_offsets(offsets(caster, grid, 1 << map.subdivisions, options), map);
    add_smoothing(caster, grid, options, map);

    map.vertex_count = static_cast<std::uint32_t>(vertices_of(rays.mesh(), triangles).size());
    if (options.corrections) add_corrections(caster, grid, cuts, triangles, options.correction_threshold * target, map);
    if (options.gaps) add_gaps(caster, grid, map);
    map.occluded_vertices = map.report.occluded_vertices;
    return map;
}

}  // namespace sqmap::paper
