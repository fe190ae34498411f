#include "sqmap/query/probe.h"
#include "sqmap/query/point.h"

#include "support/bodies.h"
#include "support/parsed.h"

#include <gtest/gtest.h>

#include <hwy/targets.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <iostream>
#include <limits>
#include <numeric>

namespace sqmap::query {
namespace {

Mat3d random_rotation(test::Random& random)
{
    const Vec3d axis = random.direction();
    return test::rotation_about(axis, random.between(0, 6.28));
}

const std::vector<Vec3d>& hand_points()
{
    static const std::vector<Vec3d> k_points = mesh::polygonized(mesh::hand_capsules(), 0.035).vertices;
    return k_points;
}

/// Some point of the probe comes near some vertex of the mesh, any way round. mesh: in the units of the pose.
std::vector<Pose> touching_poses(std::span<const Vec3d> probe, std::span<const Vec3d> mesh, int count, std::uint64_t seed)
{
    test::Random random(seed);
    std::vector<Pose> poses;
    for (int i = 0; i < count; ++i) {
        Pose pose{random_rotation(random), {}};
        pose.translation =
            mesh[random.below(mesh.size())] + 0.1 * random.direction() - pose.rotation * probe[random.below(probe.size())];
        poses.push_back(pose);
    }
    return poses;
}

struct Answer {
    ProbeResult result;
    std::vector<Contact> contacts;  ///< by index
};

/// pose: to the mesh's frame; contacts in model space.
Answer answer_of(const test::Parsed& m, const Probe& probe, const Pose& pose, const QueryOptions& options = {})
{
    Answer answer;
    answer.contacts.resize(probe.size());
    answer.result =
        query_probe({.model = &m.in_model_space()}, {.probe = &probe, .pose = m.to_model(pose)}, options, answer.contacts);
    answer.contacts.resize(std::min(answer.contacts.size(), answer.result.contacts));
    std::sort(answer.contacts.begin(), answer.contacts.end(), [](const auto& a, const auto& b) { return a.index < b.index; });
    return answer;
}

bool same_bits(const Contact& a, const Contact& b)
{
    return std::memcmp(&a.witness, &b.witness, sizeof a.witness) == 0 &&
           std::memcmp(&a.normal, &b.normal, sizeof a.normal) == 0 && std::memcmp(&a.depth, &b.depth, sizeof a.depth) == 0 &&
           a.index == b.index && a.part == b.part && a.certain == b.certain && a.status == b.status;
}

void expect_same(const Answer& a, const Answer& b, const std::string& what)
{
    EXPECT_EQ(a.result.contacts, b.result.contacts) << what;
    EXPECT_EQ(a.result.status, b.result.status) << what;
    EXPECT_EQ(a.result.unseen, b.result.unseen) << what;
    ASSERT_EQ(a.contacts.size(), b.contacts.size()) << what;
    for (std::size_t i = 0; i < a.contacts.size(); ++i)
        ASSERT_TRUE(same_bits(a.contacts[i], b.contacts[i]))
            << what << ": contact " << i << ", points " << a.contacts[i].index << " and " << b.contacts[i].index << ", depths "
            << a.contacts[i].depth << " and " << b.contacts[i].depth;
}

/// Layer One of two probes of the same points whose clusters differ: it errs towards contact, except where the locator proves a
/// whole cluster free. Contacts that both have are alike; a point that one of them leaves out is outside.
void expect_same_but_proven_free(Answer a, Answer b, const std::function<bool(std::uint32_t)>& is_outside)
{
    const auto keep_common = [&](Answer& of, const Answer& other) {
        const auto lacks = [&](const Contact& c) {
            const bool missing =
                std::none_of(other.contacts.begin(), other.contacts.end(), [&](const Contact& d) { return c.index == d.index; });
            EXPECT_TRUE(!missing || is_outside(c.index)) << c.index;
            return missing;
        };
        const auto kept = std::remove_if(of.contacts.begin(), of.contacts.end(), lacks);
        of.contacts.erase(kept, of.contacts.end());
    };
    const Answer all_of_a = a;
    keep_common(a, b);
    keep_common(b, all_of_a);
    EXPECT_FALSE(a.contacts.empty());
    a.result.contacts = a.contacts.size();
    b.result.contacts = b.contacts.size();
    expect_same(a, b, "layer 1");
}

/// Which points are in contact: one entry a point.
std::vector<const Contact*> by_point(const Answer&& answer, std::size_t points) = delete;  // it points into the answer
std::vector<const Contact*> by_point(const Answer& answer, std::size_t points)
{
    std::vector<const Contact*> out(points, nullptr);
    for (const Contact& c : answer.contacts) {
        EXPECT_EQ(out[c.index], nullptr) << "point " << c.index << " twice";
        out[c.index] = &c;
    }
    return out;
}

struct Target {
    std::string name;
    mesh::Mesh mesh;
};
std::vector<Target> targets()
{
    std::vector<Target> out = {{"torus", test::small_torus()}, {"dumbbell", mesh::dumbbell({.segments = 24})}};
    if (auto horse = test::shared_mesh_too("horse_5946.obj")) {
        // As large as the others.
        const double size = mesh::surface_area(*horse);
        out.push_back({"horse", test::mapped(*horse, std::sqrt(10 / size), {})});
    }
    return out;
}

struct Limits {
    double verdict_band;              ///< of R_max: verdicts farther from the surface are right
    double depth_share, depth_error;  ///< that share of depths errs by that much of R_max at most
};

/// A hand at many places about a mesh, against winding numbers and closest points in double precision.
void check_against_oracle(Layer layer, const Limits& limits)
{
    const std::vector<Vec3d>& points = hand_points();
    const Probe probe(points);
    for (const Target& target : targets()) {
        const test::Parsed m(target.mesh);
        const double r_max = m.r_max();
        std::size_t contacts = 0, judged = 0, wrong = 0, certain_wrong = 0;
        std::uint32_t unseen = 0;
        std::vector<double> errors, tilts;
        for (const Pose& pose : touching_poses(points, target.mesh.vertices, 8, 7)) {
            const Answer answer = answer_of(m, probe, pose, {.layer = layer});
            EXPECT_EQ(answer.result.status, k_ok);
            unseen += answer.result.unseen;
            const auto contact_of = by_point(answer, points.size());
            for (std::size_t i = 0; i < points.size(); ++i) {
                const Vec3d p = m.to_model(apply(pose, points[i]));
                const bool inside = m.solid().inside(p);
                const Contact* c = contact_of[i];
                contacts += inside ? 1u : 0u;
                if (inside != (c != nullptr)) {
                    const double distance = m.solid().closest_boundary(p).distance;
                    if (c != nullptr && c->certain) certain_wrong += distance > 1e-5 * r_max ? 1u : 0u;
                    if (distance <= limits.verdict_band * r_max) continue;
                    ++wrong;
                    ADD_FAILURE() << target.name << ": point " << i << ' ' << (inside ? "missed" : "falsely in contact") << ' '
                                  << 100 * distance / r_max << " % of R_max from the surface, at " << p.x << ' ' << p.y << ' '
                                  << p.z;
                    ASSERT_LT(wrong, 10u);
                    continue;
                }
                ++judged;
                if (c == nullptr) continue;
                const mesh::ClosestPoint nearest = m.solid().closest_boundary(p);
                errors.push_back(std::abs(static_cast<double>(c->depth) - nearest.distance) / r_max);
                ASSERT_GE(c->depth, 0.f);
                ASSERT_NEAR(norm(c->normal), 1.f, 1e-3f);
                ASSERT_GE(c->part, 0);
                ASSERT_LT(static_cast<std::size_t>(c->part), m.view().parts.size());
                EXPECT_NEAR(norm(cast<double>(c->witness) - p), c->depth, 1e-4 * r_max);
                if (nearest.distance > 0.01 * r_max)
                    tilts.push_back(dot(cast<double>(c->normal), nearest.point - p) / nearest.distance);
            }
        }
        EXPECT_EQ(certain_wrong, 0u) << target.name << ": certain and wrong";
        ASSERT_GT(errors.size(), 200u) << target.name;
        std::sort(errors.begin(), errors.end());
        std::sort(tilts.begin(), tilts.end());
        const auto within =
            static_cast<double>(std::upper_bound(errors.begin(), errors.end(), limits.depth_error) - errors.begin()) /
            static_cast<double>(errors.size());
        std::cout << target.name << ": " << contacts << " contacts, " << judged << " verdicts right, " << unseen
                  << " unseen, depth median " << 100 * errors[errors.size() / 2] << " %, p95 "
                  << 100 * errors[errors.size() * 95 / 100] << " %, p99 " << 100 * errors[errors.size() * 99 / 100]
                  << " %, worst " << 100 * errors.back() << " % of R_max, within " << 100 * limits.depth_error
                  << " %: " << 100 * within << " %\n";
        EXPECT_GE(within, limits.depth_share) << target.name;
        if (layer != Layer::Two) {
            EXPECT_LE(unseen, contacts / 50) << target.name;
        }
        // Normals of deep points lead to the nearest surface; near a medial axis another facet may be as near.
        EXPECT_GT(tilts[tilts.size() / 2], layer == Layer::Two ? 0.95 : 0.99) << target.name;
        if (layer != Layer::Two) {
            EXPECT_GT(tilts[tilts.size() / 20], 0.88) << target.name;
        }
    }
}

TEST(Frame, ExactVerdictsAreTheWindingNumbersAndDepthsTheDistances) { check_against_oracle(Layer::Exact, {1e-5, 1, 1e-7}); }

TEST(Frame, ExactDepthsHoldOnNeedles)
{
    const test::Parsed m(test::needles());
    test::Random random(8);
    std::vector<Vec3d> points(6000);
    for (Vec3d& p : points) p = random.in_box({-0.52, -0.52, -0.1}, {0.52, 0.52, 10.1});
    const Answer answer = answer_of(m, Probe(points), {}, {.layer = Layer::Exact});
    const auto contact_of = by_point(answer, points.size());
    std::size_t contacts = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3d p = m.to_model(points[i]);
        const double distance = m.solid().closest_boundary(p).distance;
        if (distance < 1e-5 * m.r_max()) continue;
        ASSERT_EQ(contact_of[i] != nullptr, m.solid().inside(p));
        if (contact_of[i] == nullptr) continue;
        ++contacts;
        ASSERT_NEAR(contact_of[i]->depth, distance, 2e-6 * m.r_max());
    }
    EXPECT_GT(contacts, 3000u);
}

TEST(Frame, LayerThreeIsRightBeyondHalfAPercentAndItsDepthIsNear) { check_against_oracle(Layer::Three, {0.005, 0.99, 0.0025}); }

TEST(Frame, LayerThreeVerdictsOfPointsBesideARealSurfaceAreRightBeyondHalfAPercent)
{
    const auto bull = test::shared_mesh("bull_7154.obj");
    if (!bull) GTEST_SKIP() << "no bull_7154.obj in " << test::shared_folder();
    const test::Parsed m(*bull);
    test::Random random(5);
    std::vector<Vec3d> points;
    for (const Vec3d& v : bull->vertices)
        for (int i = 0; i < 4; ++i)
            points.push_back(v + random.between(0, 0.04) * m.r_max() * m.view().header.unit * random.direction());
    const Probe probe(points);
    const Answer answer = answer_of(m, probe, {.rotation = test::rotation_about({1, 0, 0}, 0)});
    const auto contact_of = by_point(answer, points.size());
    int wrong = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3d p = m.to_model(points[i]);
        if (m.solid().inside(p) == (contact_of[i] != nullptr)) continue;
        if (m.solid().closest_boundary(p).distance > 0.005 * m.r_max()) ++wrong;
    }
    EXPECT_LE(wrong, 1) << "of " << points.size();
}

