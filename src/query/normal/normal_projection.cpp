// Moustakas, Tzovaras, Strintzis, "SQ-Map", section 4.2, eqs. 15 to 20, with the corrections of the errata: both search
// directions, a wide search where the window does not hold the foot, distance compared beside collinearity.
// Octahedral normals after Meyer et al. 2010.
#include "sqmap/query/normal_projection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace sqmap::query {

using model::FootSeed;
using model::k_map_cap;
using model::k_map_largest;
using model::k_map_miss;
using model::VertexCorrection;
using shape::Foot;
using shape::Superquadricf;
using shape::SurfaceAnglesf;
using shape::SurfacePlace;
using shape::SurfacePoint;

namespace {

constexpr float k_pi = std::numbers::pi_v<float>;

// Tangential miss at which a foot counts as found, of the largest semi-axis: well below a cell, above float rounding.
constexpr shape::FootOptions k_newton{.max_iterations = 10, .tolerance = 1e-5};
constexpr float k_proven_miss = 1e-3f;

SurfacePlace<float> place_of_sample(const NormalMapView& map, std::size_t row, std::size_t column)
{
    if (!map.rows.empty()) return {map.rows[row], map.columns[column]};
    return shape::place_at(map.superquadric,
                           SurfaceAnglesf{k_pi * (static_cast<float>(row) / static_cast<float>(map.eta_count - 1) - 0.5f),
                                          2 * k_pi * static_cast<float>(column) / static_cast<float>(map.omega_count) - k_pi});
}

// A base-grid sample index, with rows continued over the poles and columns around.
struct Node {
    std::int32_t row, column;
};

// Every so many samples of a map's grid, by default the base grid, in the superquadric's own frame.
struct BaseGrid {
    const NormalMapView& map;
    Superquadricf local;
    std::int32_t stride, rows, columns;

    explicit BaseGrid(const NormalMapView& m) : BaseGrid(m, std::int32_t{1} << m.subdivisions) {}
    BaseGrid(const NormalMapView& m, std::int32_t every) : map(m), local(m.superquadric), stride(every)
    {
        local.rotation = {};
        local.translation = {};
        rows = static_cast<std::int32_t>(m.eta_count - 1) / stride + 1;
        columns = static_cast<std::int32_t>(m.omega_count) / stride;
    }

    Node wrapped(std::int32_t row, std::int32_t column) const
    {
        if (row < 0) {
            row = -row;
            column += columns / 2;
        }
        if (row > rows - 1) {
            row = 2 * (rows - 1) - row;
            column += columns / 2;
        }
        column %= columns;
        return {std::clamp(row, 0, rows - 1), column < 0 ? column + columns : column};
    }
    SurfacePlace<float> place(Node n) const
    {
        return place_of_sample(map, static_cast<std::size_t>(n.row * stride), static_cast<std::size_t>(n.column * stride));
    }
    SurfacePoint<float> point(Node n) const { return shape::surface_point(local, place(n)); }
};

// One candidate of the search: what eq. 19 says, signed so that the far side of the surface does not count, and distance.
struct Candidate {
    Node node{0, 0};
    float distance_sq = std::numeric_limits<float>::infinity();
    float collinearity = -2;
};

struct Search {
    const BaseGrid& grid;
    Vec3f q;  // local
    bool compare_distance;
    int evaluations = 0;

