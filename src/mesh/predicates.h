// Signs of determinants of points, exact whatever the rounding.
#pragma once

#include "sqmap/math/vec.h"

namespace sqmap::mesh {

struct Vec2d {
    double x, y;
};

/// Sign of the volume of the tetrahedron: +1 where d lies below the plane through a, b, c (they turn clockwise seen from d
/// is -1), 0 where all four are in one plane. Exact where coordinates are zero or
/// between 1e-70 and 1e70 in size; beyond that products overflow or vanish, and the sign may be any.
int orient3d(Vec3d a, Vec3d b, Vec3d c, Vec3d d);

/// +1 where a, b, c turn counter-clockwise, -1 clockwise, 0 on one line. Exact as orient3d.
int orient2d(Vec2d a, Vec2d b, Vec2d c);

}  // namespace sqmap::mesh
