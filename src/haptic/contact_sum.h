// The sums of a zone's contacts with a touched body and their force (section 6.1, impact zones): of a patch, and of samples on a
// sphere.
#pragma once

#include "haptic/stencil.h"
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

/// A sample on the sphere.
struct Sample {
    Vec3d position{};  ///< from the centre, world axes
    Vec3d surface{};   ///< nearest surface point found, from the centre
    Vec3d normal{};
    double depth = 0;  ///< 0: free, and then the rest is not known
};

/// A sample's contact in the last tick.
struct Trail {
    Vec3d surface{};   ///< body's frame
    double depth = 0;  ///< 0: free
    bool known = false;
};

/// m, the rounding of depths, which are floats. A surface nearer by less than this counts as the same: taking it would leave a
/// sample's foot, and its normal, behind while the sample moves.
inline constexpr double k_rounding = 1e-7;

/// Number of touching samples up to which a ball's mean depth is noise; from twice as many on it is trusted.
inline constexpr double k_few_samples = 10;

/// How far samples may have moved since the last tick, and how much of a jump is left after a tick.
struct Passed {
    double motion = INFINITY, left = 0;
};

/// Limits the change of a depth to the motion: a larger change, a jump, is spread over some ticks.
inline double without_jump(double depth, const Trail& before, const Passed& passed)
{
    if (!before.known) return depth;
    const double near = std::clamp(depth, before.depth - passed.motion, before.depth + passed.motion);
    return depth + passed.left * (near - depth);
}

struct StencilSum {
    std::span<Sample> samples;  ///< on the sphere
    Sample centre{};
    bool searched = false;  ///< the centre is exact
    double depth = 0;       ///< of a stencil's centre; of a ball's deepest point
    Vec3d nearest{};        ///< unit, outwards there

    /// Corrects depths that are too large because a sample's search ended at another surface. The surfaces that its neighbours,
    /// the centre or the sample itself in the last tick found bound the depth; a correction that appears only now is spread over
    /// some ticks. On a Fibonacci lattice neighbours are Fibonacci numbers apart. trail: one per sample, then the centre;
    /// to_world takes the body's frame to the samples'.
    template <class ToWorld>
    void bound_by_neighbours(std::span<const Trail> trail, const Passed& passed, ToWorld&& to_world)
    {
        constexpr std::size_t k_steps[] = {1, 2, 3, 5, 8, 13, 21, 34, 55};
        for (std::size_t i = 0; i < samples.size(); ++i) {
            Sample& s = samples[i];
            if (!(s.depth > 0)) continue;
            const double found = std::max(s.depth - k_rounding, 0.), found_sq = found * found;
            double bound_sq = found_sq;
            const auto try_surface = [&](Vec3d surface) {
                const double d = norm_sq(s.position - surface);
                if (d < bound_sq) bound_sq = d, s.surface = surface;
            };
            if (centre.depth > 0) try_surface(centre.surface);
            if (trail[i].known && trail[i].depth > 0) try_surface(to_world(trail[i].surface));
            for (const std::size_t step : k_steps) {
                if (i >= step && samples[i - step].depth > 0) try_surface(samples[i - step].surface);
                if (i + step < samples.size() && samples[i + step].depth > 0) try_surface(samples[i + step].surface);
            }
            if (bound_sq < found_sq) {
                s.depth = std::sqrt(bound_sq);
                if (s.depth > 1e-9) s.normal = (s.surface - s.position) / s.depth;
            }
            s.depth = without_jump(s.depth, trail[i], passed);
        }
    }

    /// Finds the depth of the centre or the ball from the nearest of all surfaces found: samples see both sides of an edge.
    /// nearer(surface): the surface point nearest to the centre in the neighbourhood of surface.
    template <class Nearer>
    void settle(const ZoneOptions& o, const Trail& before, const Passed& passed, Nearer&& nearer)
    {
        const double r = o.smoothing.radius;
        const bool ball = o.averaging == Averaging::Ball, inside = centre.depth > 0;
        depth = centre.depth;
        nearest = centre.normal;
        if (!ball && (!inside || searched)) return;
        double min_sq = inside ? centre.depth * centre.depth : r * r;
        Vec3d surface{};
        for (const Sample& s : samples)
            if (s.depth > 0 && norm_sq(s.surface) < min_sq) min_sq = norm_sq(s.surface), surface = s.surface;
        if (norm_sq(surface) > 0 && !inside)
            if (const Vec3d found = nearer(surface); norm_sq(found) < min_sq) min_sq = norm_sq(found), surface = found;
        const double distance = std::sqrt(min_sq);
        if (norm_sq(surface) > 0) nearest = (inside ? 1 : -1) / distance * surface;
        depth = (ball ? r : 0) + (inside ? distance : -distance);
        if (depth > 0) depth = without_jump(depth, before, passed);
    }

