// Joysticks of SDL's own making: what they are told to rumble is seen in their callback.
#include "device/sdl_effect.h"
#include "sqmap/device/open.h"
#include "support/within.h"

#include <SDL2/SDL.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>

namespace sqmap::device {
namespace {

using namespace std::chrono_literals;
using test::within;

class Joystick {
public:
    explicit Joystick(bool rumbles = true)
    {
        desc_.version = SDL_VIRTUAL_JOYSTICK_DESC_VERSION;
        desc_.type = SDL_JOYSTICK_TYPE_FLIGHT_STICK;
        desc_.naxes = 3;
        desc_.nbuttons = 4;
        desc_.name = "test stick";
        desc_.userdata = this;
        desc_.Update = [](void* self) { static_cast<Joystick*>(self)->update(); };
        if (rumbles)
            desc_.Rumble = [](void* self, Uint16 slow, Uint16 fast) {
                static_cast<Joystick*>(self)->low = slow;
                static_cast<Joystick*>(self)->high = fast;
                return 0;
            };
        attach();
    }
    ~Joystick() { detach(); }
    Joystick(const Joystick&) = delete;
    Joystick& operator=(const Joystick&) = delete;

    void attach()
    {
        index_ = SDL_JoystickAttachVirtualEx(&desc_);
        EXPECT_GE(index_, 0) << SDL_GetError();
        handle_ = SDL_JoystickOpen(index_);
    }
    void detach()
    {
        if (index_ < 0) return;
        SDL_LockJoysticks();
        SDL_Joystick* const handle = handle_.exchange(nullptr);
        SDL_UnlockJoysticks();
        SDL_JoystickDetachVirtual(index_);
        SDL_JoystickClose(handle);
        index_ = -1;
    }

