#include "bake/locator/locator.h"

#include "bake/locator/approach.h"
#include "bake/locator/gaps.h"
#include "support/decoded.h"
#include "support/parsed.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <initializer_list>
#include <iostream>
#include <vector>

namespace sqmap::bake {
namespace {

using model::LocatorCellKind;
using model::ModelView;

/// A cell that is not divided, an eighth of another, or a brick that is one cell.
struct Cell {
    LocatorCellKind kind = LocatorCellKind::Free;
    Vec3d centre;
    double side = 0;
    double gap = 0;  ///< Free
    std::uint32_t word = 0;
};

std::vector<Cell> cells_of(const ModelView& v)
{
    std::vector<Cell> out;
    const model::Locator& l = v.locator;
    const Vec3d origin = cast<double>(model::vec3(l.origin));
    const double cell = l.cell, step = cell * static_cast<double>(model::k_gap_step);
    constexpr std::uint32_t n = model::k_brick;
    for (std::uint32_t i = 0; i < v.bricks.size(); ++i) {
        const Vec3d at{double(i % l.bricks[0]), double(i / l.bricks[0] % l.bricks[1]), double(i / (l.bricks[0] * l.bricks[1]))};
        const Vec3d corner = origin + n * cell * at, middle = corner + 0.5 * n * cell * Vec3d{1, 1, 1};
        const std::uint32_t brick = v.bricks[i];
        if ((brick & model::LocatorBrick::k_free) != 0) {
            out.push_back({LocatorCellKind::Free, middle, n * cell, step * (brick & ~model::LocatorBrick::k_free), 0});
        } else if ((brick & model::LocatorBrick::k_deep) != 0) {
            const std::uint32_t word = v.locator_cells[brick & ~model::LocatorBrick::k_deep];
            out.push_back({model::LocatorCell{word}.kind(), middle, n * cell, 0, word});
        } else {
            for (std::uint32_t k = 0; k < n * n * n; ++k) {
                const auto add = [&](auto&& again, std::uint32_t word, Vec3d centre, double side) -> void {
                    const model::LocatorCell cell_word{word};
                    if (!cell_word.is_divided()) {
                        out.push_back({cell_word.kind(), centre, side, cell_word.is_free() ? step * cell_word.gap() : 0, word});
                        return;
                    }
                    for (std::uint32_t e = 0; e < 8; ++e)
                        again(again, v.locator_cells[cell_word.first() + e],
                              centre + 0.25 * side * Vec3d{e & 1u ? 1. : -1., e & 2u ? 1. : -1., e & 4u ? 1. : -1.}, 0.5 * side);
                };
                add(add, v.locator_cells[brick + k], corner + cell * Vec3d{k % n + 0.5, k / n % n + 0.5, k / (n * n) + 0.5},
                    cell);
            }
        }
    }
    return out;
}

Vec3d point_in(const Cell& cell, test::Random& random)
{
    return cell.centre + 0.4999 * cell.side * random.in_box({-1, -1, -1}, {1, 1, 1});
}

std::span<const std::uint32_t> planes_of(const ModelView& v, const Cell& cell)
{
    return v.planes.subspan(model::LocatorCell{cell.word}.first(), model::LocatorCell{cell.word}.planes());
}

/// The seeds of a cell that is not flat.
std::vector<model::Seed> chain_of(const ModelView& v, const Cell& cell)
{
    std::vector<model::Seed> chain;
    for (std::uint32_t i = model::LocatorCell{cell.word}.first();; ++i) {
        chain.push_back(v.seeds[i]);
        if (model::is_last_seed(v.seeds[i])) return chain;
    }
}

/// Every third cell of the horse is enough.
void each_model(const std::function<void(const std::string&, const test::Parsed&, std::size_t stride)>& check)
{
    check("torus", test::Parsed(test::small_torus()), 1);
    check("dumbbell", test::Parsed(mesh::dumbbell({.segments = 24})), 1);
    check("hand", test::Parsed(test::small_hand()), 3);
    if (const auto horse = test::shared_mesh_too("horse_5946.obj")) check("horse", test::Parsed(*horse), 5);
}

TEST(Locator, HoldsTheWholeObject)
{
    each_model([](const std::string& name, const test::Parsed& m, std::size_t) {
        const model::Locator& l = m.view().locator;
        for (const Vec3d& p : m.mesh().vertices)
            for (int k = 0; k < 3; ++k) {
                const double in_cells = (p[k] - static_cast<double>(l.origin[k])) / static_cast<double>(l.cell);
                ASSERT_GT(in_cells, 0) << name;
                ASSERT_LT(in_cells, model::k_brick * l.bricks[k]) << name;
            }
    });
}

TEST(Locator, FreeCellsHoldNoPointOfTheSolidAndTheirGapIsALowerBound)
{
    each_model([](const std::string& name, const test::Parsed& m, std::size_t stride) {
        test::Random random(1);
        const std::vector<Cell> cells = cells_of(m.view());
        std::size_t checked = 0;
        double used = 0, possible = 0;
        for (std::size_t i = 0; i < cells.size(); i += stride) {
            const Cell& cell = cells[i];
            if (cell.kind != LocatorCellKind::Free) continue;
            ++checked;
            ASSERT_FALSE(m.solid().inside(cell.centre)) << name;
            const double distance = m.solid().closest_boundary(cell.centre).distance;
            ASSERT_LE(cell.gap, distance) << name;
            used += cell.gap;
            possible += distance;
            for (int k = 0; k < 6; ++k) ASSERT_FALSE(m.solid().inside(point_in(cell, random))) << name;
        }
        EXPECT_GT(checked, 100u) << name;
        EXPECT_GT(used, 0.9 * possible) << name << ": a gap of nothing would be a lower bound, too";
    });
}

TEST(Locator, InsideCellsAreInside)
{
    each_model([](const std::string& name, const test::Parsed& m, std::size_t stride) {
        test::Random random(2);
        const std::vector<Cell> cells = cells_of(m.view());
        std::size_t checked = 0;
        for (std::size_t i = 0; i < cells.size(); i += stride) {
            if (cells[i].kind != LocatorCellKind::Inside) continue;
            ++checked;
            for (int k = 0; k < 8; ++k) ASSERT_TRUE(m.solid().inside(point_in(cells[i], random))) << name;
        }
        EXPECT_GT(checked, 100u) << name;
    });
}

TEST(Locator, EveryInsidePointOfAMixedCellIsHeldByAListedChart)
{
    each_model([](const std::string& name, const test::Parsed& m, std::size_t stride) {
        test::Random random(3);
        const ModelView& v = m.view();
        const std::vector<Cell> cells = cells_of(v);
        std::size_t inside = 0, first_right = 0, judged = 0, mixed = 0, ambiguous = 0;
        for (std::size_t i = 0; i < cells.size(); i += stride) {
            const Cell& cell = cells[i];
            ambiguous += cell.kind == LocatorCellKind::Ambiguous ? 1u : 0u;
            if (cell.kind != LocatorCellKind::Mixed) continue;
            ++mixed;
            for (int k = 0; k < 4; ++k) {
                const Vec3d p = cast<double>(cast<float>(point_in(cell, random)));
                const bool is_inside = m.solid().inside(p);
                std::uint32_t list = v.part_lists[model::LocatorCell{cell.word}.list()];
                std::int64_t holder = -1;
                for (std::uint32_t j = 0; j < model::k_list_length && holder < 0; ++j, list >>= 8) {
                    const std::uint32_t part = list & 0xffu;
                    if (part == model::k_no_part) break;
                    const model::CentralMap map(v, v.parts[part]);
                    if (map.in_domain(map.to_chart_frame(cast<float>(p)))) holder = part;
                }
                if (is_inside) {
                    ++inside;
                    ASSERT_GE(holder, 0) << name << " at " << p.x << ' ' << p.y << ' ' << p.z;
                }
                if (m.solid().closest_boundary(p).distance < 0.005 * m.r_max()) continue;
                ++judged;
                if (holder < 0) {
                    ++first_right;
                    continue;
                }
                const model::CentralMap map(v, v.parts[static_cast<std::size_t>(holder)]);
                const model::ChartPoint q = model::to_chart(map.to_chart_frame(cast<float>(p)));
                first_right += model::classify(map.leaf_at(q.face, q.s, q.t), q.s, q.t, q.w).inside == is_inside ? 1u : 0u;
            }
        }
        EXPECT_GT(inside, 100u) << name;
        EXPECT_EQ(first_right, judged) << name << ": verdicts of the first chart beyond 0.5 % of R_max";
        EXPECT_LT(ambiguous, mixed / 10) << name << ": cells that ask all parts should be rare";
    });
}

TEST(Locator, ThePlanesOfAFlatCellAreTheSurface)
{
    each_model([](const std::string& name, const test::Parsed& m, std::size_t stride) {
        test::Random random(4);
        const ModelView& v = m.view();
        const double tolerance = 0.002 * m.r_max();  // 0.4 of the default target error
        std::vector<double> errors;
        std::size_t flat = 0, all = 0;
        const std::vector<Cell> cells = cells_of(v);
        for (std::size_t i = 0; i < cells.size(); i += stride) {
            const Cell& cell = cells[i];
            if (cell.kind == LocatorCellKind::Free) continue;
            ++all;
            if (model::LocatorCell{cell.word}.planes() == 0) continue;
            ++flat;
            for (int k = 0; k < 3; ++k) {
                const Vec3d p = point_in(cell, random);
                if (!m.solid().inside(p)) continue;
                const float lowest = test::flat_gap(v.locator, planes_of(v, cell), cast<float>(p - cell.centre)).gap;
                errors.push_back(std::abs(static_cast<double>(lowest) - m.solid().closest_boundary(p).distance));
            }
        }
        ASSERT_GT(errors.size(), 100u) << name;
        std::sort(errors.begin(), errors.end());
        const auto within = static_cast<double>(std::upper_bound(errors.begin(), errors.end(), tolerance) - errors.begin()) /
                            static_cast<double>(errors.size());
        std::cout << name << ": " << flat << " of " << all << " cells flat; " << 100 * within
                  << " % of points within the tolerance, median " << 100 * errors[errors.size() / 2] / m.r_max() << " %, p99 "
                  << 100 * errors[errors.size() * 99 / 100] / m.r_max() << " %, worst " << 100 * errors.back() / m.r_max()
                  << " % of R_max\n";
        EXPECT_GT(within, 0.99) << name;
        EXPECT_LT(errors.back(), 0.005 * m.r_max()) << name;
    });
}

TEST(Locator, APlaneIsOfThePartThatOwnsItsSurface)
{
    each_model([](const std::string& name, const test::Parsed& m, std::size_t stride) {
        test::Random random(6);
        const ModelView& v = m.view();
        std::size_t checked = 0, right = 0;
        const std::vector<Cell> cells = cells_of(v);
        for (std::size_t i = 0; i < cells.size(); i += stride) {
            const Cell& cell = cells[i];
            if (cell.kind == LocatorCellKind::Free || model::LocatorCell{cell.word}.planes() != 1) continue;
            const std::uint32_t plane = planes_of(v, cell).front();
            const std::uint32_t part =
                model::part_in_list(v.part_lists[model::LocatorCell{cell.word}.list()], model::LocatorPlane{plane}.slot());
            const mesh::ClosestPoint nearest = m.solid().closest_boundary(cell.centre);
            ++checked;
            right += model::part_of_triangle(v, nearest.triangle) == part ? 1u : 0u;
        }
        ASSERT_GT(checked, 50u) << name;
        // At a point whose nearest feature is an edge, two triangles are nearest.
        EXPECT_GE(100 * right, 99 * checked) << name;
    });
}

TEST(Locator, TheSearchFromSomeSeedOfACellFindsTheNearestSurface)
{
    each_model([](const std::string& name, const test::Parsed& m, std::size_t) {
        test::Random random(5);
        const ModelView& v = m.view();
        std::vector<double> errors;
        const std::vector<Cell> cells = cells_of(v);
        constexpr std::size_t k_points = 64;  // of a cell: few of them have seeds
        for (std::size_t i = 0; i < k_points * cells.size(); ++i) {
            const Cell& cell = cells[i / k_points];
            if (cell.kind == LocatorCellKind::Free || model::LocatorCell{cell.word}.planes() > 0) continue;
            const std::vector<model::Seed> chain = chain_of(v, cell);
            const Vec3d p = point_in(cell, random);
            if (!m.solid().inside(p)) continue;
            double best = INFINITY;
            for (const model::Seed& seed : chain) {
                const model::Part& part = v.parts[model::seed_part(seed)];
                const model::CentralMap map(v, part);
                const float gap = seed_gap(v.locator, seed, cast<float>(p - cell.centre));
                const Vec3f point = cast<float>(p), foot = point + gap * model::seed_normal(seed);
                best = std::min<double>(
                    best, std::sqrt(approach(map, part, map.to_chart_frame(point), map.to_chart_frame(foot)).distance_sq));
            }
            errors.push_back(std::abs(best - m.solid().closest_boundary(p).distance));
        }
        if (errors.size() < 100) return;
        std::sort(errors.begin(), errors.end());
        std::cout << name << ": " << errors.size() << " points, median " << 100 * errors[errors.size() / 2] / m.r_max()
                  << " %, p95 " << 100 * errors[errors.size() * 95 / 100] / m.r_max() << " % of R_max\n";
        EXPECT_LT(errors[errors.size() * 95 / 100], 0.005 * m.r_max()) << name;
    });
}

TEST(Locator, IsTheSameOnAnyNumberOfThreads)
{
    BakeOptions one, three;
    one.threads = 1;
    three.threads = 3;
    const model::ModelData a = bake(test::small_hand(), true, one).model, b = bake(test::small_hand(), true, three).model;
    EXPECT_FALSE(a.bricks.empty());
    EXPECT_EQ(a.bricks, b.bricks);
    EXPECT_EQ(a.cells, b.cells);
    EXPECT_EQ(a.part_lists, b.part_lists);
    EXPECT_EQ(a.near_bricks, b.near_bricks);
    EXPECT_EQ(a.near, b.near);
    EXPECT_EQ(a.planes, b.planes);
    EXPECT_EQ(a.rises, b.rises);
    ASSERT_EQ(a.seeds.size(), b.seeds.size());
    for (std::size_t i = 0; i < a.seeds.size(); ++i) {
        ASSERT_EQ(a.seeds[i].direction, b.seeds[i].direction);
        ASSERT_EQ(a.seeds[i].extent, b.seeds[i].extent);
    }
}

/// A model whose locator may take more bytes step by step, each so many times its share.
struct Grown {
    model::ModelData data;
    std::vector<bool> changed;         ///< by each step
    std::vector<std::size_t> divided;  ///< cells, after each