    Candidate at(std::int32_t row, std::int32_t column)
    {
        ++evaluations;
        Candidate c;
        c.node = grid.wrapped(row, column);
        const SurfacePoint<float> s = grid.point(c.node);
        const Vec3f line = s.point - q;
        c.distance_sq = norm_sq(line);
        const float length = std::sqrt(c.distance_sq);
        const float along = length > 0 ? dot(s.normal, line) / length : 1.0f;
        c.collinearity = compare_distance ? along : std::abs(along);  // eq. 19 takes the absolute value (errata 7)
        return c;
    }
    bool better(const Candidate& a, const Candidate& b) const
    {
        return compare_distance ? a.distance_sq < b.distance_sq : a.collinearity > b.collinearity;
    }
    void consider(Candidate& best, std::int32_t row, std::int32_t column)
    {
        const Candidate c = at(row, column);
        if (better(c, best)) best = c;
    }
    // The eight neighbours of the best at half the stride, down to single samples (Fig. 7).
    void descend(Candidate& best, std::int32_t stride)
    {
        for (; stride >= 1; stride /= 2) {
            const Node centre = best.node;
            for (std::int32_t i = -1; i <= 1; ++i)
                for (std::int32_t j = -1; j <= 1; ++j)
                    if (i != 0 || j != 0) consider(best, centre.row + i * stride, centre.column + j * stride);
        }
    }
};

std::int32_t window_levels(const BaseGrid& grid)
{
    // Eq. 18, integer part; at least one level.
    std::int32_t levels = 0;
    while ((16 << (levels + 1)) <= grid.rows || (32 << (levels + 1)) <= grid.columns) ++levels;
    return std::max(levels, 1);
}

std::int32_t nearest_row(const BaseGrid& grid, float eta)
{
    return static_cast<std::int32_t>(std::lround((eta / k_pi + 0.5f) * static_cast<float>(grid.rows - 1)));
}
std::int32_t nearest_column(const BaseGrid& grid, float omega)
{
    return static_cast<std::int32_t>(std::lround((omega / (2 * k_pi) + 0.5f) * static_cast<float>(grid.columns))) % grid.columns;
}

// The table's start for an undeformed point in units of the semi-axes, taken from the grid: no power is raised for it.
SurfacePlace<float> seed_place(const NormalMapView& map, Vec3f unit)
{
    const float n = static_cast<float>(map.seed_count);
    std::size_t index = 0;
    for (int i = 0; i < 3; ++i) {
        const float x = (map.seeds_mirrored ? std::abs(unit[i]) : 0.5f * (unit[i] + 1)) * n;
        index = index * map.seed_count + static_cast<std::size_t>(std::clamp(x, 0.0f, n - 1));
    }
    const FootSeed seed = map.seeds[index];
    SurfacePlace<float> place = place_of_sample(map, (seed.eta * (map.eta_count - 1) + 127) / 255,
                                                (seed.omega * map.omega_count + 128) / 256 % map.omega_count);
    if (map.seeds_mirrored) {
        const auto flip = [](float like, float& c, float& nc) {
            c = std::copysign(c, like);
            nc = std::copysign(nc, like);
        };
        flip(unit.x, place.longitude.c, place.longitude.nc);
        flip(unit.y, place.longitude.s, place.longitude.ns);
        flip(unit.z, place.latitude.s, place.latitude.ns);
    }
    return place;
}

// A query point as both projectors need it.
struct Query {
    Vec3f local;              // in the superquadric's frame
    Vec3f unit;               // undeformed, divided by the semi-axes
    float gauge;              // F^(1/2)
    SurfacePlace<float> own;  // where its own ray leaves the surface
};

// False where the point is outside the superquadric or not a number; most points are so before any power is raised.
bool enters(const NormalMapView& map, Vec3f p, Query& query)
{
    const Superquadricf& sq = map.superquadric;
    query.local = shape::to_local(sq, p);
    const Vec3f q = shape::undeform(sq, query.local);
    query.unit = {q.x / sq.a.x, q.y / sq.a.y, q.z / sq.a.z};
    if (!(std::abs(query.unit.x) <= 1 && std::abs(query.unit.y) <= 1 && std::abs(query.unit.z) <= 1)) return false;
    query.own.longitude = shape::arc_through(query.unit.x, query.unit.y, sq.eps2);
    query.own.latitude = shape::arc_through(query.own.longitude.gauge, query.unit.z, sq.eps1);
    query.gauge = query.own.latitude.gauge;
    return query.gauge <= 1;
}

// The nearer of the place on the point's own ray and the table's start: near the surface the first is right, deep inside
// and beside a sharp edge the second.
SurfacePlace<float> nearer_start(const BaseGrid& grid, const Query& query)
{
    const SurfacePlace<float> seed = seed_place(grid.map, query.unit);
    const float own_sq = norm_sq(shape::surface_point(grid.local, query.own).point - query.local);
    return norm_sq(shape::surface_point(grid.local, seed).point - query.local) < own_sq ? seed : query.own;
}

GridFoot search_pyramid(const BaseGrid& grid, const Query& query, const PyramidOptions& options)
{
    Search search{grid, query.local, options.compare_distance};
    const SurfaceAnglesf own = shape::angles_of(options.seeded ? nearer_start(grid, query) : query.own);
    const std::int32_t row = nearest_row(grid, own.eta), column = nearest_column(grid, own.omega);
    const std::int32_t levels = window_levels(grid);
    const std::int32_t stride = std::int32_t{1} << (levels - 1);

    // The window's ends in top-level strides: two strides each way, or the one way of eq. 16.
    std::int32_t row_lo = -2, row_hi = 2, column_lo = -2, column_hi = 2;
    if (!options.both_directions) {
        const Superquadricf& sq = grid.map.superquadric;
        const auto one_way = [](int direction, std::int32_t& lo, std::int32_t& hi) {
            lo = direction < 0 ? -2 : 0;
            hi = direction < 0 ? 0 : 2;
        };
        one_way(shape::predicted_direction(shape::parameter_of_spaced(own.eta, sq.eps1), sq.eps1), row_lo, row_hi);
        one_way(shape::predicted_direction(shape::parameter_of_spaced(own.omega, sq.eps2), sq.eps2), column_lo, column_hi);
    }
    Candidate best;
    std::int32_t best_i = 0, best_j = 0;
    for (std::int32_t i = row_lo; i <= row_hi; ++i)
        for (std::int32_t j = column_lo; j <= column_hi; ++j) {
            const Candidate c = search.at(row + i * stride, column + j * stride);
            if (search.better(c, best)) {
                best = c;
                best_i = i;
                best_j = j;
            }
        }
    const bool at_border = best_i == -2 || best_i == 2 || best_j == -2 || best_j == 2;
    search.descend(best, stride / 2);

    // The foot's cell: a sample is accepted if the line misses the normal by less than the diagonal to its neighbours.
    bool wide = false;
    if (options.wide_fallback) {
        const Vec3f here = grid.point(best.node).point;
        float diagonal = 0;
        for (const std::int32_t way : {-1, 1}) {
            const Node next = grid.wrapped(best.node.row + way, best.node.column + 1);
            diagonal = std::max(diagonal, norm(grid.point(next).point - here));
        }
        const float along = best.collinearity;
        const float miss = std::sqrt(best.distance_sq * std::max(0.0f, 1 - along * along));
        if (at_border || along < 0 || miss > diagonal) {
            wide = true;
            search.compare_distance = true;
            Candidate far = best;
            far.collinearity = along;
            const std::int32_t coarse = std::max(1, (grid.rows - 1) / 8);
            for (std::int32_t i = 0; i < grid.rows; i += coarse)
                for (std::int32_t j = 0; j < grid.columns; j += coarse) search.consider(far, i, j);
            // Walk downhill at every stride until no neighbour is nearer; each step gets nearer, so it ends.
            for (std::int32_t s = coarse; s >= 1; s /= 2)
                for (;;) {
                    const Node centre = far.node;
                    for (std::int32_t i = -1; i <= 1; ++i)
                        for (std::int32_t j = -1; j <= 1; ++j)
                            if (i != 0 || j != 0) search.consider(far, centre.row + i * s, centre.column + j * s);
                    if (far.node.row == centre.row && far.node.column == centre.column) break;
                }
            best = far;
        }
    }
    return {static_cast<std::uint32_t>(best.node.row), static_cast<std::uint32_t>(best.node.column), best.collinearity,
            search.evaluations, wide};
}

float largest_axis(const Superquadricf& sq) { return std::max({sq.a.x, sq.a.y, sq.a.z}); }

// Layer 2: the sample of the base grid itself. Layer 3: the search goes on through the subdivided levels, and one Newton
// step leads from the finest sample to the place between samples that linear interpolation is for.
Foot<float> pyramid_foot(const NormalMapView& map, Vec3f p, const Query& query, bool subdivide, std::uint8_t& flags)
{
    const BaseGrid base(map);
    const GridFoot node = search_pyramid(base, query, {});
    if (node.wide) flags |= k_projection_wide;
    Candidate best;
    best.node = {static_cast<std::int32_t>(node.row), static_cast<std::int32_t>(node.column)};
    const BaseGrid grid(map, subdivide ? 1 : base.stride);
    if (subdivide) {
        best.node = {best.node.row * base.stride, best.node.column * base.stride};
        Search search{grid, query.local, true};
        best = search.at(best.node.row, best.node.column);
        search.descend(best, base.stride / 2);
    }
    return shape::polish_foot(map.superquadric, p, grid.place(best.node), {.max_iterations = subdivide ? 1 : 0, .tolerance = 0});
}

Foot<float> newton_foot(const NormalMapView& map, Vec3f p, const Query& query, std::uint8_t& flags)
{
    const BaseGrid grid(map);
    const float proven = k_proven_miss * largest_axis(grid.local);
    Foot<float> foot = shape::polish_foot(map.superquadric, p, nearer_start(grid, query), k_newton);
    if (foot.miss <= proven) return foot;
    // The start lay in no basin (a focal point, a sharp bend): start again from the search.
    flags |= k_projection_wide;
    const GridFoot node = search_pyramid(grid, query, {});
    const Node start{static_cast<std::int32_t>(node.row), static_cast<std::int32_t>(node.column)};
    const Foot<float> again = shape::polish_foot(map.superquadric, p, grid.place(start), k_newton);
    if (again.miss < foot.miss) foot = again;
    if (!(foot.miss <= proven)) flags |= k_projection_unproven;
    return foot;
}

bool is_hit(std::uint16_t code) { return code <= k_map_largest; }

std::size_t node_index(const NormalMapView& map, std::size_t row, std::size_t column) { return row * map.omega_count + column; }

unsigned cut_bits(const NormalMapView& map, std::size_t node) { return (map.cuts[node / 4] >> (2 * (node % 4))) & 3u; }

// Position in a grid of rows by columns: cell and place within it.
struct CellPlace {
    std::size_t row, column, next_column;
    float y, x;
};

CellPlace cell_of(SurfaceAnglesf angles, std::size_t rows, std::size_t columns)
{
    CellPlace c;
    const float y = std::clamp((angles.eta / k_pi + 0.5f), 0.0f, 1.0f) * static_cast<float>(rows - 1);
    const float x = std::clamp(angles.omega / (2 * k_pi) + 0.5f, 0.0f, 1.0f) * static_cast<float>(columns);
    c.row = std::min(static_cast<std::size_t>(y), rows - 2);
    c.column = std::min(static_cast<std::size_t>(x), columns - 1);
    c.next_column = c.column + 1 == columns ? 0 : c.column + 1;
    c.y = y - static_cast<float>(c.row);
    c.x = x - static_cast<float>(c.column);
    return c;
}

float bilinear(const CellPlace& c, float v00, float v01, float v10, float v11)
{
    const float low = v00 + c.x * (v01 - v00), high = v10 + c.x * (v11 - v10);
    return low + c.y * (high - low);
}

float offset_at(const NormalMapView& map, SurfaceAnglesf angles)
{
    if (map.offset.empty()) return 0;
    const std::size_t rows = ((map.eta_count - 1) >> map.subdivisions) + 1, columns = map.omega_count >> map.subdivisions;
    const CellPlace c = cell_of(angles, rows, columns);
    const auto value = [&](std::size_t i, std::size_t j) {
        return map.offset_scale * static_cast<float>(map.offset[i * columns + j]);
    };
    return bilinear(c, value(c.row, c.column), value(c.row, c.next_column), value(c.row + 1, c.column),
                    value(c.row + 1, c.next_column));
}

MapSample value_of_code(const NormalMapView& map, std::uint16_t code, std::uint16_t normal)
{
    if (code == k_map_miss) return {std::numeric_limits<float>::infinity(), {}, k_projection_miss};
    if (code == k_map_cap) return {0, {}, k_projection_cap};
    return {map.distance_scale * static_cast<float>(code), decode_normal(normal), 0};
}

// Layer 2: the sample of the base grid nearest in angle.
MapSample nearest_base_sample(const NormalMapView& map, SurfaceAnglesf angles)
{
    const std::size_t rows = ((map.eta_count - 1) >> map.subdivisions) + 1, columns = map.omega_count >> map.subdivisions;
    const CellPlace c = cell_of(angles, rows, columns);
    const std::size_t row = (c.row + (c.y >= 0.5f ? 1 : 0)) << map.subdivisions;
    const std::size_t column = (c.x >= 0.5f ? c.next_column : c.column) << map.subdivisions;
    const std::size_t node = node_index(map, row, column);
    return value_of_code(map, map.distance[node], map.normal[node]);
}

// Step 4 of section 4.2: Layer 3 is worth its time while the base grid has fewer samples than k_L times the vertices.
bool reads_base_grid(const NormalMapView& map, const ProjectionOptions& options)
{
    if (options.layer != Layer::Gate) return options.layer == Layer::Two;
    const std::uint64_t base =
        std::uint64_t{((map.eta_count - 1) >> map.subdivisions) + 1} * (map.omega_count >> map.subdivisions);
    return base >= std::uint64_t{options.layer3_gate} * map.vertex_count;
}

float correction_at(const NormalMapView& map, const CellPlace& c)
{
    const VertexCorrection* first = map.corrections.data() + map.correction_rows[c.row];
    const VertexCorrection* last = map.corrections.data() + map.correction_rows[c.row + 1];
    first =
        std::lower_bound(first, last, c.column, [](const VertexCorrection& v, std::size_t column) { return v.column < column; });
    float sum = 0;
    for (; first != last && first->column == c.column; ++first) {
        const float y0 = (static_cast<float>(first->eta) + 0.5f) / 256, x0 = (static_cast<float>(first->omega) + 0.5f) / 256;
        const float hat = std::min({c.x / x0, (1 - c.x) / (1 - x0), c.y / y0, (1 - c.y) / (1 - y0)});
        sum += std::max(hat, 0.0f) * static_cast<float>(first->correction);
    }
    return map.distance_scale * sum;
}

// Openings of the nearest sample's ray. Sets distance to where the solid is entered again if the point at foot distance s
// lies in one or behind one; false where none matters.
bool behind_first_surface(const NormalMapView& map, SurfaceAnglesf angles, float s, float& distance)
{
    if (map.gaps.empty()) return false;
    const CellPlace c = cell_of(angles, map.eta_count, map.omega_count);
    const std::size_t row = c.row + (c.y >= 0.5f ? 1 : 0), column = c.x >= 0.5f ? c.next_column : c.column;
    const model::MapGap* first = map.gaps.data() + map.gap_rows[row];
    const model::MapGap* last = map.gaps.data() + map.gap_rows[row + 1];
    first = std::lower_bound(first, last, column, [](const model::MapGap& g, std::size_t k) { return g.column < k; });
    bool found = false;
    for (; first != last && first->column == column; ++first) {
        if (s <= map.distance_scale * static_cast<float>(first->leave)) break;
        found = true;
        distance = first->enter == k_map_miss ? std::numeric_limits<float>::infinity()
                                              : map.distance_scale * static_cast<float>(first->enter);
    }
    return found;
}

// Layer 3: linear interpolation on one sheet of the surface: that of the nearest corner, followed along uncut edges.
MapSample interpolated_sample(const NormalMapView& map, SurfaceAnglesf angles, bool use_corrections)
{
    const CellPlace c = cell_of(angles, map.eta_count, map.omega_count);
    // Corners 0 (row, column), 1 (row, next), 2 (next, column), 3 (next, next).
    const std::size_t node[4] = {node_index(map, c.row, c.column), node_index(map, c.row, c.next_column),
                                 node_index(map, c.row + 1, c.column), node_index(map, c.row + 1, c.next_column)};
    const unsigned b0 = cut_bits(map, node[0]), b1 = cut_bits(map, node[1]), b2 = cut_bits(map, node[2]);
    const bool bottom = (b0 & 2) == 0, top = (b2 & 2) == 0, left = (b0 & 1) == 0, right = (b1 & 1) == 0;  // uncut
    const int nearest = (c.y >= 0.5f ? 2 : 0) + (c.x >= 0.5f ? 1 : 0);
    const std::uint16_t code = map.distance[node[nearest]];
    const bool whole = bottom && top && left && right;
    // Where a surface enters the superquadric inside the cell, which side of it a place lies on is a guess.
    std::uint8_t mixed = whole ? 0 : k_projection_silhouette;
    for (const std::size_t k : node)
        if (!whole && code != k_map_cap && map.distance[k] == k_map_cap) mixed |= k_projection_by_cap;
    if (!is_hit(code)) {
        MapSample sample = value_of_code(map, code, 0);
        sample.flags |= mixed;
        return sample;
    }
    float value[4];
    Vec3f normal[4];
    bool known[4] = {false, false, false, false};
    known[nearest] = true;
    // Edges: 0-1 bottom, 2-3 top, 0-2 left, 1-3 right. Three sweeps reach every corner from any start.
    for (int sweep = 0; sweep < 3; ++sweep) {
        const auto join = [&](bool uncut, int a, int b) {
            if (uncut && known[a] != known[b]) known[a] = known[b] = true;
        };
        join(bottom, 0, 1);
        join(top, 2, 3);
        join(left, 0, 2);
        join(right, 1, 3);
    }
    for (int i = 0; i < 4; ++i)
        if (known[i]) {
            value[i] = map.distance_scale * static_cast<float>(map.distance[node[i]]);
            normal[i] = decode_normal(map.normal[node[i]]);
        }
    const bool all = known[0] && known[1] && known[2] && known[3];
    // Corners on another sheet are continued from this one: in the plane of three corners, level across the missing side
    // of two, constant from one.
    if (!all) {
        const bool had[4] = {known[0], known[1], known[2], known[3]};
        for (int i = 0; i < 4; ++i) {
            if (had[i]) continue;
            const int along = i ^ 1, across = i ^ 2, opposite = i ^ 3;
            const int from = had[along] ? along : (had[across] ? across : opposite);
            value[i] = had[along] && had[across] && had[opposite] ? value[along] + value[across] - value[opposite] : value[from];
            normal[i] = normal[from];
        }
    }
    MapSample sample;
    sample.distance = bilinear(c, value[0], value[1], value[2], value[3]);
    for (int k = 0; k < 3; ++k) sample.normal[k] = bilinear(c, normal[0][k], normal[1][k], normal[2][k], normal[3][k]);
    sample.normal = normalized(sample.normal);
    if (!whole) {
        sample.flags = mixed;
    } else if (use_corrections && !map.corrections.empty()) {
        sample.distance += correction_at(map, c);
    }
    sample.distance = std::max(sample.distance, 0.0f);
    return sample;
}

// Closest-point steps on the map: the surface looked up again at the projection of p on the tangent plane of the surface
// point found. A step is kept while it leads to a nearer surface point.
void seek_nearest(const NormalMapView& map, Vec3f p, const ProjectionOptions& options, PartAnswer& answer)
{
    float nearest = norm(answer.surface - p);
    for (int step = 0; step < options.nearest_steps; ++step) {
        const Vec3f target = p + dot(answer.surface - p, answer.normal) * answer.normal;
        std::uint8_t flags = 0;
        const Foot<float> foot = find_foot(map, target, Projector::Newton, &flags);
        if ((flags & k_projection_unproven) != 0) return;
        const MapSample sample = sample_map(map, shape::angles_of(foot.place), options);
        if ((sample.flags & (k_projection_miss | k_projection_cap)) != 0 || !(norm_sq(sample.normal) > 0.5f)) return;
        const Vec3f surface = foot.point - sample.distance * foot.normal;
        const float distance = norm(surface - p);
        if (!(distance < nearest)) return;
        nearest = distance;
        answer.surface = surface;
        answer.normal = sample.normal;
        answer.depth = dot(surface - p, sample.normal);
    }
}

}  // namespace

