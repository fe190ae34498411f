// Eigenvectors of symmetric 3 x 3 matrices, and least squares with planes.
#pragma once

#include "sqmap/math/vec.h"

#include <array>

namespace sqmap::mesh {

/// Sum of squared distances from planes: x A x - 2 b x + c.
struct PlaneSum {
    double a[6] = {};  ///< xx yy zz xy xz yz
    Vec3d b;
    double c = 0;

    /// Adds the plane through p with that normal.
    void add(Vec3d p, Vec3d normal, double weight = 1)
    {
        const double d = dot(normal, p);
        const double products[6] = {normal.x * normal.x, normal.y * normal.y, normal.z * normal.z,
                                    normal.x * normal.y, normal.x * normal.z, normal.y * normal.z};
        for (int k = 0; k < 6; ++k) a[k] += weight * products[k];
        b += weight * d * normal;
        c += weight * d * d;
    }
    PlaneSum& operator+=(const PlaneSum& other)
    {
        for (int k = 0; k < 6; ++k) a[k] += other.a[k];
        b += other.b;
        c += other.c;
        return *this;
    }
    [[nodiscard]] Vec3d times(Vec3d x) const
    {
        return {a[0] * x.x + a[3] * x.y + a[4] * x.z, a[3] * x.x + a[1] * x.y + a[5] * x.z, a[4] * x.x + a[5] * x.y + a[2] * x.z};
    }
    [[nodiscard]] double at(Vec3d x) const { return dot(x, times(x)) - 2 * dot(b, x) + c; }
};

/// The point of least sum, nearest to start: directions whose eigenvalue is below that share of the greatest stay as they are.
[[nodiscard]] Vec3d least_point(const PlaneSum& sum, Vec3d start, double share);
/// The same in a tenth of the time, with that share of the sum of eigenvalues added to each: all directions are damped.
[[nodiscard]] Vec3d damped_least_point(const PlaneSum& sum, Vec3d start, double share);

}  // namespace sqmap::mesh
