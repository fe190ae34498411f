// Many points of a part at once, in the coordinates in which a superquadric is not deformed.
#pragma once

#include "power_free.h"
#include "sqmap/shape/superquadric.h"

#include <span>
#include <vector>

namespace sqmap::fit {

/// Points with a superquadric's pose and deformations undone, and the power-free bound of f at each.
class UndeformedPoints {
public:
    /// Replaces what is held. The bits are those of undeform(sq, to_local(sq, p)) and PowerFreeBound, whatever the machine.
    void take(const shape::Superquadricd& sq, std::span<const Vec3d> points);

    [[nodiscard]] std::span<const Vec3d> points() const { return points_; }
    [[nodiscard]] std::span<const double> bounds() const { return bounds_; }

private:
    std::vector<Vec3d> points_;
    std::vector<double> bounds_;
};

}  // namespace sqmap::fit
