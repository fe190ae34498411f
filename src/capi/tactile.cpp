// Tactile pads behind the C interface.
#include "sqmap/haptic/tactile.h"
#include "objects.h"
#include "structs.h"

#include <cmath>
#include <cstddef>
#include <limits>
#include <string>

namespace sqmap::capi {
namespace {

static_assert(sizeof(sqmap_taxel) == sizeof(haptic::Taxel) && offsetof(sqmap_taxel, shear) == offsetof(haptic::Taxel, shear) &&
              offsetof(sqmap_taxel, depth) == offsetof(haptic::Taxel, depth));

/// Zero for a number below zero, the default for zero.
double or_default(double value, double standard, const char* element)
{
    if (value == 0) return standard;
    return value < 0 && std::isfinite(value) ? 0 : checked(value, 0, std::numeric_limits<double>::max(), element);
}

}  // namespace

/// A pad with its options.
class Pad {
public:
    Pad(std::span<const Vec3d> points, std::span<const Vec3d> normals, const sqmap_pad_options& o) : pad_(points, normals)
    {
        options_.tactile_kn = or_default(o.tactile_kn, options_.tactile_kn, "options.tactile_kn");
        options_.tactile_kt = or_default(o.tactile_kt, options_.tactile_kt, "options.tactile_kt");
        options_.tactile_mu = or_default(o.tactile_mu, options_.tactile_mu, "options.tactile_mu");
        options_.tactile_damping = checked(o.tactile_damping, 0, std::numeric_limits<double>::max(), "options.tactile_damping");
        options_.query.layer = layer_of(o.layer);
    }
    void tick(const sqmap_pad_tick& in, sqmap_taxels& out)
    {
        if (out.count != pad_.size())
            throw Failure{SQMAP_E_ARGUMENT, "taxels.count", "is " + std::to_string(out.count),
                          "give space for the pad's " + std::to_string(pad_.size()) + " taxels"};
        haptic::TactileTick tick;
        tick.touched = {&model_of(in.model, "tick.model")->view(), nullptr, pose_of(in.model_pose, "tick.model_pose")};
        tick.pose = pose_of(in.pose, "tick.pose");
        tick.dt = checked(in.dt, 0, std::numeric_limits<double>::max(), "tick.dt");
        if (in.restarts != 0) pad_.restart();
        const haptic::TactileResult result =
            pad_.tick(tick, options_, {reinterpret_cast<haptic::Taxel*>(&needed(out.taxels, "taxels.taxels")), out.count});
        out.contacts = result.contacts;
        for (int i = 0; i < 3; ++i) {
            out.force[i] = result.force[i];
            out.torque[i] = result.torque[i];
        }
        out.status = result.status;
    }

private:
    haptic::TactilePad pad_;
    haptic::TactileOptions options_;
};

static Handles<Pad, 5>& pads() { return table<Pad, 5>(); }

}  // namespace sqmap::capi

using namespace sqmap;
using capi::guarded;
using capi::needed;

sqmap_code sqmap_make_pad(const sqmap_points* points, const double* normals, const sqmap_pad_options* options, sqmap_pad* pad)
{
    return capi::opened(pad, "pad", capi::pads(), [&] {
        const sqmap_points given = capi::taken(&needed(points, "points"), "points");
        sqmap_points outward = given;
        outward.xyz = &needed(normals, "normals");
        const std::span<const Vec3d> at = capi::rows(given, "points.xyz"), along = capi::rows(outward, "normals");
        if (at.empty()) throw capi::Failure{SQMAP_E_ARGUMENT, "points.count", "is 0", "give at least one point"};
        constexpr const char* k_cure = "give finite numbers, or leave the taxel out";
        capi::check_finite(at, "points.xyz", k_cure);
        capi::check_finite(along, "normals", k_cure);
        return std::make_shared<capi::Pad>(at, along, capi::taken(options, "options"));
    });
}

sqmap_code sqmap_tick_pad(sqmap_pad pad, const sqmap_pad_tick* tick, sqmap_taxels* taxels)
{
    return guarded([&] {
        const sqmap_pad_tick in = capi::taken(&needed(tick, "tick"), "tick");
        sqmap_taxels out = capi::taken(&needed(taxels, "taxels"), "taxels");
        capi::pads().find(pad.id, "pad")->tick(in, out);
        capi::give(taxels, out);
    });
}

sqmap_code sqmap_close_pad(sqmap_pad pad)
{
    return guarded([&] { capi::pads().close(pad.id, "pad"); });
}