    /// The smoothed depth, kept within max_error of the true one, so that force begins where the true depth does. For a point the
    /// smoothed depth counts little until the two differ by twice max_error: on facets that turn mildly it differs by less, and
    /// rises and falls with every edge, as the true depth does not. For a ball it counts as little while so few samples touch
    /// that each new one changes it. reach: radius of a ball, 0 for a point.
    [[nodiscard]] double smoothed_depth(double smooth, double max_error, double reach) const
    {
        if (!(max_error > 0)) return depth;
        const double x = (smooth - depth) / max_error, cube = std::abs(x * x * x);
        const double careful = std::copysign(cube / (8 + cube), x);
        const double touching = reach > 0 ? static_cast<double>(samples.size()) * depth / (2 * reach) : 0;  // on flat ground
        const double u = std::clamp(touching / k_few_samples - 1, 0., 1.), trust = u * u * (3 - 2 * u);
        const double share = careful + trust * (x / std::sqrt(1 + x * x) - careful);
        return std::max(depth + max_error * (std::isfinite(cube) ? share : 0), 0.);
    }

    [[nodiscard]] ContactForce force(const ZoneOptions& o) const
    {
        const bool ball = o.averaging == Averaging::Ball;
        const double r = o.smoothing.radius, total = static_cast<double>(samples.size());
        double first = 0, second = 0, third = 0, fourth = 0;  // means of powers of the depths
        Vec3d normal{}, inwards1{}, inwards2{};
        ContactForce out;
        for (const Sample& s : samples) {
            if (!(s.depth > 0)) continue;
            const double d = s.depth / total, dd = d * s.depth;
            ++out.contacts;
            first += d;
            second += dd;
            third += dd * s.depth;
            fourth += dd * s.depth * s.depth;
            normal += d * s.normal;
            inwards1 += (d / r) * s.position;
            inwards2 += (dd / r) * s.position;
        }
        out.exact = out.deepest = std::max(depth, 0.);
        if (!(second > 0)) return out;
        const StencilDepth flat = depth_of_stencil(r, second);
        if (o.shading == Shading::Consistent) {
            out.depth = std::max(flat.depth + (ball ? r : 0), 0.);
            out.force = (2 * out.depth * flat.slope) * normal;
            return out;
        }
        if (!(depth > 0)) return out;
        // On flat ground a ball's depths are spread evenly from 0 to its own depth, or, once all of it is inside, about the depth
        // of its centre. One of the two estimates below is then exact and the other too large. Where walls meet, the smaller one
        // lies between the walls' depths, and so changes no faster than they do.
        const double smooth = ball ? std::min(1.25 * fourth / third, first + r) : flat.depth;
        out.depth = smoothed_depth(smooth, std::min(o.smoothing.tolerance, depth), ball ? r : 0);
        // A ball weighs a wall by the square of its depth in it, a stencil, whose centre is inside, by the cube: the mean of the
        // normals, or of depth times normal, over the part inside.
        const bool shell = o.smoothing.kernel == Kernel::Shell;
        const Vec3d sum = shell ? normal : -1. * (ball ? inwards1 : inwards2);
        const double size = norm(sum), inside = static_cast<double>(out.contacts) / total;
        // On flat ground the greater of these shares is 2/3 or more, however deep; opposite walls within the sphere cancel.
        const double coherence = shell  ? size / first
                                 : ball ? std::max(size / first, 2 * size / (r * inside))
                                        : std::max(size / second, 1.5 * size / (r * first));
        Vec3d direction = size > 0 ? sum / size : Vec3d{};
        if (const double u = (coherence - 0.2) / 0.3; u < 1) {
            // The body is thinner than the sphere: only the nearest surface gives the outward direction.
            const double share = u > 0 ? u * u * (3 - 2 * u) : 0;
            direction = share * direction + (1 - share) * nearest;
            if (norm(direction) > 0.5) direction = normalized(direction);
        }
        out.force = out.depth * direction;
        return out;
    }
};

}  // namespace sqmap::haptic