GridFoot pyramid_search(const NormalMapView& map, Vec3f p, const PyramidOptions& options) noexcept
{
    Query query;
    return enters(map, p, query) ? search_pyramid(BaseGrid(map), query, options) : GridFoot{};
}

Foot<float> find_foot(const NormalMapView& map, Vec3f p, Projector projector, std::uint8_t* flags) noexcept
{
    std::uint8_t found = 0;
    Query query;
    Foot<float> foot;
    if (!enters(map, p, query)) {
        // Outside or on the surface to rounding: the foot nearest to where its own ray leaves.
        foot = shape::polish_foot(map.superquadric, p, shape::place_through(map.superquadric, p), k_newton);
        if (!(foot.miss <= k_proven_miss * largest_axis(map.superquadric))) found = k_projection_unproven;
    } else {
        foot = projector == Projector::Pyramid ? pyramid_foot(map, p, query, true, found) : newton_foot(map, p, query, found);
    }
    if (flags) *flags = found;
    return foot;
}

MapSample sample_map(const NormalMapView& map, SurfaceAnglesf angles, const ProjectionOptions& options) noexcept
{
    MapSample sample = reads_base_grid(map, options) ? nearest_base_sample(map, angles)
                                                     : interpolated_sample(map, angles, options.use_corrections);
    if (options.use_offset && (sample.flags & (k_projection_miss | k_projection_cap)) == 0)
        sample.distance = std::max(sample.distance - offset_at(map, angles), 0.0f);
    return sample;
}

