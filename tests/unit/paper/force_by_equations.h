// Depth and normal of the paper's force at a point (eqs. 21, 22 and 26), worked out in double from the stored arrays of a paper
// model. Feet and verdicts are those of the searches, whose own tests stand in projection_test.cpp.
#pragma once

#include "paper/model/codes.h"
#include "sqmap/paper/projection.h"
#include "support/decoded.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

namespace sqmap::paper::by_equations {

/// rad: errors of the kernels' sines, cosines and angles beside functions in double (docs/algorithms/paper-map.md, Powers).
inline constexpr double k_angle_rounding = 4e-7;
/// rad: the same, and of the cell that the angles are in.
inline constexpr double k_shifted_angle = 1e-6;
/// Errors that the kernels' powers, sines and angles leave in the coordinates of a foot, as a share of its size.
inline constexpr double k_position_rounding = 1e-6;
/// A force may be off by so many times what one shift of all angles and positions moves it: each operation rounds by itself.
inline constexpr double k_shifts_margin = 4;

/// A unit vector across a unit vector.
inline Vec3d perpendicular_to(Vec3d n) { return normalized(cross(n, std::abs(n.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0})); }

/// Depth and normal at a point.
struct Spring {
    double depth = 0;  ///< 0: none
    Vec3d normal{};
    double rounding = 0;  ///< of depth times normal, from the angles; the length unit of depth
};

/// A cell of a grid that is equal-spaced in eta and omega, and a position in it.
struct Cell {
    Cell(shape::SurfaceAngles<double> angles, std::size_t row_count, std::size_t column_count)
        : rows(row_count), columns(column_count)
    {
        const auto n = static_cast<double>(rows - 1), m = static_cast<double>(columns);
        const double at_y = std::clamp((angles.eta / M_PI + 0.5) * n, 0., n);
        double at_x = (angles.omega / (2 * M_PI) + 0.5) * m;
        at_x += at_x < 0 ? m : at_x > m ? -m : 0.;  // columns go around
        row = std::min(static_cast<std::size_t>(at_y), rows - 2);
        column = std::min(static_cast<std::size_t>(at_x), columns - 1);
        y = at_y - static_cast<double>(row);
        x = at_x - static_cast<double>(column);
    }
    /// Corner i: bit 0 the next column, bit 1 the next row.
    [[nodiscard]] std::size_t corner(std::size_t i) const { return (row + i / 2) * columns + (column + i % 2) % columns; }
    [[nodiscard]] double weight(std::size_t i) const { return (i % 2 == 0 ? 1 - x : x) * (i < 2 ? 1 - y : y); }
    [[nodiscard]] std::size_t nearest() const { return (y >= 0.5 ? 2u : 0u) + (x >= 0.5 ? 1u : 0u); }
    /// True where rounding to float may choose another cell, or another nearest corner.
    [[nodiscard]] bool is_near_middle() const { return std::min(std::abs(x - 0.5), std::abs(y - 0.5)) < 2e-4; }
    [[nodiscard]] bool is_near_border() const
    {
        const auto close = [](double v) { return std::min(std::abs(v), std::abs(1 - v)) < 2e-4; };
        return close(x) || close(y);
    }

    std::size_t rows, columns, row, column;
    double x, y;
};

/// One part's map as its documentation has it.
class MapByEquations {
public:
    MapByEquations(const MapView& map, const ProjectionOptions& options, bool smoothed)
        : map_(map),
          options_(options),
          smoothed_(smoothed && !map.smoothed.empty()),
          base_rows_(((map.eta_count - 1) >> map.subdivisions) + 1),
          base_columns_(map.omega_count >> map.subdivisions),
          sq_(shape::cast<double>(map.superquadric))
    {
    }

