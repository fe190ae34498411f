// A point and a probe of that point answer alike, to the bit, in every model with a locator.
#include "sqmap/query/point.h"
#include "sqmap/query/probe.h"
#include "support/bodies.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <vector>

namespace sqmap::query {
namespace {

constexpr std::size_t k_positions = 40000;
/// Positions are multiples of this, so that a probe's frame takes them to model space without rounding.
constexpr double k_grid = 0x1p-18;

Vec3d on_grid(Vec3d p)
{
    return {std::round(p.x / k_grid) * k_grid, std::round(p.y / k_grid) * k_grid, std::round(p.z / k_grid) * k_grid};
}

/// Anywhere about the object, and near its surface.
std::vector<Vec3d> positions_about(const test::Parsed& m)
{
    test::Random random(21);
    const double r = 1.1 * static_cast<double>(m.view().header.sphere[3]);
    const Vec3d centre = cast<double>(model::vec3(m.view().header.sphere));
    std::vector<Vec3d> points;
    for (std::size_t i = 0; i < k_positions; ++i) {
        const mesh::Triangle& t = m.mesh().triangles[random.below(m.mesh().triangles.size())];
        points.push_back(on_grid(i % 2 == 0 ? centre + random.in_box({-r, -r, -r}, {r, r, r})
                                            : m.mesh().vertices[t[0]] + 0.03 * r * random.between(0, 1) * random.direction()));
    }
    return points;
}

template <class T>
bool same_bits(const T& a, const T& b)
{
    return std::memcmp(&a, &b, sizeof(T)) == 0;
}

/// touched: the model, queried in the frame of the positions.
void expect_alike(const Body& touched, const std::vector<Vec3d>& points, const std::string& name)
{
    const Probe probe(points);
    std::vector<Contact> contacts(points.size());
    std::vector<PointResult> batch(points.size());
    for (const Layer layer : {Layer::Two, Layer::Three, Layer::Exact, Layer::Gate}) {
        const ProbeResult found = query_probe(touched, {.probe = &probe}, {.layer = layer}, contacts);
        ASSERT_EQ(found.status, k_ok);
        std::vector<const Contact*> contact_of(points.size(), nullptr);
        for (std::size_t i = 0; i < found.contacts; ++i) contact_of[contacts[i].index] = &contacts[i];
        const std::size_t claimed = query_points(touched, points, {.layer = layer}, batch);
        ASSERT_EQ(claimed, found.contacts) << name;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const PointResult c = query_point(touched, points[i], {.layer = layer});
            const Contact* p = contact_of[i];
            const auto where = [&] {
                return testing::Message() << name << ", layer " << static_cast<int>(layer) << ", at " << points[i].x << ' '
                                          << points[i].y << ' ' << points[i].z;
            };
            ASSERT_EQ(c.contact, p != nullptr) << where();
            ASSERT_TRUE(same_bits(c.witness, batch[i].witness) && same_bits(c.normal, batch[i].normal) &&
                        same_bits(c.depth, batch[i].depth) && c.part == batch[i].part && c.certain == batch[i].certain &&
                        c.status == batch[i].status && c.contact == batch[i].contact)
                << where();
            if (p == nullptr) {
                ASSERT_EQ(c.witness, points[i]) << where();
                ASSERT_EQ(c.part, -1) << where();
                continue;
            }
            ASSERT_TRUE(same_bits(c.witness, found.position(*p)) && same_bits(c.normal, cast<double>(p->normal)) &&
                        same_bits(c.depth, static_cast<double>(p->depth)))
                << where();
            ASSERT_EQ(c.part, p->part) << where();
            ASSERT_EQ(c.certain, p->certain) << where();
            ASSERT_EQ(c.status, p->status) << where();
        }
    }
}

void expect_alike(const test::Parsed& m, const std::string& name)
{
    expect_alike({.model = &m.in_model_space()}, positions_about(m), name);
}

TEST(PointAndProbe, AnswerAlikeToTheBitOnEveryShape)
{
    std::vector<test::Shape> shapes = test::small_shapes();
    shapes.push_back({"needles", test::needles()});
    shapes.push_back({"crossing bars", test::crossing_bars()});
    shapes.push_back({"nested balls", test::nested_balls()});
    for (const test::Shape& shape : shapes) expect_alike(test::Parsed(shape.mesh), shape.name);
}

TEST(PointAndProbe, AnswerAlikeToTheBitInAWorldOfOtherUnits)
{
    // Turned by a quarter and scaled by a power of two, which rounds nothing.
    const test::Parsed m(test::small_torus());
    model::ModelView view = m.in_model_space();
    view.header.unit = 4;
    view.header.origin[0] = -2;
    std::vector<Vec3d> positions = positions_about(m);
    positions.resize(20000);
    for (const double far : {0.0, 1e6}) {
        const Pose quarter{{{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}}, {far, 0, 0}};
        std::vector<Vec3d> points;
        for (const Vec3d& p : positions) points.push_back(apply(quarter, 4. * p + Vec3d{-2, 0, 0}));
        expect_alike({.model = &view, .pose = quarter}, points, far > 0 ? "far away" : "turned");
    }
}

TEST(PointAndProbe, AnswerAlikeToTheBitOnRealMeshes)
{
    for (const char* file : {"horse_5946.obj", "bull_7154.obj", "fandisk_8000.obj"}) {
        const auto mesh = test::shared_mesh(file);
        if (!mesh) GTEST_SKIP() << "no " << file << " in " << test::shared_folder();
        expect_alike(test::Parsed(*mesh), file);
    }
}

TEST(PointAndProbe, LayerOneOfAProbeIsThatOfItsPointsWhereTheLocatorKnowsOfSolid)
{
    const test::Parsed m(test::small_torus());
    const std::vector<Vec3d> points = positions_about(m);
    const Probe probe(points);
    std::vector<Contact> contacts(points.size());
    const ProbeResult found = query_probe({.model = &m.in_model_space()}, {.probe = &probe}, {.layer = Layer::One}, contacts);
    ASSERT_GT(found.contacts, 1000u);
    for (std::size_t i = 0; i < found.contacts; ++i) {
        const PointResult c = query_point(m.in_model_space(), points[contacts[i].index], {.layer = Layer::One});
        ASSERT_TRUE(c.contact);
        ASSERT_TRUE(same_bits(c.depth, static_cast<double>(contacts[i].depth)) &&
                    same_bits(c.normal, cast<double>(contacts[i].normal)));
    }
}

}  // namespace
}  // namespace sqmap::query
