// The live figure. Waits for what happens, bounded; asserts no time.
#include "viewer/server/cloth/fitting.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <thread>

namespace sqmap::viewer {
namespace {

struct Shot {
    std::vector<float> v;
    [[nodiscard]] std::size_t vertices() const { return static_cast<std::size_t>(v[2]); }
    [[nodiscard]] std::size_t bones() const { return static_cast<std::size_t>(v[3]); }
    [[nodiscard]] Vec3d tension() const { return {v[7], v[8], v[9]}; }
    [[nodiscard]] Vec3d body() const { return {v[16], v[17], v[18]}; }
    [[nodiscard]] bool held() const { return v[14] > 0; }
    [[nodiscard]] Vec3d at(std::size_t i) const
    {
        const float* p = &v[19 + 12 * bones() + 3 * i];
        return {p[0], p[1], p[2]};
    }
};

/// Frames until done says so, or two minutes.
template <class Done>
Shot wait_for(Fitting& fitting, Done done)
{
    for (int i = 0; i < 12000; ++i) {
        if (const auto bytes = fitting.frame()) {
            Shot shot;
            shot.v.resize(bytes->size() / 4);
            std::memcpy(shot.v.data(), bytes->data(), bytes->size());
            if (done(shot)) return shot;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    ADD_FAILURE() << "it did not happen";
    return {};
}

Message cloth(Handling what, Vec3d position = {})
{
    Message m;
    m.say = Say::Cloth;
    m.handling = what;
    m.target = position;
    return m;
}
Message fit(const char* garment, const char* fabric)
{
    Message m;
    m.say = Say::Fit;
    m.garment = garment;
    m.fabric = fabric;
    return m;
}

// An avatar that cannot be dressed is named, and the person is taken: one figure is baked for both.
TEST(Fitting, NamesWhatCannotBeDressedAndDressesPullsPinsAndChangesThePerson)
{
    std::string trouble;  // written before the first frame is made, and where one is wrong
    Fitting fitting([](double) {}, [&](const std::string& why) { trouble += why; }, {"junk.glb", "glTF nonsense"});
    fitting.send(fit("poncho", "wool"));
    Shot first = wait_for(fitting, [](const Shot& s) { return s.v[1] > 20; });
    ASSERT_FALSE(first.v.empty());
    EXPECT_TRUE(trouble.starts_with("junk.glb: E_")) << trouble;
    const std::string junk = trouble;
    ASSERT_EQ(first.v.size(), 19 + 12 * first.bones() + 3 * first.vertices());
    EXPECT_EQ(first.bones(), 13u);
    for (std::size_t i = 0; i < first.vertices(); ++i) ASSERT_LT(norm(first.at(i)), 3);
    const auto shapes = fitting.shapes();
    ASSERT_NE(shapes, nullptr);
    EXPECT_EQ(shapes->substr(0, 4), "SQC2");

    // The lowest vertex, pulled down by 0.2 m, goes there and pulls up.
    std::size_t low = 0;
    for (std::size_t i = 1; i < first.vertices(); ++i)
        if (first.at(i).y < first.at(low).y) low = i;
    fitting.send(cloth(Handling::Grasp, first.at(low)));
    const Vec3d to = first.at(low) - Vec3d{0, 0.2, 0};
    fitting.send(cloth(Handling::Drag, to));
    const Shot pulled = wait_for(fitting, [](const Shot& s) { return s.held() && s.tension().y > 0.5; });
    ASSERT_FALSE(pulled.v.empty());
    // However far the pointer goes, the hand pulls with 30 N at most.
    fitting.send(cloth(Handling::Drag, first.at(low) + Vec3d{0, 0, 3}));
    const Shot strong = wait_for(fitting, [](const Shot& s) { return s.held() && norm(s.tension()) > 29; });
    ASSERT_FALSE(strong.v.empty());
    for (std::uint32_t frame = 1; frame < 6; ++frame)
        EXPECT_LE(
            norm(wait_for(fitting, [&](const Shot& s) { return s.v[1] >= strong.v[1] + static_cast<float>(frame); }).tension()),
            30.01);
    // Pulled into the body, it stays outside, and the body is felt.
    Vec3d middle{};
    for (std::size_t i = 0; i < first.vertices(); ++i) middle += first.at(i) / static_cast<double>(first.vertices());
    fitting.send(cloth(Handling::Drag, {middle.x, first.at(low).y, middle.z}));
    const Shot pressed = wait_for(fitting, [](const Shot& s) { return s.held() && norm(s.body()) > 5; });
    ASSERT_FALSE(pressed.v.empty());
    fitting.send(cloth(Handling::Release));
    // Once it has fallen back and hardly moves, so that what is shown is where it is.
    const Shot calm = wait_for(fitting, [](const Shot& s) { return !s.held() && s.v[10] < 0.5f; });
    ASSERT_FALSE(calm.v.empty());

    // A point far from all cloth is not taken.
    fitting.send(cloth(Handling::Grasp, {3, 3, 3}));
    fitting.send(cloth(Handling::Pin, calm.at(0)));
    const Shot pinned = wait_for(fitting, [](const Shot& s) { return s.v[13] > 0; });
    ASSERT_FALSE(pinned.v.empty());
    EXPECT_FALSE(pinned.held());
    fitting.send(cloth(Handling::Unpin));
    (void)wait_for(fitting, [](const Shot& s) { return s.v[13] == 0; });

    // Another fabric goes on in the same folds, another garment starts anew.
    fitting.send(fit("poncho", "silk"));
    EXPECT_EQ(wait_for(fitting, [&](const Shot&) { return fitting.status()["fabric"] == "silk"; }).v[15], first.v[15]);
    fitting.send(fit("shirt", "silk"));
    (void)wait_for(fitting, [&](const Shot& s) { return s.v[15] == first.v[15] + 1; });
    Message cut = cloth(Handling::Cut);
    cut.part = 1;
    fitting.send(cut);
    cut.part = 99;  // there is no such seam
    fitting.send(cut);
    (void)wait_for(fitting, [&](const Shot&) { return fitting.status()["seams"][1]["sewn"] == false; });
    EXPECT_EQ(trouble, junk);
}

TEST(Fitting, EndsWhileItsFigureIsBeingMade)
{
    const Fitting fitting([](double) {}, [](const std::string&) {});
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
}

}  // namespace
}  // namespace sqmap::viewer
