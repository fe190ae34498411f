// Section 6 tick by tick: the servo's force on paper models against eqs. 21, 22, 26 and 32, computed here in double from the
// stored arrays. The feet are those of the searches, whose own tests stand in projection_test.cpp.
#include "../haptic/touching.h"
#include "math/random.h"
#include "model/octahedral.h"
#include "paper/model/codes.h"
#include "sqmap/bake_mesh.h"
#include "sqmap/paper/force.h"
#include "sqmap/paper/projection.h"
#include "support/paper_model.h"
#include "support/shared_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace sqmap::haptic::test {
namespace {

using paper::MapView;
using paper::PartAnswer;
using paper::Projector;
using query::Layer;

constexpr double k_pi_double = 3.14159265358979323846;

/// A cell of a grid that is equal-spaced in eta and omega, and a position in it.
struct TraceCell {
    TraceCell(shape::SurfaceAnglesf angles, std::size_t row_count, std::size_t column_count)
        : rows(row_count), columns(column_count)
    {
        const auto n = static_cast<double>(rows - 1), m = static_cast<double>(columns);
        const double at_y = std::clamp((double(angles.eta) / k_pi_double + 0.5) * n, 0., n);
        const double at_x = std::clamp((double(angles.omega) / (2 * k_pi_double) + 0.5) * m, 0., m);
        row = std::min(static_cast<std::size_t>(at_y), rows - 2);
        column = std::min(static_cast<std::size_t>(at_x), columns - 1);
        y = at_y - static_cast<double>(row);
        x = at_x - static_cast<double>(column);
    }
    /// Corner i: bit 0 the next column, bit 1 the next row.
    [[nodiscard]] std::size_t corner(std::size_t i) const { return (row + i / 2) * columns + (column + i % 2) % columns; }
    [[nodiscard]] double weight(std::size_t i) const { return (i % 2 == 0 ? 1 - x : x) * (i < 2 ? 1 - y : y); }
    [[nodiscard]] std::size_t nearest() const
    {
        return (row + (y >= 0.5 ? 1 : 0)) * columns + (column + (x >= 0.5 ? 1 : 0)) % columns;
    }
    /// True where rounding to float may choose another cell, or another nearest sample. On layer 2 the foot is a sample, and no
    /// cell is chosen.
    [[nodiscard]] bool is_close(Layer layer) const
    {
        const auto close = [&](double v) {
            return std::abs(v - 0.5) < 1e-3 || (layer != Layer::Two && std::min(std::abs(v), std::abs(1 - v)) < 1e-3);
        };
        return close(x) || close(y);
    }

    std::size_t rows, columns, row, column;
    double x, y;
};

/// D of step 2 on the finest grid, bilinear, and the vertices of step 3 as pyramids over the cell; nothing where the cell holds
/// more than one sheet.
std::optional<double> interpolated_distance(const MapView& map, shape::SurfaceAnglesf angles)
{
    const TraceCell c(angles, map.eta_count, map.omega_count);
    double sum = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        const std::size_t node = c.corner(i);
        if (map.distance[node] > paper::k_map_largest) return std::nullopt;
        const unsigned cuts = map.cuts[node / 4] >> 2 * (node % 4) & 3u;
        if ((i < 2 && (cuts & 1u) != 0) || (i % 2 == 0 && (cuts & 2u) != 0)) return std::nullopt;
        sum += c.weight(i) * double(map.distance_scale) * map.distance[node];
    }
    if (!map.correction_rows.empty() && c.row + 1 < map.correction_rows.size())
        for (std::uint32_t k = map.correction_rows[c.row]; k < map.correction_rows[c.row + 1]; ++k) {
            const paper::VertexCorrection& v = map.corrections[k];
            if (v.column != c.column) continue;
            const double x0 = (v.omega + 0.5) / 256, y0 = (v.eta + 0.5) / 256;
            const double hat = std::min({c.x / x0, (1 - c.x) / (1 - x0), c.y / y0, (1 - c.y) / (1 - y0)});
            sum += std::max(hat, 0.) * double(map.distance_scale) * v.correction;
        }
    return std::max(sum, 0.);
}