    /// The spring of a part that claims the point with a surface. Nothing where rounding may decide what is read.
    [[nodiscard]] std::optional<Spring> spring(const PartAnswer& a, Vec3d p) const
    {
        const shape::SurfaceAngles<double> angles{a.angles.eta, a.angles.omega};
        if (is_unsteady(angles)) return std::nullopt;
        if (options_.nearest_steps == 0 || options_.layer == query::Layer::Two || (a.flags & k_projection_behind) != 0)
            return spring_of_foot(a, angles, p);
        Outcomes out;
        for (const Shift& shift : k_shifts) {
            const std::optional<Shown> shown = shown_at(angles, shift);
            if (!shown) return std::nullopt;
            if (shown->has_surface())
                follow(a, *shown, p, {options_.nearest_steps, shift}, out);
            else if (shift.is_none())
                return spring_of_foot(a, angles, p);
            else
                return std::nullopt;
        }
        return out.agreed(2e-5 * size());
    }

    /// The spring that closest-point steps from the part's table of surfaces lead to; without a normal: they start at none that
    /// is nearer than the nearest so far. Nothing where rounding may decide.
    [[nodiscard]] std::optional<Spring> spring_of_table(Vec3d p, const Spring& nearest) const
    {
        Outcomes out;
        const shape::SurfaceAngles<double> start = table_start(p);
        for (const Shift& shift : k_shifts) {
            if (shift.is_none()) continue;  // seeds lie on borders of cells
            const std::optional<Shown> shown = shown_at(start, shift);
            if (!shown) return std::nullopt;
            if (!shown->has_surface() || shown->is_cut) {
                out.springs.push_back({});
                continue;
            }
            const double length = norm(shown->surface - p), depth = dot(shown->surface - p, shown->normal);
            const double closer = nearest.depth - length, rounding = 1e-6 * size();
            if (std::abs(closer) < rounding + nearest.rounding || std::abs(depth) < rounding) return std::nullopt;
            if (closer > 0 && depth > 0)
                follow({}, *shown, p, {options_.nearest_steps, shift}, out);
            else
                out.springs.push_back({});
        }
        return out.agreed(2e-5 * size());
    }

private:
    struct Sample {
        double distance = 0;
        Vec3d normal{};       ///< zero: none
        bool is_cut = false;  ///< its cell holds a jump
        bool is_cap = false;  ///< the ray starts inside the solid
    };
    /// The surface that the map shows at a foot.
    struct Shown {
        shape::SurfaceAngles<double> angles;
        Vec3d surface{}, normal{};
        bool is_cut = false;
        [[nodiscard]] bool has_surface() const { return norm(normal) > 0; }
    };
    /// The way in which float rounds a foot's angles and the position that a step is taken to: 0, or 1 towards either side.
    struct Shift {
        int eta, omega, along, across;
        [[nodiscard]] bool is_none() const { return eta == 0; }
    };
    static constexpr Shift k_shifts[] = {{0, 0, 0, 0},   {-1, -1, -1, -1}, {-1, 1, -1, 1}, {1, -1, 1, -1}, {1, 1, 1, 1},
                                         {-1, -1, 1, 1}, {-1, 1, 1, -1},   {1, -1, -1, 1}, {1, 1, -1, -1}};
    /// Springs of which rounding to float may choose any.
    struct Outcomes {
        std::vector<Spring> springs;
        bool is_known = true;

        /// The spring, if shifts move it by no more than a length.
        [[nodiscard]] std::optional<Spring> agreed(double within) const
        {
            if (!is_known || springs.empty()) return std::nullopt;
            Spring out = springs[0];
            for (const Spring& s : springs) {
                const double apart = norm(s.depth * s.normal - out.depth * out.normal);
                if (apart > within || (norm(s.normal) > 0) != (norm(out.normal) > 0)) return std::nullopt;
                out.rounding = std::max(out.rounding, s.rounding + k_shifts_margin * apart);
            }
            return out;
        }
    };

