#include "sqmap/haptic/tactile.h"

#include "sqmap/math/assert.h"

namespace sqmap::haptic {

TactilePad::TactilePad(std::span<const Vec3d> points, std::span<const Vec3d> normals)
    : probe_(points), points_(points.begin(), points.end()), contacts_(points.size())
{
    SQMAP_ASSERT(points.size() == normals.size());
    normals_.reserve(normals.size());
    for (const Vec3d& n : normals) {
        const double length = norm(n);
        normals_.push_back(length > 0 ? (1 / length) * n : Vec3d{});
    }
}

}  // namespace sqmap::haptic