/// Eqs. 22 and 26 on the smoothed map: its distance and normal at a foot; nothing where there is no such map.
struct SmoothedFoot {
    double distance;
    Vec3d normal;
};
std::optional<SmoothedFoot> smoothed_at(const MapView& map, shape::SurfaceAnglesf angles, Layer layer)
{
    const TraceCell base(angles, ((map.eta_count - 1) >> map.subdivisions) + 1, map.omega_count >> map.subdivisions);
    std::optional<double> distance;
    if (layer == Layer::Two) {
        const std::size_t row = base.nearest() / base.columns << map.subdivisions,
                          column = base.nearest() % base.columns << map.subdivisions;
        const std::uint16_t code = map.distance[row * map.omega_count + column];
        if (code <= paper::k_map_largest) distance = double(map.distance_scale) * code;
    } else {
        distance = interpolated_distance(map, angles);
    }
    if (!distance || map.smoothed.empty()) return std::nullopt;
    if (layer == Layer::Two) {
        const paper::SmoothedSample& s = map.smoothed[base.nearest()];
        if (!paper::is_smoothed(s)) return std::nullopt;
        return SmoothedFoot{std::max(*distance + double(map.distance_scale) * s.change, 0.),
                            cast<double>(model::decode_normal(s.normal))};
    }
    double change = 0;
    Vec3d normal{};
    for (std::size_t i = 0; i < 4; ++i) {
        const paper::SmoothedSample& s = map.smoothed[base.corner(i)];
        if (!paper::is_smoothed(s)) return std::nullopt;
        change += base.weight(i) * double(map.distance_scale) * s.change;
        normal += base.weight(i) * cast<double>(model::decode_normal(s.normal));
    }
    return SmoothedFoot{std::max(*distance + change, 0.), normalized(normal)};
}

/// Depth and normal of a tick's point, as the documentation of the paper's force says; nothing where what decides lies within
/// rounding, or on a cell of several sheets.
struct Expected {
    bool touches = false;
    double depth = 0;
    Vec3d normal{};
    double rounding = 0;  ///< of depth, from the angles of the samples
};
/// Newton's foot: of the base samples about it whose distance is within three spacings of the map's the mean of their tangent
/// planes and of the plane through their mean, by bilinear shares.
std::optional<Expected> about_foot(const MapView& map, shape::SurfaceAnglesf angles, Vec3d p, double shift = 0)
{
    const auto sq = shape::cast<double>(map.superquadric);
    const std::optional<double> distance = interpolated_distance(map, angles);
    if (!distance || map.smoothed.empty()) return std::nullopt;
    const TraceCell base(angles, ((map.eta_count - 1) >> map.subdivisions) + 1, map.omega_count >> map.subdivisions);
    const auto spacing = k_pi_double * std::max({sq.a.x, sq.a.y, sq.a.z}) / double(std::min(base.rows - 1, base.columns / 2));
    double weights = 0, planes = 0;
    Vec3d normal{}, middle{};
    for (std::size_t i = 0; i < 4; ++i) {
        const std::size_t node = base.corner(i), row = node / base.columns, column = node % base.columns;
        const std::uint16_t code = map.distance[(row << map.subdivisions) * map.omega_count + (column << map.subdivisions)];
        if (code > paper::k_map_largest) continue;
        const auto r = shape::surface_point(
            sq, shape::SurfaceAngles<double>{std::clamp(k_pi_double * (double(row) / double(base.rows - 1) - 0.5) + shift,
                                                        -k_pi_double / 2, k_pi_double / 2),
                                             2 * k_pi_double * double(column) / double(base.columns) - k_pi_double + shift});
        const paper::SmoothedSample& s = map.smoothed[node];
        const bool is_smoothed = paper::is_smoothed(s);
        const double d = double(map.distance_scale) * code, moved = is_smoothed ? double(map.distance_scale) * s.change : 0.;
        const double rise = std::abs(d - *distance);
        if (std::abs(rise - 3 * spacing) < 1e-5) return std::nullopt;
        if (rise > 3 * spacing) continue;
        const Vec3d line = r.point - std::max(d + moved, 0.) * r.normal - p,
                    n = cast<double>(model::decode_normal(is_smoothed ? s.normal : map.normal[node]));
        const double weight = std::max(base.weight(i), 1e-4);
        weights += weight;
        planes += weight * dot(line, n);
        normal += weight * n;
        middle += weight * line;
    }
    if (!(norm(normal) > 0.3 * weights)) return std::nullopt;  // walls that face each other: what is left of them is rounding
    const Vec3d unit = normalized(normal);
    return Expected{true, std::max(0.5 * (planes + dot(middle, unit)) / weights, 0.), unit};
}