    /// The spring at the foot itself.
    [[nodiscard]] std::optional<Spring> spring_of_foot(const PartAnswer& a, shape::SurfaceAngles<double> angles, Vec3d p) const
    {
        std::optional<Spring> out = spring_at(a, angles, p, 0);
        if (!out) return out;
        const auto worse = [&](const std::optional<Spring>& moved) {
            if (moved) out->rounding = std::max(out->rounding, norm(moved->depth * moved->normal - out->depth * out->normal));
        };
        for (const double e : {-k_angle_rounding, k_angle_rounding}) {
            worse(spring_at(a, angles, p, e));
            worse(spring_at(a, {angles.eta + e, angles.omega + e}, p, 0));
            worse(spring_at(a, {angles.eta + e, angles.omega - e}, p, 0));
        }
        return out;
    }

    [[nodiscard]] double size() const { return std::max({sq_.a.x, sq_.a.y, sq_.a.z}); }
    /// The surface below a foot, whose angles float may have shifted. Nothing where rounding decides what is read.
    [[nodiscard]] std::optional<Shown> shown_at(shape::SurfaceAngles<double> angles, const Shift& shift) const
    {
        const shape::SurfaceAngles<double> at{angles.eta + k_shifted_angle * shift.eta,
                                              angles.omega + k_shifted_angle * shift.omega};
        const std::optional<Sample> sample = finest_sample(at);
        if (!sample) return std::nullopt;
        const auto foot = shape::surface_point(sq_, angles);
        return Shown{angles, foot.point - sample->distance * foot.normal, sample->normal, sample->is_cut};
    }
    /// Steps that are left, and how float shifts what they read.
    struct Going {
        int steps;
        Shift shift;
    };
    /// Closest-point steps as documented: the foot of the point's projection on the surface's tangent plane, by Newton's method
    /// from the foot before; a step counts while its surface is nearer.
    void follow(const PartAnswer& a, const Shown& from, Vec3d p, const Going& going, Outcomes& out) const
    {
        const auto stay = [&] {
            const std::optional<Spring> spring = spring_of_foot(a, from.angles, p);
            out.is_known = out.is_known && spring.has_value();
            if (spring) out.springs.push_back(*spring);
        };
        if (going.steps == 0 || !out.is_known) return stay();
        const Vec3d u = perpendicular_to(from.normal), v = cross(from.normal, u);
        const double moved = k_position_rounding * (size() + norm(p));
        const Vec3d target = p + dot(from.surface - p, from.normal) * from.normal +
                             moved * (double(going.shift.along) * u + double(going.shift.across) * v);
        std::vector<double> misses;
        // The miss at which the iteration ends is float's, of that share of the largest semi-axis.
        for (const double tolerance : {0.9e-5, 1.1e-5}) {
            const auto foot = shape::polish_foot(sq_, target, shape::position_at(sq_, from.angles),
                                                 {.max_iterations = 10, .tolerance = tolerance});
            if (!misses.empty() && misses.back() == foot.miss) continue;
            misses.push_back(foot.miss);
            const shape::SurfaceAngles<double> angles = shape::angles_of(foot.position);
            if (std::abs(foot.miss - 1e-3 * size()) < 1e-6 * size() || is_unsteady(angles)) out.is_known = false;
            const std::optional<Shown> next = shown_at(angles, going.shift);
            if (!next) out.is_known = false;
            if (!out.is_known) return;
            const double nearer = norm(from.surface - p) - norm(next->surface - p), rounding = 1e-6 * size();
            const bool shows = foot.miss <= 1e-3 * size() && next->has_surface();
            if (!shows || nearer < rounding) stay();
            if (shows && nearer > -rounding) follow(a, *next, p, {going.steps - 1, going.shift}, out);
        }
    }
    /// The start that the table of surfaces has for the cell about a point.
    [[nodiscard]] shape::SurfaceAngles<double> table_start(Vec3d p) const
    {
        const Vec3d q = shape::undeform(sq_, shape::to_local(sq_, p));
        std::size_t cell = 0;
        for (int k = 0; k < 3; ++k) {
            const double at = 0.5 * (1 + q[k] / sq_.a[k]) * k_surface_seeds;
            cell = cell * k_surface_seeds + static_cast<std::size_t>(std::clamp(at, 0., k_surface_seeds - 1.));
        }
        const FootSeed& seed = map_.surface_seeds[cell];
        return {seed.eta * M_PI / 255 - M_PI / 2, seed.omega * 2 * M_PI / 256 - M_PI};
    }