MapSample sample_smoothed(const NormalMapView& map, SurfaceAnglesf angles) noexcept
{
    MapSample sample = sample_map(map, angles, {});
    if (map.smoothed.empty() || (sample.flags & (k_projection_miss | k_projection_cap | k_projection_silhouette)) != 0)
        return sample;
    const std::size_t rows = ((map.eta_count - 1) >> map.subdivisions) + 1, columns = map.omega_count >> map.subdivisions;
    const CellPlace c = cell_of(angles, rows, columns);
    const model::SmoothedSample corner[4] = {
        map.smoothed[c.row * columns + c.column], map.smoothed[c.row * columns + c.next_column],
        map.smoothed[(c.row + 1) * columns + c.column], map.smoothed[(c.row + 1) * columns + c.next_column]};
    Vec3f normal[4];
    float change[4];
    for (int i = 0; i < 4; ++i) {
        if (corner[i].change == model::k_not_smoothed) return sample;
        change[i] = map.distance_scale * static_cast<float>(corner[i].change);
        normal[i] = decode_normal(corner[i].normal);
    }
    sample.distance = std::max(sample.distance + bilinear(c, change[0], change[1], change[2], change[3]), 0.0f);
    for (int k = 0; k < 3; ++k) sample.normal[k] = bilinear(c, normal[0][k], normal[1][k], normal[2][k], normal[3][k]);
    sample.normal = normalized(sample.normal);
    return sample;
}

