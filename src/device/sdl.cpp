// Joysticks, gamepads and wheels through SDL2: the stick moves the tool; the device shows the force as rumble or, if it has force
// feedback, as a constant force in its direction.
#include "device/families.h"
#include "device/sdl_effect.h"
#include "device/threaded.h"

#include <SDL2/SDL.h>

#include <algorithm>
#include <cmath>
#include <future>

namespace sqmap::device {

SDL_HapticEffect constant_force(Vec3d force, double full_scale)
{
    SDL_HapticEffect effect{};
    effect.type = SDL_HAPTIC_CONSTANT;
    SDL_HapticConstant& c = effect.constant;
    c.direction.type = SDL_HAPTIC_CARTESIAN;
    c.length = k_effect_length;
    const double size = norm(force);
    if (!(size > 0) || !std::isfinite(size) || !(full_scale > 0)) return effect;
    // SDL wants the direction that the force comes from, x to the right, y towards the user and z up: our x, z and y.
    const Vec3d from = -1 / size * Vec3d{force.x, force.z, force.y};
    for (int i = 0; i < 3; ++i) c.direction.dir[i] = static_cast<Sint32>(std::lround(10000 * from[i]));
    c.level = static_cast<Sint16>(std::lround(32767 * std::min(1.0, size / full_scale)));
    return effect;
}

namespace {

constexpr unsigned k_systems = SDL_INIT_JOYSTICK | SDL_INIT_GAMECONTROLLER | SDL_INIT_HAPTIC;

/// SDL as long as this lives. SDL counts, so a program that uses it too is not disturbed.
class Library {
public:
    Library()
    {
        SDL_SetHint(SDL_HINT_JOYSTICK_ALLOW_BACKGROUND_EVENTS, "1");
        SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");
        // Some systems have no haptic interface at all: joysticks rumble without it.
        if (SDL_InitSubSystem(k_systems) == 0)
            systems_ = k_systems;
        else if (SDL_InitSubSystem(SDL_INIT_JOYSTICK | SDL_INIT_GAMECONTROLLER) == 0)
            systems_ = SDL_INIT_JOYSTICK | SDL_INIT_GAMECONTROLLER;
    }
    ~Library()
    {
        if (systems_ != 0) SDL_QuitSubSystem(systems_);
    }
    Library(const Library&) = delete;
    Library& operator=(const Library&) = delete;
    [[nodiscard]] bool good() const { return systems_ != 0; }
    [[nodiscard]] bool haptic() const { return (systems_ & SDL_INIT_HAPTIC) != 0; }

private:
    unsigned systems_ = 0;
};

struct Settings {
    int index = 0;
    double range = 0.1;  ///< m, the tool's travel for the stick's full deflection to one side
    double full = 1;     ///< N, shown as the strongest rumble
};

class SdlDevice final : public ThreadedDevice {
public:
    explicit SdlDevice(const Settings& settings) : settings_(settings)
    {
        std::promise<std::string> opened;
        std::future<std::string> result = opened.get_future();
        start([this, promise = std::move(opened)]() mutable { run(std::move(promise)); });
        const std::string wrong = result.get();
        if (wrong.empty() && wait_for_sample(1)) return;
        stop();
        throw DeviceError("sdl: " + (wrong.empty() ? "the joystick gives no reading" : wrong));
    }
    ~SdlDevice() override { stop(); }

private:
    void run(std::promise<std::string> opened)
    {
        const Library library;
        if (!library.good()) return opened.set_value(std::string("SDL does not start: ") + SDL_GetError());
        const int count = SDL_NumJoysticks();
        if (settings_.index >= count)
            return opened.set_value("there is no joystick " + std::to_string(settings_.index) + ", " + std::to_string(count) +
                                    " found");
        if (!plug_in(library, settings_.index)) return opened.set_value(SDL_GetError());
        guid_ = SDL_JoystickGetGUID(joystick_);
        describe();
        opened.set_value({});
        double looked = 0;
        while (!stopping()) {
            const double time = now();
            SDL_JoystickUpdate();
            if (joystick_ != nullptr && SDL_JoystickGetAttached(joystick_) == SDL_FALSE) unplug();
            if (joystick_ == nullptr && time - looked > 0.2) {
                looked = time;
                for (int i = 0; i < SDL_NumJoysticks() && joystick_ == nullptr; ++i) {
                    const SDL_JoystickGUID guid = SDL_JoystickGetDeviceGUID(i);
                    if (std::equal(std::begin(guid.data), std::end(guid.data), std::begin(guid_.data))) plug_in(library, i);
                }
            }
            if (joystick_ != nullptr) {
                poll(time);
                exert(channel_.output(time)[0].force, time);
            }
            SDL_Delay(1);
        }
        if (joystick_ != nullptr) exert({}, now());
        unplug();
    }

    bool plug_in(const Library& library, int index)
    {
        if (SDL_IsGameController(index) == SDL_TRUE) pad_ = SDL_GameControllerOpen(index);
        joystick_ = SDL_JoystickOpen(index);
        if (joystick_ == nullptr) {
            unplug();
            return false;
        }
        if (library.haptic() && SDL_JoystickIsHaptic(joystick_) == 1) {
            haptic_ = SDL_HapticOpenFromJoystick(joystick_);
            if (haptic_ != nullptr) {
                SDL_HapticEffect none = constant_force({}, 1);
                if ((SDL_HapticQuery(haptic_) & SDL_HAPTIC_CONSTANT) != 0 && SDL_HapticNumAxes(haptic_) >= 2) {
                    SDL_HapticSetAutocenter(haptic_, 0);
                    effect_ = SDL_HapticNewEffect(haptic_, &none);
                }
            }
        }
        return true;
    }

