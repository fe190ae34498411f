#include "touch/totals.h"

#include "device/hand.h"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace sqmap::app {
namespace {

/// Prints faults of poses, and how the filter answered them.
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

std::string milliseconds(double time)
{
    char text[40];
    std::snprintf(text, sizeof text, "%.3f s", time);
    return text;
}

/// Zones that were inside an object when forces were to begin.
void print_inside(const Totals& totals, const TouchFacts& facts)
{
    for (std::size_t z = 0; z < facts.zones; ++z)
        if (const Inside& in = totals.inside[z]; in.ticks > 0)
            std::printf("  %s was inside an object when forces were to begin, and had none in %llu ticks, from %.3f s to %s\n",
                        zone_name(z, facts.zones, facts.glove).c_str(), static_cast<unsigned long long>(in.ticks), in.first,
                        in.now ? "the end" : milliseconds(in.last).c_str());
    if (std::any_of(totals.inside.begin(), totals.inside.end(), [](const Inside& in) { return in.ticks > 0; }))
        std::printf("  cure: start outside, or lift it out of the object once; force then comes in over half a second\n");
}

}  // namespace

void Totals::add(const device::TraceRow& row, std::size_t zones, double depth)
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
    bool as_commanded = true;
    for (std::size_t z = 0; z < zones; ++z) {
        largest_force = std::max(largest_force, norm(row.computed[z].force));
        largest_sent = std::max(largest_sent, norm(row.sent[z].force));
        as_commanded = as_commanded && row.sent[z] == row.computed[z];
        Inside& in = inside[z];
        in.now = (row.filter & haptic::k_acted_inside) != 0 && row.sent[z] == haptic::Wrench{} &&
                 !(row.computed[z] == haptic::Wrench{});
        if (!in.now) continue;
        if (in.ticks++ == 0) in.first = row.time;
        in.last = row.time;
    }
    changed += !as_commanded;
    deepest = std::max(deepest, depth);
    cpu += row.cpu;
    max_cpu = std::max(max_cpu, row.cpu);
}

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

std::string zone_name(std::size_t zone, std::size_t zones, bool glove)
{
    constexpr const char* k_names[device::k_glove_zones] = {"thumb",       "index",         "middle finger",
                                                            "ring finger", "little finger", "palm"};
    if (zones == 1) return "the tool";
    return glove && zone < device::k_glove_zones ? k_names[zone] : "zone " + std::to_string(zone);
}

void print(const Totals& totals, const TouchFacts& facts)
{
    std::printf("%llu ticks, %llu in contact; deepest %.4g m, largest commanded force %.4g N\n",
                static_cast<unsigned long long>(totals.ticks), static_cast<unsigned long long>(totals.contact), totals.deepest,
                totals.largest_force);
    if (totals.ticks > 0)
        std::printf("  sent: at most %.4g N of %.4g N allowed; the safety filter changed the commanded force in %llu ticks\n",
                    totals.largest_sent, facts.force_limit, static_cast<unsigned long long>(totals.changed));
    if (totals.ticks > 0 && totals.contact == 0)
        std::fprintf(stderr, "warning: nothing was touched%s\n",
                     facts.has_impact_zone
                         ? ": what touches may lie outside the impact zone\n  cure: a larger --zone, or 0 for the whole tool"
                         : "");
    if (totals.ticks > 0)
        std::printf("  CPU time a tick: mean %.1f us, most %.1f us\n", 1e6 * totals.cpu / static_cast<double>(totals.ticks),
                    1e6 * totals.max_cpu);
    if (facts.by_the_clock)
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
    print_inside(totals, facts);
    if (totals.gone) std::printf("  the device was gone at the end\n");
}

}  // namespace sqmap::app
