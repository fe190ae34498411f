// sqmap touch: a device, real or scripted, touches models; every tick can be recorded.
#include "commands.h"
#include "sqmap/device/glove.h"
#include "sqmap/device/handover.h"
#include "sqmap/device/keeper.h"
#include "sqmap/device/open.h"
#include "sqmap/device/path.h"
#include "sqmap/device/servo.h"
#include "sqmap/device/simulated.h"
#include "sqmap/device/trace.h"
#include "sqmap/haptic/safety.h"
#include "three_numbers.h"
#include "touch/setup.h"
#include "touch/strip_chart.h"

#include <poll.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <map>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <thread>

namespace sqmap::app {
namespace {

struct Arguments {
    std::vector<std::string> objects;
    std::string device = "press", record, plot;
    double unit = 0, size = 0.3, seconds = 10;
    bool own_process = false;
    bool all_of_it = true;  ///< of a recorded path: nobody said for how long
    TouchOptions touch;
    device::ServoOptions servo;
};

const std::map<std::string, device::Script> k_scripts{{"press", device::Script::Press},
                                                      {"tap", device::Script::Tap},
                                                      {"slide", device::Script::Slide},
                                                      {"circle", device::Script::Circle}};

constexpr double k_wait = 0.6, k_long = 2;  // s that scripts of so long wait for the safety filter's ramp

std::atomic<bool> interrupted{false};
extern "C" void interrupt(int) { interrupted = true; }

double thread_cpu()
{
    timespec t{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// FILE or FILE@X,Y,Z.
TouchObject object_from(const std::string& text)
{
    TouchObject object{.file = text};
    const std::size_t at = text.rfind('@');
    if (at == std::string::npos) return object;
    const std::optional<Vec3d> place = three_numbers(std::string_view(text).substr(at + 1));
    if (!place || !(std::max({std::fabs(place->x), std::fabs(place->y), std::fabs(place->z)}) <= 1000))
        throw BadTouch("--object " + text + ": a place is three numbers of at most 1000 m, as in bunny.sqmap@0.1,0,0");
    object.place = *place;
    object.file.resize(at);
    return object;
}

Vec3d vector_option(const device::DeviceSpec& spec, const char* name, Vec3d otherwise)
{
    if (std::none_of(spec.options.begin(), spec.options.end(), [&](const auto& o) { return o.first == name; })) return otherwise;
    const std::string text = spec.text(name, "");
    // Commas part options, so a direction is written with blanks or slashes between its numbers.
    const std::optional<Vec3d> v = three_numbers(text, "/ ");
    if (!v)
        throw device::DeviceError(spec.kind + ": " + name + " is three numbers with slashes between them, as in 0/0/1, found '" +
                                  text + "'");
    if (!std::isnormal(norm_sq(*v)))
        throw device::DeviceError(spec.kind + ": " + name + "=" + text +
                                  " points nowhere\n  cure: numbers that are not all 0, as in 0/0/1, or leave it out");
    return *v;
}

/// What a script has no use for is refused, not passed over.
void allow(const device::DeviceSpec& spec, device::Script script, bool simulated)
{
    std::vector<std::string_view> names{"speed", "depth", "gap", "direction", "rate", "wait"};
    if (script == device::Script::Slide || script == device::Script::Circle) names.push_back("travel");
    if (script == device::Script::Circle) names.push_back("radius");
    if (simulated) names.insert(names.end(), {"hand", "delay"});
    spec.allow(names);
}

/// Poses in the world, of press, tap, slide or circle.
std::vector<sqmap::Pose> scripted_poses(const device::DeviceSpec& spec, device::Script script, const TouchSetup& setup,
                                        double seconds, double& rate)
{
    device::ScriptOptions o;
    o.seconds = seconds;
    o.rate = rate = spec.number("rate", o.rate, 60, 1e4);  // below, every tick comes as late as silence
    o.speed = spec.number("speed", o.speed, 1e-5, 10);
    o.depth = spec.number("depth", o.depth, -1, 1);
    o.gap = spec.number("gap", o.gap, -1, 1);
    o.wait = spec.number("wait", seconds >= k_long ? k_wait : 0, 0, 1e3);
    if (!(o.gap + o.depth > 0)) {
        char text[200];
        std::snprintf(text, sizeof text,
                      "%s: depth=%g lies above gap=%g from where it starts: nothing would move\n  cure: a depth + gap above 0",
                      spec.kind.c_str(), o.depth, o.gap);
        throw device::DeviceError(text);
    }
    o.radius = spec.number("radius", o.radius, 1e-5, 1);
    o.direction = vector_option(spec, "direction", o.direction);
    o.travel = vector_option(spec, "travel", o.travel);
    if (const double needed = device::script_needs(script, o); needed > seconds)
        std::printf("  warning: %.4g s are too short for all of this script: at least %.4g s, of which it waits %.4g s (wait=)\n",
                    seconds, needed, o.wait);
    std::vector<sqmap::Pose> poses = device::scripted_path(setup.first_model(), setup.tool(), script, o);
    for (sqmap::Pose& pose : poses) pose = sqmap::compose(setup.first_pose(), pose);
    return poses;
}

/// Where the simulated hand wants to be: what simulated devices point at.
struct HandPath {
    std::vector<sqmap::Pose> poses;
    double rate = 1000;
    device::GloveMotion glove{};

    static device::HandTarget at(const void* context, double time, std::size_t) noexcept
    {
        const HandPath& path = *static_cast<const HandPath*>(context);
        const double place = std::clamp(time * path.rate, 0.0, static_cast<double>(path.poses.size() - 1));
        const auto k = static_cast<std::size_t>(place);
        const std::size_t next = std::min(k + 1, path.poses.size() - 1);
        const Vec3d a = path.poses[k].translation, b = path.poses[next].translation;
        return {{{}, a + (place - static_cast<double>(k)) * (b - a)}, {path.rate * (b - a), {}}};
    }
};

/// Devices that need the model: paths over it, and a simulated device in a hand that follows one. Null for any other kind.
std::unique_ptr<device::Device> device_over(const device::DeviceSpec& spec, const TouchSetup& setup, double seconds,
                                            HandPath& hand)
{
    if (const auto script = k_scripts.find(spec.kind); script != k_scripts.end()) {
        spec.only_named();
        allow(spec, script->second, false);
        double rate = 0;
        std::vector<sqmap::Pose> poses = scripted_poses(spec, script->second, setup, seconds, rate);
        return std::make_unique<device::PathDevice>("scripted " + spec.kind, std::move(poses), rate);
    }
    if (spec.kind == "glove") {
        // The palm sways about the top of the object, along z, while the fingers open and close.
        spec.only_named();
        spec.allow({"sway", "curl", "length"});
        hand.glove.sway = {0, 0, spec.number("sway", hand.glove.sway.z, 0, 1)};
        hand.glove.curl = spec.number("curl", hand.glove.curl, 0, 1.5);
        hand.glove.length = setup.options().hand_length;
        // From where no zone is inside: one that is has no force until it has left.
        const Vec3d wrist{0, -0.45 * hand.glove.length, 0};
        hand.glove.wrist.translation = wrist;
        const auto zones = device::glove_zones(device::hand_joints(device::posture_at(hand.glove, 0), hand.glove.length));
        const std::vector<sqmap::Pose> top =
            device::scripted_path(setup.first_model(), setup.tool_at(zones), device::Script::Press,
                                  {.seconds = 1, .depth = 1e-6, .gap = 0, .direction = {0, 0, 1}});
        hand.glove.wrist.translation = top.front().translation + setup.first_pose().translation + wrist;
        return device::simulated_glove(hand.glove);
    }
    const auto script = k_scripts.find(spec.first.empty() ? "press" : spec.first);
    if (script == k_scripts.end())
        throw device::DeviceError("simulated: a hand can press, tap, slide or circle, not '" + spec.first + "'");
    allow(spec, script->second, true);
    hand.poses = scripted_poses(spec, script->second, setup, seconds, hand.rate);
    device::SimulatedOptions options{.script = HandPath::at, .script_context = &hand};
    options.mechanism.delay_ticks = spec.whole("delay", options.mechanism.delay_ticks, 0, 8);
    options.hand = device::hand_profile(spec.text("hand", options.hand.name));
    return std::make_unique<device::SimulatedDevice>(options);
}

/// Why the safety filter has let nothing through, in words.
std::string reasons(std::uint32_t faults)
{
    constexpr std::pair<std::uint32_t, const char*> k_reasons[] = {
        {haptic::k_fault_setup, "limits that it refuses"},
        {haptic::k_fault_not_finite, "poses or forces that are not finite"},
        {haptic::k_fault_stale, "no new pose for 100 ms"},
        {haptic::k_fault_fast, "faster than the top speed for 20 ms"},
        {haptic::k_fault_stop, "stopped"}};
    std::string out;
    for (const auto& [bit, words] : k_reasons)
        if ((faults & bit) != 0) out += (out.empty() ? "" : ", ") + std::string(words);
    return out;
}

/// What was wrong with poses, and what the filter did about it.
void print_glitches(const haptic::SafetyCounters& counted)
{
    const auto ticks = [](const char* what, std::uint64_t n, const char* then) {
        if (n > 0) std::printf("  %s in %llu tick%s: %s\n", what, static_cast<unsigned long long>(n), n == 1 ? "" : "s", then);
    };
    ticks("a pose, rotation or force was not finite", counted.not_finite, "no force in them");
    ticks("no fresh pose had come for more than 5 ms", counted.stale, "force was falling or zero");
    ticks("the tool was faster than 1 m/s or 20 rad/s", counted.fast, "a damper in the force's place");
    if (counted.teleports == 1) std::printf("  the pose jumped once by more than 5 cm or 1 rad: force set in anew\n");
    if (counted.teleports > 1)
        std::printf("  the pose jumped %llu times by more than 5 cm or 1 rad: force set in anew each time\n",
                    static_cast<unsigned long long>(counted.teleports));
}

/// True once Enter was pressed, where there is somebody to press it.
bool entered()
{
    pollfd in{STDIN_FILENO, POLLIN, 0};
    char text[64];
    return ::isatty(STDIN_FILENO) == 1 && ::poll(&in, 1, 0) > 0 && ::read(STDIN_FILENO, text, sizeof text) > 0;
}

std::string milliseconds(double time)
{
    char text[40];
    std::snprintf(text, sizeof text, "%.3f s", time);
    return text;
}

/// What a zone is called: a glove's by its finger.
std::string zone_name(std::size_t zone, std::size_t zones, bool glove)
{
    constexpr const char* k_names[device::k_glove_zones] = {"thumb",       "index",         "middle finger",
                                                            "ring finger", "little finger", "palm"};
    if (zones == 1) return "the tool";
    return glove && zone < device::k_glove_zones ? k_names[zone] : "zone " + std::to_string(zone);
}

/// While a zone had no force because it was inside when forces were to begin.
struct Inside {
    std::uint64_t ticks = 0;
    double first = 0, last = 0;  ///< s
    bool now = false;
};

struct Totals {
    std::uint64_t ticks = 0, contact = 0, faulty = 0;  ///< faulty: the filter let nothing through
    double first_fault = 0;                            ///< s
    std::uint32_t faults = 0;                          ///< bits of SafetyFault
    std::uint64_t hot = 0, braked = 0;                 ///< ticks in which the filter's duty and passivity steps acted
    std::uint64_t changed = 0;                         ///< ticks in which it sent anything but what was asked for
    double largest_force = 0, largest_sent = 0, deepest = 0, cpu = 0, max_cpu = 0;
    std::array<Inside, device::k_max_zones> inside{};
    std::uint64_t unknown = 0;  ///< ticks that were too many at once to learn what they felt
    bool gone = false;
    haptic::SafetyCounters counted{};
    device::ServoCounters servo{};

    void add(const device::TraceRow& row, std::size_t zones, double depth)
    {
        ++ticks;
        // A proxy stands on the surface and has no contacts of its own.
        contact += row.contacts > 0 || (row.status & haptic::k_step_contact) != 0;
        hot += (row.filter & haptic::k_acted_duty) != 0;
        braked += (row.filter & haptic::k_acted_passivity) != 0;
        if (const std::uint32_t now = row.filter >> 16; now != 0) {
            if (faulty++ == 0) first_fault = row.time;
            faults |= now;
        }
        bool as_asked = true;
        for (std::size_t z = 0; z < zones; ++z) {
            largest_force = std::max(largest_force, norm(row.computed[z].force));
            largest_sent = std::max(largest_sent, norm(row.sent[z].force));
            as_asked = as_asked && row.sent[z] == row.computed[z];
            Inside& in = inside[z];
            in.now = (row.filter & haptic::k_acted_inside) != 0 && row.sent[z] == haptic::Wrench{} &&
                     !(row.computed[z] == haptic::Wrench{});
            if (!in.now) continue;
            if (in.ticks++ == 0) in.first = row.time;
            in.last = row.time;
        }
        changed += !as_asked;
        deepest = std::max(deepest, depth);
        cpu += row.cpu;
        max_cpu = std::max(max_cpu, row.cpu);
    }
};

/// A path: every pose once, no clock, so that the same path gives the same trace.
Totals play(device::Device& path, TouchSetup& setup, const haptic::SafetyOptions& safety, device::TraceWriter* writer,
            double seconds)
{
    const device::Capabilities& capabilities = path.capabilities();
    const std::size_t zones = capabilities.zones;
    haptic::SafetyFilter filter(device::safety_limits(capabilities, 1 / capabilities.rate), safety);
    if (filter.verdict() != haptic::SetupVerdict::Ok) throw BadTouch(haptic::describe(filter.verdict()));
    Totals totals;
    device::Sample sample;
    device::TraceRow row;
    row.dt = 1 / capabilities.rate;
    // As many ticks as a script of so many seconds has.
    const double ticks = std::round(seconds * capabilities.rate);
    while (!interrupted && static_cast<double>(totals.ticks) < ticks && path.read(sample)) {
        const double begin = thread_cpu();
        row.sequence = sample.sequence;
        row.time = static_cast<double>(sample.sequence - 1) / capabilities.rate;
        row.poses = sample.poses;
        setup.step(row);
        const haptic::SafetyReport report = filter.tick({.time = row.time,
                                                         .sample_time = row.time,
                                                         .sequence = sample.sequence,
                                                         .poses = {row.poses.data(), zones},
                                                         .commanded = {row.computed.data(), zones},
                                                         .pushes = setup.pushes()},
                                                        {row.sent.data(), zones});
        row.filter = haptic::bits(report);
        row.cpu = thread_cpu() - begin;
        path.write({row.sent.data(), zones});
        totals.add(row, zones, setup.device_depth());
        if (writer != nullptr) writer->push_wait(row);
    }
    totals.counted = filter.counters();
    return totals;
}

/// What the servo's own record of a tick does not have.
struct Felt {
    std::uint64_t tick = 0;
    std::uint32_t contacts = 0, input = 0;
    double depth = 0, device_depth = 0;
};

struct Feeling {
    Feeling(TouchSetup& touched, std::size_t zone_count) : setup(touched), zones(zone_count) {}

    TouchSetup& setup;
    std::size_t zones;
    device::TraceRow row{};
    device::Ring<Felt, 2048> felt{};
};

std::uint32_t feel_tick(void* context, const device::TickInput& input, std::span<haptic::Wrench> wrenches) noexcept
{
    Feeling& f = *static_cast<Feeling*>(context);
    f.row.dt = input.dt;
    f.row.poses = input.sample.poses;
    f.row.twists = input.sample.twists;
    f.row.input =
        (input.sample.has_twist ? device::k_trace_measured_twist : 0u) | (input.degraded ? device::k_trace_degraded : 0u);
    f.setup.step(f.row);
    std::copy_n(f.row.computed.begin(), std::min(f.zones, wrenches.size()), wrenches.begin());
    std::copy_n(f.setup.pushes().begin(), std::min(f.zones, input.pushes.size()), input.pushes.begin());
    (void)f.felt.push({input.tick, f.row.contacts, f.row.input, f.row.depth, f.setup.device_depth()});
    return f.row.status;
}

/// A device, by the clock: the servo's thread ticks, this one records.
Totals feel(device::Device& device, TouchSetup& setup, const device::ServoOptions& options, device::TraceWriter* writer,
            double seconds, bool glove)
{
    const std::size_t zones = device.capabilities().zones;
    const auto feeling = std::make_unique<Feeling>(setup, zones);
    Totals totals;
    {
        device::Servo servo(device, options, feel_tick, feeling.get());
        device::ServoTick tick;
        Felt newest;  // that was popped: of this tick or of a later one
        std::optional<double> begin;
        bool more = true;
        std::uint32_t told = 0, told_inside = 0;
        while (more) {
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
            if (entered()) servo.resume();
            while (more && servo.next(tick)) {
                // Ticks come in order on both ways; one that only one of them holds was idle, or dropped by the other. A device
                // may go while a tick runs: what was computed for it counts.
                while (newest.tick < tick.tick && feeling->felt.pop(newest)) {
                }
                const bool ran = newest.tick == tick.tick, idle = !ran && (!tick.connected || tick.sample.sequence == 0);
                const Felt felt = ran ? newest : Felt{.tick = tick.tick, .input = device::k_trace_idle};
                if (!begin) begin = tick.time;
                device::TraceRow row{.time = tick.time - *begin,
                                     .dt = tick.dt,
                                     .sequence = tick.sample.sequence,
                                     .buttons = tick.sample.buttons,
                                     .input = felt.input,
                                     .cpu = tick.cpu,
                                     .contacts = felt.contacts,
                                     .depth = felt.depth,
                                     .status = tick.status,
                                     .filter = haptic::bits(tick.safety),
                                     .poses = tick.sample.poses,
                                     .computed = tick.commanded,
                                     .sent = tick.sent};
                if (tick.sample.has_twist) row.twists = tick.sample.twists;
                totals.add(row, zones, felt.device_depth);
                totals.counted = tick.counted;
                if (tick.safety.faults != 0 && told == 0)
                    std::fprintf(stderr, "  no force from %.3f s on: %s%s\n", row.time, reasons(tick.safety.faults).c_str(),
                                 ::isatty(STDIN_FILENO) == 1 ? "; Enter goes on" : "");
                told = tick.safety.faults;
                if (const std::uint32_t more_inside = tick.safety.waiting & ~told_inside; more_inside != 0) {
                    told_inside |= more_inside;
                    for (std::size_t z = 0; z < zones; ++z)
                        if ((more_inside >> z & 1) != 0)
                            std::fprintf(stderr, "  %s is inside an object at %.3f s: no force until it is lifted out once\n",
                                         zone_name(z, zones, glove).c_str(), row.time);
                }
                totals.gone = !tick.connected;
                if (!ran && !idle)
                    ++totals.unknown;
                else if (writer != nullptr)
                    writer->push_wait(row);
                more = row.time < seconds;
            }
            more = more && !interrupted;
        }
        totals.servo = servo.counters();
    }
    return totals;
}

/// Before any thread runs: a process that owns the device is forked.
std::unique_ptr<device::Device> open_device(const Arguments& arguments)
{
    if (!arguments.own_process) return device::open_device(arguments.device);
    std::string spec = arguments.device;
    try {
        return device::keep_in_own_process([](void* context) { return device::open_device(*static_cast<std::string*>(context)); },
                                           &spec);
    } catch (const std::runtime_error& e) {
        throw device::DeviceError(e.what());
    }
}

/// A fake is never presented as hardware; some say so in their name.
const char* note(const device::Capabilities& capabilities)
{
    return capabilities.simulated && capabilities.name.find("no hardware") == std::string::npos ? " (no hardware)" : "";
}

/// What the filter refuses, with the option and the device's number.
std::string limit_above(const haptic::DeviceLimits& device, const haptic::SafetyOptions& options)
{
    const double force = device.max_force > 0 ? device.max_force : haptic::k_unknown_force,
                 torque = device.max_torque > 0 ? device.max_torque : haptic::k_unknown_torque;
    const bool is_force = options.force_limit && *options.force_limit > force;
    const bool told = is_force ? device.max_force > 0 : device.max_torque > 0;
    char text[200];
    std::snprintf(text, sizeof text,
                  "%s %g is more than the device holds: %g %s%s\n  cure: at most that, or none for the default",
                  is_force ? "--force-limit" : "--torque-limit", is_force ? *options.force_limit : *options.torque_limit,
                  is_force ? force : torque, is_force ? "N" : "N m",
                  told ? "" : ", the most for a device that does not say what it can hold");
    return text;
}

void touch(const Arguments& arguments)
{
    check_plot_name(arguments.plot);
    if (!arguments.plot.empty() && arguments.record.empty()) throw BadTouch("--plot draws what is recorded: add --record FILE");
    if (!arguments.record.empty()) device::check_recording(arguments.record);
    TouchOptions options = arguments.touch;
    check(options, "");
    for (const std::string& text : arguments.objects) options.objects.push_back(object_from(text));
    for (TouchObject& object : options.objects) {
        const io::MappedModel model(object.file);
        const model::Header& h = model.view().header;
        // One scale for all, so that objects keep their sizes to each other.
        if (&object == &options.objects.front())
            object.metres_per_unit = arguments.unit > 0 ? arguments.unit : arguments.size / (h.r_max * h.unit);
        else
            object.metres_per_unit = options.objects.front().metres_per_unit;
    }
    const device::DeviceSpec spec = device::parse_spec(arguments.device);
    const bool glove = spec.kind == "glove";
    const bool over = k_scripts.contains(spec.kind) || spec.kind == "simulated" || glove;
    if (glove) options.hand_length = spec.number("length", options.hand_length, 0.05, 0.4);
    HandPath hand;
    std::unique_ptr<device::Device> device;
    if (!over) device = open_device(arguments);
    const auto setup = std::make_unique<TouchSetup>(options, glove  ? device::k_glove_zones
                                                             : over ? 1
                                                                    : device->capabilities().zones);
    if (over) device = device_over(spec, *setup, arguments.seconds, hand);
    const device::Capabilities& capabilities = device->capabilities();

    std::printf("%s%s, %zu zone%s; R_max of %s is %.4g m\n", capabilities.name.c_str(), note(capabilities), capabilities.zones,
                capabilities.zones == 1 ? "" : "s", options.objects.front().file.c_str(),
                static_cast<double>(setup->first_model().header.r_max) * setup->first_model().header.unit);
    const haptic::DeviceLimits limits = device::safety_limits(capabilities, arguments.servo.period);
    const bool path = dynamic_cast<device::PathDevice*>(device.get()) != nullptr;
    setup->suit(path ? nullptr : &limits);
    const double stiffness = setup->options().zone.stiffness;
    const haptic::ZoneOptions& zone = setup->options().zone;
    const haptic::StiffnessCheck check = haptic::check_stiffness(limits, stiffness, zone.damping + zone.brake);
    for (const std::string& note : setup->notes()) std::printf("  %s\n", note.c_str());
    device::ServoOptions servo = arguments.servo;
    servo.safety.softest = softest_spring(setup->options());
    if (!path && !check.safe && options.zone.mode != haptic::Mode::Coupled)
        std::printf("  warning: this device can show %.0f N/m without ever giving energy (%s)%s; asked for %.0f\n", check.largest,
                    haptic::describe(check.reason), check.assumed ? ", with careful numbers where it tells none" : "", stiffness);
    if (!capabilities.simulated && !capabilities.force_out && !capabilities.torque_out && !capabilities.rumble_out)
        std::printf("  warning: this device says that it exerts nothing: what is sent is computed and not felt\n");
    if (arguments.own_process && over) std::printf("  warning: --own-process is for hardware: this device needs none\n");
    if (path && arguments.servo.priority > 0) std::printf("  warning: --priority is of the servo: a path has no clock\n");
    // Paths tick as fast as they were made, devices as fast as the servo.
    const haptic::SafetyFilter filter(path ? device::safety_limits(capabilities, 1 / capabilities.rate) : limits, servo.safety);
    if (filter.verdict() == haptic::SetupVerdict::LimitAboveDevice) throw BadTouch(limit_above(limits, servo.safety));

    std::optional<device::TraceWriter> writer;
    if (!arguments.record.empty())
        writer.emplace(arguments.record, device::TraceHeader{.zones = capabilities.zones,
                                                             .fields = {{"made-by", "sqmap " SQMAP_VERSION},
                                                                        {"device", capabilities.name + note(capabilities)},
                                                                        {"simulated", capabilities.simulated ? "yes" : "no"},
                                                                        {"setup", setup_text(setup->options())}}});
    struct sigaction action {};
    action.sa_handler = interrupt;
    ::sigaction(SIGINT, &action, nullptr);
    ::sigaction(SIGTERM, &action, nullptr);
    device::TraceWriter* const out = writer ? &*writer : nullptr;
    const double seconds = over || !arguments.all_of_it ? arguments.seconds : INFINITY;
    const Totals totals =
        path ? play(*device, *setup, servo.safety, out, seconds) : feel(*device, *setup, servo, out, arguments.seconds, glove);
    device.reset();
    std::printf("%llu ticks, %llu in contact; deepest %.4g m, largest force asked for %.4g N\n",
                static_cast<unsigned long long>(totals.ticks), static_cast<unsigned long long>(totals.contact), totals.deepest,
                totals.largest_force);
    if (totals.ticks > 0)
        std::printf("  sent: at most %.4g N of %.4g N allowed; the safety filter changed what was asked for in %llu ticks\n",
                    totals.largest_sent, filter.force_limit(), static_cast<unsigned long long>(totals.changed));
    if (totals.ticks > 0 && totals.contact == 0)
        std::fprintf(stderr, "warning: nothing was touched%s\n",
                     options.zone_radius > 0
                         ? ": what touches may lie outside the impact zone\n  cure: a larger --zone, or 0 for the whole tool"
                         : "");
    if (totals.ticks > 0)
        std::printf("  CPU time a tick: mean %.1f us, most %.1f us\n", 1e6 * totals.cpu / static_cast<double>(totals.ticks),
                    1e6 * totals.max_cpu);
    if (!path)
        std::printf("  %llu ticks late by more than one, %llu degraded, worst %.2f ms late; not recorded: %llu\n",
                    static_cast<unsigned long long>(totals.servo.late), static_cast<unsigned long long>(totals.servo.degraded),
                    1e3 * totals.servo.worst_late, static_cast<unsigned long long>(totals.servo.dropped + totals.unknown));
    print_glitches(totals.counted);
    if (totals.hot > 0 || totals.braked > 0)
        std::printf("  the safety filter held force back in %llu ticks for the motors' heat, in %llu for passivity\n",
                    static_cast<unsigned long long>(totals.hot), static_cast<unsigned long long>(totals.braked));
    if (totals.faulty > 0)
        std::printf("  the safety filter let no force through in %llu ticks, first at %.3f s: %s\n",
                    static_cast<unsigned long long>(totals.faulty), totals.first_fault, reasons(totals.faults).c_str());
    for (std::size_t z = 0; z < capabilities.zones; ++z)
        if (const Inside& in = totals.inside[z]; in.ticks > 0)
            std::printf("  %s was inside an object when forces were to begin, and had none in %llu ticks, from %.3f s to %s\n",
                        zone_name(z, capabilities.zones, glove).c_str(), static_cast<unsigned long long>(in.ticks), in.first,
                        in.now ? "the end" : milliseconds(in.last).c_str());
    if (std::any_of(totals.inside.begin(), totals.inside.end(), [](const Inside& in) { return in.ticks > 0; }))
        std::printf("  cure: start outside, or lift it out of the object once; force then comes in over half a second\n");
    if (totals.gone) std::printf("  the device was gone at the end\n");
    if (!writer) return;
    writer->finish();
    std::printf("recorded in %s%s\n", arguments.record.c_str(),
                writer->dropped() > 0 ? (", " + std::to_string(writer->dropped()) + " rows dropped").c_str() : "");
    if (!arguments.plot.empty()) plot_trace(arguments.record, arguments.plot);
}

}  // namespace

void add_touch(CLI::App& app, int& exit_code)
{
    const auto arguments = std::make_shared<Arguments>();
    CLI::App* command = app.add_subcommand("touch", "Touch models with a device, a scripted or a recorded path, and record it");
    command->add_option("--object", arguments->objects, "Models (.sqmap); FILE@X,Y,Z puts the model's origin there, m")
        ->required();
    command
        ->add_option("--tool", arguments->touch.tool,
                     "sphere[:RADIUS, m], point[:RADIUS of its smoothing, m] or a mesh; with a glove a glTF hand of 25 joints")
        ->capture_default_str();
    command
        ->add_option("--tool-spacing", arguments->touch.tool_spacing,
                     "m; larger triangles of a mesh as tool are divided, so that it is felt between its vertices too; 0: not")
        ->check(in_range(0., 1.));
    arguments->touch.tool_touching = 1200;  // a trace that does not say has none
    command
        ->add_option("--tool-touching", arguments->touch.tool_touching,
                     "A mesh as tool without --tool-spacing is felt with ever more points, to 1.5 mm, while no more than so many "
                     "touch; 0: with its vertices")
        ->check(in_range(0., 1e5))
        ->capture_default_str();
    command->add_option("--tool-size", arguments->touch.tool_size, "R_max, m, that a mesh as tool is scaled to")
        ->check(above_zero())
        ->capture_default_str();
    command
        ->add_option("--device", arguments->device,
                     "KIND[:ARGS]. Without hardware: press, tap, slide, circle (speed, depth, gap, radius, direction=X/Y/Z, "
                     "travel, rate, wait), path:FILE, trace:FILE, simulated[:press...][,hand=], glove. Others: see sqmap devices")
        ->capture_default_str();
    auto* const size = command->add_option("--scale", arguments->size, "Scale all objects so that the first has this R_max, m")
                           ->check(above_zero(1000))
                           ->capture_default_str();
    command->add_option("--unit", arguments->unit, "Or take a mesh unit as this many metres")
        ->transform(CLI::Transformer(std::map<std::string, double>{{"mm", 1e-3}, {"cm", 1e-2}, {"m", 1.0}, {"in", 0.0254}}))
        ->check(above_zero())
        ->excludes(size);
    const auto* const seconds =
        command->add_option("--seconds", arguments->seconds, "How long; of path: and trace: all, unless said")
            ->check(above_zero())
            ->capture_default_str();
    command->add_option("--record", arguments->record, "Trace to write (CSV, see docs/trace-format.md)");
    command->add_option("--plot", arguments->plot, "Draw the recording: depth, force, torque, CPU time (SVG)");
    add_force_options(*command, arguments->touch);
    const std::string safety = "Safety (a filter that is always on)";
    command->add_option("--force-limit", arguments->servo.safety.force_limit, "N; default: 2, or the device's most if less")
        ->check(above_zero())
        ->group(safety);
    command->add_option("--torque-limit", arguments->servo.safety.torque_limit, "N m; default: 0.1, or the device's most if less")
        ->check(above_zero())
        ->group(safety);
    command
        ->add_flag("--own-process", arguments->own_process,
                   "A small process owns the device and lets it go when this one is killed")
        ->group(safety);
    command->add_option("--priority", arguments->servo.priority, "SCHED_FIFO of the servo, see sqmap rtcheck; 0: none")
        ->check(in_range(0, 98))
        ->capture_default_str()
        ->group(safety);
    command->footer("Exit code: 0 done, 2 bad model, tool, device or file, 64 wrong usage, 70 internal error.");
    const auto* const stiffness = command->get_option("--stiffness");
    command->callback([arguments, command, &exit_code, seconds, stiffness] {
        arguments->all_of_it = seconds->count() == 0;
        arguments->touch.stiffness_wished = stiffness->count() > 0;
        warn_of_idle(*command, arguments->touch);
        exit_code = 2;
        try {
            touch(*arguments);
            exit_code = 0;
        } catch (const BadTouch& e) {
            std::fprintf(stderr, "%s\n", e.what());
        } catch (const device::DeviceError& e) {
            std::fprintf(stderr, "%s\n", e.what());
        } catch (const std::invalid_argument& e) {  // limits or a priority that the servo refuses
            std::fprintf(stderr, "%s\n", e.what());
        } catch (const std::system_error& e) {
            std::fprintf(stderr, "%s\n", e.what());
        } catch (const device::TraceError& e) {
            std::fprintf(stderr, "%s\n", e.what());
        } catch (const io::ModelFileError& e) {
            std::fprintf(stderr, "%s\n", e.what());
        }
    });
}

}  // namespace sqmap::app
