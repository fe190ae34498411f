// Solids whose surface hides from the parts' projections: the locator must answer.
#include "bake/bake.h"
#include "sqmap/bake/evaluate.h"
#include "sqmap/io/model_file.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/model/model.h"
#include "support/baked_shapes.h"
#include "support/hard_shapes.h"

#include <gtest/gtest.h>

namespace sqmap::bake {
namespace {

/// No wrong verdict of layer 3 beyond its band, of the exact layer beyond rounding.
void expect_right_verdicts(const test::Baked& baked)
{
    const mesh::Solid solid(baked.mesh, mesh::find_self_intersections(baked.mesh).crossed);
    const Evaluation layer3 = evaluate(baked.in_model_space(), solid, {});
    EXPECT_EQ(layer3.missed, 0u);
    EXPECT_EQ(layer3.false_contacts, 0u);
    EXPECT_GT(layer3.inside, 1000u);
    const Evaluation exact = evaluate(baked.in_model_space(), solid, {.layer = query::Layer::Exact, .verdict_band = 1e-5});
    EXPECT_EQ(exact.missed + exact.false_contacts, 0u);
}

TEST(BakeHardSolids, ABlockWithCrossingHolesKeepsItsVerdicts)
{
    const test::Baked block = test::baked(test::drilled_block(4));
    EXPECT_GT(block.result.model.measured.q2_share, 50);
    EXPECT_TRUE(block.result.report.target_met);
    EXPECT_FALSE(model::is_doubtful(block.result.model.measured));
    expect_right_verdicts(block);
}

TEST(BakeHardSolids, AThinCupTakes45BytesAFace)
{
    const test::Baked cup = test::baked(test::cup(0.02, 120, 50), {.keep_input = false});
    EXPECT_TRUE(cup.result.report.target_met);
    expect_right_verdicts(cup);
    const std::size_t faces = cup.mesh.triangles.size();
    EXPECT_NEAR(static_cast<double>(faces), 30000, 1000);
    EXPECT_LE(io::serialize(cup.result.model).size(), 45 * faces);
}

TEST(BakeHardSolids, AChainKeepsItsVerdicts)
{
    const test::Baked chain = test::baked(test::chain(7));
    EXPECT_TRUE(chain.result.report.target_met);
    expect_right_verdicts(chain);
}

}  // namespace
}  // namespace sqmap::bake
