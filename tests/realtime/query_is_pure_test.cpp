// The real-time contract (docs/realtime.md): after a model is parsed no query allocates, and none raises a
// floating-point exception that would stop a program that traps them.
#include "sqmap/io/model_file.h"
#include "sqmap/query/query.h"
#include "support/baked_shapes.h"

#include <gtest/gtest.h>

#include <cfenv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <new>

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
std::vector<Vec3f> points_about(const model::ModelView& view)
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
    return points;
}

std::vector<model::ModelData> models()
{
    std::vector<model::ModelData> out;
    for (const test::Shape& shape : test::small_shapes()) out.push_back(test::baked(shape.mesh).result.model);
    bake::BakeOptions normal;
    normal.projection = model::Projection::Normal;
    out.push_back(test::baked(test::small_hand(), normal).result.model);
    return out;
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
    for (const model::ModelData& data : models()) {
        const std::vector<std::byte> bytes = io::serialize(data);
        model::ModelView view;
        EXPECT_EQ(allocations_of([&] { (void)model::parse(bytes, view); }), 0);
        ASSERT_FALSE(view.parts.empty());
        const std::vector<Vec3f> points = points_about(view);
        std::vector<query::Contact> contacts(points.size());
        for (const query::Layer layer : k_layers) {
            EXPECT_EQ(allocations_of([&] { query::query_points(view, points, layer, contacts); }), 0);
            EXPECT_EQ(allocations_of([&] {
                          for (const Vec3f& p : points) contacts[0] = query::query_point(view, p, layer);
                      }),
                      0);
        }
    }
}

TEST(RealTime, QueriesRaiseNoFloatingPointException)
{
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    for (const model::ModelData& data : models()) {
        const model::ModelView view = data.view();
        std::vector<Vec3f> points = points_about(view);
        points.push_back({nan, 0, 0});
        points.push_back({0, inf, 0});
        points.push_back({-inf, nan, inf});
        for (const query::Layer layer : k_layers) {
            int shown = 0;
            for (const Vec3f& p : points) {
                std::feclearexcept(FE_ALL_EXCEPT);
                (void)query::query_point(view, p, layer);
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

}  // namespace
}  // namespace sqmap
