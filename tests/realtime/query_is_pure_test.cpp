// The real-time contract (docs/realtime.md): after a model is parsed no query allocates, and none raises a
// floating-point exception that would stop a program that traps them.
#include "bake/bake.h"
#include "haptic/stencil.h"
#include "sqmap/bake/skin_lattice.h"
#include "sqmap/haptic/step.h"
#include "sqmap/io/model_file.h"
#include "sqmap/paper/bake.h"
#include "sqmap/paper/model_file.h"
#include "sqmap/query/distance.h"
#include "sqmap/query/point.h"
#include "sqmap/query/probe_workspace.h"
#include "sqmap/query/scene.h"
#include "sqmap/query/skin.h"
#include "sqmap/query/swept.h"
#include "support/bodies.h"

#include <gtest/gtest.h>

#include <array>
#include <cfenv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <new>
#include <optional>

#ifdef __linux__
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>
#include <csignal>
#endif

namespace {

thread_local bool g_guarded = false;
thread_local int g_allocations = 0;

void* counted(std::size_t size)
{
    if (g_guarded) ++g_allocations;
    void* p = std::malloc(size == 0 ? 1 : size);
    if (p == nullptr) throw std::bad_alloc();
    return p;
}

}  // namespace

// Every plain operator new ends in one of these.
void* operator new(std::size_t size) { return counted(size); }
void* operator new[](std::size_t size) { return counted(size); }
void operator delete(void* p) noexcept { std::free(p); }
void operator delete[](void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
void operator delete[](void* p, std::size_t) noexcept { std::free(p); }

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
extern "C" void* __libc_malloc(std::size_t size);
extern "C" void* malloc(std::size_t size) noexcept
{
    if (g_guarded) ++g_allocations;
    return __libc_malloc(size);
}
#endif

namespace sqmap {
namespace {

constexpr query::Layer k_layers[] = {query::Layer::One, query::Layer::Two, query::Layer::Three, query::Layer::Exact,
                                     query::Layer::Auto};

/// Allocations while work runs.
template <class Work>
int allocations_of(Work&& work)
{
    g_allocations = 0;
    g_guarded = true;
    work();
    g_guarded = false;
    return g_allocations;
}

/// Points in and around a model, and the awkward ones: centres, vertices, edge midpoints, zeros, far, tiny, not finite.
std::vector<Vec3d> points_about(const model::ModelView& view)
{
    test::Random random(7);
    std::vector<Vec3f> points;
    const float r = view.header.sphere[3];
    for (int i = 0; i < 2000; ++i) points.push_back(r * cast<float>(random.in_box({-1.1, -1.1, -1.1}, {1.1, 1.1, 1.1})));
    for (const model::Part& part : view.parts) {
        const Vec3f c = model::vec3(part.chart_centre);
        points.push_back(c);
        points.push_back(model::vec3(part.translation));
        for (int k = 0; k < 3; ++k)
            for (const float step : {1e-30f, 1e-7f, 0.01f, 0.1f, 0.3f}) {
                Vec3f p = c;
                p[k] += step;
                points.push_back(p);
                p[(k + 1) % 3] += step;
                points.push_back(p);
            }
    }
    for (std::size_t v = 0; v + 5 < view.vertices.size(); v += 30) {
        const Vec3f a = model::vec3(view.vertices.data() + v), b = model::vec3(view.vertices.data() + v + 3);
        points.push_back(a);
        points.push_back(0.5f * (a + b));
    }
    for (const float big : {1e3f, 1e18f, 1e20f, 1e30f, 3e38f, -3e38f, 1e-30f, 1e-39f, 1e-45f, 0.f, -0.f}) {
        points.push_back({big, 0, 0});
        points.push_back({0, big, big});
        points.push_back({big, big, big});
    }
    std::vector<Vec3d> out;
    for (const Vec3f& p : points) out.push_back(cast<double>(p));
    return out;
}

/// As files hold them: all small shapes, and a paper model.
const std::vector<std::vector<std::byte>>& models()
{
    static const std::vector<std::vector<std::byte>> k_models = [] {
        std::vector<std::vector<std::byte>> out;
        for (const test::Shape& shape : test::small_shapes()) out.push_back(test::baked_bytes(shape.mesh, true));
        out.push_back(paper::serialize(paper::bake(test::small_hand(), true, {}, paper::MapOptions{}).model));
        return out;
    }();
    return k_models;
}

TEST(RealTime, TheGuardSeesAllocations)
{
    EXPECT_GE(allocations_of([] {
                  std::vector<int> v(100);
                  volatile int* p = v.data();
                  p[0] = 1;
              }),
              1);
}

TEST(RealTime, ParsingAndQueriesDoNotAllocate)
{
    for (const std::vector<std::byte>& bytes : models()) {
        model::ModelView view;
        paper::ModelView own;
        EXPECT_EQ(allocations_of([&] {
                      if (model::parse(bytes, view) == model::ParseStatus::PaperModel) (void)paper::parse(bytes, own);
                  }),
                  0);
        const paper::Reading reading(own);
        if (view.parts.empty()) view = reading.view();
        ASSERT_FALSE(view.parts.empty());
        const std::vector<Vec3d> points = points_about(view);
        std::vector<query::PointResult> contacts(points.size());
        for (const query::Layer layer : k_layers) {
            EXPECT_EQ(allocations_of([&] { query::query_points({.model = &view}, points, {.layer = layer}, contacts); }), 0);
            EXPECT_EQ(allocations_of([&] {
                          for (const Vec3d& p : points) contacts[0] = query::query_point(view, p, {.layer = layer});
                      }),
                      0);
        }
    }
}

/// Frames, pairs and scenes of a hand, a ring and a ball, near and far, with room and without.
class Frames {
public:
    void run()
    {
        for (const query::Layer layer : k_layers)
            for (const bool offset : {false, true})
                for (const sqmap::Pose& pose : poses_)
                    frame({.layer = layer, .offset = offset, .margin = offset ? 0.02 : 0.}, pose);
        deforming_.move(hand_.mesh.vertices);
        slow_ticks();
    }
    [[nodiscard]] std::size_t passed_over() const { return passed_over_; }
    [[nodiscard]] std::size_t contacts() const { return total_; }

private:
    /// From each pose on in steps that a workspace keeps, into contact and out of it.
    void slow_ticks()
    {
        for (const sqmap::Pose& from : poses_)
            for (int tick = 0; tick < 200; ++tick) {
                sqmap::Pose pose = from;
                pose.translation = (1 - 3e-4 * tick) * pose.translation;
                total_ += query::query_probe({.model = &ring_.view}, {.probe = &hand_.probe, .pose = pose},
                                             {.layer = query::Layer::Exact}, kept_)
                              .contacts;
                if (kept_.reuse().kept) passed_over_ += hand_.probe.clusters() - kept_.reuse().clusters;
            }
    }
    void frame(const query::QueryOptions& options, const sqmap::Pose& pose)
    {
        total_ += query::query_probe({.model = &ring_.view}, {.probe = &hand_.probe, .pose = pose}, options, frame_).contacts;
        for (query::PairWorkspace* workspace : {&workspace_, &small_workspace_})
            total_ += query::query_pair(ring_.at(), hand_.at(pose), {.query = options}, *workspace).contacts.size();
        // Every third body jumps.
        for (query::BodyId id = 0; id < scene_.size(); ++id)
            (void)scene_.set_pose(id, {pose.rotation, (id % 3 == 0 ? 2.0 : 0.01) * static_cast<double>(id) * pose.translation});
        const query::SceneResult r = scene_.query_pairs({.query = options}, std::span(pairs_).first(20), contacts_);
        total_ += r.pairs + r.contacts;
        total_ += scene_.query_probe({.probe = &deforming_, .pose = pose}, options, pairs_, contacts_).contacts;
    }

    test::Solid hand_{test::small_hand()}, ring_{test::small_torus()}, ball_{mesh::sphere(0.3, 2)};
    query::Probe deforming_{hand_.mesh.vertices};
    query::ProbeWorkspace kept_{hand_.probe, 4096};
    std::size_t passed_over_ = 0;
    query::PairWorkspace workspace_{2048}, small_workspace_{5};
    query::Scene scene_{2048};
    std::vector<query::ScenePair> pairs_{500};
    std::vector<query::PairContact> contacts_{4096};
    std::vector<query::Contact> frame_{4096};
    std::vector<sqmap::Pose> poses_;
    std::size_t total_ = 0;

public:
    Frames()
    {
        test::Random random(41);
        for (int i = 0; i < 3; ++i) poses_.push_back(test::random_pose(random, 0.5));
        poses_.push_back(test::shifted({1e6, 0, 0}));
        poses_.push_back(test::shifted({0, std::numeric_limits<double>::quiet_NaN(), 0}));
        for (int i = 0; i < 30; ++i)
            (void)scene_.add(&(i % 2 == 0 ? ring_ : ball_).view, &(i % 2 == 0 ? ring_ : ball_).probe, poses_[0]);
    }
};

TEST(RealTime, FramesPairsAndScenesDoNotAllocate)
{
    Frames frames;
    EXPECT_EQ(allocations_of([&] { frames.run(); }), 0);
    EXPECT_GT(frames.contacts(), 1000u);
    EXPECT_GT(frames.passed_over(), 1000u);
}

/// A ring whose halves move apart, asked by a hand; and the hand swept through the ring at rest.
class Deforming {
public:
    Deforming()
    {
        for (const Vec3d& v : ring_.mesh.vertices) {
            const double right = std::min(1.0, std::max(0.0, 0.5 + v.x));
            influences_.joints.push_back({0, 1, 0, 0});
            influences_.weights.push_back({1 - right, right, 0, 0});
        }
        lattice_ = bake::skin_lattice(ring_.mesh, influences_);
        skin_.emplace(lattice_);
        test::Random random(42);
        for (int i = 0; i < 6; ++i) poses_.push_back(test::random_pose(random, 0.5));
        poses_.push_back(test::shifted({1e6, 0, 0}));
        poses_.push_back(test::shifted({0, std::numeric_limits<double>::quiet_NaN(), 0}));
        previous_ = hand_.mesh.vertices;
        for (Vec3d& p : previous_) p += Vec3d{0.3, -0.2, 0.1};
    }
    void run()
    {
        const std::span<const Vec3d> now = hand_.mesh.vertices;
        query::SweptOptions swept;
        swept.step = 0.05;
        for (const query::Layer layer : k_layers)
            for (std::size_t i = 0; i < poses_.size(); ++i) {
                const sqmap::Pose &to = poses_[i], &from = poses_[(i + 1) % poses_.size()];
                swept.query.layer = layer;
                const query::SweptQuery path{{.model = &ring_.view}, &probe_, from, to, previous_, now};
                swept_ += query::query_swept(path, swept, workspace_, contacts_).probe.contacts;
                // The second half of the ring goes where the pose says.
                const Affine maps[] = {{}, {to.rotation, to.translation}};
                (void)skin_->pose(maps);
                const query::SkinnedQuery points{&ring_.view, &*skin_, now, {}};
                skinned_ += query::query_skin(points, {.layer = layer}, skin_workspace_, skin_contacts_).contacts;
            }
    }
    [[nodiscard]] std::size_t swept() const { return swept_; }
    [[nodiscard]] std::size_t skinned() const { return skinned_; }

private:
    test::Solid hand_{test::small_hand()}, ring_{test::small_torus()};
    mesh::Influences influences_;
    query::SkinLattice lattice_;
    std::optional<query::PosedSkin> skin_;
    query::Probe probe_{hand_.mesh.vertices};
    query::SweptWorkspace workspace_{hand_.mesh.vertices.size()};
    query::SkinWorkspace skin_workspace_{lattice_, hand_.mesh.vertices};
    std::vector<query::Contact> contacts_{4096};
    std::vector<query::SkinContact> skin_contacts_{4096};
    std::vector<sqmap::Pose> poses_;
    std::vector<Vec3d> previous_;
    std::size_t swept_ = 0, skinned_ = 0;
};

TEST(RealTime, SweptAndSkinnedQueriesDoNotAllocate)
{
    Deforming deforming;
    EXPECT_EQ(allocations_of([&] { deforming.run(); }), 0);
    EXPECT_GT(deforming.swept(), 1000u);
    EXPECT_GT(deforming.skinned(), 1000u);
}

/// Steps of a hand, a tip and a ball in every mode, with everything on, near and far, late and not finite.
class Steps {
public:
    Steps()
    {
        (void)haptic::gaussian_texture({.amplitude = 0.01, .wavelength = 0.1}, relief_);
        texture_ = haptic::gaussian_texture({.amplitude = 0.01, .wavelength = 0.1}, relief_);
        for (haptic::TouchedBody& s : solids_) s.material.texture = &texture_;
        solids_[0].model = &ring_.view;
        solids_[1].model = &ball_.view;
        solids_[0].material.friction = Friction::Paper;
        for (const haptic::Mode mode : {haptic::Mode::Direct, haptic::Mode::Proxy, haptic::Mode::Coupled})
            for (const haptic::Averaging averaging :
                 {haptic::Averaging::Patch, haptic::Averaging::Stencil, haptic::Averaging::Ball})
                for (const haptic::Shading shading : {haptic::Shading::Levelled, haptic::Shading::Consistent}) {
                    haptic::ZoneOptions o{.mode = mode, .averaging = averaging, .shading = shading, .damping = 1, .brake = 1};
                    o.layer = shading == haptic::Shading::Levelled ? query::Layer::Exact : query::Layer::Three;
                    o.smoothing.radius = 0.05;
                    zones_.push_back(
                        {.probe = averaging == haptic::Averaging::Patch ? &hand_.probe : &tip_, .radius = 3, .options = o});
                }
        state_.emplace(zones_);
        wrenches_.resize(zones_.size());
        test::Random random(4);
        for (int i = 0; i < 4; ++i) {
            paths_.emplace_back(zones_.size(), test::random_pose(random, 0.8));
            paths_.push_back(paths_.back());
            for (sqmap::Pose& p : paths_.back()) p.translation += Vec3d{0.01, 0, 0.01};
        }
        paths_.emplace_back(zones_.size(), test::shifted({1e9, 0, 0}));
        paths_.emplace_back(zones_.size(), test::shifted({0, std::numeric_limits<double>::quiet_NaN(), 0}));
        paths_.emplace_back(zones_.size(), test::shifted({0, -std::numeric_limits<double>::infinity(), 0}));
        paths_.push_back(paths_.front());
    }
    void run()
    {
        for (const std::vector<sqmap::Pose>& poses : paths_)
            for (const bool degraded : {false, true}) {
                solids_[1].pose = paths_.front().front();
                const haptic::StepResult r =
                    haptic::step(*state_, {.touched = solids_, .poses = poses, .degraded = degraded}, wrenches_, on_touched_);
                contacts_ += r.contacts;
                for (const haptic::Wrench& w : wrenches_) finite_ = finite_ && std::isfinite(norm(w.force) + norm(w.torque));
            }
        state_->reset();
    }
    [[nodiscard]] std::size_t contacts() const { return contacts_; }
    [[nodiscard]] bool finite() const { return finite_; }

private:
    test::Solid hand_{test::small_hand()}, ring_{test::small_torus()}, ball_{mesh::sphere(0.3, 2)};
    query::Probe tip_{haptic::stencil_points({.radius = 0.05})};
    std::vector<float> relief_;
    haptic::Texture texture_;
    haptic::TouchedBody solids_[2];
    std::vector<haptic::Zone> zones_;
    std::optional<haptic::State> state_;
    std::vector<haptic::Wrench> wrenches_;
    haptic::Wrench on_touched_[2];
    std::vector<std::vector<sqmap::Pose>> paths_;
    std::size_t contacts_ = 0;
    bool finite_ = true;
};

TEST(RealTime, HapticStepsDoNotAllocate)
{
    Steps steps;
    EXPECT_EQ(allocations_of([&] { steps.run(); }), 0);
    EXPECT_GT(steps.contacts(), 1000u);
    EXPECT_TRUE(steps.finite());
}

#if defined(__linux__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
/// The signal that ends a process that may do nothing but leave, read and write while it works; 0 for none.
template <class Work>
int signal_of(Work&& work)
{
    const pid_t child = fork();
    if (child == 0) {
        prctl(PR_SET_SECCOMP, SECCOMP_MODE_STRICT);
        work();
        syscall(SYS_exit, 0);
    }
    int status = -1;
    waitpid(child, &status, 0);
    return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

TEST(RealTime, FramesPairsAndScenesMakeNoSystemCall)
{
    Frames frames;
    ASSERT_EQ(signal_of([] { (void)getppid(); }), SIGKILL) << "the guard sees system calls";
    EXPECT_EQ(signal_of([&] { frames.run(); }), 0);
}

TEST(RealTime, SweptAndSkinnedQueriesMakeNoSystemCall)
{
    Deforming deforming;
    EXPECT_EQ(signal_of([&] { deforming.run(); }), 0);
}

TEST(RealTime, HapticStepsMakeNoSystemCall)
{
    Steps steps;
    EXPECT_EQ(signal_of([&] { steps.run(); }), 0);
}
#endif

TEST(RealTime, QueriesRaiseNoFloatingPointException)
{
    const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
    for (const std::vector<std::byte>& bytes : models()) {
        paper::AnyModel parsed;
        ASSERT_EQ(parsed.parse(bytes), model::ParseStatus::Ok);
        const model::ModelView view = model::normalized(parsed.view());
        std::vector<Vec3d> points = points_about(view);
        points.push_back({nan, 0, 0});
        points.push_back({0, inf, 0});
        points.push_back({-inf, nan, inf});
        for (const query::Layer layer : k_layers) {
            int shown = 0;
            for (const Vec3d& p : points) {
                std::feclearexcept(FE_ALL_EXCEPT);
                (void)query::query_point(view, p, {.layer = layer});
                const int raised = std::fetestexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW);
                if (raised != 0 && ++shown <= 3)
                    ADD_FAILURE() << "layer " << static_cast<int>(layer) << " projection " << view.header.projection << " at "
                                  << p.x << ' ' << p.y << ' ' << p.z << ((raised & FE_INVALID) != 0 ? " invalid" : "")
                                  << ((raised & FE_DIVBYZERO) != 0 ? " division by zero" : "")
                                  << ((raised & FE_OVERFLOW) != 0 ? " overflow" : "");
            }
            EXPECT_EQ(shown, 0) << "points of " << points.size();
        }
    }
}

/// Leaves numbers on the stack whose squares overflow, in float and in double: a query that reads what it has not written raises
/// an exception.
[[gnu::noinline]] void fill_stack()
{
    std::array<unsigned char, 2'000'000> bytes;
    volatile unsigned char* const to = bytes.data();
    for (std::size_t i = 0; i < bytes.size(); ++i) to[i] = 0x7f;
}

/// One by one, a few and many; of a probe; clearance.
void query_distances(const query::Body& touched, std::span<const Vec3d> points, const query::Body& collider,
                     std::span<query::SignedDistance> answers)
{
    for (std::size_t i = 0; i < points.size(); i += 7) answers[i] = query::distance(touched, points[i]);
    for (const std::size_t count : {std::size_t{3}, std::size_t{100}, points.size()}) {
        fill_stack();
        query::distances(touched, points.first(count), answers);
    }
    fill_stack();
    query::exact_distances(touched, points.first(std::min<std::size_t>(points.size(), 500)), answers);
    query::distances(touched, collider, answers);
    (void)query::is_nearer(touched, collider, 0.1);
}

TEST(RealTime, DistancesDoNotAllocateAndRaiseNoFloatingPointException)
{
    std::vector<std::vector<std::byte>> tried = models();
    tried.push_back(io::serialize(bake::bake(test::small_hand(), true, {.exact = false}).model));
    for (const std::vector<std::byte>& bytes : tried) {
        paper::AnyModel model;
        ASSERT_EQ(model.parse(bytes), model::ParseStatus::Ok);
        const model::ModelView& view = model.view();
        std::vector<Vec3d> points;
        for (const Vec3d& p : points_about(view)) points.push_back(model::to_mesh_units(view.header, cast<float>(p)));
        const query::Probe probe(std::span<const Vec3d>(points).first(2000));
        std::vector<query::SignedDistance> answers(points.size());
        const query::Body touched{&view, nullptr, {{}, {0.1, 0.2, 0.3}}}, collider{nullptr, &probe, {{}, {0.3, 0.1, 0.2}}};
        EXPECT_EQ(allocations_of([&] { query_distances(touched, points, collider, answers); }), 0);
        std::feclearexcept(FE_ALL_EXCEPT);
        query_distances(touched, points, collider, answers);
        EXPECT_EQ(std::fetestexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW), 0);
    }
}

}  // namespace
}  // namespace sqmap
