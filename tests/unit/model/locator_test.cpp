// The look-up of one point, and of as many as a vector holds: the same cell, plane and offset.
#include "model/locator.h"

#include "math/lanes-inl.h"
#include "query/locator/locate-inl.h"
#include "support/decoded.h"
#include "support/parsed.h"

#include <gtest/gtest.h>

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

/// The cells that LocatorLanes finds, one a lane.
struct Lanes {
    std::int32_t cell[k_lanes], index[k_lanes], brick[k_lanes], within[k_lanes];
    float x[k_lanes], y[k_lanes], z[k_lanes], below[k_lanes];
    bool occupied[k_lanes] = {}, flat[k_lanes] = {};
};

Lanes look_up(const ModelView& view, const float* x, const float* y, const float* z)
{
    const LocatorLanes lanes(view);
    const V3 at = lanes.in_cells({hn::LoadU(df, x), hn::LoadU(df, y), hn::LoadU(df, z)});
    const M in_grid = lanes.in_grid(at);
    LocatorLanes::Located found = lanes.locate(at, in_grid);
    M occupied = hn::AndNot(found.is_free, in_grid);
    lanes.divide(found.cell, found.index, found.offset, occupied);
    const M flat = LocatorLanes::is_flat(found.cell, occupied);
    Lanes out;
    hn::StoreU(found.cell, di, out.cell);
    hn::StoreU(found.index, di, out.index);
    hn::StoreU(found.brick, di, out.brick);
    hn::StoreU(found.within, di, out.within);
    hn::StoreU(found.offset.x, df, out.x);
    hn::StoreU(found.offset.y, df, out.y);
    hn::StoreU(found.offset.z, df, out.z);
    hn::StoreU(lanes.lowest_planes(found.cell, found.offset, flat).below, df, out.below);
    each_lane(occupied, [&](std::size_t i) { out.occupied[i] = true; });
    each_lane(flat, [&](std::size_t i) { out.flat[i] = true; });
    return out;
}

TEST(Locator, AVectorOfPointsIsFoundWhereEachOfThemIs)
{
    std::size_t divided = 0;
    for (const mesh::Mesh& mesh : {test::small_torus(), mesh::dumbbell({.segments = 24}), test::small_hand()}) {
        const test::Parsed m(mesh);
        const ModelView& view = m.view();
        const model::Locator& grid = view.locator;
        test::Random random(1);
        std::size_t occupied = 0;
        for (int i = 0; i < 100000; i += static_cast<int>(hn::Lanes(df))) {
            float p[3][k_lanes];
            for (std::size_t k = 0; k < 3; ++k)
                for (float& v : p[k]) {
                    const float side = grid.cell * static_cast<float>(model::k_brick * grid.bricks[k]);
                    v = grid.origin[k] + side * static_cast<float>(random.between(-0.02, 1.02));
                }
            const Lanes lanes = look_up(view, p[0], p[1], p[2]);
            for (std::size_t k = 0; k < hn::Lanes(df); ++k) {
                const model::LocatedCell one = model::locate(view, {p[0][k], p[1][k], p[2][k]});
                ASSERT_EQ(lanes.occupied[k], !one.is_free);
                if (one.is_free) continue;
                ASSERT_EQ(static_cast<std::uint32_t>(lanes.cell[k]), one.cell.word);
                ASSERT_EQ(static_cast<std::size_t>(lanes.index[k]), one.index);
                ASSERT_EQ(static_cast<std::size_t>(lanes.brick[k]), one.brick);
                ASSERT_EQ(static_cast<std::uint32_t>(lanes.within[k]), one.within);
                ASSERT_EQ((Vec3f{lanes.x[k], lanes.y[k], lanes.z[k]}), one.offset);
                ASSERT_EQ(lanes.flat[k], one.cell.is_flat());
                ++occupied;
                const model::LocatorBrick brick{view.bricks[one.brick]};
                divided += one.index != brick.first() + one.within ? 1u : 0u;
                if (!one.cell.is_flat()) continue;
                const auto planes = view.planes.subspan(one.cell.first(), one.cell.planes());
                ASSERT_NEAR(lanes.below[k] * grid.cell, test::flat_gap(grid, planes, grid.cell * one.offset).gap,
                            1e-5f * grid.cell);
            }
        }
        EXPECT_GT(occupied, 10000u);
    }
    EXPECT_GT(divided, 20u);
}

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
