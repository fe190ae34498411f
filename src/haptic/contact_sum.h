// Contacts of a zone with a solid, summed up, and the force that the sum stands for (section 6.1, impact zones).
#pragma once

#include "sqmap/haptic/step.h"

#include <algorithm>
#include <cmath>

namespace sqmap::haptic {

/// Below this share of full strength opposite walls cancel; above it a levelled force has full strength. 1/2: an edge of 120
/// degrees.
inline constexpr double k_least_coherence = 0.5;

/// One spring: eq. 32 over the stiffness.
struct Spring {
    Vec3d point{};  ///< of the zone, from the pose's centre, world axes
    Vec3d normal{};
    double depth = 0;   ///< > 0
    double weight = 0;  ///< area
};

/// What a zone feels of one solid.
struct Felt {
    double depth = 0;  ///< effective
    double exact = 0;  ///< before smoothing: how far out the surface is; of a patch the effective one
    Vec3d force{};     ///< over the stiffness: depth times the way out, or less (see Shading)
    Vec3d torque{};    ///< over the stiffness, about the pose's centre
    Vec3d lever{};     ///< centre of the contact, from the pose's centre
    std::uint32_t contacts = 0;
    double deepest = 0;
};

/// Moments of the contacts: weights times powers of depth. Whatever enters or leaves does so with weight zero.
class ContactSum {
public:
    void add(const Spring& s)
    {
        const double wd = s.weight * s.depth, wdd = wd * s.depth;
        const Vec3d turn = cross(s.point, s.normal);
        first_ += wd;
        second_ += wdd;
        third_ += wdd * s.depth;
        normal1_ += wd * s.normal;
        normal2_ += wdd * s.normal;
        turn1_ += wd * turn;
        turn2_ += wdd * turn;
        point_ += wd * s.point;
        deepest_ = std::max(deepest_, s.depth);
        ++count_;
    }

    /// Depth-weighted means over the contacts. Consistent: minus the gradient of half the square of third / second.
    [[nodiscard]] Felt patch(Shading shading) const
    {
        if (!(first_ > 0) || !(second_ > 0)) return {};
        Felt felt;
        felt.contacts = count_;
        felt.deepest = deepest_;
        felt.lever = point_ / first_;
        if (shading == Shading::Consistent) {
            felt.exact = felt.depth = third_ / second_;
            const double a = 3 * felt.depth / second_, b = -2 * felt.depth * felt.depth / second_;
            felt.force = a * normal2_ + b * normal1_;
            felt.torque = a * turn2_ + b * turn1_;
            return felt;
        }
        felt.exact = felt.depth = second_ / first_;
        const double coherence = norm(normal2_) / second_, gain = 1 / (first_ * std::max(coherence, k_least_coherence));
        felt.force = gain * normal2_;
        felt.torque = gain * turn2_;
        return felt;
    }

private:
    double first_ = 0, second_ = 0, third_ = 0;
    Vec3d normal1_{}, normal2_{}, turn1_{}, turn2_{}, point_{};
    double deepest_ = 0;
    std::uint32_t count_ = 0;
};

}  // namespace sqmap::haptic
