#include "admit_steps.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace sqmap::mesh {
namespace {

constexpr double k_plane_rounding = 1e-12;  // of the diagonal: rounding of a plane

}  // namespace

std::string length_text(double length)
{
    char text[32];
    std::snprintf(text, sizeof text, "%.2g", length);
    return text;
}

Flatness flatness_of(const Surface& surface, std::span<const Vec3d> points, std::span<const std::uint32_t> component,
                     double scale)
{
    Flatness out;
    Vec3d mean{};
    // Volumes are summed by component: shells may be turned either way, and small solids far apart are not a sheet.
    std::vector<double> six_volumes_of(surface.faces.size(), 0), area_of_component(surface.faces.size(), 0);
    for (std::size_t i = 0; i < surface.faces.size(); ++i) {
        const Face& f = surface.faces[i];
        const Vec3d a = points[f.v[0]], b = points[f.v[1]], c = points[f.v[2]];
        const double w = 0.5 * norm(cross(b - a, c - a));
        out.area += w;
        mean += w / 3.0 * (a + b + c);
        six_volumes_of[component[i]] += six_volumes(points, f.v);
        area_of_component[component[i]] += w;
    }
    if (!(out.area > 0)) return out;
    // A plate of thickness t has a volume of t times half its area.
    out.encloses_volume = false;
    double thickness = 0;
    for (std::size_t i = 0; i < six_volumes_of.size(); ++i) {
        const double twice_volume = std::abs(six_volumes_of[i]) / 3, area = area_of_component[i];
        out.encloses_volume = out.encloses_volume || twice_volume > k_flat_thickness * std::pow(area, 1.5);
        if (area > 0) thickness = std::max(thickness, twice_volume / area);
    }
    out.message = "the shells are sheets folded onto themselves, " + length_text(thickness * scale) + " thick on average";

    mean = mean / out.area;
    Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
    for (const Face& f : surface.faces) {
        const Vec3d corner[3] = {points[f.v[0]] - mean, points[f.v[1]] - mean, points[f.v[2]] - mean};
        const double w = 0.5 * norm(cross(corner[1] - corner[0], corner[2] - corner[0])) / (3 * out.area);
        for (const Vec3d& p : corner) {
            const Eigen::Vector3d x(p.x, p.y, p.z);
            moments += w * x * x.transpose();
        }
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(moments);
    out.is_plane = std::sqrt(std::max(0.0, axes.eigenvalues()[0])) < k_flat_thickness * std::sqrt(out.area);
    if (!out.is_plane) return out;
    const Eigen::Vector3d n = axes.eigenvectors().col(0);
    double lo = 0, hi = 0;
    for (const Face& f : surface.faces)
        for (const std::uint32_t v : f.v) {
            const Vec3d p = points[v] - mean;
            const double height = n.x() * p.x + n.y() * p.y + n.z() * p.z;
            lo = std::min(lo, height);
            hi = std::max(hi, height);
        }
    out.message = hi - lo < k_plane_rounding ? "all faces lie in one plane"
                                             : "the mesh is only " + length_text((hi - lo) * scale) + " thick and " +
                                                   length_text(scale) + " across: a sheet";
    return out;
}

}  // namespace sqmap::mesh
