// Superquadrics that tests run over: exponents from 0.1 to 2, long and flat, tapered, bent, moved.
#pragma once

#include "sqmap/shape/superquadric.h"

#include <vector>

namespace sqmap::test {

inline std::vector<shape::Superquadricd> sample_superquadrics(bool deformed = true)
{
    std::vector<shape::Superquadricd> out;
    const double exponents[] = {0.1, 0.3, 0.7, 1.0, 1.4, 2.0};
    const Vec3d axes[] = {{1, 1, 1}, {1, 0.5, 2}, {0.3, 1.2, 0.6}};
    int i = 0;
    for (double eps1 : exponents)
        for (double eps2 : exponents) {
            shape::Superquadricd sq;
            sq.a = axes[i % 3];
            sq.eps1 = eps1;
            sq.eps2 = eps2;
            sq.rotation = shape::rotation_of<double>({0.3 + i, 0.2 + 0.05 * i, -0.7 * i});
            sq.translation = {0.1 * i, -0.3, 0.2};
            if (deformed && i % 4 >= 2) {
                sq.taper_x = 0.5 - 0.02 * i;
                sq.taper_y = -0.3 + 0.02 * i;
            }
            if (deformed && i % 4 % 2 == 1) {
                sq.bend = 0.35 / (i % 3 == 1 ? 1.0 : 1.3);
                sq.bend_angle = 0.4 * i;
            }
            out.push_back(sq);
            ++i;
        }
    return out;
}

}  // namespace sqmap::test
