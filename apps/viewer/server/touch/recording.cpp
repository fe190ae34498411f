#include "viewer/server/touch/recording.h"

#include "viewer/server/protocol/bytes.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace sqmap::viewer {
namespace {

bool same(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }
bool same(Vec3d a, Vec3d b) { return same(a.x, b.x) && same(a.y, b.y) && same(a.z, b.z); }

}  // namespace

Again compute_again(const Recording& recording, const std::optional<Other>& other, const std::function<bool()>& stop)
{
    Again out;
    double sum = 0;
    for (const std::shared_ptr<const Take>& take : recording) {
        Forces forces(other ? other->objects : take->objects, other ? other->settings : take->settings);
        std::uint32_t live = 0;
        double depth = 0;
        out.lost += take->lost;
        for (const Take::Tick& tick : take->ticks) {
            if (out.ticks.size() % 1000 == 0 && stop && stop()) return out;
            if (!other && tick.live != live) forces.adjust(take->live[live = tick.live]);
            haptic::Wrench wrench{};
            (void)forces.step(tick.input, wrench);
            if (!tick.input.degraded) depth = forces.depth();
            if (!same(wrench.force, tick.commanded.force) || !same(wrench.torque, tick.commanded.torque) ||
                !same(depth, tick.depth))
                ++out.different;
            const double force = norm(wrench.force - tick.commanded.force);
            sum += force * force;
            out.largest_force = std::max(out.largest_force, force);
            out.largest_depth = std::max(out.largest_depth, std::abs(depth - tick.depth));
            out.ticks.push_back(
                {static_cast<float>(norm(wrench.force)), static_cast<float>(norm(wrench.torque)), static_cast<float>(depth)});
        }
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

}  // namespace sqmap::viewer
