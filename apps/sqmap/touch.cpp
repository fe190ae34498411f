// sqmap touch: a device, real or scripted, touches models; every tick can be recorded.
#include "commands.h"
#include "sqmap/device/open.h"
#include "sqmap/device/path.h"
#include "sqmap/device/trace.h"
#include "sqmap/haptic/safety.h"
#include "strip_chart.h"
#include "touch_setup.h"

#include <time.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <map>
#include <optional>
#include <thread>

namespace sqmap::app {
namespace {

struct Arguments {
    std::vector<std::string> objects;
    std::string device = "press", record, plot;
    double unit = 0, size = 0.3, seconds = 10;
    TouchOptions touch;
};

const std::map<std::string, device::Script> k_scripts{{"press", device::Script::Press},
                                                      {"tap", device::Script::Tap},
                                                      {"slide", device::Script::Slide},
                                                      {"circle", device::Script::Circle}};

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
    const char* c = text.data() + at + 1;
    const char* const last = text.data() + text.size();
    for (int i = 0; i < 3; ++i) {
        const auto [end, error] = std::from_chars(c, last, object.place[i]);
        if (error != std::errc() || !std::isfinite(object.place[i]) || (i < 2 ? end == last || *end != ',' : end != last))
            throw BadTouch("--object " + text + ": a place is three numbers, as in bunny.sqmap@0.1,0,0");
        c = end + 1;
    }
    object.file.resize(at);
    return object;
}

Vec3d vector_option(const device::DeviceSpec& spec, const char* name, Vec3d otherwise)
{
    const std::string text = spec.text(name, "");
    if (text.empty()) return otherwise;
    // Commas part options, so a direction is written with blanks or slashes between its numbers.
    Vec3d v;
    const char* c = text.data();
    const char* const last = c + text.size();
    for (int i = 0; i < 3; ++i) {
        const auto [end, error] = std::from_chars(c, last, v[i]);
        if (error != std::errc() || !std::isfinite(v[i]) || (i < 2 ? end == last || (*end != '/' && *end != ' ') : end != last))
            throw device::DeviceError(std::string(name) + " is three numbers with slashes between them, as in 0/0/1");
        c = end + 1;
    }
    return v;
}

std::unique_ptr<device::Device> scripted(const device::DeviceSpec& spec, const TouchSetup& setup, double seconds)
{
    spec.allow({"speed", "depth", "gap", "radius", "direction", "travel", "rate"});
    device::ScriptOptions o;
    o.seconds = seconds;
    o.rate = spec.number("rate", o.rate, 1, 1e5);
    o.speed = spec.number("speed", o.speed, 1e-6, 1e3);
    o.depth = spec.number("depth", o.depth, -1, 1);
    o.gap = spec.number("gap", o.gap, -1, 1);
    o.radius = spec.number("radius", o.radius, 1e-6, 1e3);
    o.direction = vector_option(spec, "direction", o.direction);
    o.travel = vector_option(spec, "travel", o.travel);
    std::vector<haptic::Pose> poses = device::scripted_path(setup.first_model(), setup.tool(), k_scripts.at(spec.kind), o);
    for (haptic::Pose& pose : poses) pose = query::compose(setup.first_pose(), pose);
    return std::make_unique<device::PathDevice>("scripted " + spec.kind, std::move(poses), o.rate);
}

struct Totals {
    std::uint64_t ticks = 0, contact = 0, stale = 0;
    double largest_force = 0, deepest = 0, cpu = 0, most_cpu = 0;
    bool gone = false;

    void add(const device::TraceRow& row, std::size_t zones)
    {
        ++ticks;
        contact += row.contacts > 0;
        for (std::size_t z = 0; z < zones; ++z) largest_force = std::max(largest_force, norm(row.computed[z].force));
        deepest = std::max(deepest, row.depth);
        cpu += row.cpu;
        most_cpu = std::max(most_cpu, row.cpu);
    }
};

haptic::DeviceLimits limits_of(const device::Capabilities& c)
{
    return {.max_force = c.max_force,
            .max_torque = c.max_torque,
            .continuous_force = c.continuous_force,
            .damping = c.damping,
            .coulomb_friction = c.coulomb_friction,
            .resolution = c.resolution,
            .delay = c.delay,
            .sample_period = c.rate > 0 ? 1 / c.rate : 1e-3};
}

/// One tick from a reading to what is sent: the row holds everything that happened.
class Ticker {
public:
    Ticker(TouchSetup& setup, const device::Capabilities& capabilities)
        : setup_(setup), zones_(capabilities.zones), filter_(limits_of(capabilities), {})
    {
    }

