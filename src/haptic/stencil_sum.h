// What the samples on a sphere feel together.
#pragma once

#include "contact_sum.h"

namespace sqmap::haptic {

/// A sample in contact.
struct Sample {
    Vec3d place{};  ///< from the centre
    Vec3d normal{};
    double depth = 0;
};

/// Samples of a stencil or ball that are in contact.
struct StencilSum {
    std::span<Sample> samples;  ///< on the sphere
    double total = 0;           ///< how many there are, in contact or not
    Sample centre{};            ///< stencils only: depth 0 where free

    /// |depth(a) - depth(b)| <= |a - b|: a search for the nearest surface that ended at another one gave a depth that is too
    /// large, and its neighbours know. Outside samples have depth 0, which bounds all the more.
    void trust_the_least(double radius)
    {
        double least = total > static_cast<double>(samples.size()) ? 0 : INFINITY;
        for (const Sample& s : samples) least = std::min(least, s.depth);
        centre.depth = std::min(centre.depth, least + radius);
        for (Sample& s : samples) s.depth = std::min(s.depth, centre.depth + radius);
    }

    [[nodiscard]] Felt felt(const ZoneOptions& o) const
    {
        const double r = o.smoothing.radius;
        const bool ball = o.averaging == Averaging::Ball;
        double first = 0, second = 0, deepest = 0;
        Vec3d normal{}, gradient{};
        for (const Sample& s : samples) {
            first += s.depth / total;
            second += s.depth * s.depth / total;
            deepest = std::max(deepest, s.depth);
            normal += (s.depth / total) * s.normal;
            gradient -= (s.depth * s.depth / total / r) * s.place;
        }
        Felt felt;
        felt.contacts = static_cast<std::uint32_t>(samples.size());
        felt.deepest = deepest;
        if (!(second > 0)) return felt;
        const StencilDepth smooth = depth_of_stencil(r, second);
        const double offset = ball ? r : 0;
        if (o.shading == Shading::Consistent) {
            felt.depth = std::max(smooth.depth + offset, 0.);
            felt.force = (2 * felt.depth * smooth.slope) * normal;
            return felt;
        }
        // The smoothed depth, as far as it stays near the true one.
        const double exact = ball ? deepest : centre.depth, excess = smooth.depth + offset - exact;
        felt.depth =
            std::max(exact + excess / std::sqrt(1 + excess * excess / (o.smoothing.tolerance * o.smoothing.tolerance)), 0.);
        const Vec3d sum = o.smoothing.kernel == Kernel::Shell ? normal : gradient;
        const double size = norm(sum);
        // On flat ground the greater of these shares is 3/4 or more; opposite walls within the sphere cancel.
        const double coherence = o.smoothing.kernel == Kernel::Shell ? size / first : std::max(size / second, 1.5 * size / first);
        Vec3d direction = size > 0 ? sum / size : Vec3d{};
        if (const double u = (coherence - 0.2) / 0.3; !ball && u < 1) {
            // Thinner than the sphere: the nearest surface alone says which way is out.
            const double share = u > 0 ? u * u * (3 - 2 * u) : 0;
            direction = share * direction + (1 - share) * centre.normal;
            if (norm(direction) > 0.5) direction = normalized(direction);
        } else if (ball && coherence < k_least_coherence) {
            direction = coherence / k_least_coherence * direction;
        }
        felt.force = felt.depth * direction;
        return felt;
    }
};

}  // namespace sqmap::haptic
