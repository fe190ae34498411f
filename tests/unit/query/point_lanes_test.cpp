// The pieces of the probe kernels, on every instruction set, against the same for one point.
#include "bake/locator/approach.h"
#include "query/locator/locate_point.h"
#include "support/decoded.h"
#include "support/parsed.h"
#include "support/superquadrics.h"

#ifndef SQMAP_POINT_LANES_TEST_TYPES
#define SQMAP_POINT_LANES_TEST_TYPES
namespace sqmap::query {

struct CellAnswer {
    bool is_free = true;
    std::uint32_t cell = 0, index = 0, brick = 0, within = 0;
    Vec3f offset{};        ///< in cells
    float gap = 0;         ///< flat: below the planes, in cells; else below the first seed's plane, model units
    Vec3f normal{};        ///< of the first seed
    float coarse_gap = 0;  ///< on layer 2, model units
};

struct LeafAnswer {
    bool in_domain = false, inside = false, certain = false;
    std::uint32_t cell = 0;
    float s0 = 0, t0 = 0, inverse_size = 0, w = 0, ws = 0, wt = 0, deviation = 0;
};

struct ApproachAnswer {
    float distance = 0;
    Vec3f offset{};
};

}  // namespace sqmap::query
#endif

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "unit/query/point_lanes_test.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "query/chart/chart_search-inl.h"
#include "query/chart/chart_verdict-inl.h"
#include "query/dispatch/plane_kernel-inl.h"
#include "query/locator/locate-inl.h"
#include "query/superquadric/layer_one-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

struct Stored {
    HWY_ALIGN float f[k_lanes];
    HWY_ALIGN std::int32_t i[k_lanes];
    explicit Stored(F v) { hn::Store(v, df, f); }
    explicit Stored(I v) { hn::Store(v, di, i); }
    explicit Stored(M v) { hn::Store(hn::VecFromMask(di, hn::RebindMask(di, v)), di, i); }
};

V3 loaded(std::span<const Vec3f> p, std::size_t first)
{
    HWY_ALIGN float x[3][k_lanes];
    for (std::size_t i = 0; i < k_lanes; ++i)
        for (int k = 0; k < 3; ++k) x[k][i] = p[std::min(first + i, p.size() - 1)][k];
    return {hn::Load(df, x[0]), hn::Load(df, x[1]), hn::Load(df, x[2])};
}

/// visit(lane, its index among the points) for a vector of points.
template <class Visit>
void each_present(std::size_t first, std::size_t size, Visit&& visit)
{
    for (std::size_t i = 0; i < std::min(hn::Lanes(df), size - first); ++i) visit(i, first + i);
}

}  // namespace

void cells(const model::ModelView& model, std::span<const Vec3f> p, std::span<CellAnswer> out)
{
    const LocatorLanes locator(model);
    for (std::size_t first = 0; first < p.size(); first += hn::Lanes(df)) {
        const V3 at = locator.in_cells(loaded(p, first));
        const M in = locator.in_grid(at);
        LocatorLanes::Located found = locator.locate(at, in);
        M occupied = hn::AndNot(found.is_free, in);
        locator.divide(found.cell, found.index, found.offset, occupied);
        const M flat = LocatorLanes::is_flat(found.cell, occupied), seeded = hn::AndNot(flat, occupied);
        const F flat_gap = any(flat) ? locator.lowest_planes(found.cell, found.offset, flat).below : hn::Zero(df);
        const auto* words = reinterpret_cast<const std::uint32_t*>(model.seeds.data());
        const I seed = blend(seeded, LocatorLanes::first_of(found.cell), hn::Zero(di)), word = hn::Add(seed, seed);
        LocatorLanes::SeedPlanes planes{};
        if (any(seeded)) planes = locator.seed_planes(gather_word(words, word), gather_word(words + 1, word), found.offset);
        const Stored is_occupied(occupied), cell(found.cell), index(found.index), brick(found.brick), within(found.within),
            x(found.offset.x), y(found.offset.y), z(found.offset.z), gap(blend(flat, flat_gap, planes.below)),
            nx(planes.normal.x), ny(planes.normal.y), nz(planes.normal.z),
            coarse(CoarsePlanes(locator, found.cell, found.offset, occupied).below());
        each_present(first, p.size(), [&](std::size_t i, std::size_t k) {
            if (is_occupied.i[i] == 0) return;
            out[k] = {false,
                      static_cast<std::uint32_t>(cell.i[i]),
                      static_cast<std::uint32_t>(index.i[i]),
                      static_cast<std::uint32_t>(brick.i[i]),
                      static_cast<std::uint32_t>(within.i[i]),
                      {x.f[i], y.f[i], z.f[i]},
                      gap.f[i],
                      {nx.f[i], ny.f[i], nz.f[i]},
                      coarse.f[i]};
        });
    }
}