/// The same for one part that claims the point.
std::optional<Expected> expected_of(const MapView& map, const PartAnswer& a, Vec3d point, Layer layer, Projector projector)
{
    if ((a.flags & paper::k_projection_unproven) != 0) return std::nullopt;  // its foot is a guess, and is not smoothed
    if (TraceCell(a.angles, map.eta_count, map.omega_count).is_close(layer)) return std::nullopt;
    if (TraceCell(a.angles, ((map.eta_count - 1) >> map.subdivisions) + 1, map.omega_count >> map.subdivisions).is_close(layer))
        return std::nullopt;
    if (projector != Projector::Printed) {
        std::optional<Expected> out = about_foot(map, a.angles, point);
        // The kernels' sines and angles err by up to 4e-7, which beside an edge of a superquadric moves its samples.
        for (const double shift : {-4e-7, 4e-7})
            if (const std::optional<Expected> moved = about_foot(map, a.angles, point, shift); out && moved)
                out->rounding = std::max(out->rounding, std::abs(moved->depth - out->depth));
        return out;
    }
    const std::optional<SmoothedFoot> s = smoothed_at(map, a.angles, layer);
    if (!s) return std::nullopt;
    const auto foot =
        shape::surface_point(shape::cast<double>(map.superquadric), shape::SurfaceAngles<double>{a.angles.eta, a.angles.omega});
    return Expected{true, std::max(norm(point - foot.point) - s->distance, 0.), s->normal};  // eq. 21
}

std::optional<Expected> expected_at(const model::ModelView& view, Vec3f p, Layer layer, Projector projector)
{
    const Vec3d point = cast<double>(p);
    std::vector<PartAnswer> answers(view.parts.size());
    for (std::size_t i = 0; i < answers.size(); ++i) {
        const MapView map = paper::map_of(view, i);
        // The spheres come first (section 4.2): a part is asked about points in its own and the object's.
        const float* const sphere = view.parts[i].sphere;
        const double beyond = norm(point - cast<double>(model::vec3(sphere))) - double(sphere[3]),
                     beyond_all = norm(point - cast<double>(model::vec3(view.header.sphere))) - double(view.header.sphere[3]);
        if (std::min(std::abs(beyond), std::abs(beyond_all)) < 1e-6 * double(view.header.r_max)) return std::nullopt;
        if (beyond > 0 || beyond_all > 0) continue;
        const double f = shape::implicit(shape::cast<double>(map.superquadric), point);
        if (std::abs(f - 1) < 1e-5) return std::nullopt;
        answers[i] = paper::project(map, p, {.layer = layer, .projector = projector, .nearest_steps = 0});
        if (answers[i].verdict == paper::Verdict::Outside) continue;
        const auto r = static_cast<float>(view.header.r_max);
        if (std::abs(answers[i].depth_along) < 1e-6f * r) return std::nullopt;
    }
    const paper::CombinedAnswer all = paper::combine(answers);
    if (!all.contact || !all.has_surface) return Expected{};
    // The part of the least smoothed depth speaks, of those that claim the point.
    std::optional<Expected> least;
    double next = INFINITY;
    for (std::size_t i = 0; i < answers.size(); ++i) {
        const PartAnswer& a = answers[i];
        if (a.verdict != paper::Verdict::Contact || (a.flags & (paper::k_projection_cap | paper::k_projection_miss)) != 0)
            continue;
        const std::optional<Expected> found = expected_of(paper::map_of(view, i), a, point, layer, projector);
        if (!found) return std::nullopt;
        if (!least || found->depth < least->depth) {
            if (least) next = least->depth;
            least = found;
        } else {
            next = std::min(next, found->depth);
        }
    }
    if (least->depth > 0 && next - least->depth < 1e-5 * double(view.header.r_max) + least->rounding) return std::nullopt;
    return least;
}

struct TraceCount {
    int ticks = 0, touching = 0, compared = 0, jumps = 0;
};

