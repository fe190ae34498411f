#include "sqmap/bulk/pile.h"

#include "support/bodies.h"
#include "support/small_meshes.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

namespace sqmap::bulk {
namespace {

using query::BodyId;
using query::SurfaceContact;

bool is_same(const SurfaceContact& a, const SurfaceContact& b)
{
    return a.witness.on_a == b.witness.on_a && a.witness.on_b == b.witness.on_b && a.normal == b.normal && a.depth == b.depth &&
           a.feature_a == b.feature_a && a.feature_b == b.feature_b && a.index_a == b.index_a && a.index_b == b.index_b &&
           a.region == b.region && a.part_a == b.part_a && a.part_b == b.part_b && a.certain == b.certain && a.status == b.status;
}

/// A pile of balls, bars and tori, some of them models, others triangles alone.
class PileTest : public testing::Test {
protected:
    PileTest()
    {
        for (int i = 0; i < 60; ++i) pile_.add(i % 3 == 0 ? &ball_.view : nullptr, probe(i));
        move();
    }
    [[nodiscard]] const query::Probe* probe(int i) const
    {
        return i % 3 == 0 ? &ball_.probe : (i % 3 == 1 ? &bar_probe_ : &torus_probe_);
    }
    void move()
    {
        for (BodyId id = 0; id < 60; ++id) pile_.set_pose(id, test::random_pose(random_, 5));
    }
    /// Compares with each pair alone, of all pairs there are.
    void expect_is_as_alone(const PileResult& result, const query::ContactOptions& options)
    {
        query::ContactWorkspace space(4096);
        std::size_t pair = 0;
        for (BodyId a = 0; a < 60; ++a)
            for (BodyId b = a + 1; b < 60; ++b) {
                const query::ContactResult alone = query::query_contacts(pile_.body(a), pile_.body(b), options, space);
                if (alone.found == 0) continue;
                ASSERT_LT(pair, result.pairs.size());
                const PilePair& p = result.pairs[pair++];
                ASSERT_EQ(p.a, a);
                ASSERT_EQ(p.b, b);
                EXPECT_EQ(p.found, alone.found);
                EXPECT_EQ(p.regions, alone.regions);
                EXPECT_EQ(p.status, alone.status);
                ASSERT_EQ(p.count, alone.contacts.size());
                for (std::size_t i = 0; i < p.count; ++i)
                    EXPECT_TRUE(is_same(result.contacts[p.first + i], alone.contacts[i])) << a << " " << b << " " << i;
            }
        EXPECT_EQ(pair, result.pairs.size());
        EXPECT_GT(pair, 20u);
        EXPECT_LT(result.near, 60u * 59u / 2);
    }

    test::Random random_{41};
    const test::Solid ball_{mesh::sphere(1, 2)};
    const mesh::Mesh bar_ = test::diamond_bar(true, 3, 0.3, 0), torus_ = test::small_torus();
    const query::Probe bar_probe_{bar_.vertices, bar_.triangles}, torus_probe_{torus_.vertices, torus_.triangles};
    Pile pile_;
};

TEST_F(PileTest, GivesWhatEachPairGivesAloneWhateverWasBefore)
{
    for (int step = 0; step < 3; ++step) {
        move();
        const query::ContactOptions options{.per_region = step == 2 ? 4u : 0u};
        expect_is_as_alone(pile_.query({.contacts = options}), options);
    }
}

TEST_F(PileTest, DoesNotDependOnTheNumberOfThreads)
{
    const PileResult one = pile_.query({.threads = 1});
    const std::vector<PilePair> pairs(one.pairs.begin(), one.pairs.end());
    const std::vector<SurfaceContact> contacts(one.contacts.begin(), one.contacts.end());
    for (const unsigned threads : {2u, 7u}) {
        const PileResult more = pile_.query({.threads = threads});
        ASSERT_EQ(more.pairs.size(), pairs.size());
        ASSERT_EQ(more.contacts.size(), contacts.size());
        EXPECT_EQ(std::memcmp(more.pairs.data(), pairs.data(), pairs.size() * sizeof(PilePair)), 0) << "all bytes are specified";
        for (std::size_t i = 0; i < contacts.size(); ++i) EXPECT_TRUE(is_same(more.contacts[i], contacts[i])) << i;
    }
}

TEST_F(PileTest, ForgetsWhatIsRemovedAndSaysWhatIsNotFinite)
{
    const PileResult before = pile_.query();
    ASSERT_FALSE(before.pairs.empty());
    EXPECT_EQ(before.status, query::k_ok);
    const BodyId gone = before.pairs[0].a;
    pile_.remove(gone);
    EXPECT_EQ(pile_.size(), 59u);
    for (const PilePair& p : pile_.query().pairs) EXPECT_TRUE(p.a != gone && p.b != gone);
    EXPECT_FALSE(pile_.set_pose(5, test::shifted({std::numeric_limits<double>::quiet_NaN(), 0, 0})));
    const PileResult after = pile_.query();
    EXPECT_EQ(after.status, query::k_not_finite);
    for (const PilePair& p : after.pairs) EXPECT_TRUE(p.a != 5 && p.b != 5);
    EXPECT_FALSE(pile_.set_pose(1000, {}));
    EXPECT_TRUE(Pile().query().pairs.empty());
}

TEST(Pile, KeepsAllContactsOfAPairThatHasMoreThanItWasMadeFor)
{
    const mesh::Mesh ball = mesh::sphere(1, 3);
    const query::Probe probe(ball.vertices, ball.triangles);
    Pile pile(4);
    pile.add(nullptr, &probe);
    pile.add(nullptr, &probe, test::shifted({0.5, 0.1, 0}));
    query::ContactWorkspace space(4096);
    const std::size_t alone = query::query_contacts(pile.body(0), pile.body(1), {}, space).contacts.size();
    for (int step = 0; step < 2; ++step) {
        const PileResult result = pile.query();
        ASSERT_EQ(result.pairs.size(), 1u);
        EXPECT_EQ(result.status, query::k_ok);
        EXPECT_EQ(result.pairs[0].found, alone);
        EXPECT_EQ(result.contacts.size(), alone);
        EXPECT_GT(result.pairs[0].meetings, 16u);
    }
}

}  // namespace
}  // namespace sqmap::bulk