TEST(Frame, LayerTwoIsCoarser) { check_against_oracle(Layer::Two, {0.03, 0.9, 0.02}); }

TEST(Frame, LayerOneMissesNothing)
{
    const Probe probe(hand_points());
    const test::Parsed m(test::small_torus());
    for (const Pose& pose : touching_poses(hand_points(), test::small_torus().vertices, 4, 3)) {
        const Answer answer = answer_of(m, probe, pose, {.layer = Layer::One});
        const auto contact_of = by_point(answer, hand_points().size());
        for (std::size_t i = 0; i < hand_points().size(); ++i) {
            const Vec3d p = m.to_model(apply(pose, hand_points()[i]));
            if (contact_of[i] != nullptr || !m.solid().inside(p)) continue;
            ASSERT_LT(m.solid().closest_boundary(p).distance, 1e-5 * m.r_max());
        }
    }
}

TEST(Frame, EveryInstructionSetGivesTheSameBits)
{
    const std::int64_t supported = hwy::SupportedTargets() & HWY_TARGETS;
    const Probe probe(hand_points());
    for (const Target& target : targets()) {
        const test::Parsed m(target.mesh);
        for (const Pose& pose : touching_poses(hand_points(), target.mesh.vertices, 4, 11))
            for (const Layer layer : {Layer::One, Layer::Two, Layer::Three, Layer::Exact}) {
                const Answer best = answer_of(m, probe, pose, {.layer = layer});
                int others = 0;
                for (std::int64_t left = supported; left != 0; left &= left - 1) {
                    const std::int64_t one = left & -left;
                    hwy::SetSupportedTargetsForTest(one);
                    const Answer answer = answer_of(m, probe, pose, {.layer = layer});
                    const Answer first = answer_of(m, probe, pose, {.layer = layer, .first_only = true});
                    hwy::SetSupportedTargetsForTest(0);
                    expect_same(best, answer, target.name + " by " + hwy::TargetName(one));
                    EXPECT_EQ(first.result.contacts > 0, best.result.contacts > 0) << hwy::TargetName(one);
                    ++others;
                }
                EXPECT_GE(others, 2) << "this machine has one instruction set: nothing was compared";
            }
    }
    for (std::int64_t left = supported; left != 0; left &= left - 1) std::cout << hwy::TargetName(left & -left) << ' ';
    std::cout << "compared\n";
}

