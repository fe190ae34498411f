// A pile of many bodies: all contacts at given poses, beside FCL's pairs of triangles and Bullet's GImpact, each with its own
// broad phase and as many threads.
#include "clock.h"
#include "fcl_tree.h"
#include "frames.h"
#include "measure.h"
#include "setting.h"

#include "math/random.h"
#include "parallel/for_each.h"
#include "sqmap/bake_mesh.h"
#include "sqmap/bulk/pile.h"
#include "sqmap/math/rotation.h"
#include "sqmap/query/clearance.h"

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/narrowphase/collision.h>

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletCollisionCommon.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

namespace sqmap::bench {
namespace {

constexpr double k_pressed = 0.005;  ///< how far each body is pressed into what it fell on, of the meshes' diagonal

/// A mesh as sqmap and FCL have it.
struct PileItem {
    explicit PileItem(mesh::Mesh m)
        : mesh(std::move(m)),
          baked(bake_mesh(mesh)),
          view(baked.view()),
          probe(mesh.vertices, mesh.triangles),
          tree(fcl_tree<fcl::OBBRSS<double>>(mesh.vertices, mesh.triangles))
    {
    }
    mesh::Mesh mesh;
    BakedModel baked;
    model::ModelView view;
    query::Probe probe;
    std::shared_ptr<fcl::BVHModel<fcl::OBBRSS<double>>> tree;
};
using PileItems = std::vector<std::unique_ptr<PileItem>>;

/// Bodies that fell one after the other, each until it touched, and were pressed in a little.
std::vector<Pose> fallen(const PileItems& items, std::size_t count)
{
    SplitMix64 random(11);
    const double side = 0.6 * std::cbrt(static_cast<double>(count));
    std::vector<Pose> poses;
    std::vector<sqmap::Sphere> spheres;
    double top = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const PileItem& own = *items[i % items.size()];
        const Mat3d turn = rotation_by({random.between(-3, 3), random.between(-3, 3), random.between(-3, 3)});
        Pose pose{turn, {side * random.between(-0.5, 0.5), side * random.between(-0.5, 0.5), top + 2}};
        constexpr double k_near = 1e-4;
        for (int step = 0; step < 60 && pose.translation.z > 0; ++step) {
            const sqmap::Sphere ball = query::sphere_of({&own.view, &own.probe, pose});
            double gap = pose.translation.z + k_near;
            for (std::size_t j = 0; j < i; ++j) {
                const Vec3d beside = spheres[j].centre - ball.centre;
                const double radii = spheres[j].radius + ball.radius;
                if (beside.z > radii || std::hypot(beside.x, beside.y) > radii || norm(beside) - radii > gap) continue;
                const PileItem& other = *items[j % items.size()];
                gap = std::min(gap,
                               query::clearance({&other.view, &other.probe, poses[j]}, {&own.view, &own.probe, pose}).distance);
            }
            if (gap < k_near) break;
            pose.translation.z -= gap;
        }
        pose.translation.z -= k_pressed;
        top = std::max(top, pose.translation.z);
        poses.push_back(pose);
        spheres.push_back(query::sphere_of({&own.view, &own.probe, pose}));
    }
    return poses;
}

using BodyPairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// Runs work on every pair by as many threads; work gets the number of the thread.
template <class Work>
void share_pairs(const BodyPairs& pairs, unsigned threads, Work&& work)
{
    std::atomic<std::size_t> next{0};
    parallel::for_each(threads, threads, [&](std::size_t w) {
        for (std::size_t i = next++; i < pairs.size(); i = next++) work(w, i);
    });
}

/// FCL's dynamic tree of boxes, then its pairs of triangles.
class FclPile {
public:
    FclPile(const PileItems& items, const std::vector<Pose>& poses)
    {
        for (std::size_t i = 0; i < poses.size(); ++i) {
            objects_.push_back(std::make_unique<fcl::CollisionObjectd>(items[i % items.size()]->tree, fcl_transform(poses[i])));
            objects_.back()->setUserData(reinterpret_cast<void*>(i));
            manager_.registerObject(objects_.back().get());
        }
        manager_.setup();
    }
    /// Numbers of pairs of triangles, by pairs of bodies.
    void run(const std::vector<Pose>& poses, unsigned threads)
    {
        for (std::size_t i = 0; i < poses.size(); ++i) {
            objects_[i]->setTransform(fcl_transform(poses[i]));
            objects_[i]->computeAABB();
        }
        manager_.update();
        pairs.clear();
        manager_.collide(&pairs, [](fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* out) {
            const auto i = static_cast<std::uint32_t>(reinterpret_cast<std::size_t>(a->getUserData())),
                       j = static_cast<std::uint32_t>(reinterpret_cast<std::size_t>(b->getUserData()));
            static_cast<BodyPairs*>(out)->push_back({std::min(i, j), std::max(i, j)});
            return false;
        });
        meetings.assign(pairs.size(), 0);
        share_pairs(pairs, threads, [&](std::size_t, std::size_t i) {
            fcl::CollisionResultd result;
            fcl::collide(objects_[pairs[i].first].get(), objects_[pairs[i].second].get(),
                         fcl::CollisionRequestd(std::numeric_limits<int>::max(), false), result);
            meetings[i] = result.numContacts();
        });
    }
    BodyPairs pairs;
    std::vector<std::size_t> meetings;

private:
    fcl::DynamicAABBTreeCollisionManagerd manager_;
    std::vector<std::unique_ptr<fcl::CollisionObjectd>> objects_;
};

struct PointCounter final : btManifoldResult {
    using btManifoldResult::btManifoldResult;
    std::size_t points = 0;
    void addContactPoint(const btVector3&, const btVector3&, btScalar) override { ++points; }
};

/// A thread's own shapes and dispatcher: GImpact locks a shape while it reads it.
class BulletThread {
public:
    explicit BulletThread(const PileItems& items) : dispatcher_(&configuration_)
    {
        btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher_);
        for (const auto& item : items) {
            Form& f = *forms_.emplace_back(std::make_unique<Form>());
            for (const Vec3d& v : item->mesh.vertices)
                for (int k = 0; k < 3; ++k) f.points.push_back(static_cast<btScalar>(v[k]));
            for (const mesh::Triangle& t : item->mesh.triangles)
                for (const std::uint32_t v : t) f.indices.push_back(static_cast<int>(v));
            f.array = std::make_unique<btTriangleIndexVertexArray>(
                static_cast<int>(f.indices.size() / 3), f.indices.data(), static_cast<int>(3 * sizeof(int)),
                static_cast<int>(f.points.size() / 3), f.points.data(), static_cast<int>(3 * sizeof(btScalar)));
            f.shape = std::make_unique<btGImpactMeshShape>(f.array.get());
            f.shape->setMargin(0);
            f.shape->updateBound();
        }
    }
    std::size_t contacts(std::size_t a, const btTransform& at_a, std::size_t b, const btTransform& at_b)
    {
        btCollisionObject first, second;
        first.setCollisionShape(forms_[a]->shape.get());
        first.setWorldTransform(at_a);
        second.setCollisionShape(forms_[b]->shape.get());
        second.setWorldTransform(at_b);
        const btCollisionObjectWrapper one(nullptr, first.getCollisionShape(), &first, at_a, -1, -1),
            other(nullptr, second.getCollisionShape(), &second, at_b, -1, -1);
        btCollisionAlgorithm* const algorithm = dispatcher_.findAlgorithm(&one, &other, nullptr, BT_CONTACT_POINT_ALGORITHMS);
        PointCounter counter(&one, &other);
        algorithm->processCollision(&one, &other, info_, &counter);
        algorithm->~btCollisionAlgorithm();
        dispatcher_.freeCollisionAlgorithm(algorithm);
        return counter.points;
    }
    [[nodiscard]] const btCollisionShape& shape(std::size_t i) const { return *forms_[i]->shape; }

private:
    struct Form {
        std::vector<btScalar> points;
        std::vector<int> indices;
        std::unique_ptr<btTriangleIndexVertexArray> array;
        std::unique_ptr<btGImpactMeshShape> shape;
    };
    btDefaultCollisionConfiguration configuration_;
    btCollisionDispatcher dispatcher_;
    btDispatcherInfo info_;
    std::vector<std::unique_ptr<Form>> forms_;
};