    [[nodiscard]] Cell base_cell(shape::SurfaceAngles<double> angles) const { return {angles, base_rows_, base_columns_}; }
    [[nodiscard]] std::size_t finest_node(std::size_t base_node) const
    {
        return (base_node / base_columns_ << map_.subdivisions) * map_.omega_count +
               (base_node % base_columns_ << map_.subdivisions);
    }
    [[nodiscard]] std::uint16_t base_code(std::size_t base_node) const { return map_.distance[finest_node(base_node)]; }
    [[nodiscard]] double length_of(double code) const { return double(map_.distance_scale) * code; }
    /// Both are stored for hits alone.
    [[nodiscard]] Vec3d normal_of(std::size_t base_node) const
    {
        return base_code(base_node) > k_map_largest ? Vec3d{} : decoded(map_.normal[hit_index(map_, base_node)]);
    }
    static Vec3d smoothed_normal(const SmoothedSample& s) { return cast<double>(model::octahedral_normal<7>(s.normal)); }
    [[nodiscard]] double change_of(const SmoothedSample& s) const { return double(map_.change_scale) * s.steps(); }
    /// Rise from one sheet's base sample to the next, at most: three spacings.
    [[nodiscard]] double steepest() const
    {
        return 3 * M_PI * std::max({sq_.a.x, sq_.a.y, sq_.a.z}) / double(std::min(base_rows_ - 1, base_columns_ / 2));
    }
    /// Positions at which what is read jumps. Within whole cells interpolation is steady, but the corners that others leave alone
    /// keep a share.
    [[nodiscard]] bool is_unsteady(shape::SurfaceAngles<double> angles) const
    {
        const Cell base = base_cell(angles), finest(angles, map_.eta_count, map_.omega_count);
        if (options_.layer == query::Layer::Two) return base.is_near_middle();
        return finest.is_near_middle() || finest.is_near_border() || base.is_near_border();
    }