/// One part's leaf under each point, and the verdict of a cell that lists that part alone.
void leaves(const model::ModelView& model, std::size_t part, std::span<const Vec3f> p, std::span<LeafAnswer> out)
{
    const ChartLanes chart(model, model.parts[part]);
    for (std::size_t first = 0; first < p.size(); first += hn::Lanes(df)) {
        const V3 x = chart.to_frame(loaded(p, first));
        const M held = chart.in_domain(x), all = hn::FirstN(df, hn::Lanes(df));
        const Chart q = to_chart(face_point(x));
        const Leaves leaf = chart.leaves_at(q.face, q.s, q.t, all);
        const Sheet sheet = chart.value(leaf, q.s, q.t);
        const Stored is_held(held), cell(leaf.cell), s0(leaf.s0), t0(leaf.t0), size(leaf.inverse_size), w(sheet.w), ws(sheet.ws),
            wt(sheet.wt), deviation(chart.deviation(leaf.cell));
        const VerdictLanes verdict = ChartVerdicts(model).by_part(part, loaded(p, first), all);
        const Stored inside(verdict.inside), certain(verdict.certain);
        each_present(first, p.size(), [&](std::size_t i, std::size_t k) {
            out[k] = {is_held.i[i] != 0, inside.i[i] != 0, certain.i[i] != 0, static_cast<std::uint32_t>(cell.i[i]),
                      s0.f[i],           t0.f[i],          size.f[i],         w.f[i],
                      ws.f[i],           wt.f[i],          deviation.f[i]};
        });
    }
}

void held(const shape::Superquadricf& sq, std::span<const Vec3f> p, std::span<std::uint8_t> out)
{
    const SuperquadricLanes lanes(sq);
    for (std::size_t first = 0; first < p.size(); first += hn::Lanes(df)) {
        HeldLanes point;
        point.unit = lanes.to_unit(lanes.to_local(loaded(p, first)));
        const Stored is_held(hn::And(in_box(point.unit), holds(lanes, point)));
        each_present(first, p.size(), [&](std::size_t lane, std::size_t i) { out[i] = is_held.i[lane] != 0 ? 1 : 0; });
    }
}

void approaches(const model::ModelView& model, std::size_t part, std::span<const Vec3f> p, std::span<const Vec3f> start,
                std::span<ApproachAnswer> out)
{
    const ChartSearch search(model, part);
    for (std::size_t first = 0; first < p.size(); first += hn::Lanes(df)) {
        const V3 from = loaded(start, first);
        const Found found = search.approach({loaded(p, first), from, from}, hn::FirstN(df, hn::Lanes(df)), k_approach_steps);
        const Stored distance(hn::Sqrt(found.distance_sq)), x(found.offset.x), y(found.offset.y), z(found.offset.z);
        each_present(first, p.size(), [&](std::size_t i, std::size_t k) { out[k] = {distance.f[i], {x.f[i], y.f[i], z.f[i]}}; });
    }
}

}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>

