// sqmap replay: computes the forces of a recording anew and compares them with what was recorded, to the bit.
#include "commands.h"
#include "parallel/for_each.h"
#include "sqmap/device/trace.h"
#include "touch/page_replay.h"
#include "touch/replayed.h"
#include "touch/setup.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace sqmap::app {

void print_difference_head()
{
    std::printf("line,time,columns,recorded_depth,depth,recorded_force,force,force_difference,torque_difference\n");
}

void add_difference(Replayed& replayed, const Difference& d, bool rows)
{
    if (replayed.different++ == 0) {
        replayed.first_line = d.line;
        replayed.first_time = d.time;
        replayed.first_columns = d.columns;
    }
    replayed.largest_force = std::max(replayed.largest_force, d.force_apart);
    replayed.largest_torque = std::max(replayed.largest_torque, d.torque_apart);
    replayed.largest_depth = std::max(replayed.largest_depth, std::abs(d.depth[1] - d.depth[0]));
    replayed.sum_force_sq += d.force_apart * d.force_apart;
    if (rows)
        std::printf("%zu,%.9g,%s,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n", d.line, d.time, d.columns.c_str(), d.depth[0], d.depth[1],
                    d.force[0], d.force[1], d.force_apart, d.torque_apart);
}

namespace {

/// rows: prints the rows that differ. computed: receives the recomputed trace; may be null. Threads share nothing: each call has
/// its own setup, reader and state.
Replayed replay(const ReplayArguments& arguments, const TouchOptions& options, bool rows, Comparison* computed)
{
    device::TraceReader reader(arguments.trace);
    const std::size_t zones = reader.header().zones;
    TouchSetup setup(options, zones, std::filesystem::absolute(arguments.trace).parent_path());
    Replayed o;
    device::TraceRow recorded;
    double time = -INFINITY;
    if (rows) print_difference_head();
    while (reader.next(recorded)) {
        // A pose or a force may be NaN, as in a recording of a fault; a clock never is, nor does it run back.
        if (!std::isfinite(recorded.time) || recorded.time < time || !std::isfinite(recorded.dt) || recorded.dt < 0)
            throw BadTouch(
                arguments.trace + ":" + std::to_string(reader.line()) +
                ": time must be finite and not run back, dt finite and not below 0\n  cure: record again, or remove the row "
                "and count the last line's rows anew");
        constexpr std::uint32_t k_inputs = device::k_trace_measured_twist | device::k_trace_degraded | device::k_trace_idle;
        if ((recorded.input & ~k_inputs) != 0)
            throw BadTouch(arguments.trace + ":" + std::to_string(reader.line()) + ": input is " +
                           std::to_string(recorded.input) + ": it must be 0 to " + std::to_string(k_inputs) +
                           "\n  cure: record again, or replay with the version that recorded it");
        time = recorded.time;
        device::TraceRow row = recorded;
        if ((row.input & device::k_trace_idle) == 0) setup.step(row);
        ++o.ticks;
        if (computed != nullptr) {
            double force = 0, torque = 0;
            for (std::size_t z = 0; z < zones; ++z) {
                force = std::max(force, norm(row.computed[z].force));
                torque = std::max(torque, norm(row.computed[z].torque));
            }
            computed->depth.push_back(row.depth);
            computed->force.push_back(force);
            computed->torque.push_back(torque);
        }
        for (std::size_t z = 0; z < zones; ++z)
            for (int i = 0; i < 3; ++i) {
                o.mix(row.computed[z].force[i]);
                o.mix(row.computed[z].torque[i]);
            }
        if (device::same_bits(recorded, row, zones)) continue;
        Difference d{.line = reader.line(),
                     .time = recorded.time,
                     .columns = device::differences(recorded, row, zones),
                     .depth = {recorded.depth, row.depth}};
        for (std::size_t z = 0; z < zones; ++z) {
            d.force_apart = std::max(d.force_apart, norm(row.computed[z].force - recorded.computed[z].force));
            d.torque_apart = std::max(d.torque_apart, norm(row.computed[z].torque - recorded.computed[z].torque));
            d.force[0] = std::max(d.force[0], norm(recorded.computed[z].force));
            d.force[1] = std::max(d.force[1], norm(row.computed[z].force));
        }
        add_difference(o, d, rows);
    }
    o.complete = reader.complete();
    o.dropped = reader.dropped();
    return o;
}

int run(const ReplayArguments& arguments)
{
    check_plot_name(arguments.plot);
    TouchOptions options;
    bool of_page = false;
    {
        const device::TraceReader reader(arguments.trace);
        const auto setup = reader.header().find("setup");
        of_page = !setup && is_of_page(reader.header());
        if (!setup && !of_page)
            throw BadTouch(arguments.trace +
                           " has no setup: neither sqmap touch nor the page of sqmap view has recorded it\n  cure: replay what "
                           "one of these has written");
        if (setup) options = setup_from(*setup);
    }
    if (!of_page && !arguments.models.empty())
        throw BadTouch("--model is for recordings of the page: " + arguments.trace +
                       " names its files itself\n  cure: leave --model out, or --against another model");
    if (!of_page && !arguments.against.empty()) {
        options.objects.front().file = arguments.against;
        options.objects.front().hash = 0;
    }
    const bool compare = !arguments.against.empty() && !arguments.plot.empty();
    Comparison computed{.name = std::filesystem::path(arguments.against).filename().string()};
    const auto once = [&](bool rows, Comparison* with) {
        return of_page ? replay_page(arguments, rows, with) : replay(arguments, options, rows, with);
    };
    std::vector<Replayed> outcomes(arguments.threads);
    parallel::for_each(arguments.threads, arguments.threads, [&](std::size_t i) {
        if (i == 0) {
            outcomes[0] = once(arguments.diff, compare ? &computed : nullptr);
            return;
        }
        try {
            outcomes[i] = once(false, nullptr);
        } catch (const std::exception& e) {
            outcomes[i].error = e.what();
        }
    });
    const Replayed& o = outcomes.front();
    std::FILE* const out = arguments.diff ? stderr : stdout;  // the rows have the other one
    if (!o.complete) std::fprintf(out, "%s was cut short: its last whole row is the last tick\n", arguments.trace.c_str());
    if (o.dropped > 0)
        std::fprintf(out, "%llu rows were dropped while recording: what has a memory may differ after each\n",
                     static_cast<unsigned long long>(o.dropped));
    bool alike = true;
    for (const Replayed& other : outcomes) alike &= other.error.empty() && other.hash == o.hash && other.ticks == o.ticks;
    const auto ticks = static_cast<unsigned long long>(o.ticks);
    if (o.different == 0) {
        std::fprintf(out, "%llu ticks, all bit-identical; forces %016llx\n", ticks, static_cast<unsigned long long>(o.hash));
    } else {
        std::fprintf(out, "%llu of %llu ticks differ; forces %016llx\n", static_cast<unsigned long long>(o.different), ticks,
                     static_cast<unsigned long long>(o.hash));
        std::fprintf(out, "  first on line %zu, at %.6g s: %s\n", o.first_line, o.first_time, o.first_columns.c_str());
        std::fprintf(
            out,
            "  largest difference: force %.6g N, torque %.6g N m, depth %.6g m; force, root mean square over all ticks %.6g N\n",
            o.largest_force, o.largest_torque, o.largest_depth, std::sqrt(o.sum_force_sq / static_cast<double>(o.ticks)));
    }
    if (arguments.threads > 1)
        std::fprintf(out, "%u threads: %s\n", arguments.threads, alike ? "all the same forces" : "NOT the same forces");
    if (!arguments.plot.empty()) plot_trace(arguments.trace, arguments.plot, compare ? &computed : nullptr);
    const bool failed = !alike || (o.different > 0 && arguments.against.empty());
    return failed ? 1 : 0;
}

}  // namespace

void add_replay(CommandLine& line)
{
    const auto arguments = std::make_shared<ReplayArguments>();
    Command command = line.add("replay", "Compute the forces of a recording anew and compare them, to the bit");
    command.option("trace", arguments->trace, "What sqmap touch --record or the page of sqmap view wrote").required();
    command
        .option("--model", arguments->models,
                "Models of a page's recording; without it they are found beside the recording, by their content")
        .existing_file();
    command.option("--against", arguments->against, "Another model instead of the first: how do its forces differ?");
    command.flag("--diff", arguments->diff, "Print every tick that differs, as CSV; the summary goes to standard error");
    command.option("--threads", arguments->threads, "Replay in so many threads at once: all must agree").in_range(1, 64);
    command.option("--plot", arguments->plot, "Draw the recording: depth, force, torque, CPU time (SVG); with --against both");
    command.footer(
        "Exit code: 0 bit-identical, or compared --against another model; 1 different; 2 bad trace or model, 64 wrong usage, 70 "
        "internal error.");
    command.run<BadTouch, device::TraceError, io::ModelFileError>([arguments] { return run(*arguments); });
}

}  // namespace sqmap::app
