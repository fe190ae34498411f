// sqmap rtcheck: what this machine can hold of a 1 kHz loop, and what to do about it.
#include "commands.h"
#include "device/jitter.h"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <memory>
#include <optional>

namespace sqmap::app {
namespace {

using device::Holds;
using device::Jitter;
using nlohmann::ordered_json;

constexpr int k_priority = 80;
constexpr const char* k_take_priority = "sqmap touch --priority 80";

ordered_json as_json(const std::optional<Jitter>& j)
{
    if (!j) return nullptr;
    return {{"ticks", j->ticks},      {"late", j->late},          {"p50_us", 1e6 * j->p50},
            {"p99_us", 1e6 * j->p99}, {"p999_us", 1e6 * j->p999}, {"max_us", 1e6 * j->max}};
}

const char* word(Holds holds) { return holds == Holds::Steadily ? "steadily" : holds == Holds::Mostly ? "mostly" : "not"; }

void print(const char* policy, const std::optional<Jitter>& j)
{
    if (!j) {
        std::printf("  %-14s not granted\n", policy);
        return;
    }
    std::printf("  %-14s %8.0f %8.0f %8.0f %8.0f   %llu of %llu (%.3f %%)\n", policy, 1e6 * j->p50, 1e6 * j->p99, 1e6 * j->p999,
                1e6 * j->max, static_cast<unsigned long long>(j->late), static_cast<unsigned long long>(j->ticks),
                100. * static_cast<double>(j->late) / static_cast<double>(j->ticks));
}

void report(const device::Machine& m, const Jitter& plain, const std::optional<Jitter>& fifo, Holds holds)
{
    std::printf("kernel %s %s, %d processors%s%s%s, load %.1f\n", m.kernel.c_str(),
                m.preemption.empty() ? "without kernel preemption" : m.preemption.c_str(), m.processors,
                m.virtual_machine ? ", virtual machine" : "", m.governor.empty() ? "" : ", clock governor ", m.governor.c_str(),
                m.load);
    std::printf("lateness of a 1 ms loop, us\n  %-14s %8s %8s %8s %8s   ticks late by more than 1 ms\n", "policy", "p50", "p99",
                "p99.9", "max");
    print("SCHED_OTHER", plain);
    print("SCHED_FIFO 80", fifo);
    std::printf("%s\n", holds == Holds::Steadily ? "holds 1 kHz steadily"
                        : holds == Holds::Mostly ? "holds 1 kHz mostly: some ticks will be answered from the last contacts"
                                                 : "does not hold 1 kHz: the safety filter will often ramp down or start anew");
    for (const std::string& line : device::advice(m, plain, fifo, k_take_priority)) std::printf("- %s\n", line.c_str());
    std::printf(
        "This is measured without work and for as long as asked: a longer run finds worse. Each tick's own work is bounded "
        "apart from this; a late tick is never unsafe, see docs/realtime.md.\n");
}

}  // namespace

void add_rtcheck(CommandLine& line)
{
    struct Options {
        double seconds = 10;
        bool json = false;
    };
    const auto options = std::make_shared<Options>();
    Command command = line.add("rtcheck", "Measure what this machine can hold of a 1 kHz loop, with and without SCHED_FIFO");
    command.option("--seconds", options->seconds, "How long to measure, for each of the two").in_range(0.1, 3600.);
    command.flag("--json", options->json, "Answer as JSON");
    command.footer("Exit code: 0 measured, whatever was found, 64 wrong usage, 70 internal error.");
    command.run([options] {
        const device::Machine m = device::machine();
        const Jitter plain = *device::measure_jitter({.seconds = options->seconds});
        const std::optional<Jitter> fifo = device::measure_jitter({.seconds = options->seconds, .priority = k_priority});
        const Holds holds = std::min(device::judge(plain), fifo ? device::judge(*fifo) : Holds::Not);
        if (options->json) {
            const ordered_json out{{"period_us", 1000},
                                   {"seconds", options->seconds},
                                   {"machine",
                                    {{"kernel", m.kernel},
                                     {"preemption", m.preemption},
                                     {"processors", m.processors},
                                     {"virtual", m.virtual_machine},
                                     {"governor", m.governor},
                                     {"rtprio_limit", m.rt_priority},
                                     {"memlock_limit", m.memory_lock},
                                     {"load", m.load}}},
                                   {"other", as_json(plain)},
                                   {"fifo", as_json(fifo)},
                                   {"holds", word(holds)},
                                   {"advice", device::advice(m, plain, fifo, k_take_priority)}};
            std::printf("%s\n", out.dump(2, ' ', false, ordered_json::error_handler_t::replace).c_str());
        } else {
            report(m, plain, fifo, holds);
        }
        return 0;
    });
}

}  // namespace sqmap::app
