#include "collider/searches.h"

#include "sqmap/math/rotation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sqmap::collider {
namespace {

constexpr double k_same_direction = 0.9986;  ///< cosine of 3 degrees

}  // namespace

Mat3d axes_along(Vec3d direction)
{
    const Vec3d z = normalized(direction);
    const Vec3d x = normalized(cross(std::abs(z.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}, z)), y = cross(z, x);
    return transpose(Mat3d{{x, y, z}});
}

Mat3d turned(const Mat3d& axes, Vec3d by) { return rotation_by(by) * axes; }

std::vector<Vec3d> half_sphere(int count)
{
    std::vector<Vec3d> out;
    for (int i = 0; i < count; ++i) {
        const double z = 1 - (i + 0.5) / count, r = std::sqrt(1 - z * z), angle = std::numbers::pi * (3 - std::sqrt(5.)) * i;
        out.push_back({r * std::cos(angle), r * std::sin(angle), z});
    }
    return out;
}

std::vector<Vec3d> facet_normals(const mesh::Mesh& hull, std::size_t count)
{
    std::vector<Vec3d> scaled;
    for (const mesh::Triangle& t : hull.triangles) {
        const Vec3d a = hull.vertices[t[0]];
        scaled.push_back(cross(hull.vertices[t[1]] - a, hull.vertices[t[2]] - a));
    }
    std::stable_sort(scaled.begin(), scaled.end(), [](Vec3d l, Vec3d r) { return norm_sq(l) > norm_sq(r); });
    std::vector<Vec3d> out;
    for (const Vec3d& v : scaled) {
        if (out.size() == count) break;
        const Vec3d n = normalized(v);
        if (norm(n) > 0.5 &&
            std::none_of(out.begin(), out.end(), [&](Vec3d o) { return std::abs(dot(o, n)) > k_same_direction; }))
            out.push_back(n);
    }
    return out;
}

}  // namespace sqmap::collider
