// FCL's broad phase with sqmap's contacts.
#include "sqmap_fcl.h"

#include "support/bodies.h"

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/sphere.h>
#include <gtest/gtest.h>

#include <memory>
#include <numbers>
#include <vector>

namespace {

using Object = fcl::CollisionObject<double>;

const sqmap::test::Solid& torus()
{
    static const sqmap::test::Solid solid(sqmap::test::small_torus());  // about z: radii 1 and 0.3
    return solid;
}

class Fcl : public testing::Test {
protected:
    /// A torus moved and turned about x.
    Object& add_torus(fcl::Vector3d at, double angle)
    {
        const auto bound = std::make_shared<fcl::Boxd>(2.6, 2.6, 0.6);
        Object& object = *objects_.emplace_back(std::make_unique<Object>(bound));
        object.setTransform(Eigen::AngleAxisd(angle, fcl::Vector3d::UnitX()).toRotationMatrix(), at);
        object.setUserData(&solid_);
        object.computeAABB();
        manager_.registerObject(&object);
        return object;
    }
    fcl::CollisionResult<double> collide()
    {
        manager_.setup();
        sqmap_fcl::Collision collision(workspace_);
        collision.request.num_max_contacts = 100000;
        collision.request.enable_contact = true;
        collision.options.query.layer = sqmap::query::Layer::Exact;
        manager_.collide(&collision, sqmap_fcl::collide);
        return collision.result;
    }

    sqmap_fcl::Solid solid_{&torus().view, &torus().probe};
    sqmap::query::PairWorkspace workspace_{4096};
    fcl::DynamicAABBTreeCollisionManagerd manager_;
    std::vector<std::unique_ptr<Object>> objects_;
};

TEST_F(Fcl, LinkedRingsDoNotTouch)
{
    add_torus({0, 0, 0}, 0);
    add_torus({1, 0, 0}, std::numbers::pi / 2);  // through the hole of the first
    EXPECT_FALSE(collide().isCollision());
}

TEST_F(Fcl, RingsThatOverlapHaveDepthAndNormalFromTheFirstToTheSecond)
{
    const Object& a = add_torus({0, 0, 0}, 0);
    add_torus({2.5, 0, 0}, 0);
    const auto result = collide();
    ASSERT_TRUE(result.isCollision());
    double deepest = 0;
    for (std::size_t i = 0; i < result.numContacts(); ++i) {
        const auto& c = result.getContact(i);
        const double sign = c.o1 == a.collisionGeometry().get() ? 1 : -1;
        EXPECT_GT(sign * c.normal[0], 0.5);
        EXPECT_NEAR(c.pos[0], 1.25, 0.1);
        deepest = std::max(deepest, c.penetration_depth);
    }
    EXPECT_NEAR(deepest, 0.1, 0.03);  // the tubes have edges
}

TEST_F(Fcl, PairsWithoutSolidsAreFclsOwn)
{
    for (const double x : {0.0, 1.5}) {
        Object& ball = *objects_.emplace_back(std::make_unique<Object>(std::make_shared<fcl::Sphered>(1.0)));
        ball.setUserData(nullptr);
        ball.setTranslation({x, 0, 10});
        ball.computeAABB();
        manager_.registerObject(&ball);
    }
    const auto result = collide();
    ASSERT_EQ(result.numContacts(), 1U);
    EXPECT_NEAR(result.getContact(0).penetration_depth, 0.5, 1e-6);
}

}  // namespace
