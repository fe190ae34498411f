// sqmap touch: a device, real or scripted, touches models; every tick can be recorded.
#include "commands.h"
#include "device/hand.h"
#include "device/own_process.h"
#include "sqmap/device/open.h"
#include "sqmap/device/path.h"
#include "sqmap/device/servo.h"
#include "sqmap/device/trace.h"
#include "sqmap/haptic/safety.h"
#include "sqmap/paper/model_file.h"
#include "three_numbers.h"
#include "touch/force_options.h"
#include "touch/over_model.h"
#include "touch/run.h"
#include "touch/setup.h"
#include "touch/strip_chart.h"
#include "touch/totals.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>

namespace sqmap::app {
namespace {

struct TouchArguments {
    std::vector<std::string> objects;
    std::string device = "press", record, plot;
    double unit = 0, size = 0.3, seconds = 10;
    bool own_process = false;
    bool all_of_it = true;  ///< of a recorded path: nobody said for how long
    TouchOptions touch;
    device::ServoOptions servo;
};

/// FILE or FILE@X,Y,Z.
TouchObject object_from(const std::string& text)
{
    TouchObject object{.file = text};
    const std::size_t at = text.rfind('@');
    if (at == std::string::npos) return object;
    const std::optional<Vec3d> position = three_numbers(std::string_view(text).substr(at + 1));
    if (!position || !(std::max({std::fabs(position->x), std::fabs(position->y), std::fabs(position->z)}) <= 1000))
        throw BadTouch("--object " + text + ": a position is three numbers of at most 1000 m, as in bunny.sqmap@0.1,0,0");
    object.position = *position;
    object.file.resize(at);
    return object;
}

/// Before any thread runs: a process that owns the device is forked.
std::unique_ptr<device::Device> open_device(const TouchArguments& arguments)
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

/// Says which limit the filter refuses, with the option and the device's number.
std::string limit_above(const haptic::DeviceLimits& device, const haptic::SafetyOptions& options)
{
    const double force = device.max_force > 0 ? device.max_force : haptic::k_unknown_force,
                 torque = device.max_torque > 0 ? device.max_torque : haptic::k_unknown_torque;
    const bool is_force = options.force_limit && *options.force_limit > force;
    const bool stated = is_force ? device.max_force > 0 : device.max_torque > 0;
    char text[200];
    std::snprintf(text, sizeof text,
                  "%s %g is more than the device holds: %g %s%s\n  cure: at most that, or none for the default",
                  is_force ? "--force-limit" : "--torque-limit", is_force ? *options.force_limit : *options.torque_limit,
                  is_force ? force : torque, is_force ? "N" : "N m",
                  stated ? "" : ", the most for a device that does not say what it can hold");
    return text;
}

/// The objects and the tool as the arguments give them, checked before any device is opened.
TouchOptions options_of(const TouchArguments& arguments)
{
    TouchOptions options = arguments.touch;
    check(options, "");
    for (const std::string& text : arguments.objects) options.objects.push_back(object_from(text));
    for (TouchObject& object : options.objects) {
        const paper::MappedModel model(object.file);
        const model::Header& h = model.view().header;
        // One scale for all, so that objects keep their sizes to each other.
        if (&object == &options.objects.front())
            object.metres_per_unit = arguments.unit > 0 ? arguments.unit : arguments.size / (h.r_max * h.unit);
        else
            object.metres_per_unit = options.objects.front().metres_per_unit;
    }
    return options;
}

/// The device, what it touches, and how its forces are limited.
struct Session {
    bool over = false, glove = false;  ///< a device over the model; the simulated glove
    bool path = false;                 ///< poses without a clock
    HandPath hand;                     // what the device points at
    std::unique_ptr<device::Device> device;
    std::unique_ptr<TouchSetup> setup;
    haptic::DeviceLimits limits;
    device::ServoOptions servo;
};

/// @throw BadTouch, device::DeviceError
std::unique_ptr<Session> open(const TouchArguments& arguments)
{
    TouchOptions options = options_of(arguments);
    auto s = std::make_unique<Session>();
    const device::DeviceSpec spec = device::parse_spec(arguments.device);
    s->glove = spec.kind == "glove";
    s->over = is_over_model(spec.kind);
    if (s->glove) options.hand_length = spec.number("length", options.hand_length, 0.05, 0.4);
    if (!s->over) s->device = open_device(arguments);
    const std::size_t zones = s->glove ? device::k_glove_zones : s->over ? 1 : s->device->capabilities().zones;
    s->setup = std::make_unique<TouchSetup>(options, zones);
    if (s->over) s->device = device_over(spec, *s->setup, arguments.seconds, s->hand);
    s->limits = device::safety_limits(s->device->capabilities(), arguments.servo.period);
    s->path = dynamic_cast<device::PathDevice*>(s->device.get()) != nullptr;
    s->setup->suit(s->path ? nullptr : &s->limits);
    s->servo = arguments.servo;
    s->servo.safety.softest = softest_spring(s->setup->options());
    return s;
}

void print(const Session& s, const TouchArguments& arguments)
{
    const device::Capabilities& capabilities = s.device->capabilities();
    const TouchOptions& options = s.setup->options();
    const model::Header& first = s.setup->first_model().header;
    std::printf("%s%s, %zu zone%s; R_max of %s is %.4g m\n", capabilities.name.c_str(), note(capabilities), capabilities.zones,
                capabilities.zones == 1 ? "" : "s", options.objects.front().file.c_str(),
                static_cast<double>(first.r_max) * first.unit);
    const double stiffness = options.zone.stiffness;
    const haptic::StiffnessCheck check = haptic::check_stiffness(s.limits, stiffness, options.zone.damping + options.zone.brake);
    for (const std::string& note : s.setup->notes()) std::printf("  %s\n", note.c_str());
    if (!s.path && !check.safe && options.zone.mode != haptic::Mode::Coupled)
        std::printf("  warning: this device can show %.0f N/m without ever giving energy (%s)%s; requested: %.0f\n",
                    check.largest, haptic::describe(check.reason),
                    check.assumed ? ", with careful numbers where it tells none" : "", stiffness);
    if (!capabilities.simulated && !capabilities.force_out && !capabilities.torque_out && !capabilities.rumble_out)
        std::printf("  warning: this device says that it exerts nothing: what is sent is computed and not felt\n");
    if (arguments.own_process && s.over) std::printf("  warning: --own-process is for hardware: this device needs none\n");
    if (s.path && arguments.servo.priority > 0) std::printf("  warning: --priority is of the servo: a path has no clock\n");
}

void touch(const TouchArguments& arguments)
{
    check_plot_name(arguments.plot);
    if (!arguments.plot.empty() && arguments.record.empty()) throw BadTouch("--plot draws what is recorded: add --record FILE");
    if (!arguments.record.empty()) device::check_recording(arguments.record);
    const std::unique_ptr<Session> s = open(arguments);
    const device::Capabilities capabilities = s->device->capabilities();
    print(*s, arguments);
    // Paths tick as fast as they were made, devices as fast as the servo.
    const haptic::SafetyFilter filter(s->path ? device::safety_limits(capabilities, 1 / capabilities.rate) : s->limits,
                                      s->servo.safety);
    if (filter.setup_status() == haptic::SetupStatus::LimitAboveDevice) throw BadTouch(limit_above(s->limits, s->servo.safety));

    std::optional<device::TraceWriter> writer;
    if (!arguments.record.empty())
        writer.emplace(arguments.record, device::TraceHeader{.zones = capabilities.zones,
                                                             .fields = {{"made-by", "sqmap " SQMAP_VERSION},
                                                                        {"device", capabilities.name + note(capabilities)},
                                                                        {"simulated", capabilities.simulated ? "yes" : "no"},
                                                                        {"setup", setup_text(s->setup->options())}}});
    catch_interrupts();
    const bool whole_path = s->path && !s->over && arguments.all_of_it;
    const RunOptions run{
        .seconds = whole_path ? INFINITY : arguments.seconds, .writer = writer ? &*writer : nullptr, .glove = s->glove};
    const Totals totals =
        s->path ? play(*s->device, *s->setup, s->servo.safety, run) : run_servo(*s->device, *s->setup, s->servo, run);
    s->device.reset();
    print(totals, {.zones = capabilities.zones,
                   .glove = s->glove,
                   .by_the_clock = !s->path,
                   .has_impact_zone = s->setup->options().zone_radius > 0,
                   .force_limit = filter.force_limit()});
    if (!writer) return;
    writer->finish();
    std::printf("recorded in %s%s\n", arguments.record.c_str(),
                writer->dropped() > 0 ? (", " + std::to_string(writer->dropped()) + " rows dropped").c_str() : "");
    if (!arguments.plot.empty()) plot_trace(arguments.record, arguments.plot);
}

void add_safety_options(Command safety, TouchArguments& arguments)
{
    safety.option("--force-limit", arguments.servo.safety.force_limit, "N; default: 2, or the device's most if less")
        .above_zero();
    safety.option("--torque-limit", arguments.servo.safety.torque_limit, "N m; default: 0.1, or the device's most if less")
        .above_zero();
    safety.flag("--own-process", arguments.own_process, "A small process owns the device and lets it go when this one is killed");
    safety.option("--priority", arguments.servo.priority, "SCHED_FIFO of the servo, see sqmap rtcheck; 0: none").in_range(0, 98);
}

}  // namespace

void add_touch(CommandLine& line)
{
    const auto arguments = std::make_shared<TouchArguments>();
    Command command = line.add("touch", "Touch models with a device, a scripted or a recorded path, and record it");
    command.option("--object", arguments->objects, "Models (.sqmap); FILE@X,Y,Z puts the model's origin there, m").required();
    command.option("--tool", arguments->touch.tool,
                   "sphere[:RADIUS, m], point[:RADIUS of its smoothing, m] or a mesh; with a glove a glTF hand of 25 joints");
    command
        .option("--tool-spacing", arguments->touch.tool_spacing,
                "m; larger triangles of a mesh as tool are divided, so that it is felt between its vertices too; 0: not")
        .in_range(0., 1.);
    arguments->touch.tool_touching = 1200;  // a trace that does not say has none
    command
        .option("--tool-touching", arguments->touch.tool_touching,
                "A mesh as tool without --tool-spacing is felt with ever more points, to 1.5 mm, while no more than so many "
                "touch; 0: with its vertices")
        .in_range(0., 1e5)
        .shows_default("1200, or 300 on a paper model");
    command.flag("--edges", arguments->touch.edges,
                 "Edges and faces of a mesh as tool touch too, not its points alone: a ridge is felt between two points");
    command.option("--tool-size", arguments->touch.tool_size, "R_max, m, that a mesh as tool is scaled to").above_zero();
    command.option("--device", arguments->device,
                   "KIND[:ARGS]. Without hardware: press, tap, slide, circle (speed, depth, gap, radius, direction=X/Y/Z, "
                   "travel, rate, wait), path:FILE, trace:FILE, simulated[:press...][,hand=], glove. Others: see sqmap devices");
    const Option size =
        command.option("--scale", arguments->size, "Scale all objects so that the first has this R_max, m").above_zero(1000);
    command
        .unit(
            "--unit", [arguments](double metres) { arguments->unit = metres; }, "Or take a mesh unit as this many metres")
        .excludes(size);
    command.option("--seconds", arguments->seconds, "How long; of path: and trace: all, unless said").above_zero();
    command.option("--record", arguments->record, "Trace to write (CSV, see docs/trace-format.md)");
    command.option("--plot", arguments->plot, "Draw the recording: depth, force, torque, CPU time (SVG)");
    add_force_options(command, arguments->touch);
    add_safety_options(command.titled("Safety (a filter that is always on)"), *arguments);
    command.footer("Exit code: 0 done, 2 bad model, tool, device or file, 64 wrong usage, 70 internal error.");
    // Limits or a priority that the servo refuses are invalid arguments.
    command.run<BadTouch, device::DeviceError, std::invalid_argument, std::system_error, device::TraceError, io::ModelFileError>(
        [arguments, command] {
            arguments->all_of_it = !command.given("--seconds");
            arguments->touch.touching_wished = command.given("--tool-touching");
            arguments->touch.stiffness_wished = command.given("--stiffness");
            finish_force_options(command, arguments->touch);
            warn_of_idle(command, arguments->touch);
            touch(*arguments);
            return 0;
        });
}

}  // namespace sqmap::app
