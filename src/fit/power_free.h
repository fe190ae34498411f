// A bound of f = sqrt(F) that takes no powers, so that most points of a large set need none.
#pragma once

#include "sqmap/shape/superquadric.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sqmap::fit {

/// Upper bound of f, eq. 1's norm, for one shape. f is a nest of two norms |(u, v)| = big (1 + r^p)^(1/p), p = 2/eps >= 1,
/// r = small/big. Between powers of two r^p lies below their weighted mean, and (1 + x)^(1/p), concave, below its tangents.
/// Larger than f by at most some percent; NaN where the point is.
class PowerFreeBound {
public:
    explicit PowerFreeBound(const shape::Superquadricd& sq) : a_(sq.a), xy_(sq.eps2), z_(sq.eps1) {}

    /// u: an undeformed local point.
    double operator()(Vec3d u) const { return z_(xy_(std::abs(u.x / a_.x), std::abs(u.y / a_.y)), std::abs(u.z / a_.z)); }

    /// One of the two norms.
    struct Blend {
        struct Tangent {
            double at_0, slope;
        };

        explicit Blend(double eps)
        {
            if (!(eps <= 2)) {  // no norm
                for (Tangent& t : tangents) t = {std::numeric_limits<double>::infinity(), 0};
                return;
            }
            double power = 1;
            for (; 2 * power * eps <= 2; power *= 2) ++squarings;
            weight = 2 / (eps * power) - 1;
            double x = 0;
            for (Tangent& t : tangents) {
                const double value = std::pow(1 + x, eps / 2), slope = eps / 2 * value / (1 + x);
                t = {(value - slope * x) * k_up, slope * k_up};
                x = 2 * x + 0.15;
            }
        }
        double operator()(double u, double v) const
        {
            const double big = u > v ? u : v, small = u > v ? v : u;
            if (!(small > 0)) return big;
            double r = small / big;
            for (int i = 0; i < squarings; ++i) r *= r;
            const double x = r + weight * (r * r - r);
            double least = tangents[0].at_0 + tangents[0].slope * x;
            for (const Tangent& t : tangents) least = std::min(least, t.at_0 + t.slope * x);
            return big * least;
        }

        static constexpr double k_up = 1 + 1e-12;  ///< more than every rounding here and in F
        int squarings = 0;                         ///< of r, to the power of two below p
        double weight = 0;                         ///< of the power of two above p
        Tangent tangents[4];                       ///< of (1 + x)^(1/p)
    };
    [[nodiscard]] const Blend& xy() const { return xy_; }
    [[nodiscard]] const Blend& z() const { return z_; }

private:
    Vec3d a_;
    Blend xy_, z_;
};

}  // namespace sqmap::fit