TEST(Frame, TheOrderOfPointsDoesNotMatter)
{
    const test::Parsed m(test::small_torus());
    std::vector<std::uint32_t> position(hand_points().size());
    std::iota(position.begin(), position.end(), 0u);
    test::Random random(13);
    for (std::size_t i = position.size(); i > 1; --i) std::swap(position[i - 1], position[random.below(i)]);
    std::vector<Vec3d> shuffled(position.size());
    for (std::size_t i = 0; i < position.size(); ++i) shuffled[position[i]] = hand_points()[i];
    const Probe straight(hand_points()), mixed(shuffled);
    for (const Pose& pose : touching_poses(hand_points(), test::small_torus().vertices, 4, 13))
        for (const Layer layer : {Layer::One, Layer::Two, Layer::Three, Layer::Exact}) {
            Answer a = answer_of(m, straight, pose, {.layer = layer});
            for (Contact& c : a.contacts) c.index = position[c.index];
            std::sort(a.contacts.begin(), a.contacts.end(), [](const auto& x, const auto& y) { return x.index < y.index; });
            expect_same(a, answer_of(m, mixed, pose, {.layer = layer}), "layer " + std::to_string(static_cast<int>(layer)));
        }
}

TEST(Frame, MovingBothBodiesChangesNothing)
{
    const test::Parsed m(test::small_torus());
    const std::vector<Vec3d>& points = hand_points();
    const Probe probe(points);
    test::Random random(17);
    for (const Pose& pose : touching_poses(points, test::small_torus().vertices, 6, 17)) {
        // Both in a world that is moved as a whole, and the probe's points told in another frame of its own.
        const Pose object{random_rotation(random), 3. * random.direction()},
            world{random_rotation(random), 50. * random.direction()};
        const Pose moved = compose(inverse(compose(world, object)), compose(world, compose(object, pose)));
        const Pose frame{random_rotation(random), 2. * random.direction()};
        std::vector<Vec3d> retold;
        for (const Vec3d& p : points) retold.push_back(apply(frame, p));
        const Answer plain = answer_of(m, probe, pose, {.layer = Layer::Exact});
        for (const Answer& other : {answer_of(m, probe, moved, {.layer = Layer::Exact}),
                                    answer_of(m, Probe(retold), compose(pose, inverse(frame)), {.layer = Layer::Exact})}) {
            const auto a = by_point(plain, points.size()), b = by_point(other, points.size());
            std::size_t both = 0, near = 0;
            for (std::size_t i = 0; i < points.size(); ++i) {
                if (a[i] != nullptr && b[i] != nullptr) {
                    ++both;
                    near += std::abs(a[i]->depth - b[i]->depth) < 1e-5 * m.r_max() ? 1u : 0u;
                } else if (a[i] != nullptr || b[i] != nullptr) {
                    EXPECT_LT((a[i] != nullptr ? a[i] : b[i])->depth, 1e-5 * m.r_max());
                }
            }
            // Between two equally near surfaces a hair decides which the search goes for.
            EXPECT_GE(near, both - both / 100);
        }
    }
}

