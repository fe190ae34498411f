// Recordings of the page as files: what comes back computes the same bits; what is none, or of other objects, is refused.
#include "viewer/server/touch/recording_file.h"

#include "sqmap/device/trace.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/model/parse.h"
#include "viewer/server/scene/load.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

namespace sqmap::viewer {
namespace {

ObjectPtr ball(Vec3d position)
{
    AdmittedMesh j;
    j.admission = mesh::Admission::Accept;
    j.solid = true;
    j.mesh = mesh::sphere(1, 3);
    const auto object = object_from_mesh(j, "ball.obj", 0.1, {});
    object->position = position;
    return object;
}

/// Drawn over the top of the ball; from the middle on with another stiffness.
std::shared_ptr<Take> drawn(const ObjectPtr& object, double begin)
{
    const auto take = std::make_shared<Take>();
    take->objects = {object};
    take->settings = {
        {.friction = 0.4, .texture = 0.0002}, {.stiffness = 100}, {.stiffness = 250, .friction = 0.4, .texture = 0.0002}};
    Forces forces(take->objects, take->settings.front());
    for (std::uint32_t i = 0; i < 400; ++i) {
        Take::Tick tick;
        const double x = begin + 4e-5 * i;
        tick.input.pose.translation =
            object->position + Vec3d{x, 0.05 + 0.006 - std::min(0.003, 2e-5 * i), 0.001 * std::sin(0.1 * i)};
        tick.input.dt = 0.001 + 1e-6 * (i % 7);
        tick.input.degraded = i % 50 == 49;
        tick.number = i < 200 ? 0 : 2;
        if (i == 200) forces.adjust(live_of(take->settings[2], 2));
        (void)forces.step(tick.input, tick.commanded);
        tick.sent = tick.commanded;
        tick.depth = forces.found().depth;
        tick.time = 0.001 * i;
        tick.sequence = i + 1;
        tick.contacts = forces.found().contacts;
        take->ticks.push_back(tick);
    }
    return take;
}

TEST(RecordingFile, ComputesTheSameBitsAfterAFile)
{
    const ObjectPtr here = ball({0.1, 0.2, 1.0 / 3}), there = ball({-0.2, 0, 0});
    const auto turned = std::make_shared<Object>(*there);
    turned->put_at(there->metres_per_unit, there->position, Up::Z);
    const std::shared_ptr<Take> beside_hidden = drawn(turned, 0.002);
    beside_hidden->objects.push_back(nullptr);
    const Recording recording{drawn(here, -0.004), std::make_shared<Take>(), beside_hidden};
    const std::string text = recording_text(recording);
    EXPECT_TRUE(text.starts_with("# sqmap-trace 1\n"));

    const RecordingFile file = read_recording(text, "touch.csv");
    ASSERT_EQ(file.objects.size(), 2u);
    EXPECT_EQ(file.objects[0].name, "ball");
    EXPECT_EQ(file.objects[0].hash, model::content_hash(here->view));
    EXPECT_EQ(file.objects[0].metres_per_unit, here->metres_per_unit);
    EXPECT_EQ(file.objects[0].position, here->position);
    ASSERT_EQ(file.takes.size(), 2u) << "a take without a tick is none";
    EXPECT_EQ(file.objects_of, (std::vector<std::vector<std::uint32_t>>{{0}, {1, k_hidden_object}}));
    EXPECT_EQ(file.objects[0].up, Up::Y);
    EXPECT_EQ(file.objects[1].up, Up::Z);
    EXPECT_EQ(file.takes[0]->settings.size(), 2u) << "settings that no tick had are not kept";
    EXPECT_EQ(file.takes[1]->ticks.front().time, 0);

    file.takes[0]->objects = {here};
    file.takes[1]->objects = {turned, nullptr};
    const Recording opened{file.takes[0], file.takes[1]};
    const Again again = compute_again(opened, std::nullopt);
    EXPECT_EQ(again.ticks.size(), 800u);
    EXPECT_EQ(again.different, 0u);
    double largest = 0;
    for (const Again::Tick& tick : again.ticks) largest = std::max(largest, static_cast<double>(tick.force));
    EXPECT_GT(largest, 0.3) << "there is something to compare";
    EXPECT_EQ(recording_text(opened), text);
}

TEST(RecordingFile, IsDrawnFromItsPosesAlone)
{
    const ObjectPtr object = ball({});
    const Recording recording{drawn(object, 0)};
    const std::string bytes = frames_bytes(recording, std::vector<ObjectPtr>{nullptr, object});
    std::uint32_t count = 0;
    std::memcpy(&count, bytes.data() + 4, 4);
    EXPECT_EQ(count, 25u);
    std::size_t at = 8, ticks = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        std::uint32_t length = 0;
        std::memcpy(&length, bytes.data() + at, 4);
        std::vector<float> floats(length);
        std::memcpy(floats.data(), bytes.data() + at + 4, 4 * length);
        at += 4 + 4 * length;
        ticks += static_cast<std::size_t>(floats[27]);
        EXPECT_EQ(floats[28], static_cast<float>(ticks));
        if (i + 1 == count) {
            EXPECT_EQ(floats[19], 1) << "its number in the scene of now";
            EXPECT_GT(floats[18], 0) << "it touches";
            EXPECT_GT(floats[3], floats[39]) << "the tool is drawn above the hand, on the surface";
        }
    }
    EXPECT_EQ(at, bytes.size());
    EXPECT_EQ(ticks, 400u);
}

/// As sqmap touch records: a setup instead of the page's fields.
std::string of_touch(const std::string& text, const std::string& setup)
{
    const std::size_t fields = text.find("# page "), columns = text.find("\ntime,") + 1;
    return text.substr(0, fields) + "# setup " + setup + "\n" + text.substr(columns);
}

constexpr const char* k_setup =
    R"({"objects":[{"file":"models/ball.sqmap","hash":"00000000000000ff","metres_per_unit":0.1,"place":[0.1,0.2,0.3]}],)"
    R"("tool":"sphere:0.006","mode":"proxy","layer":"exact","force":"full","friction":"coulomb","stiffness":300.0,"damping":0.0,)"
    R"("mu_dynamic":0.4,"f_c":0.1,"k_f":10.0,"object_mass":0.0,"sway_x":0.0})";

TEST(RecordingFile, OfSqmapTouchHasItsTicksAndTheNearestSettings)
{
    const Recording recording{drawn(ball({}), 0)};
    std::string text = of_touch(recording_text(recording), k_setup);
    const RecordingFile file = read_recording(text, "touch.csv");
    EXPECT_TRUE(file.of_touch);
    ASSERT_EQ(file.objects.size(), 1u);
    EXPECT_EQ(file.objects[0].name, "ball");
    EXPECT_EQ(file.objects[0].hash, 0xffu);
    EXPECT_EQ(file.objects[0].metres_per_unit, 0.1);
    EXPECT_EQ(file.objects[0].position, (Vec3d{0.1, 0.2, 0.3}));
    ASSERT_EQ(file.takes.size(), 1u);
    EXPECT_EQ(file.objects_of, (std::vector<std::vector<std::uint32_t>>{{0}}));
    const Take& take = *file.takes[0];
    ASSERT_EQ(take.settings.size(), 1u);
    const Settings& s = take.settings[0];
    EXPECT_EQ(s.stiffness, 300);
    EXPECT_EQ(s.tool_radius, 0.006);
    EXPECT_EQ(s.friction, 0.4);
    EXPECT_EQ(s.layer, query::Layer::Exact);
    EXPECT_TRUE(s.proxy);
    ASSERT_EQ(take.ticks.size(), 400u);
    EXPECT_EQ(take.ticks[300].sent.force, recording[0]->ticks[300].sent.force);
    // A tick without a reading has no pose.
    const std::string begin = "0,0.001,1,0,0,";
    const std::size_t row = text.find("\n" + begin) + 1, length = text.find('\n', row) + 1 - row;
    text.insert(row, "0,0.001,1,0,4," + text.substr(row + begin.size(), length - begin.size()));
    text.replace(text.find("# end 400"), 9, "# end 401");
    EXPECT_EQ(read_recording(text, "touch.csv").takes[0]->ticks.size(), 400u);
}

std::string why(const std::string& text)
{
    try {
        (void)read_recording(text, "touch.csv");
    } catch (const device::TraceError& e) {
        return e.what();
    }
    return "";
}

TEST(RecordingFile, WhatIsNoneIsRefused)
{
    const std::string text = recording_text({drawn(ball({}), 0)});
    EXPECT_EQ(why(text), "");
    const auto with = [&](const std::string& old, const std::string& by) {
        std::string out = text;
        const std::size_t at = out.find(old);
        EXPECT_NE(at, std::string::npos) << old;
        return out.replace(at, old.size(), by);
    };
    const auto refuses = [&](const std::string& damaged, const std::string& reason) {
        EXPECT_NE(why(damaged).find(reason), std::string::npos) << why(damaged) << "\nwanted: " << reason;
        EXPECT_TRUE(why(damaged).starts_with("touch.csv:")) << why(damaged);
    };
    refuses("x", "not a trace");
    refuses(with("# page 1", "# page 9"), "another version");
    refuses(with("# page 1\n", ""), "neither the page nor sqmap touch");
    const auto touched = [&](const std::string& old, const std::string& by) {
        std::string setup = k_setup;
        EXPECT_NE(setup.find(old), std::string::npos) << old;
        return of_touch(text, setup.replace(setup.find(old), old.size(), by));
    };
    refuses(touched("sphere:0.006", "hand.glb"), "neither sphere nor point\n  cure: sqmap replay");
    refuses(touched("sphere:0.006", "sphere:6"), "do not reach");
    refuses(touched("\"stiffness\":300.0,", ""), "do not reach");
    refuses(touched("proxy", "coupled"), "coupled");
    refuses(touched("\"object_mass\":0.0", "\"object_mass\":0.5"), "objects move");
    refuses(touched("\"hash\":\"00", "\"hash\":\"zz"), "objects");
    refuses(touched("[0.1,0.2,0.3]", "[0.1,0.2]"), "objects");
    refuses(touched("[0.1,0.2,0.3]", "[[[0.1]],0.2]"), "setup");
    refuses(of_touch(text, "[]"), "setup");
    refuses(of_touch(text, "{\"objects\":[]}"), "setup");
    refuses(with("\"stiffness\":250", "\"stiffness\":\"much\""), "settings");
    refuses(with("\"stiffness\":250", "\"stiffness\":1e9"), "settings");
    refuses(with("\"row\":200", "\"row\":0"), "settings");
    refuses(with("\"row\":0", "\"row\":1"), "takes");
    refuses(with("\"objects\":[0]", "\"objects\":[1]"), "takes");
    refuses(with("\"position\":[", "\"position\":[1e9,"), "objects");
    refuses(with("# objects [", "# objects [[[[[["), "objects");
    refuses(with("\n0.1,", "\nnan,"), "clock");
    refuses(text.substr(0, text.find("\n0,") + 1), "cut short");
}

}  // namespace
}  // namespace sqmap::viewer