/// Bullet's dynamic trees of boxes, then GImpact.
class BulletPile {
public:
    BulletPile(const PileItems& items, std::size_t bodies, unsigned threads) : items_(items.size()), dispatcher_(&configuration_)
    {
        for (unsigned i = 0; i < threads; ++i) threads_.push_back(std::make_unique<BulletThread>(items));
        for (std::size_t i = 0; i < bodies; ++i) {
            auto& o = *objects_.emplace_back(std::make_unique<btCollisionObject>());
            o.setUserIndex(static_cast<int>(i));
            proxies_.push_back(broad_.createProxy({0, 0, 0}, {0, 0, 0}, 0, &o, 1, 1, &dispatcher_));
        }
    }
    ~BulletPile()
    {
        for (btBroadphaseProxy* p : proxies_) broad_.destroyProxy(p, &dispatcher_);
    }
    BulletPile(const BulletPile&) = delete;
    BulletPile& operator=(const BulletPile&) = delete;

    void run(const std::vector<Pose>& poses)
    {
        std::vector<btTransform> at;
        for (std::size_t i = 0; i < poses.size(); ++i) {
            const auto& r = poses[i].rotation.row;
            const auto s = [](double v) { return static_cast<btScalar>(v); };
            at.push_back(btTransform(
                btMatrix3x3(s(r[0].x), s(r[0].y), s(r[0].z), s(r[1].x), s(r[1].y), s(r[1].z), s(r[2].x), s(r[2].y), s(r[2].z)),
                btVector3(s(poses[i].translation.x), s(poses[i].translation.y), s(poses[i].translation.z))));
            btVector3 lo, hi;
            threads_[0]->shape(i % items_).getAabb(at.back(), lo, hi);
            broad_.setAabb(proxies_[i], lo, hi, &dispatcher_);
        }
        broad_.calculateOverlappingPairs(&dispatcher_);
        const btBroadphasePairArray& found = broad_.getOverlappingPairCache()->getOverlappingPairArray();
        pairs.clear();
        for (int i = 0; i < found.size(); ++i) {
            const auto number = [](const btBroadphaseProxy* p) {
                return static_cast<std::uint32_t>(static_cast<const btCollisionObject*>(p->m_clientObject)->getUserIndex());
            };
            pairs.push_back(std::minmax({number(found[i].m_pProxy0), number(found[i].m_pProxy1)}));
        }
        contacts.assign(pairs.size(), 0);
        share_pairs(pairs, static_cast<unsigned>(threads_.size()), [&](std::size_t w, std::size_t i) {
            const auto [a, b] = pairs[i];
            contacts[i] = threads_[w]->contacts(a % items_, at[a], b % items_, at[b]);
        });
    }
    BodyPairs pairs;
    std::vector<std::size_t> contacts;

private:
    std::size_t items_;
    btDefaultCollisionConfiguration configuration_;
    btCollisionDispatcher dispatcher_;
    btDbvtBroadphase broad_;
    std::vector<std::unique_ptr<BulletThread>> threads_;
    std::vector<std::unique_ptr<btCollisionObject>> objects_;
    std::vector<btBroadphaseProxy*> proxies_;
};