/// Deformed inside the same box, so that stored places are the same bits.
std::vector<Vec3d> deformed(std::vector<Vec3d> points)
{
    Vec3d lo = points.front(), hi = lo;
    for (const Vec3d& p : points)
        for (int k = 0; k < 3; ++k) {
            lo[k] = std::min(lo[k], p[k]);
            hi[k] = std::max(hi[k], p[k]);
        }
    const auto on_box = [&](Vec3d p) {
        for (int k = 0; k < 3; ++k)
            if (p[k] == lo[k] || p[k] == hi[k]) return true;
        return false;
    };
    for (Vec3d& p : points)
        if (!on_box(p)) {
            const Vec3d q = p + Vec3d{0.1 * std::sin(7 * p.y), 0.05 * std::cos(9 * p.x), 0.08 * std::sin(5 * p.y)};
            for (int k = 0; k < 3; ++k) p[k] = std::clamp(q[k], lo[k], hi[k]);
        }
    return points;
}

TEST(Frame, AMovedProbeAnswersAsAFreshOneDoes)
{
    const test::Parsed m(test::small_torus());
    const std::vector<Vec3d> bent = deformed(hand_points());
    Probe probe(hand_points());
    const Probe fresh(bent);
    for (const Pose& pose : touching_poses(bent, test::small_torus().vertices, 6, 19)) {
        const Answer before = answer_of(m, probe, pose);
        probe.move(bent);
        for (const Layer layer : {Layer::Two, Layer::Three, Layer::Exact})
            expect_same(answer_of(m, fresh, pose, {.layer = layer}), answer_of(m, probe, pose, {.layer = layer}), "moved");
        expect_same_but_proven_free(
            answer_of(m, fresh, pose, {.layer = Layer::One}), answer_of(m, probe, pose, {.layer = Layer::One}),
            [&](std::uint32_t i) { return !query_point(m.view(), apply(pose, bent[i]), {.layer = Layer::Exact}).contact; });
        probe.move(hand_points());
        expect_same(before, answer_of(m, probe, pose), "moved back");
    }
}

