#include "bake/exact/candidate_lists.h"

#include "math/triangle.h"
#include "model/candidate_lists.h"
#include "support/decoded.h"
#include "support/parsed.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

namespace sqmap::bake {
namespace {

using model::LocatorCellKind;
using model::ModelView;

/// A cell that is not Free, an eighth of one that is divided, and the list that it shares.
struct ListedCell {
    Vec3d centre;
    double half;
    std::uint32_t index, word;
    model::CandidateList near;
};

std::vector<ListedCell> listed_cells(const ModelView& v)
{
    std::vector<ListedCell> out;
    const model::Locator& l = v.locator;
    const double cell = l.cell;
    constexpr std::uint32_t n = model::k_brick;
    const auto add = [&](Vec3d centre, double half, std::uint32_t index, const model::CandidateList& near) {
        const std::uint32_t word = v.locator_cells[index];
        if (!model::LocatorCell{word}.is_free()) out.push_back({centre, half, index, word, near});
    };
    for (std::uint32_t i = 0; i < v.bricks.size(); ++i) {
        if ((v.bricks[i] & model::LocatorBrick::k_free) != 0) continue;
        const Vec3d at{double(i % l.bricks[0]), double(i / l.bricks[0] % l.bricks[1]), double(i / (l.bricks[0] * l.bricks[1]))};
        const Vec3d corner = cast<double>(model::vec3(l.origin)) + n * cell * at;
        const bool deep = (v.bricks[i] & model::LocatorBrick::k_deep) != 0;
        const std::uint32_t first = v.bricks[i] & ~model::LocatorBrick::k_deep;
        if (deep) {
            add(corner + 0.5 * n * cell * Vec3d{1, 1, 1}, 0.5 * n * cell, first, model::candidate_list(v, i, 0));
            continue;
        }
        for (std::uint32_t k = 0; k < n * n * n; ++k) {
            const std::uint32_t word = v.locator_cells[first + k];
            if (model::LocatorCell{word}.is_free()) continue;
            const Vec3d centre = corner + cell * Vec3d{k % n + 0.5, k / n % n + 0.5, k / (n * n) + 0.5};
            const model::CandidateList near = model::candidate_list(v, i, k);
            const auto add_all = [&](auto&& again, Vec3d middle, double half, std::uint32_t index) -> void {
                const model::LocatorCell one{v.locator_cells[index]};
                if (!one.is_divided()) return add(middle, half, index, near);
                for (std::uint32_t e = 0; e < 8; ++e)
                    again(again, middle + 0.5 * half * Vec3d{e & 1u ? 1. : -1., e & 2u ? 1. : -1., e & 4u ? 1. : -1.}, 0.5 * half,
                          one.first() + e);
            };
            add_all(add_all, centre, 0.5 * cell, first + k);
        }
    }
    return out;
}

void each_model(const std::function<void(const std::string&, const test::Parsed&)>& check)
{
    check("torus", test::Parsed(test::small_torus()));
    check("dumbbell", test::Parsed(mesh::dumbbell({.segments = 24})));
    check("hand", test::Parsed(test::small_hand()));
    // Coplanar triangles, many of them equally near.
    check("rounded box", test::Parsed(mesh::rounded_box({1, 0.6, 0.4}, 0.2, 3)));
    if (const auto horse = test::shared_mesh_too("horse_5946.obj")) check("horse", test::Parsed(*horse));
}

TEST(CandidateLists, HoldTheNearestTriangleOfAnyPointOfTheirCell)
{
    each_model([](const std::string& name, const test::Parsed& m) {
        test::Random random(11);
        const std::vector<ListedCell> cells = listed_cells(m.view());
        const std::size_t stride = std::max<std::size_t>(1, cells.size() / 1000);
        double listed = 0, lists = 0;
        for (std::size_t i = 0; i < cells.size(); i += stride) {
            const ListedCell& cell = cells[i];
            ASSERT_GT(cell.near.count, 0u) << name;
            listed += cell.near.count;
            ++lists;
            for (int k = 0; k < 10; ++k) {
                const Vec3d p = cell.centre + cell.half * random.in_box({-1, -1, -1}, {1, 1, 1});
                const double nearest = m.solid().closest_boundary(p).distance;
                double found = INFINITY;
                for (std::uint32_t e = 0; e < cell.near.count; ++e) {
                    const mesh::Triangle& t = m.mesh().triangles[cell.near[e]];
                    const auto& v = m.mesh().vertices;
                    found = std::min(found, norm(closest_point_on_triangle(p, v[t[0]], v[t[1]], v[t[2]]) - p));
                }
                ASSERT_LE(found, nearest * (1 + 1e-9) + 1e-12) << name;
            }
        }
        EXPECT_LT(listed / lists, 0.3 * static_cast<double>(m.mesh().triangles.size())) << name << ": all would be right, too";
    });
}

TEST(CandidateLists, NoPointOfTheSolidIsAboveAFlatCellsPlanesByMoreThanItsRise)
{
    each_model([](const std::string& name, const test::Parsed& m) {
        test::Random random(12);
        const ModelView& v = m.view();
        std::size_t inside = 0, outside = 0, dropped = 0;
        for (const ListedCell& cell : listed_cells(v)) {
            if (model::LocatorCell{cell.word}.kind() != LocatorCellKind::Mixed) continue;
            const std::uint8_t code = v.rises[cell.index];
            if (model::LocatorCell{cell.word}.planes() == 0 || code == model::k_no_rise) continue;
            const auto planes = v.planes.subspan(model::LocatorCell{cell.word}.first(), model::LocatorCell{cell.word}.planes());
            const float rise = static_cast<float>(code) * model::k_rise_step * v.locator.cell;
            for (int k = 0; k < 8; ++k) {
                const Vec3d p = cell.centre + cell.half * random.in_box({-1, -1, -1}, {1, 1, 1});
                const float gap = test::flat_gap(v.locator, planes, cast<float>(p - cell.centre)).gap;
                const bool is_inside = m.solid().inside(p);
                (is_inside ? inside : outside) += 1;
                if (is_inside) {
                    ASSERT_GE(gap + rise, 0) << name << " at " << p.x << ' ' << p.y << ' ' << p.z;
                }
                dropped += !is_inside && gap + rise < 0 ? 1u : 0u;
            }
        }
        EXPECT_GT(inside, 100u) << name;
        EXPECT_GT(dropped, outside / 2) << name << ": a rise without end would be a bound, too";
    });
}

}  // namespace
}  // namespace sqmap::bake
