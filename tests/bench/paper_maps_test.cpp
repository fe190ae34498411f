#include "paper_maps.h"

#include "frames.h"
#include "settings.h"
#include "sqmap/paper/model.h"

#include <gtest/gtest.h>

namespace sqmap::bench {
namespace {

class PaperMapsTest : public testing::Test {
protected:
    static void SetUpTestSuite()
    {
        setting_ = test::egg_on_ring();
        parts_ = std::make_shared<const PaperParts>(*setting_);
        path_ = test::short_path(*setting_, 0.02);
        truth_ = true_contacts(*setting_, path_);
    }
    static void TearDownTestSuite()
    {
        parts_.reset();
        setting_.reset();
    }
    static Record run(query::Layer layer, Density density, paper::Projector projector = paper::Projector::Pyramid)
    {
        const auto maps = std::make_shared<const PaperMaps>(parts_, density);
        const auto method = make_paper_query(*setting_, maps, {layer, projector});
        const MethodEntry entry{.name = "normal"};
        const Contestant contestant{&entry, method.get()};
        return race(*setting_, path_, truth_, {&contestant, 1}, {.passes = 1}).front();
    }

    static inline std::unique_ptr<Setting> setting_;
    static inline std::shared_ptr<const PaperParts> parts_;
    static inline std::vector<Pose> path_;
    static inline std::vector<std::vector<TrueContact>> truth_;
};

TEST_F(PaperMapsTest, LayerOneMissesNothing) { EXPECT_EQ(run(query::Layer::One, {}).accuracy->missed_pct, 0); }

TEST_F(PaperMapsTest, EachLayerIsRightMoreOftenThanTheOneBefore)
{
    const Density density{.level = 4, .subdivisions = 3};
    const auto wrong = [&](query::Layer layer) {
        const Accuracy a = *run(layer, density).accuracy;
        return a.missed_pct + a.false_pct;
    };
    const double one = wrong(query::Layer::One), two = wrong(query::Layer::Two), three = wrong(query::Layer::Three);
    EXPECT_LT(two, one);
    EXPECT_LT(three, two);
}

TEST_F(PaperMapsTest, ErrorFallsAndBytesGrowWithDensity)
{
    std::vector<Vec3d> points;
    for (const Pose& pose : path_)
        for (const Vec3d& v : setting_->probe.vertices) points.push_back(apply(pose, v));
    const PaperMaps coarse(parts_, {4, 0}), fine(parts_, {6, 0});
    const ProjectionError rough = projection_error(coarse, points, query::Layer::Three),
                          close = projection_error(fine, points, query::Layer::Three);
    EXPECT_GT(rough.points, 100u);
    EXPECT_LT(close.mean, 0.5 * rough.mean);
    EXPECT_LT(close.mean, 0.1);
    EXPECT_GT(fine.bytes, 4 * coarse.bytes);
    EXPECT_NEAR(coarse.spacing / fine.spacing, 4, 0.5);
}

TEST_F(PaperMapsTest, ThePrintedSearchFindsContactsToo)
{
    const Record record = run(query::Layer::Two, {}, paper::Projector::Printed);
    EXPECT_GT(record.contacts, 0);
    EXPECT_LT(record.accuracy->missed_pct, 50);
}

}  // namespace
}  // namespace sqmap::bench
