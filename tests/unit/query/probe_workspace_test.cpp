#include "sqmap/query/probe_workspace.h"

#include "support/bodies.h"
#include "support/parsed.h"

#include <gtest/gtest.h>

#include <hwy/targets.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

namespace sqmap::query {
namespace {

constexpr double k_step = 4e-4;  // of the radius of the object: 0.1 mm where that is 0.25 m

/// A probe query with a workspace, and one without, which it has to equal in every bit and in order.
class Twin {
public:
    explicit Twin(const Probe& probe, std::size_t space = 1u << 13) : workspace_(probe, space), plain_(space) {}

    ProbeResult query(const model::ModelView& model, const Probe& probe, const Pose& pose, const QueryOptions& options)
    {
        const Body touched{&model, nullptr, {}}, tool{nullptr, &probe, pose};
        const ProbeResult plain = query_probe(touched, tool, options, plain_);
        const ProbeResult kept = query_probe(touched, tool, options, workspace_);
        EXPECT_EQ(plain.contacts, kept.contacts) << "tick " << ticks_;
        EXPECT_EQ(plain.status, kept.status) << "tick " << ticks_;
        EXPECT_EQ(plain.unseen, kept.unseen) << "tick " << ticks_;
        const std::size_t written = plain.written(plain_).size();
        static_assert(sizeof(Contact) == 36, "no padding: bytes can be compared");
        if (kept.contacts == plain.contacts && written > 0) {
            EXPECT_EQ(std::memcmp(plain_.data(), workspace_.contacts().data(), written * sizeof(Contact)), 0)
                << "tick " << ticks_;
        }
        ++ticks_;
        contacts_ += plain.contacts;
        const ProbeReuse reuse = workspace_.reuse();
        kept_ += reuse.kept ? 1 : 0;
        passed_over_ += reuse.kept ? probe.clusters() - reuse.clusters : 0;
        return kept;
    }
    ProbeWorkspace& workspace() { return workspace_; }
    [[nodiscard]] std::size_t contacts() const { return contacts_; }
    [[nodiscard]] std::size_t kept() const { return kept_; }
    [[nodiscard]] std::size_t passed_over() const { return passed_over_; }

private:
    ProbeWorkspace workspace_;
    std::vector<Contact> plain_;
    std::size_t ticks_ = 0, contacts_ = 0, kept_ = 0, passed_over_ = 0;
};

const test::Solid& whole_hand()
{
    static const test::Solid k_hand(mesh::polygonized(mesh::hand_capsules(), 0.03));
    return k_hand;
}

/// The probe wanders about a point of the surface: in and out, sideways and turning, no point farther than a step a tick.
class Wander {
public:
    Wander(const test::Solid& object, std::uint64_t seed) : random_(seed), object_(object)
    {
        const Vec3d at = object.mesh.vertices[random_.below(object.mesh.vertices.size())];
        tip_ = whole_hand().mesh.vertices[random_.below(whole_hand().mesh.vertices.size())];
        pose_.rotation = test::rotation_about(random_.direction(), random_.between(0, 3));
        pose_.translation = at - pose_.rotation * tip_;
        size_ = static_cast<double>(object.view.header.sphere[3]) * object.view.header.unit;
        turn();
    }
    const Pose& next()
    {
        if (left_-- == 0) turn();
        const double step = k_step * size_;
        const Vec3d centre = apply(pose_, whole_hand().probe.sphere().centre);
        const Mat3d by = test::rotation_about(axis_, 0.5 * step / whole_hand().probe.sphere().radius);
        pose_.rotation = by * pose_.rotation;
        pose_.translation = centre + by * (pose_.translation - centre) + 0.5 * step * along_;
        return pose_;
    }
    void jump(double length) { pose_.translation += length * size_ * random_.direction(); }

private:
    void turn()
    {
        left_ = 20 + random_.below(60);
        axis_ = random_.direction();
        // Back to the surface, by and large.
        const Vec3d away = apply(pose_, tip_) - object_.mesh.vertices[random_.below(object_.mesh.vertices.size())];
        along_ = normalized(random_.direction() - 0.5 * normalized(away));
    }