    /// Layer 2: the base sample nearest in angle.
    [[nodiscard]] Sample base_sample(shape::SurfaceAngles<double> angles) const
    {
        const Cell c = base_cell(angles);
        const std::size_t node = c.corner(c.nearest());
        return {length_of(base_code(node)), normal_of(node)};
    }
    /// Layer 3: steps 2 and 3 on the sheet of the nearest corner.
    [[nodiscard]] std::optional<Sample> finest_sample(shape::SurfaceAngles<double> angles) const
    {
        const Cell c(angles, map_.eta_count, map_.omega_count);
        std::array<double, 4> value{};
        for (std::size_t i = 0; i < 4; ++i) value[i] = length_of(map_.distance[c.corner(i)]);
        Sample out;
        out.is_cap = map_.distance[c.corner(c.nearest())] > k_map_largest;
        if (out.is_cap) return out;
        const std::array<bool, 4> uncut = joined(c);
        out.is_cut = !(uncut[0] && uncut[1] && uncut[2] && uncut[3]);
        if (out.is_cut) value = on_one_sheet(value, uncut, c.nearest());
        for (std::size_t i = 0; i < 4; ++i) out.distance += c.weight(i) * value[i];
        const std::optional<Vec3d> normal = normal_at(angles, out.distance);
        if (!normal) return std::nullopt;
        out.normal = *normal;
        if (!out.is_cut) out.distance += correction(c);
        out.distance = std::max(out.distance, 0.);
        return out;
    }
    /// Uncut sides of a cell: bottom, top, left, right.
    [[nodiscard]] std::array<bool, 4> joined(const Cell& c) const
    {
        const auto cuts = [&](std::size_t node) { return map_.cuts[node / 4] >> 2 * (node % 4) & 3u; };
        const unsigned b0 = cuts(c.corner(0)), b1 = cuts(c.corner(1)), b2 = cuts(c.corner(2));
        return {(b0 & 2u) == 0, (b2 & 2u) == 0, (b0 & 1u) == 0, (b1 & 1u) == 0};
    }
    /// Corners across cuts go on from those of the nearest corner's sheet: in the plane of three, level across the missing side
    /// of two, constant from one.
    static std::array<double, 4> on_one_sheet(std::array<double, 4> value, std::array<bool, 4> uncut, std::size_t nearest)
    {
        constexpr std::size_t k_sides[4][2] = {{0, 1}, {2, 3}, {0, 2}, {1, 3}};
        std::array<bool, 4> known{};
        known[nearest] = true;
        for (int sweep = 0; sweep < 3; ++sweep)
            for (std::size_t s = 0; s < 4; ++s)
                if (const auto [a, b] = k_sides[s]; uncut[s] && (known[a] || known[b])) known[a] = known[b] = true;
        const std::array<double, 4> had = value;
        for (std::size_t i = 0; i < 4; ++i) {
            const std::size_t along = i ^ 1, across = i ^ 2, opposite = i ^ 3;
            if (known[i]) continue;
            if (known[along] && known[across] && known[opposite])
                value[i] = had[along] + had[across] - had[opposite];
            else
                value[i] = had[known[along] ? along : known[across] ? across : opposite];
        }
        return value;
    }
    /// The pyramids of step 3's vertices.
    [[nodiscard]] double correction(const Cell& c) const
    {
        double sum = 0;
        if (map_.correction_rows.empty() || c.row + 1 >= map_.correction_rows.size()) return sum;
        for (std::uint32_t k = map_.correction_rows[c.row]; k < map_.correction_rows[c.row + 1]; ++k) {
            const VertexCorrection& v = map_.corrections[k];
            if (v.column != c.column) continue;
            const double x0 = (v.omega + 0.5) / 256, y0 = (v.eta + 0.5) / 256;
            const double hat = std::min({c.x / x0, (1 - c.x) / (1 - x0), c.y / y0, (1 - c.y) / (1 - y0)});
            sum += length_of(std::max(hat, 0.) * v.correction);
        }
        return sum;
    }
    /// Between the base samples whose distance is within three spacings; nothing where rounding decides which.
    [[nodiscard]] std::optional<Vec3d> normal_at(shape::SurfaceAngles<double> angles, double distance) const
    {
        const Cell c = base_cell(angles);
        Vec3d sum{};
        for (std::size_t i = 0; i < 4; ++i) {
            const std::uint16_t code = base_code(c.corner(i));
            const double rise = std::abs(length_of(code) - distance);
            if (code > k_map_largest) continue;
            if (std::abs(rise - steepest()) < 1e-5) return std::nullopt;
            if (rise < steepest()) sum += std::max(c.weight(i), 1e-4) * normal_of(c.corner(i));
        }
        return norm(sum) > 0 ? normalized(sum) : sum;
    }
    static Vec3d decoded(std::uint16_t code) { return cast<double>(test::decode_normal(code)); }

    /// A sample with what smoothing adds there; as it is where the smoothed map has a hole.
    [[nodiscard]] Sample smoothed(shape::SurfaceAngles<double> angles, Sample sample) const
    {
        const Cell c = base_cell(angles);
        const bool coarse = options_.layer == query::Layer::Two;
        double change = 0;
        Vec3d normal{};
        for (std::size_t i = 0; i < 4; ++i) {
            const double weight = coarse ? double(i == c.nearest()) : c.weight(i);
            if (coarse && i != c.nearest()) continue;
            if (base_code(c.corner(i)) > k_map_largest) return sample;
            const SmoothedSample s = smoothed_at(map_, hit_index(map_, c.corner(i)));
            if (!is_smoothed(s) || sample.is_cut) return sample;
            change += weight * change_of(s);
            normal += weight * smoothed_normal(s);
        }
        return {std::max(sample.distance + change, 0.), normalized(normal)};
    }

