// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, section 4.2, eqs. 15 to 20, with corrections: both
// search directions, a wide search where the window does not hold the foot, distance compared beside collinearity.
#include "foot_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace sqmap::query {

using model::FootSeed;
using shape::Foot;
using shape::Superquadricf;
using shape::SurfaceAnglesf;
using shape::SurfacePoint;
using shape::SurfacePosition;

namespace {

constexpr float k_pi = std::numbers::pi_v<float>;

// Tangential miss at which a foot counts as found, of the largest semi-axis: well below a cell, above float rounding.
constexpr shape::FootOptions k_newton{.max_iterations = 10, .tolerance = 1e-5};
constexpr float k_proven_miss = 1e-3f;

SurfacePosition<float> position_of_sample(const NormalMapView& map, std::size_t row, std::size_t column)
{
    if (!map.rows.empty()) return {map.rows[row], map.columns[column]};
    return shape::position_at(map.superquadric,
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
    SurfacePosition<float> position(Node n) const
    {
        return position_of_sample(map, static_cast<std::size_t>(n.row * stride), static_cast<std::size_t>(n.column * stride));
    }
    SurfacePoint<float> point(Node n) const { return shape::surface_point(local, position(n)); }
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
SurfacePosition<float> table_start(const NormalMapView& map, Vec3f unit)
{
    const float n = static_cast<float>(map.seed_count);
    std::size_t index = 0;
    for (int i = 0; i < 3; ++i) {
        const float x = (map.seeds_mirrored ? std::abs(unit[i]) : 0.5f * (unit[i] + 1)) * n;
        index = index * map.seed_count + static_cast<std::size_t>(std::clamp(x, 0.0f, n - 1));
    }
    const FootSeed seed = map.seeds[index];
    SurfacePosition<float> position = position_of_sample(map, (seed.eta * (map.eta_count - 1) + 127) / 255,
                                                         (seed.omega * map.omega_count + 128) / 256 % map.omega_count);
    if (map.seeds_mirrored) {
        const auto flip = [](float like, float& c, float& nc) {
            c = std::copysign(c, like);
            nc = std::copysign(nc, like);
        };
        flip(unit.x, position.longitude.c, position.longitude.nc);
        flip(unit.y, position.longitude.s, position.longitude.ns);
        flip(unit.z, position.latitude.s, position.latitude.ns);
    }
    return position;
}

// The nearer of the place on the point's own ray and the table's start: near the surface the first is right, deep inside
// and beside a sharp edge the second.
SurfacePosition<float> nearer_start(const BaseGrid& grid, const FootQuery& query)
{
    const SurfacePosition<float> seed = table_start(grid.map, query.unit);
    const float own_sq = norm_sq(shape::surface_point(grid.local, query.own).point - query.local);
    return norm_sq(shape::surface_point(grid.local, seed).point - query.local) < own_sq ? seed : query.own;
}

GridFoot search_pyramid(const BaseGrid& grid, const FootQuery& query, const PyramidOptions& options)
{
    Search search{grid, query.local, options.compare_distance};
    const SurfaceAnglesf own = shape::angles_of(options.seeded ? nearer_start(grid, query) : query.own);
    const std::int32_t row = nearest_row(grid, own.eta), column = nearest_column(grid, own.omega);
    const std::int32_t levels = window_levels(grid);
    const std::int32_t stride = std::int32_t{1} << (levels - 1);

    // The window's ends in top-level strides: two strides each direction, or the one of eq. 16.
    std::int32_t row_lo = -2, row_hi = 2, column_lo = -2, column_hi = 2;
    if (!options.both_directions) {
        const Superquadricf& sq = grid.map.superquadric;
        const auto one_direction = [](int direction, std::int32_t& lo, std::int32_t& hi) {
            lo = direction < 0 ? -2 : 0;
            hi = direction < 0 ? 0 : 2;
        };
        one_direction(shape::predicted_direction(shape::parameter_of_spaced(own.eta, sq.eps1), sq.eps1), row_lo, row_hi);
        one_direction(shape::predicted_direction(shape::parameter_of_spaced(own.omega, sq.eps2), sq.eps2), column_lo, column_hi);
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
        for (const std::int32_t side : {-1, 1}) {
            const Node next = grid.wrapped(best.node.row + side, best.node.column + 1);
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

}  // namespace

bool enters(const NormalMapView& map, Vec3f p, FootQuery& query)
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

Foot<float> pyramid_foot(const NormalMapView& map, Vec3f p, const FootQuery& query, bool subdivide, std::uint8_t& flags)
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
    return shape::polish_foot(map.superquadric, p, grid.position(best.node),
                              {.max_iterations = subdivide ? 1 : 0, .tolerance = 0});
}

Foot<float> newton_foot(const NormalMapView& map, Vec3f p, const FootQuery& query, std::uint8_t& flags)
{
    const BaseGrid grid(map);
    const float proven = k_proven_miss * largest_axis(grid.local);
    Foot<float> foot = shape::polish_foot(map.superquadric, p, nearer_start(grid, query), k_newton);
    if (foot.miss <= proven) return foot;
    // The start lay in no basin (a focal point, a sharp bend): start again from the search.
    flags |= k_projection_wide;
    const GridFoot node = search_pyramid(grid, query, {});
    const Node start{static_cast<std::int32_t>(node.row), static_cast<std::int32_t>(node.column)};
    const Foot<float> again = shape::polish_foot(map.superquadric, p, grid.position(start), k_newton);
    if (again.miss < foot.miss) foot = again;
    if (!(foot.miss <= proven)) flags |= k_projection_unproven;
    return foot;
}

GridFoot pyramid_search(const NormalMapView& map, Vec3f p, const PyramidOptions& options) noexcept
{
    FootQuery query;
    return enters(map, p, query) ? search_pyramid(BaseGrid(map), query, options) : GridFoot{};
}

Foot<float> find_foot(const NormalMapView& map, Vec3f p, Projector projector, std::uint8_t* flags) noexcept
{
    std::uint8_t found = 0;
    FootQuery query;
    Foot<float> foot;
    if (!enters(map, p, query)) {
        // Outside or on the surface to rounding: the foot nearest to where its own ray leaves.
        foot = shape::polish_foot(map.superquadric, p, shape::position_through(map.superquadric, p), k_newton);
        if (!(foot.miss <= k_proven_miss * largest_axis(map.superquadric))) found = k_projection_unproven;
    } else {
        foot = projector == Projector::Pyramid ? pyramid_foot(map, p, query, true, found) : newton_foot(map, p, query, found);
    }
    if (flags) *flags = found;
    return foot;
}

}  // namespace sqmap::query