namespace sqmap::query {

HWY_EXPORT(cells);
HWY_EXPORT(leaves);
HWY_EXPORT(approaches);
HWY_EXPORT(held);

namespace {

/// Once on every instruction set that the machine has.
template <class Test>
void on_every_target(Test&& test)
{
    for (std::int64_t left = hwy::SupportedTargets() & HWY_TARGETS; left != 0; left &= left - 1) {
        const std::int64_t one = left & -left;
        hwy::SetSupportedTargetsForTest(one);
        test(hwy::TargetName(one));
        hwy::SetSupportedTargetsForTest(0);
    }
}

std::vector<Vec3f> positions(const test::Parsed& m, int count)
{
    test::Random random(5);
    const double r = 1.2 * static_cast<double>(m.view().header.sphere[3]);
    std::vector<Vec3f> points;
    for (int i = 0; i < count; ++i) {
        const Vec3d vertex = m.mesh().vertices[random.below(m.mesh().vertices.size())];
        points.push_back(i % 2 == 0 ? model::vec3(m.view().header.sphere) + cast<float>(random.in_box({-r, -r, -r}, {r, r, r}))
                                    : cast<float>(vertex + 0.05 * r * random.between(0, 1) * random.direction()));
    }
    return points;
}

std::vector<test::Shape> shapes()
{
    std::vector<test::Shape> out = test::small_shapes();
    out.push_back({"crossing bars", test::crossing_bars()});
    out.push_back({"nested balls", test::nested_balls()});
    if (auto horse = test::shared_mesh("horse_5946.obj")) out.push_back({"horse", *horse});
    return out;
}

/// How far a point in a flat cell is below the plane that layer 2 takes.
float lowest_gap(const model::ModelView& view, const LocatedCell& at)
{
    const auto planes = view.planes.subspan(at.cell.first(), at.cell.planes());
    const bool one_does = model::LocatorPlane{planes.front()}.is_sufficient();
    float lowest = INFINITY;
    for (const std::uint32_t word : planes.first(one_does ? 1 : planes.size()))
        lowest = std::min(lowest, test::plane_gap(view.locator, {word}, view.locator.cell * at.offset));
    return lowest;
}

void check_cells(const test::Parsed& m, const std::string& what)
{
    const model::ModelView& view = m.view();
    const std::vector<Vec3f> points = positions(m, 20000);
    std::vector<CellAnswer> found(points.size());
    HWY_DYNAMIC_DISPATCH(cells)(view, points, found);
    const float cell_size = view.locator.cell;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const LocatedCell one = locate(view, points[i]);
        ASSERT_EQ(one.is_free, found[i].is_free) << what;
        if (one.is_free) continue;
        ASSERT_EQ(one.cell.word, found[i].cell) << what;
        ASSERT_EQ(one.index, found[i].index) << what;
        ASSERT_EQ(one.brick, found[i].brick) << what;
        ASSERT_EQ(one.within, found[i].within) << what;
        ASSERT_EQ(one.offset, found[i].offset) << what;
        if (one.cell.is_flat()) {
            const auto planes = view.planes.subspan(one.cell.first(), one.cell.planes());
            const float gap = test::flat_gap(view.locator, planes, cell_size * one.offset).gap;
            const float rounding = 4e-6f * cell_size * view.locator.plane_reach;
            ASSERT_NEAR(gap, cell_size * found[i].gap, rounding) << what;
            ASSERT_NEAR(lowest_gap(view, one), found[i].coarse_gap, rounding) << what;
            // No point is in contact there that is in none on layer 3, but where one plane does for all.
            if (!model::LocatorPlane{planes.front()}.is_sufficient()) {
                ASSERT_LE(found[i].coarse_gap, gap + rounding) << what;
            }
        } else {
            const model::Seed seed = view.seeds[one.cell.first()];
            ASSERT_LT(norm(model::seed_normal(seed) - found[i].normal), 4e-7f) << what;
            ASSERT_NEAR(bake::seed_gap(view.locator, seed, cell_size * one.offset), found[i].gap,
                        4e-6f * cell_size * view.locator.plane_reach)
                << what;
        }
    }
}

TEST(PointLanes, LocatorCellsPlanesAndSeedsAreThoseOfOnePoint)
{
    for (const test::Shape& shape : shapes()) {
        const test::Parsed m(shape.mesh);
        on_every_target([&](const char* target) { check_cells(m, shape.name + " by " + target); });
    }
}

void check_leaves(const test::Parsed& m, std::size_t part, const std::string& what)
{
    const model::ModelView& view = m.view();
    const std::vector<Vec3f> points = positions(m, 4000);
    std::vector<LeafAnswer> found(points.size());
    HWY_DYNAMIC_DISPATCH(leaves)(view, part, points, found);
    const model::CentralMap map(view, view.parts[part]);
    std::size_t on_border = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3f x = map.to_chart_frame(points[i]);
        const model::ChartPoint q = model::to_chart(x);
        const model::Leaf leaf = map.leaf_at(q.face, q.s, q.t);
        const LeafAnswer& lane = found[i];
        ASSERT_EQ(map.in_domain(x), lane.in_domain) << what;
        if (leaf.s0 != lane.s0 || leaf.t0 != lane.t0) {
            // Rounding decides between neighbours on whose common border the point lies: both hold it.
            constexpr float k_border = 1e-6f;
            const float size = 1 / lane.inverse_size;
            ASSERT_LE(std::abs(q.s - lane.s0 - 0.5f * size), 0.5f * size + k_border) << what;
            ASSERT_LE(std::abs(q.t - lane.t0 - 0.5f * size), 0.5f * size + k_border) << what;
            ASSERT_LE(++on_border, points.size() / 1000) << what;
            continue;
        }
        ASSERT_EQ(leaf.kind, model::CentralCell{static_cast<std::uint16_t>(lane.cell)}.kind()) << what;
        ASSERT_EQ(1.f / leaf.size, lane.inverse_size) << what;
        if (leaf.kind == model::CellKind::Single) {
            const model::SheetValue value = model::sheet_value(leaf, 0, q.s, q.t);
            const float rounding = 4e-6f * std::max(std::abs(value.w), 1.f);
            ASSERT_NEAR(value.w, lane.w, rounding) << what;
            ASSERT_NEAR(value.ws, lane.ws, rounding / leaf.size) << what;
            ASSERT_NEAR(value.wt, lane.wt, rounding / leaf.size) << what;
            ASSERT_EQ(leaf.deviation, lane.deviation) << what;
        }
        if (!lane.in_domain) continue;
        const model::ChartVerdict one = model::classify(leaf, q.s, q.t, q.w);
        if (one.margin < 1e-5f * q.w || std::abs(one.margin - leaf.deviation) < 1e-5f * q.w) continue;  // rounding decides
        ASSERT_EQ(one.inside, lane.inside) << what;
        ASSERT_EQ(one.certain, lane.certain) << what;
    }
}