    /// Distance of the surface behind the last opening before a foot distance; nothing within rounding.
    [[nodiscard]] std::optional<double> behind(shape::SurfaceAngles<double> angles, double s, double first) const
    {
        const Cell c(angles, map_.eta_count, map_.omega_count);
        const std::size_t node = c.corner(c.nearest()), row = node / map_.omega_count, column = node % map_.omega_count;
        if (map_.gaps.empty() || s <= first) return first;
        for (std::uint32_t k = map_.gap_rows[row]; k < map_.gap_rows[row + 1]; ++k) {
            const MapGap& gap = map_.gaps[k];
            if (gap.column != column) continue;
            if (std::abs(s - length_of(gap.leave)) < 1e-5) return std::nullopt;
            if (s < length_of(gap.leave)) break;
            first = length_of(gap.enter);
        }
        return first;
    }

    [[nodiscard]] std::optional<Spring> spring_at(const PartAnswer& a, shape::SurfaceAngles<double> angles, Vec3d p,
                                                  double shift) const
    {
        const auto foot = shape::surface_point(sq_, shape::SurfaceAngles<double>{angles.eta + shift, angles.omega + shift});
        const std::optional<Sample> sample = options_.layer == query::Layer::Two ? base_sample(angles) : finest_sample(angles);
        if (!sample) return std::nullopt;
        const double to_foot = norm(p - foot.point);  // S of eq. 21
        const bool printed = options_.projector == Projector::Printed;
        if (smoothed_ && !sample->is_cap && (a.flags & k_projection_unproven) == 0) {
            if (printed) {
                const Sample s = smoothed(angles, *sample);
                if (norm(s.normal) > 0) return Spring{std::max(to_foot - s.distance, 0.), s.normal};
            } else {
                const auto about = about_foot(angles, sample->distance, p, shift);
                if (!about || about->depth >= 0) return about;
            }
        }
        const bool is_behind = (a.flags & k_projection_behind) != 0;
        std::optional<double> distance = sample->distance;
        if (is_behind) distance = behind(angles, to_foot, sample->distance);
        if (!distance) return std::nullopt;
        const Vec3d normal = !is_behind && norm(sample->normal) > 0 ? sample->normal : foot.normal;
        const double along = to_foot - *distance;
        return Spring{std::max(printed ? along : dot(foot.point - *distance * foot.normal - p, normal), 0.), normal};
    }

    /// The smoothed surface about a foot: of the base samples about it whose distance is within three spacings of the map's, the
    /// mean of their tangent planes and of the plane through their mean, by bilinear shares. Depth -1: there is none.
    [[nodiscard]] std::optional<Spring> about_foot(shape::SurfaceAngles<double> angles, double distance, Vec3d p,
                                                   double shift) const
    {
        const Cell base = base_cell(angles);
        double weights = 0, planes = 0;
        Vec3d normal{}, middle{};
        for (std::size_t i = 0; i < 4; ++i) {
            const std::size_t node = base.corner(i);
            if (base_code(node) > k_map_largest) continue;
            const double d = length_of(base_code(node)), rise = std::abs(d - distance);
            if (std::abs(rise - steepest()) < 1e-5) return std::nullopt;
            if (rise > steepest()) continue;
            const double eta = M_PI * (double(node / base_columns_) / double(base_rows_ - 1) - 0.5),
                         omega = 2 * M_PI * double(node % base_columns_) / double(base_columns_) - M_PI;
            const auto r = shape::surface_point(
                sq_, shape::SurfaceAngles<double>{std::clamp(eta + shift, -M_PI / 2, M_PI / 2), omega + shift});
            const SmoothedSample s = smoothed_at(map_, hit_index(map_, node));
            const double moved = is_smoothed(s) ? change_of(s) : 0.;
            const Vec3d line = r.point - std::max(d + moved, 0.) * r.normal - p,
                        n = is_smoothed(s) ? smoothed_normal(s) : normal_of(node);
            const double weight = std::max(base.weight(i), 1e-4);
            weights += weight;
            planes += weight * dot(line, n);
            normal += weight * n;
            middle += weight * line;
        }
        if (weights == 0) return Spring{-1, {}};
        if (!(norm(normal) > 0.3 * weights)) return std::nullopt;  // normals of opposite walls cancel: the rest is rounding
        const Vec3d unit = normalized(normal);
        return Spring{std::max(0.5 * (planes + dot(middle, unit)) / weights, 0.), unit};
    }