    test::Random random_;
    const test::Solid& object_;
    Pose pose_;
    Vec3d tip_{}, axis_{}, along_{};
    double size_ = 1;
    std::size_t left_ = 0;
};

const test::Solid& ring()
{
    static const test::Solid k_ring(test::small_torus());
    return k_ring;
}

TEST(ProbeWorkspace, SlowPathsHaveTheSameBits)
{
    for (const test::Shape& shape : test::small_shapes()) {
        const test::Solid object(shape.mesh);
        if (!model::has_locator(object.view)) continue;
        SCOPED_TRACE(shape.name);
        Twin twin(whole_hand().probe);
        for (std::uint64_t seed = 1; seed < 4; ++seed) {
            Wander wander(object, seed);
            for (int i = 0; i < 400; ++i)
                (void)twin.query(object.view, whole_hand().probe, wander.next(), {.layer = Layer::Exact});
        }
        EXPECT_GT(twin.contacts(), 1000u);
        EXPECT_GT(twin.kept(), 1000u);
    }
}

TEST(ProbeWorkspace, EveryInstructionSetHasTheSameBits)
{
    const std::int64_t supported = hwy::SupportedTargets() & HWY_TARGETS;
    int sets = 0;
    for (std::int64_t left = supported; left != 0; left &= left - 1, ++sets) {
        const std::int64_t one = left & -left;
        SCOPED_TRACE(hwy::TargetName(one));
        hwy::SetSupportedTargetsForTest(one);
        Twin twin(whole_hand().probe);
        Wander wander(ring(), 9);
        for (int i = 0; i < 300; ++i) (void)twin.query(ring().view, whole_hand().probe, wander.next(), {.layer = Layer::Exact});
        hwy::SetSupportedTargetsForTest(0);
        EXPECT_GT(twin.contacts(), 100u);
        EXPECT_GT(twin.passed_over(), 1000u);
    }
    EXPECT_GE(sets, 2) << "this machine has one instruction set: nothing was compared";
}

TEST(ProbeWorkspace, SmallMotionNearTheSurfacePassesClustersOver)
{
    Twin twin(whole_hand().probe);
    // Outside, the nearest point two hundredths of the size above the ring.
    Pose pose;
    const double size = static_cast<double>(ring().view.header.sphere[3]) * ring().view.header.unit;
    for (pose.translation.z = 3; pose.translation.z > 0; pose.translation.z -= 0.01 * size)
        if (twin.query(ring().view, whole_hand().probe, pose, {.layer = Layer::Exact}).contacts > 0) break;
    ASSERT_GT(twin.contacts(), 0u);
    pose.translation.z += 0.03 * size;
    Twin near(whole_hand().probe);
    constexpr int k_ticks = 1000;
    for (int i = 0; i < k_ticks; ++i) {
        pose.translation.x += (i / 10 % 2 == 0 ? k_step : -k_step) * size;
        (void)near.query(ring().view, whole_hand().probe, pose, {.layer = Layer::Exact});
    }
    EXPECT_EQ(near.contacts(), 0u);
    EXPECT_GT(near.kept(), k_ticks - 10u);
    EXPECT_GT(near.passed_over(), 85 * k_ticks * whole_hand().probe.clusters() / 100);
}

TEST(ProbeWorkspace, JumpsNaNAndOtherQueriesBetweenAreSeen)
{
    const test::Solid ball(mesh::sphere(0.4, 3));
    const std::vector<Vec3d> few(whole_hand().mesh.vertices.begin(), whole_hand().mesh.vertices.begin() + 100);
    const Probe small(few), copy = whole_hand().probe;
    Twin twin(whole_hand().probe);
    test::Random random(3);
    for (std::uint64_t seed = 20; seed < 26; ++seed) {
        Wander wander(ring(), seed);
        for (int i = 0; i < 300; ++i) {
            const Pose pose = wander.next();
            QueryOptions options{.layer = Layer::Exact};
            switch (random.below(24)) {
                case 0:
                    wander.jump(0.02);
                    break;
                case 1:
                    (void)twin.query(ball.view, whole_hand().probe, pose, options);
                    break;
                case 2:
                    (void)twin.query(ring().view, small, pose, options);
                    break;
                case 3:
                    (void)twin.query(ring().view, copy, pose, options);
                    break;
                case 4: {
                    Pose broken = pose;
                    broken.translation.y = std::numeric_limits<double>::quiet_NaN();
                    EXPECT_NE(twin.query(ring().view, whole_hand().probe, broken, options).status & k_not_finite, 0);
                    EXPECT_FALSE(twin.workspace().reuse().kept);
                    break;
                }
                case 5:
                    options.layer = Layer::Three;
                    break;
                case 6:
                    options.first_only = true;
                    break;
                case 7:
                    options.margin = 0.001;
                    break;
                case 8:
                    twin.workspace().forget();
                    break;
                case 9:
                    (void)twin.query(ring().view, whole_hand().probe, test::shifted({1e6, 0, 0}), options);
                    break;
                case 10:
                    options = {.layer = Layer::Auto};
                    break;
                default:
                    break;
            }
            (void)twin.query(ring().view, whole_hand().probe, pose, options);
        }
    }
    EXPECT_GT(twin.contacts(), 1000u);
    EXPECT_GT(twin.kept(), 300u);
}

TEST(ProbeWorkspace, PointsThatMoveAreSeen)
{
    std::vector<Vec3d> points = whole_hand().mesh.vertices;
    Probe probe(points);
    Twin twin(probe);
    Wander wander(ring(), 5);
    test::Random random(8);
    std::vector<std::uint8_t> active(points.size(), 1);
    for (int i = 0; i < 600; ++i) {
        const Pose& pose = wander.next();
        if (i % 29 == 28) {
            const Vec3d by = 0.05 * random.direction();
            for (Vec3d& p : points) p += by;
            probe.move(points);
        } else if (i % 67 == 66) {
            for (std::uint8_t& a : active) a = random.below(3) != 0;
            probe.move(points, active);
        }
        (void)twin.query(ring().view, probe, pose, {.layer = Layer::Exact});
    }
    EXPECT_GT(twin.contacts(), 1000u);
    EXPECT_GT(twin.kept(), 300u);
}

TEST(ProbeWorkspace, ForgettingLooksAtAllClustersAgain)
{
    Pose pose = test::shifted({0, 0, 2 * ring().view.header.sphere[3]});
    ProbeWorkspace workspace(whole_hand().probe, 100);
    const auto looked_at = [&] {
        (void)query_probe({.model = &ring().view}, {.probe = &whole_hand().probe, .pose = pose}, {.layer = Layer::Exact},
                          workspace);
        return workspace.reuse().clusters;
    };
    // Down until the probe's sphere meets the model, then at rest.
    for (int i = 0; i < 5000 && looked_at() < whole_hand().probe.clusters() / 2; ++i) pose.translation.z -= 0.001;
    for (int i = 0; i < 10; ++i) (void)looked_at();
    ASSERT_TRUE(workspace.reuse().kept);
    const std::size_t at_rest = looked_at();
    EXPECT_LT(at_rest, whole_hand().probe.clusters() / 10);
    workspace.forget();
    EXPECT_GT(looked_at(), whole_hand().probe.clusters() / 2);
    EXPECT_EQ(looked_at(), at_rest);
}

TEST(ProbeWorkspace, AnotherModelAtTheSameAddressIsSeen)
{
    const test::Solid ball(mesh::sphere(0.7, 3));
    model::ModelView view = ring().view;
    Twin twin(whole_hand().probe);
    Wander wander(ring(), 6);
    for (int i = 0; i < 300; ++i) {
        if (i % 40 == 39) view = i % 80 == 79 ? ring().view : ball.view;
        (void)twin.query(view, whole_hand().probe, wander.next(), {.layer = Layer::Exact});
    }
    EXPECT_GT(twin.contacts(), 100u);
    EXPECT_GT(twin.kept(), 100u);
}

TEST(ProbeWorkspace, WithoutSpaceContactsAreCounted)
{
    Twin twin(whole_hand().probe, 3);
    Wander wander(ring(), 7);
    for (int i = 0; i < 300; ++i) (void)twin.query(ring().view, whole_hand().probe, wander.next(), {.layer = Layer::Exact});
    EXPECT_EQ(twin.workspace().contacts().size(), 3u);
    EXPECT_GT(twin.contacts(), 3u * 300u);
}

TEST(ProbeWorkspace, OneOfNoPointsAndOneThatWasMovedFromAreRight)
{
    const Probe none(std::span<const Vec3d>{});
    Twin twin(none);
    for (int i = 0; i < 10; ++i) EXPECT_EQ(twin.query(ring().view, none, {}, {.layer = Layer::Exact}).contacts, 0u);
    ProbeWorkspace first(whole_hand().probe, 10);
    const ProbeWorkspace second = std::move(first);
    EXPECT_EQ(second.contacts().size(), 10u);
    first.forget();                    // NOLINT(bugprone-use-after-move): it says that it is empty
    EXPECT_FALSE(first.reuse().kept);  // NOLINT(bugprone-use-after-move)
    (void)query_probe({.model = &ring().view}, {.probe = &whole_hand().probe}, {.layer = Layer::Exact}, first);
    EXPECT_FALSE(first.reuse().kept);
}

}  // namespace
}  // namespace sqmap::query