TEST(Frame, AFullSpanIsFlaggedAndTheRestCounted)
{
    const test::Parsed m(test::small_torus()), surface(test::small_torus(), false);
    const Probe probe(hand_points());
    int full = 0;
    for (const model::ModelView* view : {&m.view(), &surface.view()})
        for (const Pose& pose : touching_poses(hand_points(), test::small_torus().vertices, 4, 23))
            for (const Layer layer : {Layer::Three, Layer::Exact}) {
                std::vector<Contact> all(probe.size());
                const ProbeResult whole = query_probe({.model = view}, {.probe = &probe, .pose = pose}, {.layer = layer}, all);
                EXPECT_EQ(whole.status, k_ok);
                for (const std::size_t space : {whole.contacts / 2, std::size_t{0}, whole.contacts}) {
                    // One more entry behind the span must stay as it is.
                    std::vector<Contact> some(space + 1);
                    some.back().depth = -7;
                    const ProbeResult part = query_probe({.model = view}, {.probe = &probe, .pose = pose}, {.layer = layer},
                                                         std::span(some).first(space));
                    EXPECT_EQ(part.contacts, whole.contacts);
                    EXPECT_EQ(part.status, space < whole.contacts ? k_full : k_ok);
                    full += space < whole.contacts ? 1 : 0;
                    EXPECT_EQ(some.back().depth, -7);
                    for (std::size_t i = 0; i < space; ++i) ASSERT_TRUE(same_bits(some[i], all[i]));
                }
            }
    EXPECT_GT(full, 0);
}