    const MapView& map_;
    const ProjectionOptions options_;
    const bool smoothed_;
    const std::size_t base_rows_, base_columns_;
    const shape::Superquadric<double> sq_;
};

/// The spring of all parts together, model frame: of those that claim the point the one of least depth, if none proves it free.
/// Nothing where rounding to float may decide which part or sample speaks.
inline std::optional<Spring> spring_by_equations(const model::ModelView& view, Vec3f p, const ProjectionOptions& options,
                                                 bool smoothed)
{
    const Vec3d point = cast<double>(p);
    const auto r = static_cast<double>(view.header.r_max);
    std::vector<PartAnswer> answers(view.parts.size());
    for (std::size_t i = 0; i < answers.size(); ++i) {
        const MapView map = map_of(view, i);
        // Bounding spheres come first (section 4.2): a part answers points that lie in its sphere and in the object's.
        const auto beyond = [&](const float* sphere) {
            return norm(point - cast<double>(model::vec3(sphere))) - double(sphere[3]);
        };
        const double part = beyond(view.parts[i].sphere), all = beyond(view.header.sphere);
        if (std::min(std::abs(part), std::abs(all)) < 1e-6 * r) return std::nullopt;
        if (part > 0 || all > 0) continue;
        const double f = shape::implicit(shape::cast<double>(map.superquadric), point);
        if (std::abs(f - 1) < 1e-5) return std::nullopt;
        answers[i] = project(map, p, options);
        if (answers[i].verdict == Verdict::Outside) continue;
        if (std::abs(double(answers[i].depth_along)) < 1e-6 * r) return std::nullopt;
    }
    const CombinedAnswer all = combine(answers);
    if (!all.contact || (!all.has_surface && options.nearest_steps == 0)) return Spring{};
    std::vector<Spring> heard;
    std::optional<Spring> least;
    const auto hear = [&](const Spring& found) {
        heard.push_back(found);
        if (!least || found.depth < least->depth) least = found;
    };
    for (std::size_t i = 0; i < answers.size(); ++i) {
        const PartAnswer& a = answers[i];
        if (a.verdict != Verdict::Contact || (a.flags & (k_projection_cap | k_projection_miss)) != 0) continue;
        const MapView map = map_of(view, i);
        const std::optional<Spring> found = MapByEquations(map, options, smoothed).spring(a, point);
        if (!found) return std::nullopt;
        hear(*found);
    }
    for (std::size_t i = 0; i < answers.size() && options.nearest_steps > 0; ++i) {
        const MapView map = map_of(view, i);
        const float* sphere = view.parts[i].sphere;
        const auto radius = static_cast<double>(sphere[3]);
        const Spring nearest = least.value_or(Spring{.depth = INFINITY});
        const double beyond = norm(point - cast<double>(model::vec3(sphere))) - radius - std::min(nearest.depth, 0.5 * radius);
        if (map.surface_seeds.empty() || beyond > 1e-6 * r) continue;
        if (beyond > -1e-6 * r) return std::nullopt;
        const std::optional<Spring> found = MapByEquations(map, options, smoothed).spring_of_table(point, nearest);
        if (!found) return std::nullopt;
        if (norm(found->normal) > 0) hear(*found);
    }
    if (!least) return Spring{};
    // Beside a depth of zero, or where two others are as deep, rounding decides.
    if (least->depth < 2e-6 * r) return std::nullopt;
    const Spring chosen = *least;
    for (const Spring& other : heard) {
        if (other.depth - chosen.depth >= 1e-5 * r + chosen.rounding) continue;
        const double apart = norm(other.depth * other.normal - chosen.depth * chosen.normal);
        if (apart > 5e-6 * r) return std::nullopt;
        least->rounding = std::max(least->rounding, other.rounding + apart);
    }
    return least;
}

}  // namespace sqmap::paper::by_equations