std::size_t count_above_zero(const std::vector<std::size_t>& v)
{
    return static_cast<std::size_t>(std::count_if(v.begin(), v.end(), [](std::size_t n) { return n > 0; }));
}
std::size_t sum_of(const std::vector<std::size_t>& v)
{
    std::size_t sum = 0;
    for (const std::size_t n : v) sum += n;
    return sum;
}

/// Pairs of bodies of which one answer says that surfaces meet and the other does not.
std::size_t differing(const bulk::PileResult& own, const FclPile& fcl)
{
    BodyPairs ours, theirs, different;
    for (const bulk::PilePair& p : own.pairs)
        if (p.meetings > 0) ours.push_back({p.a, p.b});
    for (std::size_t i = 0; i < fcl.pairs.size(); ++i)
        if (fcl.meetings[i] > 0) theirs.push_back(fcl.pairs[i]);
    std::sort(theirs.begin(), theirs.end());
    std::set_symmetric_difference(ours.begin(), ours.end(), theirs.begin(), theirs.end(), std::back_inserter(different));
    return different.size();
}

int run_pile(std::size_t bodies, unsigned threads, const PileItems& items)
{
    std::vector<Pose> poses = fallen(items, bodies);
    bulk::Pile pile;
    for (std::size_t i = 0; i < bodies; ++i) {
        const PileItem& item = *items[i % items.size()];
        pile.add(&item.view, &item.probe, poses[i]);
    }
    FclPile fcl(items, poses);
    BulletPile bullet(items, bodies, threads);
    const FrameClock clock;
    std::vector<double> times[4];
    const auto time = [&](std::size_t which, auto&& work) {
        const FrameClock::Mark mark = FrameClock::start();
        work();
        times[which].push_back(clock.stop_us(mark) / 1000);
    };
    SplitMix64 random(3);
    std::size_t different = 0;
    bulk::PileResult own;
    for (int step = 0; step < 5; ++step) {
        // Every body moves by a little, so that broad phases have something to mend.
        for (std::size_t i = 0; i < bodies; ++i) {
            poses[i].translation += 1e-3 * Vec3d{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
            pile.set_pose(static_cast<query::BodyId>(i), poses[i]);
        }
        time(0, [&] { own = pile.query({.threads = threads}); });
        time(1, [&] { own = pile.query({.contacts = {.per_region = 4}, .threads = threads}); });
        time(2, [&] { fcl.run(poses, threads); });
        time(3, [&] { bullet.run(poses); });
        different += differing(own, fcl);
    }
    std::size_t meetings = 0;
    for (const bulk::PilePair& p : own.pairs) meetings += p.meetings;
    const double all = percentile(times[0], 0.5), few = percentile(times[1], 0.5), theirs = percentile(times[2], 0.5),
                 gimpact = percentile(times[3], 0.5);
    std::printf("%zu bodies, %u threads; 5 steps, medians in ms\n", bodies, threads);
    std::printf("  sqmap, complete contacts  %8.1f  near pairs %zu, touching %zu, pairs of triangles %zu; four a region %.1f\n",
                all, own.near, own.pairs.size(), meetings, few);
    std::printf("  FCL, pairs of triangles   %8.1f  (%.1f times)  near pairs %zu, touching %zu, pairs of triangles %zu\n", theirs,
                theirs / all, fcl.pairs.size(), count_above_zero(fcl.meetings), sum_of(fcl.meetings));
    std::printf("  Bullet, GImpact's contacts%8.1f  (%.1f times)  near pairs %zu, touching %zu, contacts %zu\n", gimpact,
                gimpact / all, bullet.pairs.size(), count_above_zero(bullet.contacts), sum_of(bullet.contacts));
    std::printf("  pairs of bodies on whose surfaces sqmap and FCL differ, of all steps: %zu\n", different);
    return 0;
}

}  // namespace
}  // namespace sqmap::bench

int sqmap::bench::measure_pile(int argc, char** argv)
{
    if (argc < 4 || std::atoi(argv[1]) < 2 || std::atoi(argv[2]) < 1) return k_wrong_usage;
    PileItems items;
    for (int i = 3; i < argc; ++i) {
        const std::unique_ptr<Setting> setting = load_setting({argv[i], argv[i]});
        items.push_back(std::make_unique<PileItem>(setting->object));
    }
    return run_pile(static_cast<std::size_t>(std::atoi(argv[1])), static_cast<unsigned>(std::atoi(argv[2])), items);
}