TEST(Frame, FirstOnlySaysWhetherThereAreContacts)
{
    const test::Parsed m(test::small_torus());
    const Probe probe(hand_points());
    test::Random random(29);
    int yes = 0, no = 0;
    for (int i = 0; i < 200; ++i) {
        const Pose pose{random_rotation(random), random.between(0.2, 2.2) * random.direction()};
        for (const Layer layer : {Layer::One, Layer::Two, Layer::Three, Layer::Exact}) {
            const bool any = answer_of(m, probe, pose, {.layer = layer}).result.contacts > 0;
            const ProbeResult first =
                query_probe({.model = &m.view()}, {.probe = &probe, .pose = pose}, {.layer = layer, .first_only = true}, {});
            ASSERT_EQ(first.contacts > 0, any);
            (any ? yes : no) += 1;
        }
    }
    EXPECT_GT(yes, 40);
    EXPECT_GT(no, 40);
}

TEST(Frame, APoseThatIsNotFiniteIsRefused)
{
    const test::Parsed m(test::small_torus()), surface(test::small_torus(), false);
    const Probe probe(hand_points());
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
        for (int i = 0; i < 12; ++i)
            for (const test::Parsed* view : {&m, &surface}) {
                Pose pose;
                (i < 9 ? pose.rotation.row[i / 3][i % 3] : pose.translation[i - 9]) = bad;
                const Answer answer = answer_of(*view, probe, pose);
                EXPECT_EQ(answer.result.contacts, 0u);
                EXPECT_EQ(answer.result.status, k_not_finite);
            }
}

TEST(Frame, FarPosesGiveNothing)
{
    const test::Parsed m(test::small_torus()), surface(test::small_torus(), false);
    const Probe probe(hand_points());
    for (const double far : {4.0, 1e3, 1e9, 1e18, 1e19, 1e30, 1e37, 1e300})
        for (const Vec3d direction : {Vec3d{1, 0, 0}, Vec3d{0, -1, 0}, Vec3d{1, 1, -1}})
            for (const Layer layer : {Layer::One, Layer::Two, Layer::Three, Layer::Exact})
                for (const test::Parsed* view : {&m, &surface}) {
                    const Answer answer = answer_of(*view, probe, {{}, far * direction}, {.layer = layer});
                    EXPECT_EQ(answer.result.contacts, 0u) << far;
                    if (far < 1e38) {
                        EXPECT_EQ(answer.result.status, k_ok) << far;
                    }
                }
}

TEST(Frame, MeshesFarFromTheirOriginAreAnswered)
{
    const Vec3d shift{1e8, -1e8, 1e8};
    const mesh::Mesh moved = test::mapped(test::small_torus(), 1000, shift);
    const test::Parsed m(mesh::canonicalized(moved));
    std::vector<Vec3d> points;
    for (const Vec3d& p : hand_points()) points.push_back(1000. * p - shift);
    const Probe probe(points);
    std::size_t contacts = 0;
    for (Pose pose : touching_poses(hand_points(), test::small_torus().vertices, 4, 31)) {
        // The probe is told about a far origin of its own: only the posed points are near the mesh.
        pose.translation = 1000. * pose.translation + shift + pose.rotation * shift;
        const Answer answer = answer_of(m, probe, pose, {.layer = Layer::Exact});
        const auto contact_of = by_point(answer, points.size());
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Vec3d p = m.to_model(apply(pose, points[i]));
            const double distance = m.solid().closest_boundary(p).distance;
            if (distance < 1e-5 * m.r_max()) continue;
            ASSERT_EQ(contact_of[i] != nullptr, m.solid().inside(p)) << distance / m.r_max();
            contacts += contact_of[i] != nullptr ? 1u : 0u;
        }
    }
    EXPECT_GT(contacts, 100u);
}