    void operator()(const device::Sample& sample, double time, bool connected, device::TraceRow& row) noexcept
    {
        const double begin = thread_cpu();
        row.sequence = sample.sequence;
        row.buttons = sample.buttons;
        row.input = sample.has_twist ? device::k_trace_measured_twist : 0u;
        row.poses = sample.poses;
        row.twists = sample.has_twist ? sample.twists : decltype(row.twists){};
        setup_.step(row);
        haptic::SafetyInput in{.time = time,
                               .sample_time = sample.time,
                               .sequence = sample.sequence,
                               .poses = {row.poses.data(), zones_},
                               .asked = {row.computed.data(), zones_},
                               .connected = connected};
        if (sample.has_twist) in.twists = {row.twists.data(), zones_};
        const haptic::SafetyReport report = filter_.tick(in, {row.sent.data(), zones_});
        row.filter = report.acted | report.faults << 16;
        row.cpu = thread_cpu() - begin;
    }

    [[nodiscard]] const haptic::SafetyFilter& filter() const { return filter_; }

private:
    TouchSetup& setup_;
    std::size_t zones_;
    haptic::SafetyFilter filter_;
};

/// A path: every pose once, no clock, so that the same path gives the same trace.
Totals play(device::Device& path, TouchSetup& setup, device::TraceWriter* writer)
{
    const std::size_t zones = path.capabilities().zones;
    Ticker tick(setup, path.capabilities());
    Totals totals;
    device::Sample sample;
    device::TraceRow row;
    row.dt = 1 / path.capabilities().rate;
    while (!interrupted && path.read(sample)) {
        row.time = sample.time;
        tick(sample, sample.time, true, row);
        path.write({row.sent.data(), zones});
        totals.add(row, zones);
        if (writer != nullptr) writer->push_wait(row);
    }
    return totals;
}

/// A device: a tick a millisecond by the clock.
Totals feel(device::Device& device, TouchSetup& setup, device::TraceWriter* writer, double seconds)
{
    using Clock = std::chrono::steady_clock;
    const std::size_t zones = device.capabilities().zones;
    Ticker tick(setup, device.capabilities());
    Totals totals;
    device::Sample sample;
    device::TraceRow row;
    const Clock::time_point begin = Clock::now();
    Clock::time_point next = begin, last = begin - std::chrono::milliseconds(1);
    while (!interrupted && next - begin < std::chrono::duration<double>(seconds)) {
        const Clock::time_point now = Clock::now();
        row.time = std::chrono::duration<double>(now - begin).count();
        row.dt = std::chrono::duration<double>(now - last).count();
        last = now;
        const std::uint64_t before = sample.sequence;
        const bool connected = device.read(sample);
        totals.stale += sample.sequence == before;
        tick(sample, std::chrono::duration<double>(now.time_since_epoch()).count(), connected, row);
        totals.gone = !device.write({row.sent.data(), zones}) || !connected;
        totals.add(row, zones);
        if (writer != nullptr) (void)writer->push(row);
        next += std::chrono::milliseconds(1);
        std::this_thread::sleep_until(next);
    }
    device.zero();
    return totals;
}

void touch(const Arguments& arguments)
{
    if (!arguments.plot.empty() && arguments.record.empty()) throw BadTouch("--plot draws what is recorded: add --record FILE");
    TouchOptions options = arguments.touch;
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
    const bool scripts = k_scripts.contains(spec.kind);
    std::unique_ptr<device::Device> device;
    std::unique_ptr<TouchSetup> setup;
    if (!scripts) device = device::open_device(arguments.device);
    setup = std::make_unique<TouchSetup>(options, scripts ? 1 : device->capabilities().zones);
    if (scripts) device = scripted(spec, *setup, arguments.seconds);
    const device::Capabilities& capabilities = device->capabilities();

    std::printf("%s%s, %zu zone%s; R_max of %s is %.4g m\n", capabilities.name.c_str(),
                capabilities.simulated ? " (no hardware)" : "", capabilities.zones, capabilities.zones == 1 ? "" : "s",
                options.objects.front().file.c_str(),
                static_cast<double>(setup->first_model().header.r_max) * setup->first_model().header.unit);
    const haptic::StiffnessCheck check =
        haptic::check_stiffness(limits_of(capabilities), options.zone.stiffness, options.zone.damping);
    const bool path = dynamic_cast<device::PathDevice*>(device.get()) != nullptr;
    if (!path && !check.safe)
        std::printf("  warning: this device can show %.0f N/m without ever giving energy (%s)%s; asked for %.0f\n", check.largest,
                    haptic::describe(check.reason), check.assumed ? ", with careful numbers where it tells none" : "",
                    options.zone.stiffness);

    std::optional<device::TraceWriter> writer;
    if (!arguments.record.empty())
        writer.emplace(arguments.record, device::TraceHeader{.zones = capabilities.zones,
                                                             .fields = {{"made-by", "sqmap " SQMAP_VERSION},
                                                                        {"device", capabilities.name},
                                                                        {"simulated", capabilities.simulated ? "yes" : "no"},
                                                                        {"setup", setup_text(setup->options())}}});
    struct sigaction action {};
    action.sa_handler = interrupt;
    ::sigaction(SIGINT, &action, nullptr);
    ::sigaction(SIGTERM, &action, nullptr);
    device::TraceWriter* const out = writer ? &*writer : nullptr;
    const Totals totals = path ? play(*device, *setup, out) : feel(*device, *setup, out, arguments.seconds);
    device.reset();
    std::printf("%llu ticks, %llu in contact; deepest %.4g m, largest force %.4g N\n",
                static_cast<unsigned long long>(totals.ticks), static_cast<unsigned long long>(totals.contact), totals.deepest,
                totals.largest_force);
    if (totals.ticks > 0)
        std::printf("  CPU time a tick: mean %.1f us, most %.1f us\n", 1e6 * totals.cpu / static_cast<double>(totals.ticks),
                    1e6 * totals.most_cpu);
    if (!path && totals.stale > 0)
        std::printf("  %llu ticks without a fresh pose\n", static_cast<unsigned long long>(totals.stale));
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
    command->add_option("--tool", arguments->touch.tool, "sphere[:RADIUS, m], point[:RADIUS of its smoothing, m] or a mesh")
        ->capture_default_str();
    command->add_option("--tool-size", arguments->touch.tool_size, "R_max, m, that a mesh as tool is scaled to")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    command
        ->add_option("--device", arguments->device,
                     "KIND[:ARGS]. Without hardware: press, tap, slide, circle (speed, depth, gap, radius, direction=X/Y/Z, "
                     "travel, rate), path:FILE, trace:FILE. Others: see sqmap devices")
        ->capture_default_str();
    auto* const size = command->add_option("--scale", arguments->size, "Scale all objects so that the first has this R_max, m")
                           ->check(CLI::PositiveNumber)
                           ->capture_default_str();
    command->add_option("--unit", arguments->unit, "Or take a mesh unit as this many metres")
        ->transform(CLI::Transformer(std::map<std::string, double>{{"mm", 1e-3}, {"cm", 1e-2}, {"m", 1.0}, {"in", 0.0254}}))
        ->check(CLI::PositiveNumber)
        ->excludes(size);
    command->add_option("--seconds", arguments->seconds, "How long")->check(CLI::PositiveNumber)->capture_default_str();
    command->add_option("--record", arguments->record, "Trace to write (CSV, see docs/trace-format.md)");
    command->add_option("--plot", arguments->plot, "Draw the recording: depth, force, torque, CPU time (SVG)");
    add_force_options(*command, arguments->touch);
    command->footer("Exit code: 0 done, 2 bad model, tool, device or file, 64 wrong usage, 70 internal error.");
    command->callback([arguments, &exit_code] {
        exit_code = 2;
        try {
            touch(*arguments);
            exit_code = 0;
        } catch (const BadTouch& e) {
            std::fprintf(stderr, "%s\n", e.what());
        } catch (const device::DeviceError& e) {
            std::fprintf(stderr, "%s\n", e.what());
        } catch (const device::TraceError& e) {
            std::fprintf(stderr, "%s\n", e.what());
        } catch (const io::ModelFileError& e) {
            std::fprintf(stderr, "%s\n", e.what());
        }
    });
}

}  // namespace sqmap::app