PartAnswer project(const NormalMapView& map, Vec3f p, const ProjectionOptions& options) noexcept
{
    PartAnswer answer;
    Query query;
    if (!enters(map, p, query)) return answer;
    if (options.layer == Layer::One) {
        answer.verdict = Verdict::Contact;
        const SurfacePoint<float> s = shape::surface_point(map.superquadric, query.own);
        answer.angles = shape::angles_of(query.own);
        answer.foot = answer.surface = s.point;
        answer.foot_normal = answer.normal = s.normal;
        answer.foot_distance = answer.depth_along = norm(s.point - p);
        answer.depth = dot(s.point - p, s.normal);
        return answer;
    }
    const Foot<float> foot = options.projector == Projector::Pyramid
                                 ? pyramid_foot(map, p, query, !reads_base_grid(map, options), answer.flags)
                                 : newton_foot(map, p, query, answer.flags);
    answer.angles = shape::angles_of(foot.place);
    answer.foot = foot.point;
    answer.foot_normal = foot.normal;
    answer.foot_distance = norm(foot.point - p);
    MapSample sample = sample_map(map, answer.angles, options);
    if (options.use_gaps && answer.foot_distance > sample.distance && !reads_base_grid(map, options) &&
        behind_first_surface(map, answer.angles, answer.foot_distance, sample.distance)) {
        sample.flags = k_projection_behind | (sample.distance < std::numeric_limits<float>::infinity() ? 0 : k_projection_miss);
        sample.normal = {};
    }
    answer.flags |= sample.flags;
    answer.map_distance = sample.distance;
    answer.verdict = answer.foot_distance >= sample.distance ? Verdict::Contact : Verdict::Free;
    const bool surface = (sample.flags & (k_projection_miss | k_projection_cap)) == 0;
    answer.surface = surface ? foot.point - sample.distance * foot.normal : foot.point;
    answer.normal = surface && norm_sq(sample.normal) > 0.5f ? sample.normal : foot.normal;
    answer.depth_along = answer.foot_distance - sample.distance;
    answer.depth = surface ? dot(answer.surface - p, answer.normal) : answer.depth_along;
    if (surface && answer.verdict == Verdict::Contact && norm_sq(sample.normal) > 0.5f && !reads_base_grid(map, options))
        seek_nearest(map, p, options, answer);
    return answer;
}

