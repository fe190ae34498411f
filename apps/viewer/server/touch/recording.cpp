#include "viewer/server/touch/recording.h"

#include "sqmap/haptic/safety.h"
#include "viewer/server/protocol/bytes.h"
#include "viewer/server/touch/frame.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace sqmap::viewer {
namespace {

constexpr std::size_t k_ticks_a_frame = 16;  // as many as are streamed: 60 frames a second

bool same(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }
bool same(Vec3d a, Vec3d b) { return same(a.x, b.x) && same(a.y, b.y) && same(a.z, b.z); }

/// Each tick of a take once more, over other objects where there are: visit(tick, forces, wrench); false ends it.
template <class Visit>
void repeat(const Take& take, const std::optional<Other>& other, Visit visit)
{
    if (take.ticks.empty()) return;  // nor has it settings, where the touch did not begin
    Forces forces(other ? other->objects : take.objects, other ? other->settings : take.settings.front());
    std::uint32_t number = 0;
    for (const Take::Tick& tick : take.ticks) {
        if (!other && tick.number != number) {
            number = tick.number;
            forces.adjust(live_of(take.settings[number], number));
        }
        haptic::Wrench wrench{};
        (void)forces.step(tick.input, wrench);
        if (!visit(tick, forces, wrench)) return;
    }
}

/// Adds a tick to the frame, without its contacts.
void add_tick(TouchFrame& frame, const Take::Tick& tick, const Forces::Found& found)
{
    if (frame.ticks.empty()) frame.time = tick.time;
    frame.ticks.push_back({static_cast<float>(norm(tick.sent.force)), static_cast<float>(norm(tick.sent.torque)),
                           static_cast<float>(found.depth), static_cast<float>(1e6 * tick.cpu),
                           static_cast<float>(tick.time - frame.time)});
    frame.force = tick.sent.force;
    frame.torque = tick.sent.torque;
    frame.acted = tick.filter & 0xffff;
    frame.faults = tick.filter >> 16;
    frame.engaged = frame.faults == 0 && (frame.acted & (haptic::k_acted_engage | haptic::k_acted_off)) == 0;
    frame.degraded = frame.degraded || tick.input.degraded;
}

}  // namespace

Again compute_again(const Recording& recording, const std::optional<Other>& other, const std::function<bool()>& stop,
                    const TickWitness& witness)
{
    Again out;
    double sum = 0;
    for (const std::shared_ptr<const Take>& take : recording) {
        out.lost += take->lost;
        repeat(*take, other, [&](const Take::Tick& tick, const Forces& forces, const haptic::Wrench& wrench) {
            const double depth = forces.found().depth;
            if (witness) witness(tick, wrench, depth);
            if (!same(wrench.force, tick.commanded.force) || !same(wrench.torque, tick.commanded.torque) ||
                !same(depth, tick.depth))
                ++out.different;
            const double force = norm(wrench.force - tick.commanded.force);
            sum += force * force;
            out.largest_force = std::max(out.largest_force, force);
            out.largest_depth = std::max(out.largest_depth, std::abs(depth - tick.depth));
            out.ticks.push_back(
                {static_cast<float>(norm(wrench.force)), static_cast<float>(norm(wrench.torque)), static_cast<float>(depth)});
            return out.ticks.size() % 1000 != 0 || !stop || !stop();
        });
    }
    if (!out.ticks.empty()) out.rms_force = std::sqrt(sum / static_cast<double>(out.ticks.size()));
    return out;
}

std::string again_bytes(const Again& again)
{
    Bytes out("SQR1");
    out.count(again.ticks.size());
    out.count(again.different);
    out.count(again.lost);
    for (const double x : {again.largest_force, again.rms_force, again.largest_depth}) out.put(static_cast<float>(x));
    for (const Again::Tick& t : again.ticks) out.put(t.force), out.put(t.torque), out.put(t.depth);
    return out.take();
}

std::string frames_bytes(const Recording& recording, std::span<const ObjectPtr> scene, const std::function<bool()>& stop)
{
    std::size_t count = 0, ticks = 0;
    for (const std::shared_ptr<const Take>& take : recording)
        count += (take->ticks.size() + k_ticks_a_frame - 1) / k_ticks_a_frame;
    Bytes out("SQL1");
    out.count(count);
    for (const std::shared_ptr<const Take>& take : recording) {
        TouchFrame frame;
        std::size_t of_take = 0;
        repeat(*take, std::nullopt, [&](const Take::Tick& tick, const Forces& forces, const haptic::Wrench&) {
            add_tick(frame, tick, forces.found());
            ++ticks;
            if (++of_take % k_ticks_a_frame != 0 && of_take != take->ticks.size()) return true;
            set_contact(frame, tick.input.pose, forces.found(), forces.objects());
            if (frame.object >= 0) {
                // An object that was moved or renamed since is another copy of the same file.
                const auto& file = forces.objects()[static_cast<std::size_t>(frame.object)]->file;
                const auto at =
                    std::find_if(scene.begin(), scene.end(), [&](const ObjectPtr& o) { return o != nullptr && o->file == file; });
                frame.object = at == scene.end() ? -1 : static_cast<int>(at - scene.begin());
            }
            const std::vector<float> floats = frame_floats(frame, of_take, ticks);
            out.count(floats.size());
            for (const float x : floats) out.put(x);
            frame = {};
            return !stop || !stop();
        });
    }
    return out.take();
}

}  // namespace sqmap::viewer
