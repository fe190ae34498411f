// Tests the force that the page's touch sends to a hand: force that holds as long and as hard as it presses, on the side that it
// came from, without ringing. In steps of a tick, without a clock.
#include "rehearsal.h"
#include "sqmap/bake_mesh.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/mesh/solid.h"
#include "support/bodies.h"
#include "support/parsed.h"
#include "support/shared_folder.h"
#include "viewer/server/scene/load.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <map>

namespace sqmap::viewer {
namespace {

using test::Rehearsal;

constexpr double k_size = 0.2;     // m, R_max of an object, as in the page
constexpr double k_lift = 0.018;   // m above the surface, where the page takes the tool up
constexpr double k_engaged = 0.7;  // s, more than the filter's ramp

ObjectPtr object_of(const mesh::Mesh& mesh, const std::string& name)
{
    return object_from_model(sqmap::test::baked_bytes(mesh, true), name, k_size);
}

/// Meshes of the demo scene, where it was fetched, else meshes like them; and the project's own hand. ./dev test all presses on
/// every one, ./dev test on two.
const std::vector<ObjectPtr>& demo_objects()
{
    static std::vector<ObjectPtr> out;
    if (!out.empty()) return out;
    for (const auto& [name, like] : {std::pair{"elephant", "elephant_10272.obj"},
                                     {"bull", "bull_7154.obj"},
                                     {"triceratops", "cat_8108.obj"},
                                     {"camel", "camel_4512.obj"},
                                     {"cow", "horse_5946.obj"}}) {
        if (std::getenv("SQMAP_EVERY_OBJECT") == nullptr && !out.empty()) break;
        std::filesystem::path file = std::filesystem::path(SQMAP_TEST_MESHES_DIR) / (std::string(name) + ".off");
        if (!std::filesystem::exists(file)) file = sqmap::test::real_mesh_file(like);
        if (file.empty()) continue;
        out.push_back(object_of(admit_mesh(file).mesh, name));
    }
    out.push_back(object_of(mesh::polygonized(mesh::hand_capsules(), 0.03), "hand"));
    return out;
}

/// 20 cm long and wide, 1 mm thick.
ObjectPtr plate()
{
    mesh::Mesh mesh = sqmap::test::cube();
    const double side = k_size / std::sqrt(2.) / 2;
    for (Vec3d& v : mesh.vertices) v = {side * v.x, 0.0005 * v.y, side * v.z};
    return object_of(mesh, "plate");
}

mesh::Mesh world_mesh(const Object& object)
{
    mesh::Mesh out;
    out.triangles = object.mesh.triangles;
    for (const Vec3d& v : object.mesh.vertices) out.vertices.push_back(cast<double>(object.world(v)));
    return out;
}

/// A spot where the page would press: world.
struct Spot {
    Vec3d point{}, normal{};
    double thickness = 0;  ///< m, along the normal
};

/// Spots of so thick parts, far from one another, to which a ball gets from where the page takes it up.
std::vector<Spot> spots(const Object& object, double least, double largest, std::size_t count)
{
    const mesh::Mesh mesh = world_mesh(object);
    const mesh::Solid solid(mesh);
    const double radius = Settings{}.tool_radius;
    std::vector<Spot> all;
    const std::size_t step = std::max<std::size_t>(1, mesh.triangles.size() / 1500);
    for (std::size_t t = 0; t < mesh.triangles.size(); t += step) {
        const auto& [i, j, k] = mesh.triangles[t];
        const Vec3d a = mesh.vertices[i], b = mesh.vertices[j], c = mesh.vertices[k], across = cross(b - a, c - a);
        Spot spot{(a + b + c) / 3., normalized(across), 0};
        const auto clear = [&](double height) {
            const Vec3d at = spot.point + (radius + height) * spot.normal;
            return !solid.inside(at) && solid.closest_boundary(at).distance > radius + std::min(0.9 * height, 0.004) - 2e-4;
        };
        constexpr double k_march = 2.5e-4;
        for (spot.thickness = k_march; spot.thickness <= largest + k_march; spot.thickness += k_march)
            if (!solid.inside(spot.point - spot.thickness * spot.normal)) break;
        if (spot.thickness < least || (spot.thickness > largest && largest < 1)) continue;
        if (clear(0) && clear(0.002) && clear(0.006) && clear(k_lift)) all.push_back(spot);
    }
    // The one farthest from all that were taken, again and again.
    std::vector<Spot> out;
    std::vector<double> far(all.size(), std::numeric_limits<double>::infinity());
    while (out.size() < std::min(count, all.size())) {
        const std::size_t best = static_cast<std::size_t>(std::max_element(far.begin(), far.end()) - far.begin());
        out.push_back(all[best]);
        for (std::size_t i = 0; i < all.size(); ++i) far[i] = std::min(far[i], norm(all[i].point - out.back().point));
    }
    return out;
}

/// The spot of a part at least 2 cm thick; searched once for each object, as every test presses there.
const Spot& thick_spot(const Object& object)
{
    static std::map<std::string, Spot> found;
    const auto at = found.find(object.name);
    if (at != found.end()) return at->second;
    return found.emplace(object.name, spots(object, 0.02, 1, 1).at(0)).first->second;
}

/// A press as the page does it: taken up off the surface, then down.
class Press {
public:
    Press(const ObjectPtr& object, const Settings& settings, const Spot& spot)
        : spot_(spot),
          radius_(settings.smoothing > 0 ? settings.smoothing : settings.tool_radius),
          run_({object}, settings, over(k_lift))
    {
        run_.run(k_engaged);
    }
    [[nodiscard]] Vec3d over(double height) const { return spot_.point + (radius_ + height) * spot_.normal; }
    Rehearsal& to(double depth)
    {
        run_.aim(over(-depth));
        return run_;
    }
    /// Pressed in so deep over another point.
    Rehearsal& over(Vec3d point, Vec3d normal, double depth)
    {
        run_.aim(point + (radius_ - depth) * normal);
        return run_;
    }
    Rehearsal& up()
    {
        run_.aim(over(k_lift));
        return run_;
    }

private:
    Spot spot_;
    double radius_;
    Rehearsal run_;
};

double mean_force(Rehearsal& run, double seconds)
{
    double sum = 0;
    int n = 0;
    run.run(seconds, [&](const Rehearsal::Tick& t) { sum += norm(t.sent.force), ++n; });
    return sum / n;
}

TEST(Feel, ForceIsTheSpringUpToItsLimit)
{
    std::printf("%-12s %9s | N at a press of 2 4 6 8 10 12 mm\n", "object", "N/m");
    for (const ObjectPtr& object : demo_objects()) {
        double softer[6] = {};
        for (const double stiffness : {100., 300., 500., 800., 1100., 1500.}) {
            Press press(object, {.stiffness = stiffness}, thick_spot(*object));
            std::printf("%-12s %9.0f |", object->name.c_str(), stiffness);
            double before = 0;
            for (int i = 0; i < 6; ++i) {
                Rehearsal& run = press.to(0.002 * (i + 1));
                run.run(0.4);
                const double force = mean_force(run, 0.2), wanted = std::min(stiffness * run.last().depth, run.limit());
                std::printf(" %5.2f", force);
                EXPECT_NEAR(force, wanted, 0.05 * wanted) << object->name << ' ' << stiffness << ' ' << i;
                EXPECT_GE(force, 0.999 * before) << object->name << ' ' << stiffness << ": harder feels no softer";
                EXPECT_GE(force, 0.999 * softer[i]) << object->name << ' ' << stiffness << ": stiffer feels no softer";
                before = softer[i] = force;
            }
            std::printf("\n");
        }
    }
}

/// How far the sent torque over force is from the computed one, a share; and the ticks in which a limit shortened the wrench.
/// Ticks in which the wrench still grows (slew) are a mean of two wrenches, and those of the passivity step have a damper's
/// force.
struct Ratio {
    double worst = 0;
    int force = 0, last = 0;  ///< ticks
};
void add_ratio(Ratio& ratio, const Rehearsal::Tick& t)
{
    constexpr std::uint32_t k_limits = haptic::k_acted_clamp | haptic::k_acted_last;
    constexpr std::uint32_t k_others = haptic::k_acted_slew | haptic::k_acted_passivity | haptic::k_acted_speed;
    const double force = norm(t.computed.force), sent = norm(t.sent.force);
    if ((t.acted & k_limits) == 0 || (t.acted & k_others) != 0 || sent < 0.02 || norm(t.computed.torque) < 1e-5) return;
    ratio.force += (t.acted & haptic::k_acted_clamp) != 0;
    ratio.last += (t.acted & haptic::k_acted_last) != 0;
    const double was = norm(t.computed.torque) / force, is = norm(t.sent.torque) / sent;
    ratio.worst = std::max(ratio.worst, std::abs(is / was - 1));
}

TEST(Feel, TorqueOverForceIsThatOfTheUnlimitedWrench)
{
    std::size_t objects = 0;
    for (const ObjectPtr& object : demo_objects()) {
        const Spot& spot = thick_spot(*object);
        ++objects;
        // A ball at 2 N and at a user's 0.6 N; a hand, whose levers bring the limit in torque.
        for (const auto& [name, settings] : {std::pair{"ball, 2 N", Settings{.stiffness = 1500}},
                                             std::pair{"ball, 0.6 N", Settings{.stiffness = 1500, .force_limit = 0.6}},
                                             std::pair{"hand", Settings{.stiffness = 1500, .tool = ToolKind::Hand}}}) {
            const bool ball = settings.tool == ToolKind::Ball;
            const Vec3d from = spot.point + (ball ? k_lift : 0.2) * spot.normal;
            Rehearsal run({object}, settings, from);
            run.run(k_engaged);
            Ratio ratio;
            for (const double depth : {0.008, 0.012, 0.016, 0.02}) {
                run.aim(spot.point + ((ball ? settings.tool_radius : 0) - depth) * spot.normal);
                run.run(ball ? 0.4 : 0.8, [&](const Rehearsal::Tick& t) { add_ratio(ratio, t); });
            }
            std::printf("%-12s %-12s %.2g %% apart; ticks with a limit: %d clamp, %d last\n", object->name.c_str(), name,
                        100 * ratio.worst, ratio.force, ratio.last);
            EXPECT_GT(ratio.force + ratio.last, 100) << object->name << ' ' << name;
            EXPECT_LE(ratio.worst, 0.02) << object->name << ' ' << name;
        }
    }
    EXPECT_GE(objects, 2u);
}

TEST(Feel, AStiffnessSetWhileHeldIsTheOneSetBefore)
{
    constexpr double k_sequence[] = {50, 100, 250, 500, 1000, 1500, 500, 1500, 50, 500};
    for (const ObjectPtr& object : demo_objects())
        for (const double depth : {0.0045, 0.012}) {  // below the limit in force, and at it
            const Spot& spot = thick_spot(*object);
            std::map<double, double> afresh;  // N
            for (const double stiffness : k_sequence) {
                if (afresh.count(stiffness) > 0) continue;
                Press press(object, {.stiffness = stiffness}, spot);
                press.to(depth).run(1);
                afresh[stiffness] = mean_force(press.to(depth), 0.2);
            }
            Press press(object, {.stiffness = k_sequence[0]}, spot);
            press.to(depth).run(2);
            for (const double stiffness : k_sequence) {
                Rehearsal& run = press.to(depth);
                run.adjust({.stiffness = stiffness});
                run.run(1.5);
                double sum = 0, squares = 0;
                int n = 0;
                run.run(0.5, [&](const Rehearsal::Tick& t) {
                    const double force = norm(t.sent.force);
                    sum += force, squares += force * force, ++n;
                });
                const double mean = sum / n, wanted = afresh[stiffness];
                EXPECT_NEAR(mean, wanted, 0.03 * wanted) << object->name << ' ' << depth << " m, " << stiffness << " N/m";
                EXPECT_LE(std::sqrt(std::max(0., squares / n - mean * mean)), 0.01 * mean)
                    << object->name << ' ' << depth << " m, " << stiffness << " N/m chatters";
                EXPECT_EQ(run.last().faults, 0u);
            }
        }
}

TEST(Feel, TenTapsAreAlike)
{
    for (const ObjectPtr& object : demo_objects())
        for (const double stiffness : {500., 1500.}) {
            Press press(object, {.stiffness = stiffness}, thick_spot(*object));
            double least = 1e9, max = 0;
            for (int tap = 0; tap < 10; ++tap) {
                double peak = 0;
                press.to(0.006).run(0.4, [&](const Rehearsal::Tick& t) { peak = std::max(peak, norm(t.sent.force)); });
                press.up().run(0.4);
                least = std::min(least, peak), max = std::max(max, peak);
            }
            EXPECT_LT(max, 1.02 * least) << object->name << ' ' << stiffness;
            EXPECT_GT(least, 0.5);
        }
}

/// The result of a press that was held: the least of all ticks.
struct Hold {
    double height = 1;     ///< m, of the tool over the spot, along its normal
    double turn = 1;       ///< cosine between the force and the normal
    double clearance = 1;  ///< m between the tool's centre and the surface, negative inside; where a solid is given
    bool touching = false;
};

Hold hold(const ObjectPtr& object, const Settings& settings, const Spot& spot, const mesh::Solid* solid = nullptr)
{
    constexpr int k_look = 5;  // ticks, in which a tool moves by less than a millimetre
    Press press(object, settings, spot);
    Hold out;
    int tick = 0;
    press.to(0.012).run(1.5, [&](const Rehearsal::Tick& t) {
        out.height = std::min(out.height, dot(t.tool - spot.point, spot.normal));
        if (norm(t.sent.force) > 0.1) out.turn = std::min(out.turn, dot(t.sent.force, spot.normal) / norm(t.sent.force));
        out.touching = t.touching;
        if (solid == nullptr || tick++ % k_look != 0) return;
        const double away = solid->closest_boundary(t.tool).distance;
        out.clearance = std::min(out.clearance, solid->inside(t.tool) ? -away : away);
    });
    return out;
}

/// The tool and the force stay on the side that they came from.
bool held(const Hold& h, const Spot& spot) { return h.touching && h.turn > 0 && h.height > -0.4 * spot.thickness; }

TEST(Feel, ThinPartsHold)
{
    constexpr double k_rests = 0.2, k_margin = 0.1;  // of the ball's radius
    int presses = 0, off = 0;
    std::printf("%-12s %6s %14s\n", "object", "spots", "thickness mm");
    for (const ObjectPtr& object : demo_objects()) {
        const mesh::Mesh mesh = world_mesh(*object);
        const mesh::Solid solid(mesh);
        const std::vector<Spot> all = spots(*object, 0.0004, 0.012, 16);
        double thinnest = 1, thickest = 0;
        for (std::size_t i = 0; i < all.size(); ++i) {
            const Spot& spot = all[i];
            thinnest = std::min(thinnest, spot.thickness), thickest = std::max(thickest, spot.thickness);
            // Both stiffnesses at each spot, with friction at one of them.
            for (const bool stiff : {false, true}) {
                const double stiffness = stiff ? 1500 : 100, friction = stiff == (i % 2 == 0) ? 0.3 : 0;
                const Hold h = hold(object, {.stiffness = stiffness, .friction = friction}, spot, &solid);
                const auto where = [&] {
                    return testing::Message() << object->name << ' ' << 1e3 * spot.thickness << " mm thick, " << stiffness
                                              << " N/m, friction " << friction;
                };
                EXPECT_GT(h.clearance, (1 - k_rests - k_margin) * Settings{}.tool_radius) << where() << ": has gone through";
                ++presses;
                if (held(h, spot)) continue;
                // A ball without friction slips off the tip of a horn, about it.
                EXPECT_EQ(friction, 0) << where() << ": slipped off";
                ++off;
            }
        }
        if (all.empty()) continue;
        std::printf("%-12s %6zu %6.1f to %4.1f\n", object->name.c_str(), all.size(), 1e3 * thinnest, 1e3 * thickest);
    }
    std::printf("%d of %d presses slipped off a tip\n", off, presses);
    EXPECT_LE(off, presses / 50);
}

TEST(Feel, APlateOfAMillimetreHolds)
{
    const ObjectPtr object = plate();
    for (const double radius : {0.002, 0.006, 0.02})
        for (const double smoothing : {0., radius / 4})
            for (const double stiffness : {100., 500., 1500.})
                for (const Vec3d at : {Vec3d{0, 0.0005, 0}, Vec3d{0.031, 0.0005, -0.023}}) {
                    const Settings settings{.stiffness = stiffness, .smoothing = smoothing, .tool_radius = radius};
                    const Spot spot{object->position + at, {0, 1, 0}, 0.001};
                    const Hold h = hold(object, settings, spot);
                    EXPECT_TRUE(held(h, spot))
                        << radius << ' ' << smoothing << ' ' << stiffness << ": height " << h.height << ", turn " << h.turn;
                }
}

TEST(Feel, ATouchNeitherOvershootsNorRings)
{
    double worst = 0, longest = 0, tick = 0;
    for (const ObjectPtr& object : demo_objects())
        for (const double stiffness : {100., 500., 1500.})
            for (const double depth : {0.002, 0.006}) {
                Press press(object, {.stiffness = stiffness}, thick_spot(*object));
                std::vector<Rehearsal::Tick> ticks;
                press.to(depth).run(1, [&](const Rehearsal::Tick& t) { ticks.push_back(t); });
                const double last = ticks.back().depth;
                std::size_t reached = 0, left = 0;
                double peak = 0, before = 0;
                for (std::size_t i = 0; i < ticks.size(); ++i) {
                    peak = std::max(peak, ticks[i].depth);
                    if (reached == 0 && ticks[i].depth >= 0.95 * last) reached = i;
                    if (std::abs(ticks[i].depth - last) > 0.05 * last) left = i + 1;
                    const double torque = norm(ticks[i].sent.torque);
                    if (i > reached + 100 && reached > 0) tick = std::max(tick, std::abs(torque - before));
                    before = torque;
                }
                const double ring = left > reached ? 1e-3 * static_cast<double>(left - reached) : 0;
                EXPECT_LE(peak, 1.1 * last) << object->name << ' ' << stiffness << ' ' << depth;
                EXPECT_LE(ring, 0.04) << object->name << ' ' << stiffness << ' ' << depth;
                worst = std::max(worst, peak / last - 1), longest = std::max(longest, ring);
            }
    EXPECT_LT(tick, 1e-5) << "N m from tick to tick";
    std::printf("overshoot at most %.1f %%, ring %.0f ms, torque at rest changes by at most %.2g mN m in a tick\n", 100 * worst,
                1e3 * longest, 1e3 * tick);
}

TEST(Feel, ADragHasNoSpikes)
{
    constexpr double k_frame = 0.016, k_swing = 0.012;  // s between two words of the page; m to each side
    constexpr int k_busy = 37;                          // every so many ticks the servo has no time to query
    double worst = 0;
    for (const ObjectPtr& object : demo_objects()) {
        const mesh::Mesh mesh = world_mesh(*object);
        const mesh::Solid solid(mesh);
        const Spot& spot = thick_spot(*object);
        const Vec3d along = normalized(cross(spot.normal, {0.3, 1, 0.2}));
        for (const double friction : {0., 0.3}) {
            Press press(object, {.friction = friction}, spot);
            press.to(0.006).run(0.5);
            std::vector<Vec3d> torques;
            for (int i = 0; i < 100; ++i) {
                const mesh::ClosestPoint near = solid.closest_boundary(spot.point + k_swing * std::sin(i / 8.) * along);
                const auto& [a, b, c] = mesh.triangles[near.triangle];
                const Vec3d across = cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a]);
                Rehearsal& run = press.over(near.point, normalized(across), 0.006);
                for (double t = 0; t < k_frame; t += Rehearsal::k_tick)
                    torques.push_back(run.tick(torques.size() % k_busy == k_busy / 2).sent.torque);
            }
            for (std::size_t i = 1; i + 1 < torques.size(); ++i)
                worst = std::max(worst, norm(torques[i] - 0.5 * (torques[i - 1] + torques[i + 1])));
        }
    }
    EXPECT_LT(worst, 2e-4) << "N m of one tick beside its neighbours";
    std::printf("torque of a tick beside its neighbours at most %.2g mN m away\n", 1e3 * worst);
}

}  // namespace
}  // namespace sqmap::viewer