CombinedAnswer combine(std::span<const PartAnswer> answers) noexcept
{
    CombinedAnswer out;
    float least = std::numeric_limits<float>::infinity();
    for (std::size_t i = 0; i < answers.size(); ++i) {
        const PartAnswer& a = answers[i];
        if (is_witness(a)) return {};
        if (a.verdict != Verdict::Contact) continue;
        out.contact = true;
        const bool surface = (a.flags & k_projection_cap) == 0;
        if (surface && std::abs(a.depth) < least) {
            least = std::abs(a.depth);
            out.has_surface = true;
            out.part = static_cast<std::int32_t>(i);
        } else if (!out.has_surface && out.part < 0) {
            out.part = static_cast<std::int32_t>(i);
        }
    }
    return out;
}

std::uint16_t encode_normal(Vec3f n) noexcept
{
    const float sum = std::abs(n.x) + std::abs(n.y) + std::abs(n.z);
    if (!(sum > 0)) return encode_normal({0, 0, 1});
    float u = n.x / sum, v = n.y / sum;
    if (n.z < 0) {
        const float fold = (1 - std::abs(v)) * (u < 0 ? -1.0f : 1.0f);
        v = (1 - std::abs(u)) * (v < 0 ? -1.0f : 1.0f);
        u = fold;
    }
    const auto code = [](float w) { return static_cast<unsigned>(std::lround(std::clamp((w + 1) * 127.5f, 0.0f, 255.0f))); };
    return static_cast<std::uint16_t>(code(u) | code(v) << 8);
}

Vec3f decode_normal(std::uint16_t code) noexcept
{
    float u = static_cast<float>(code & 255u) / 127.5f - 1, v = static_cast<float>(code >> 8) / 127.5f - 1;
    const float z = 1 - std::abs(u) - std::abs(v);
    if (z < 0) {
        const float fold = (1 - std::abs(v)) * (u < 0 ? -1.0f : 1.0f);
        v = (1 - std::abs(u)) * (v < 0 ? -1.0f : 1.0f);
        u = fold;
    }
    return normalized(Vec3f{u, v, z});
}

}  // namespace sqmap::query