TEST(PointLanes, LeavesDeviationsAndVerdictsAreThoseOfOnePoint)
{
    for (const test::Shape& shape : shapes()) {
        const test::Parsed m(shape.mesh);
        on_every_target([&](const char* target) {
            for (std::size_t part = 0; part < m.view().parts.size(); ++part)
                check_leaves(m, part, shape.name + " part " + std::to_string(part) + " by " + target);
        });
    }
}

TEST(PointLanes, TheSearchInAChartEndsWhereThatOfOnePointDoes)
{
    for (const test::Shape& shape : shapes()) {
        const test::Parsed m(shape.mesh);
        const model::ModelView& view = m.view();
        // From points of the surface near each point, as seeds are.
        std::vector<Vec3f> points = positions(m, 2000), starts;
        for (const Vec3f& p : points) starts.push_back(cast<float>(m.solid().closest_boundary(cast<double>(p)).point));
        on_every_target([&](const char* target) {
            for (std::size_t part = 0; part < view.parts.size(); ++part) {
                std::vector<ApproachAnswer> found(points.size());
                HWY_DYNAMIC_DISPATCH(approaches)(view, part, points, starts, found);
                const model::CentralMap map(view, view.parts[part]);
                std::size_t differ = 0, seen = 0;
                for (std::size_t i = 0; i < points.size(); ++i) {
                    const bake::Approach one =
                        bake::approach(map, view.parts[part], map.to_chart_frame(points[i]), map.to_chart_frame(starts[i]));
                    if (!(one.distance_sq < INFINITY)) continue;
                    ++seen;
                    // A step may end in another leaf by rounding.
                    differ += std::abs(std::sqrt(one.distance_sq) - found[i].distance) > 1e-4f * view.header.sphere[3] ? 1u : 0u;
                }
                EXPECT_LE(differ, seen / 50) << shape.name << " part " << part << " by " << target << " of " << seen;
            }
        });
    }
}

TEST(PointLanes, SuperquadricsHoldWhatTheImplicitFunctionSays)
{
    const std::vector<shape::Superquadricd> samples = test::sample_superquadrics();
    on_every_target([&](const char* target) {
        test::Random random(9);
        std::size_t left_out = 0, kept_outside = 0, outside = 0;
        for (const shape::Superquadricd& sample : samples) {
            const shape::Superquadricf sq = shape::cast<float>(sample);
            std::vector<Vec3f> points;
            for (int i = 0; i < 2000; ++i) points.push_back(sq.translation + cast<float>(random.in_box({-3, -3, -3}, {3, 3, 3})));
            std::vector<std::uint8_t> is_held(points.size());
            HWY_DYNAMIC_DISPATCH(held)(sq, points, is_held);
            for (std::size_t i = 0; i < points.size(); ++i) {
                const float f = shape::implicit(sq, points[i]);
                // Both round.
                left_out += f <= 1 - 1e-5f && is_held[i] == 0 ? 1u : 0u;
                outside += f > 1.01f ? 1u : 0u;
                kept_outside += f > 1.01f && is_held[i] != 0 ? 1u : 0u;
            }
        }
        EXPECT_EQ(left_out, 0u) << target;
        EXPECT_GT(outside, 1000u);
        EXPECT_EQ(kept_outside, 0u) << target << " of " << outside;
    });
}

}  // namespace
}  // namespace sqmap::query
#endif