    void unplug()
    {
        channel_.lose();
        if (haptic_ != nullptr) SDL_HapticClose(haptic_);
        if (pad_ != nullptr) SDL_GameControllerClose(pad_);
        if (joystick_ != nullptr) SDL_JoystickClose(joystick_);
        haptic_ = nullptr;
        pad_ = nullptr;
        joystick_ = nullptr;
        effect_ = -1;
        force_shown_ = {};
        strength_ = 0;
    }

    void describe()
    {
        const char* name = SDL_JoystickName(joystick_);
        capabilities_.name = std::string(name != nullptr ? name : "joystick") + " (SDL)";
        capabilities_.simulated = SDL_JoystickIsVirtual(settings_.index) == SDL_TRUE;
        capabilities_.force_out = effect_ >= 0;
        capabilities_.rumble_out = effect_ < 0 && SDL_JoystickHasRumble(joystick_) == SDL_TRUE;
        // SDL reports no newtons: max_force stays unknown, and the safety filter takes its careful default.
        capabilities_.resolution = settings_.range / 32768;
    }

    [[nodiscard]] double axis(int joystick_axis, SDL_GameControllerAxis pad_axis) const
    {
        const Sint16 raw = pad_ != nullptr                                  ? SDL_GameControllerGetAxis(pad_, pad_axis)
                           : joystick_axis < SDL_JoystickNumAxes(joystick_) ? SDL_JoystickGetAxis(joystick_, joystick_axis)
                                                                            : Sint16{0};
        return std::max(-1.0, raw / 32767.0);
    }

    void poll(double time)
    {
        Sample sample;
        sample.time = time;
        // Right is x, up is y, towards the user is z; sticks report down and towards as positive.
        sample.poses[0].translation =
            settings_.range *
            Vec3d{axis(0, SDL_CONTROLLER_AXIS_LEFTX), -axis(2, SDL_CONTROLLER_AXIS_RIGHTY), axis(1, SDL_CONTROLLER_AXIS_LEFTY)};
        const int buttons = std::min(32, SDL_JoystickNumButtons(joystick_));
        for (int b = 0; b < buttons; ++b) sample.buttons |= static_cast<std::uint32_t>(SDL_JoystickGetButton(joystick_, b)) << b;
        channel_.publish(sample);
    }

    /// Every effect and rumble has an end, so that the device falls still if this process dies; exert() renews them in time.
    void exert(Vec3d force, double time)
    {
        if (effect_ >= 0) {
            if (force == force_shown_ && (force == Vec3d{} || time - renewed_ < 0.5e-3 * k_effect_length)) return;
            SDL_HapticEffect effect = constant_force(force, settings_.full);
            SDL_HapticUpdateEffect(haptic_, effect_, &effect);
            if (force == Vec3d{})
                SDL_HapticStopEffect(haptic_, effect_);
            else
                SDL_HapticRunEffect(haptic_, effect_, 1);
            force_shown_ = force;
            renewed_ = time;
        } else if (capabilities_.rumble_out) {
            const auto strength = static_cast<Uint16>(std::lround(65535 * std::clamp(norm(force) / settings_.full, 0.0, 1.0)));
            if (strength == strength_ && (strength == 0 || time - renewed_ < 0.5e-3 * k_effect_length)) return;
            SDL_JoystickRumble(joystick_, strength, strength, strength == 0 ? 0 : k_effect_length);
            strength_ = strength;
            renewed_ = time;
        }
    }

    Settings settings_;
    // The thread's own.
    SDL_Joystick* joystick_ = nullptr;
    SDL_GameController* pad_ = nullptr;
    SDL_Haptic* haptic_ = nullptr;
    SDL_JoystickGUID guid_{};
    int effect_ = -1;
    Vec3d force_shown_{};
    Uint16 strength_ = 0;
    double renewed_ = 0;
};

}  // namespace

void list_sdl(std::vector<DeviceListing>& list)
{
    const Library library;
    const int count = library.good() ? SDL_NumJoysticks() : 0;
    if (count <= 0) list.push_back({"sdl:0", Presence::Absent, "no joystick or gamepad is plugged in", {}});
    for (int i = 0; i < count; ++i) {
        const char* name = SDL_JoystickNameForIndex(i);
        DeviceListing entry{"sdl:" + std::to_string(i), Presence::Here, name != nullptr ? name : "joystick", {}};
        entry.capabilities.simulated = SDL_JoystickIsVirtual(i) == SDL_TRUE;
        if (SDL_Joystick* joystick = SDL_JoystickOpen(i); joystick != nullptr) {
            entry.capabilities.rumble_out = SDL_JoystickHasRumble(joystick) == SDL_TRUE;
            entry.capabilities.force_out = library.haptic() && SDL_JoystickIsHaptic(joystick) == 1;
            SDL_JoystickClose(joystick);
        }
        list.push_back(std::move(entry));
    }
}

std::unique_ptr<Device> open_sdl(const DeviceSpec& spec)
{
    spec.allow({"range", "full"});
    Settings settings;
    settings.index = spec.index(0, 0, 1000);
    settings.range = spec.number("range", settings.range, 1e-4, 10);
    settings.full = spec.number("full", settings.full, 1e-3, 1e3);
    return std::make_unique<SdlDevice>(settings);
}

}  // namespace sqmap::device