    std::atomic<int> x{0}, y{0}, z{0};
    std::atomic<bool> pressed{false};
    std::atomic<int> low{-1}, high{-1};

private:
    void update()  // by whoever updates SDL's joysticks
    {
        SDL_Joystick* const handle = handle_;
        if (handle == nullptr) return;
        SDL_JoystickSetVirtualAxis(handle, 0, static_cast<Sint16>(x));
        SDL_JoystickSetVirtualAxis(handle, 1, static_cast<Sint16>(y));
        SDL_JoystickSetVirtualAxis(handle, 2, static_cast<Sint16>(z));
        SDL_JoystickSetVirtualButton(handle, 2, pressed ? 1 : 0);
    }
    SDL_VirtualJoystickDesc desc_{};
    int index_ = -1;
    std::atomic<SDL_Joystick*> handle_{nullptr};
};

class Sdl : public ::testing::Test {
protected:
    static void SetUpTestSuite() { ASSERT_EQ(SDL_InitSubSystem(SDL_INIT_JOYSTICK), 0) << SDL_GetError(); }
    static void TearDownTestSuite() { SDL_QuitSubSystem(SDL_INIT_JOYSTICK); }
};

/// As a servo does: writes every millisecond until the condition holds.
template <class Condition>
bool writing(Device& device, const Wrench& wrench, Condition condition)
{
    return within(5s, [&] {
        device.write({&wrench, 1});
        return condition();
    });
}

TEST_F(Sdl, AxesMoveTheToolAndButtonsAreBits)
{
    Joystick stick;
    stick.x = 32767;
    stick.y = -32768;
    stick.z = 16384;
    stick.pressed = true;
    const auto device = open_device("sdl:0,range=0.2");
    EXPECT_TRUE(device->capabilities().simulated) << "a virtual joystick is no hardware";
    EXPECT_EQ(device->capabilities().name, "test stick (SDL)");
    EXPECT_TRUE(device->capabilities().rumble_out);
    EXPECT_FALSE(device->capabilities().force_out);
    Sample sample;
    EXPECT_TRUE(within(5s, [&] { return device->read(sample) && sample.poses[0].translation.x > 0.19; }));
    EXPECT_DOUBLE_EQ(sample.poses[0].translation.x, 0.2);
    EXPECT_DOUBLE_EQ(sample.poses[0].translation.z, -0.2) << "away from the user, and never beyond the range";
    EXPECT_NEAR(sample.poses[0].translation.y, -0.1, 1e-5) << "sticks report down as positive";
    EXPECT_EQ(sample.buttons, 4u);
    const std::uint64_t before = sample.sequence;
    EXPECT_TRUE(within(5s, [&] { return device->read(sample) && sample.sequence > before; })) << "a stick at rest is still read";
}

TEST_F(Sdl, RumbleIsAsStrongAsTheForce)
{
    Joystick stick;
    const auto device = open_device("sdl:0,full=2");
    EXPECT_TRUE(writing(*device, {{0, 0.6, 0.8}, {}}, [&] { return stick.low > 0; }));
    EXPECT_NEAR(stick.low, 65535 / 2, 1);
    EXPECT_EQ(stick.high, stick.low);
    EXPECT_TRUE(writing(*device, {{0, 0, -1e3}, {}}, [&] { return stick.low == 65535; })) << "and no stronger than all";
}

TEST_F(Sdl, ZeroSilenceAndClosingEndTheRumble)
{
    Joystick stick;
    auto device = open_device("sdl:0");
    const Wrench push{{1, 0, 0}, {}};
    EXPECT_TRUE(writing(*device, push, [&] { return stick.low > 0; }));
    EXPECT_TRUE(within(5s, [&] { return stick.low == 0; })) << "a servo that writes no more";
    EXPECT_TRUE(writing(*device, push, [&] { return stick.low > 0; }));
    device->zero();
    EXPECT_TRUE(within(5s, [&] { return stick.low == 0; }));
    EXPECT_TRUE(writing(*device, push, [&] { return stick.low > 0; }));
    device.reset();
    EXPECT_EQ(stick.low, 0);
}

TEST_F(Sdl, AnUnpluggedStickIsGoneAndComesBack)
{
    Joystick stick;
    const auto device = open_device("sdl:0");
    Sample sample;
    EXPECT_TRUE(device->read(sample));
    stick.detach();
    EXPECT_TRUE(within(5s, [&] { return !device->read(sample); }));
    EXPECT_FALSE(device->write({}));
    stick.x = 32767;
    stick.attach();
    EXPECT_TRUE(within(5s, [&] { return device->read(sample) && sample.poses[0].translation.x > 0; }));
}

TEST_F(Sdl, AStickWithoutRumbleSaysSo)
{
    Joystick stick(false);
    const auto device = open_device("sdl:0");
    EXPECT_FALSE(device->capabilities().rumble_out);
}

TEST_F(Sdl, TheListNamesWhatIsThere)
{
    const auto entry = [] {
        for (DeviceListing& e : list_devices())
            if (e.spec.starts_with("sdl:")) return e;
        return DeviceListing{};
    };
    EXPECT_EQ(entry().presence, Presence::Absent);
    const Joystick stick;
    EXPECT_EQ(entry().presence, Presence::Here);
    EXPECT_EQ(entry().state, "test stick");
    EXPECT_TRUE(entry().capabilities.rumble_out);
    EXPECT_THROW((void)open_device("sdl:1"), DeviceError);
}

TEST(SdlEffect, PushesWhereTheForcePoints)
{
    // SDL's direction is where the force comes from: x right, y towards the user, z up.
    const SDL_HapticEffect right = constant_force({2, 0, 0}, 4);
    EXPECT_EQ(right.type, SDL_HAPTIC_CONSTANT);
    EXPECT_EQ(right.constant.direction.type, SDL_HAPTIC_CARTESIAN);
    EXPECT_EQ(right.constant.direction.dir[0], -10000);
    EXPECT_EQ(right.constant.direction.dir[1], 0);
    EXPECT_EQ(right.constant.level, 16384);
    EXPECT_EQ(right.constant.length, k_effect_length) << "ends by itself";
    const SDL_HapticEffect towards = constant_force({0, 0, 3}, 1);
    EXPECT_EQ(towards.constant.direction.dir[1], -10000);
    EXPECT_EQ(towards.constant.level, 32767) << "no stronger than all";
    const SDL_HapticEffect up = constant_force({0, 3, 0}, 3);
    EXPECT_EQ(up.constant.direction.dir[2], -10000);
    for (const Vec3d none : {Vec3d{}, Vec3d{std::nan(""), 0, 0}, Vec3d{INFINITY, 0, 0}})
        EXPECT_EQ(constant_force(none, 1).constant.level, 0);
    EXPECT_EQ(constant_force({1, 0, 0}, 0).constant.level, 0);
}

}  // namespace
}  // namespace sqmap::device