/// Ticks of a point near the surface: each force against eq. 32.
TraceCount follow(sqmap::test::PaperModel& baked, Layer layer, Projector projector, int ticks)
{
    baked.set_options({.projector = projector, .nearest_steps = 0});
    const model::ModelView& view = baked.in_model_space();
    const auto r = static_cast<float>(view.header.r_max);
    constexpr double k_stiffness = 300;
    ZoneOptions options = paper::with_paper_force({.layer = layer, .stiffness = k_stiffness});
    Tool tool({{}}, options);
    TouchedBody body{.model = &view};
    body.material.friction = Friction::None;
    SplitMix64 random(7);
    TraceCount count;
    // About the surface: points of the superquadrics, drawn in by up to a third of what they bound.
    while (count.ticks < ticks) {
        const auto part = static_cast<std::size_t>(random.between(0, double(view.parts.size()) - 1e-9));
        const MapView map = paper::map_of(view, part);
        const auto at =
            shape::surface_point(map.superquadric, shape::SurfaceAngles<float>{static_cast<float>(random.between(-1.5, 1.5)),
                                                                               static_cast<float>(random.between(-3.1, 3.1))});
        const Vec3f p = at.point - static_cast<float>(random.between(0, 0.06)) * r * at.normal;
        ++count.ticks;
        const Vec3d force = tool.touch(body, cast<double>(p)).force;
        const std::optional<Expected> expected = expected_at(view, p, layer, projector);
        count.touching += norm(force) > 0;
        if (!expected) continue;
        count.compared += expected->touches;
        const auto error_of = [&](const Expected& e) { return norm(force - (k_stiffness * e.depth) * e.normal); };  // eq. 32
        const double allowed = 3e-4 * k_stiffness * expected->depth + k_stiffness * (4e-6 * double(r) + expected->rounding);
        if (error_of(*expected) < allowed) continue;
        // Rounding may lead to another foot, as at the medial axis: the force is that of a point beside it.
        ++count.jumps;
        bool is_beside = false;
        for (int k = 0; k < 6 && !is_beside; ++k) {
            Vec3f beside = p;
            beside[k / 2] += (k % 2 == 0 ? 1e-6f : -1e-6f) * r;
            const std::optional<Expected> other = expected_at(view, beside, layer, projector);
            is_beside = !other || error_of(*other) < allowed;
        }
        EXPECT_TRUE(is_beside) << "tick " << count.ticks << ", layer " << static_cast<int>(layer) << ", projector "
                               << static_cast<int>(projector) << ", depth " << expected->depth / double(r) << ", error "
                               << error_of(*expected) / (k_stiffness * double(r));
    }
    return count;
}

void follow_all(sqmap::test::PaperModel& baked, int ticks)
{
    for (const Projector projector : {Projector::Printed, Projector::Newton})
        for (const Layer layer : {Layer::Two, Layer::Three}) {
            if (projector == Projector::Newton && layer == Layer::Two) continue;  // its depth is on the finest map
            const TraceCount count = follow(baked, layer, projector, ticks);
            EXPECT_GT(count.touching, ticks / 10);
            EXPECT_LE(count.jumps, ticks / 1000);
            EXPECT_GT(count.compared, count.touching / 4) << "of " << count.touching << " touching";
        }
}

TEST(PaperForceTrace, EveryTickIsEqs21To32OnTheStoredMap)
{
    sqmap::test::PaperModel baked(sqmap::test::small_hand(), {.exact = false});
    follow_all(baked, 10000);
}

class PaperForceTraceOfAnimals : public testing::TestWithParam<const char*> {};

TEST_P(PaperForceTraceOfAnimals, EveryTickIsEqs21To32OnTheStoredMap)
{
    const std::filesystem::path file = sqmap::test::real_mesh_file(GetParam());
    if (file.empty()) GTEST_SKIP() << "there is no " << GetParam();
    const AdmittedMesh admitted = admit_mesh(file);
    ASSERT_FALSE(admitted.refused());
    sqmap::test::PaperModel baked(admitted.mesh, {.exact = false});
    follow_all(baked, 10000);
}

INSTANTIATE_TEST_SUITE_P(Meshes, PaperForceTraceOfAnimals,
                         testing::Values("cat_8108.obj", "horse_5946.obj", "elephant_10272.obj", "camel_4512.obj",
                                         "bull_7154.obj", "hand_9344.obj"),
                         [](const auto& param) {
                             const std::string name = param.param;
                             return name.substr(0, name.find('_')) + name.substr(name.find('_') + 1, 4);
                         });

}  // namespace
}  // namespace sqmap::haptic::test