TEST(Frame, AProbeOfNoPointsTouchesNothing)
{
    const test::Parsed m(test::small_torus());
    Probe probe(std::span<const Vec3d>{});
    EXPECT_EQ(probe.size(), 0u);
    probe.move({});
    for (const Layer layer : {Layer::One, Layer::Two, Layer::Three, Layer::Exact}) {
        const ProbeResult result = query_probe({.model = &m.view()}, {.probe = &probe}, {.layer = layer}, {});
        EXPECT_EQ(result.contacts, 0u);
        EXPECT_EQ(result.status, k_ok);
    }
}

TEST(Frame, ProbesOfAnySizeAnswerEachPointOnce)
{
    // Clusters and groups that are not full.
    const test::Parsed m(test::small_torus());
    test::Random random(37);
    for (const std::size_t size : {1u, 2u, 15u, 16u, 17u, 255u, 256u, 257u, 273u}) {
        std::vector<Vec3d> points(size);
        for (Vec3d& p : points) p = random.in_box({-1.3, -1.3, -0.3}, {1.3, 1.3, 0.3});
        const Probe probe(points);
        const Answer answer = answer_of(m, probe, {}, {.layer = Layer::Exact});
        const auto contact_of = by_point(answer, size);
        for (std::size_t i = 0; i < size; ++i) {
            const Vec3d p = m.to_model(points[i]);
            if (m.solid().closest_boundary(p).distance < 1e-5 * m.r_max()) continue;
            ASSERT_EQ(contact_of[i] != nullptr, m.solid().inside(p)) << size;
        }
    }
}

TEST(Frame, AModelWithoutALocatorIsAnsweredPointByPoint)
{
    const test::Parsed m(test::small_torus(), false);
    ASSERT_FALSE(model::has_locator(m.view()));
    const std::vector<Vec3d>& points = hand_points();
    const Probe probe(points);
    std::size_t contacts = 0;
    for (const Pose& pose : touching_poses(points, test::small_torus().vertices, 4, 41)) {
        const Answer answer = answer_of(m, probe, pose, {.layer = Layer::Exact});
        const auto contact_of = by_point(answer, points.size());
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Vec3d p = m.to_model(apply(pose, points[i]));
            const double distance = m.solid().closest_boundary(p).distance;
            if (distance < 1e-5 * m.r_max()) continue;
            ASSERT_EQ(contact_of[i] != nullptr, m.solid().inside(p));
            if (contact_of[i] == nullptr) continue;
            ++contacts;
            EXPECT_FALSE(contact_of[i]->certain);
        }
    }
    EXPECT_GT(contacts, 100u);
}

TEST(Frame, WithoutTheExactLayerThreeAnswersAndSaysSo)
{
    const test::Parsed m(test::small_torus(), true, {.exact = false});
    const Probe probe(hand_points());
    std::size_t contacts = 0;
    for (const Pose& pose : touching_poses(hand_points(), test::small_torus().vertices, 4, 43)) {
        const Answer exact = answer_of(m, probe, pose, {.layer = Layer::Exact}), three = answer_of(m, probe, pose);
        EXPECT_EQ(exact.result.status, k_no_exact);
        contacts += exact.result.contacts;
        EXPECT_NEAR(static_cast<double>(exact.result.contacts), static_cast<double>(three.result.contacts),
                    0.01 * static_cast<double>(probe.size()));
    }
    EXPECT_GT(contacts, 100u);
}

TEST(Frame, PosesComposeAndInvert)
{
    test::Random random(47);
    for (int i = 0; i < 50; ++i) {
        const Pose a{random_rotation(random), random.direction()}, b{random_rotation(random), random.direction()};
        const Vec3d x = random.direction();
        EXPECT_LT(norm(apply(compose(a, b), x) - apply(a, apply(b, x))), 1e-14);
        EXPECT_LT(norm(apply(inverse(a), apply(a, x)) - x), 1e-14);
    }
}

}  // namespace
}  // namespace sqmap::query
