// A triangle's piece in a locator cell.
#pragma once

#include "sqmap/math/vec.h"

#include <array>

namespace sqmap::bake {

/// A triangle cut to a cube leaves at most nine corners.
struct ClippedTriangle {
    Vec3d corners[9];
    int count = 0;
};

/// Cut to the cube about the origin (Sutherland and Hodgman 1974).
inline ClippedTriangle clip_to_cube(const std::array<Vec3d, 3>& triangle, double half)
{
    ClippedTriangle piece{{triangle[0], triangle[1], triangle[2]}, 3};
    for (int axis = 0; axis < 3; ++axis) {
        const double a = triangle[0][axis], b = triangle[1][axis], c = triangle[2][axis];
        if ((a > half && b > half && c > half) || (a < -half && b < -half && c < -half)) return {{}, 0};
    }
    for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {1.0, -1.0}) {
            const auto inside_by = [&](Vec3d p) { return half - sign * p[axis]; };
            bool whole = true;
            for (int i = 0; i < piece.count; ++i) whole = whole && inside_by(piece.corners[i]) >= 0;
            if (whole) continue;
            ClippedTriangle next;
            for (int i = 0; i < piece.count; ++i) {
                const Vec3d a = piece.corners[i], b = piece.corners[(i + 1) % piece.count];
                const double at_a = inside_by(a), at_b = inside_by(b);
                if (at_a >= 0) next.corners[next.count++] = a;
                if ((at_a < 0) != (at_b < 0)) next.corners[next.count++] = a + (at_a / (at_a - at_b)) * (b - a);
            }
            piece = next;
        }
    return piece;
}

}  // namespace sqmap::bake