    Grown(const BakeResult& baked, const mesh::Solid& solid, std::initializer_list<double> steps) : data(baked.model)
    {
        GrowingLocator locator({solid, baked.report.partition.part_of_triangle}, {.target_error = 2, .threads = 1}, data);
        for (const double more : steps) {
            changed.push_back(locator.bake(more));
            const auto is_divided = [](std::uint32_t word) { return model::LocatorCell{word}.is_divided(); };
            divided.push_back(static_cast<std::size_t>(std::ranges::count_if(data.locator_cells, is_divided)));
        }
    }
};

TEST(GrowingLocator, StepByStepItHasTheCellsOfOneThatMayBeAsLargeAtOnce)
{
    const mesh::Mesh hand = test::small_hand();
    const BakeResult baked = bake(hand, true, {.exact = false, .threads = 1});
    const mesh::Mesh mesh = model_space(hand);
    const mesh::Solid solid(mesh);
    const Grown slowly(baked, solid, {1, 2, 64, 64}), at_once(baked, solid, {64});
    EXPECT_EQ(slowly.changed.front(), true);
    EXPECT_EQ(slowly.changed.back(), false) << "there is nothing left to divide";
    EXPECT_GT(slowly.divided.back(), slowly.divided.front());
    EXPECT_EQ(slowly.data.bricks, at_once.data.bricks);
    EXPECT_EQ(slowly.data.locator_cells, at_once.data.locator_cells);
    EXPECT_EQ(slowly.data.planes, at_once.data.planes);
}

TEST(Locator, SurfacesHaveNone) { EXPECT_FALSE(model::has_locator(bake(test::small_torus(), false, {}).model.view())); }

}  // namespace
}  // namespace sqmap::bake
