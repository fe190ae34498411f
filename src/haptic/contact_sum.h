// The sum of a zone's contacts with a touched body, and its force (section 6.1, impact zones).
#pragma once

#include "sqmap/haptic/zone.h"

#include <algorithm>
#include <cmath>

namespace sqmap::haptic {

/// Length of the mean normal above which a levelled force has full strength; below it opposite walls cancel. 1/2 is that of an
/// edge of 120 degrees.
inline constexpr double k_min_coherence = 0.5;

/// One spring: eq. 32 over the stiffness.
struct Spring {
    Vec3d point{};  ///< of the zone, from the pose's centre, world axes
    Vec3d normal{};
    double depth = 0;   ///< > 0
    double weight = 0;  ///< area
};

/// The force of one touched body on a zone, over the stiffness.
struct ContactForce {
    double depth = 0;  ///< m, effective
    double exact = 0;  ///< m, before smoothing: distance out to the surface; of a patch the effective one
    Vec3d force{};     ///< m: depth times the outward direction, or less (see Shading)
    Vec3d torque{};    ///< m^2, about the pose's centre
    Vec3d lever{};     ///< m, centre of the contact, from the pose's centre
    std::uint32_t contacts = 0;
    double deepest = 0;  ///< m
    double reach = 0;    ///< m, of a patch: farthest contact from the pose's centre
};

/// Depth of full weight; 0: every contact has full weight. A proxy gets more, so that friction does not swing between the few
/// points that it rests on.
[[nodiscard]] inline double entry_depth(const ZoneOptions& options)
{
    if (!(options.entry_depth > 0)) return 0;
    return options.mode == Mode::Proxy ? std::max(options.entry_depth, 0.5 * options.proxy_depth) : options.entry_depth;
}

/// Moments of the contacts: weights times powers of depth. A contact enters and leaves with weight zero.
class ContactSum {
public:
    explicit ContactSum(const ZoneOptions& options) : shading_(options.shading), per_entry_(1 / entry_depth(options)) {}

    void add(const Spring& s)
    {
        const Vec3d turn = cross(s.point, s.normal);
        // Consistent: squares of depths throughout. Levelled: the paper's mean, but for the shallowest contacts.
        const double share = shading_ == Shading::Consistent ? s.depth : std::min(1., s.depth * per_entry_);
        const double w = s.weight * share, wd = w * s.depth, wdd = wd * s.depth;
        weight_ += w;
        first_ += wd;
        second_ += wdd;
        normal0_ += w * s.normal;
        normal1_ += wd * s.normal;
        turn0_ += w * turn;
        turn1_ += wd * turn;
        point_ += w * s.point;
        deepest_ = std::max(deepest_, s.depth);
        reach_sq_ = std::max(reach_sq_, norm_sq(s.point));
        ++count_;
    }

    /// Means over the contacts. Consistent: minus the gradient of half the square of sum w d^3 / sum w d^2.
    [[nodiscard]] ContactForce force() const
    {
        if (!(weight_ > 0) || !(first_ > 0)) return {};
        ContactForce out;
        out.contacts = count_;
        out.deepest = deepest_;
        out.lever = point_ / weight_;
        out.reach = std::sqrt(reach_sq_);
        if (shading_ == Shading::Consistent) {
            out.exact = out.depth = second_ / first_;
            const double a = 3 * out.depth / first_, b = -2 * out.depth * out.depth / first_;
            out.force = a * normal1_ + b * normal0_;
            out.torque = a * turn1_ + b * turn0_;
            return out;
        }
        out.exact = out.depth = first_ / weight_;
        const double coherence = shading_ == Shading::Mean ? 1 : std::max(norm(normal1_) / first_, k_min_coherence);
        const double gain = 1 / (weight_ * coherence);
        out.force = gain * normal1_;
        out.torque = gain * turn1_;
        return out;
    }

private:
    Shading shading_;
    double per_entry_;
    double weight_ = 0, first_ = 0, second_ = 0;
    Vec3d normal0_{}, normal1_{}, turn0_{}, turn1_{}, point_{};
    double deepest_ = 0, reach_sq_ = 0;
    std::uint32_t count_ = 0;
};

}  // namespace sqmap::haptic
