// Drafts of a bake are measured by a shorter search: their figures are those that evaluate() gives for the finished model, but
// for the depths at a few points.
#include "bake/evaluate/drafts.h"
#include "query/dispatch/model_point.h"

#include "sqmap/mesh/solid.h"
#include "sqmap/model/model.h"
#include "support/baked_shapes.h"
#include "support/hard_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>

namespace sqmap::bake {
namespace {

void expect_equal(const Distribution& a, const Distribution& b)
{
    EXPECT_EQ(a.count, b.count);
    EXPECT_EQ(a.mean, b.mean);
    EXPECT_EQ(a.median, b.median);
    EXPECT_EQ(a.p95, b.p95);
    EXPECT_EQ(a.p99, b.p99);
    EXPECT_EQ(a.max, b.max);
}

void expect_figures_of_layer3(const Evaluation& draft, const Evaluation& whole)
{
    EXPECT_EQ(draft.points, whole.points);
    EXPECT_EQ(draft.inside, whole.inside);
    EXPECT_EQ(draft.missed, whole.missed);
    EXPECT_EQ(draft.false_contacts, whole.false_contacts);
    EXPECT_EQ(draft.missed_any, whole.missed_any);
    EXPECT_EQ(draft.false_any, whole.false_any);
    EXPECT_EQ(draft.eq35_left_out, whole.eq35_left_out);
    EXPECT_EQ(draft.eq35_one_sided, whole.eq35_one_sided);
    EXPECT_EQ(draft.no_surface, whole.no_surface);
    expect_equal(draft.eq35, whole.eq35);
    EXPECT_EQ(draft.depth.count, whole.depth.count);
    EXPECT_EQ(draft.normal.count, whole.normal.count);
}

/// The shorter search has the same verdict everywhere, and another depth only where a map shows surface that the mesh has not,
/// nearer than the mesh's: at one point in 200 at most.
void expect_same_depths(const model::ModelView& draft, SampledSolid& samples, int points)
{
    int contacts = 0, others = 0;
    for (int i = 0; i < points; ++i) {
        const Sampled& at = samples.at(static_cast<std::size_t>(i));
        const auto near = static_cast<float>(at.nearest.distance);
        const query::ModelContact brief = query::query_unlocated_near(draft, cast<float>(at.q), near);
        const query::PointResult whole = query::query_point(draft, at.q, {.layer = query::Layer::Three});
        ASSERT_EQ(brief.contact, whole.contact) << i;
        if (!brief.contact) continue;
        ++contacts;
        EXPECT_EQ(brief.status, whole.status) << i;
        others += static_cast<double>(brief.depth) != whole.depth;
    }
    EXPECT_GT(contacts, points / 4);
    EXPECT_LE(others, points / 200);
}

/// A model without a locator, its maps as coarse as the target allows.
test::Baked draft_of(const mesh::Mesh& mesh, double target_error, const decompose::Partition* partition)
{
    return test::baked(mesh, {.target_error = target_error, .exact = false, .locator = false, .partition = partition});
}

void expect_same_chart(const model::Part& a, const model::Part& b)
{
    ASSERT_TRUE(std::equal(std::begin(a.chart_centre), std::end(a.chart_centre), std::begin(b.chart_centre)));
    ASSERT_TRUE(std::equal(std::begin(a.chart_lo), std::end(a.chart_lo), std::begin(b.chart_lo)));
    ASSERT_TRUE(std::equal(std::begin(a.chart_hi), std::end(a.chart_hi), std::begin(b.chart_hi)));
}

TEST(BakeDrafts, HaveTheFiguresOfTheWholeEvaluation)
{
    // The holes hide surface from the projection, so that the maps' nearest surface often is not the mesh's.
    const mesh::Mesh block = test::drilled_block(3);
    // Both drafts fit the same given parts: a bake that looks for parts keeps fits from before their neighbours were cut.
    const test::Baked first = draft_of(block, 8, nullptr);
    const test::Baked coarse = draft_of(block, 8, &first.result.report.partition),
                      fine = draft_of(block, 0.2, &first.result.report.partition);
    ASSERT_EQ(coarse.result.model.parts.size(), fine.result.model.parts.size());
    for (std::size_t i = 0; i < coarse.result.model.parts.size(); ++i)
        expect_same_chart(coarse.result.model.parts[i], fine.result.model.parts[i]);

    const mesh::Solid solid(coarse.mesh);
    SampledSolid samples(solid, model::normalized(coarse.in_model_space()).header.r_max);
    DraftEvaluator drafts(samples);
    for (const test::Baked* draft : {&coarse, &fine}) {
        drafts.begin(draft->in_model_space());
        for (const std::uint32_t points : {2000u, 6000u})
            expect_figures_of_layer3(drafts.first(points), evaluate(draft->in_model_space(), solid, {.points = points}));
        expect_same_depths(model::normalized(draft->in_model_space()), samples, 6000);
    }
    // The layers are measured at the same points.
    const LayerErrors shared = layer_errors(fine.in_model_space(), samples, {.points = 2000});
    const LayerErrors alone = layer_errors(fine.in_model_space(), solid, {.points = 2000});
    EXPECT_EQ(shared.points, 2000u);
    EXPECT_EQ(shared.missed, alone.missed);
    EXPECT_EQ(shared.false_contacts, alone.false_contacts);
    for (std::size_t k = 0; k < 3; ++k) expect_equal(shared.depth[k], alone.depth[k]);
    expect_equal(shared.normal, alone.normal);
}

}  // namespace
}  // namespace sqmap::bake
