// FCL's broad phase with sqmap's contacts.
#include "sqmap_fcl.h"

#include "support/bodies.h"
#include "support/small_meshes.h"

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/sphere.h>
#include <gtest/gtest.h>

#include <algorithm>
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

TEST_F(Fcl, NoContactIsLostWhereAWorkspaceIsSmall)
{
    Object &first = add_torus({0, 0, 0}, 0), &second = add_torus({2.5, 0, 0}, 0);
    for (const bool complete : {false, true}) {
        std::size_t found[2] = {};
        for (const std::size_t space : {1, 4096}) {
            sqmap::query::PairWorkspace workspace(space);
            sqmap::query::ContactWorkspace surfaces(space);
            sqmap_fcl::Collision c(workspace);
            c.request.num_max_contacts = 100000;
            c.request.enable_contact = true;
            c.options.query.layer = sqmap::query::Layer::Exact;
            if (complete) c.surfaces = &surfaces;
            sqmap_fcl::collide(&first, &second, &c);
            EXPECT_EQ(c.status, sqmap::query::k_ok);
            found[space == 1] = c.result.numContacts();
        }
        EXPECT_GT(found[0], 1U);
        EXPECT_EQ(found[1], found[0]);
    }
}

TEST(FclSurfaces, RidgesThatCrossBetweenTheirVerticesTouch)
{
    const sqmap::test::Solid lower(sqmap::test::diamond_bar(true, 3, 1, 0)), upper(sqmap::test::diamond_bar(false, 3, 1, 0));
    sqmap_fcl::Solid of_lower{&lower.view, &lower.probe}, of_upper{&upper.view, &upper.probe};
    Object first(std::make_shared<fcl::Boxd>(6, 2, 2)), second(std::make_shared<fcl::Boxd>(2, 6, 2));
    first.setUserData(&of_lower);
    second.setUserData(&of_upper);
    sqmap::query::PairWorkspace workspace(64);
    sqmap::query::ContactWorkspace surfaces(64);
    const auto contacts = [&](double height, bool complete, bool swapped, bool enable) {
        second.setTranslation({0, 0, height});
        sqmap_fcl::Collision c(workspace);
        c.request.num_max_contacts = 64;
        c.request.enable_contact = enable;
        c.options.query.layer = sqmap::query::Layer::Exact;
        if (complete) c.surfaces = &surfaces;
        sqmap_fcl::collide(swapped ? &second : &first, swapped ? &first : &second, &c);
        EXPECT_EQ(c.status, sqmap::query::k_ok);
        return c.result;
    };
    EXPECT_FALSE(contacts(1.9, false, false, true).isCollision());  // no vertex is inside
    EXPECT_FALSE(contacts(2.1, true, false, true).isCollision());
    EXPECT_TRUE(contacts(1.9, true, false, false).isCollision());
    for (const bool swapped : {false, true}) {
        const auto result = contacts(1.9, true, swapped, true);
        ASSERT_EQ(result.numContacts(), 1U);
        const auto& c = result.getContact(0);
        EXPECT_NEAR(c.penetration_depth, 0.1, 1e-6);
        EXPECT_NEAR(c.normal[2], swapped ? -1 : 1, 1e-6);
        EXPECT_LT((c.pos - fcl::Vector3d(0, 0, 0.95)).norm(), 1e-6);
        EXPECT_EQ(c.o1, (swapped ? second : first).collisionGeometry().get());
        ASSERT_GE(c.b1, 0);
        ASSERT_GE(c.b2, 0);
        const auto has_ridge = [](const sqmap::mesh::Mesh& mesh, auto triangle, double z) {
            int on = 0;
            for (const auto v : mesh.triangles.at(static_cast<std::size_t>(triangle))) on += mesh.vertices.at(v).z == z ? 1 : 0;
            return on == 2;
        };
        EXPECT_TRUE(has_ridge(lower.mesh, swapped ? c.b2 : c.b1, 1));
        EXPECT_TRUE(has_ridge(upper.mesh, swapped ? c.b1 : c.b2, -1));
    }
}

TEST(FclSurfaces, AProbeOfVerticesAloneIsSaid)
{
    const sqmap::query::Probe vertices(torus().mesh.vertices);
    sqmap_fcl::Solid whole{&torus().view, &torus().probe}, bare{&torus().view, &vertices};
    Object first(std::make_shared<fcl::Boxd>(2.6, 2.6, 0.6)), second(std::make_shared<fcl::Boxd>(2.6, 2.6, 0.6));
    first.setUserData(&whole);
    second.setUserData(&bare);
    second.setTranslation({2.5, 0, 0});
    sqmap::query::PairWorkspace workspace(64);
    sqmap::query::ContactWorkspace surfaces(64);
    sqmap_fcl::Collision c(workspace);
    c.request.enable_contact = true;  // a yes or no ends at the first vertex
    c.request.num_max_contacts = 64;
    c.surfaces = &surfaces;
    sqmap_fcl::collide(&first, &second, &c);
    EXPECT_NE(c.status & sqmap::query::k_no_triangles, 0);
}

TEST(FclSurfaces, OfMoreContactsThanTheRequestTakesTheDeepestAreKept)
{
    const sqmap::test::Solid ball(sqmap::mesh::sphere(1, 3));
    const sqmap_fcl::Solid solid{&ball.view, &ball.probe};
    Object first(std::make_shared<fcl::Sphered>(1.0)), second(std::make_shared<fcl::Sphered>(1.0));
    first.setUserData(const_cast<sqmap_fcl::Solid*>(&solid));
    second.setUserData(const_cast<sqmap_fcl::Solid*>(&solid));
    second.setTranslation({1.7, 0.1, 0.05});
    sqmap::query::PairWorkspace workspace(4096);
    sqmap::query::ContactWorkspace surfaces(4096);
    const auto depths = [&](std::size_t max) {
        sqmap_fcl::Collision c(workspace);
        c.request.num_max_contacts = max;
        c.request.enable_contact = true;
        c.surfaces = &surfaces;
        sqmap_fcl::collide(&first, &second, &c);
        std::vector<double> out;
        for (std::size_t i = 0; i < c.result.numContacts(); ++i) out.push_back(c.result.getContact(i).penetration_depth);
        std::sort(out.rbegin(), out.rend());
        return out;
    };
    const std::vector<double> all = depths(100000), few = depths(5);
    ASSERT_GT(all.size(), 20U);
    EXPECT_EQ(few, std::vector<double>(all.begin(), all.begin() + 5));
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
