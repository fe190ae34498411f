#include "scaled_part.h"

#include "sqmap/math/box.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace sqmap::fit {

namespace {

Mat3d principal_frame(std::span<const Corners> triangles, Vec3d origin)
{
    Eigen::Matrix3d moment = Eigen::Matrix3d::Zero(), corner_moment = Eigen::Matrix3d::Zero();
    Eigen::Vector3d first = Eigen::Vector3d::Zero(), corner_first = Eigen::Vector3d::Zero();
    double area = 0;
    const auto eigen = [&](Vec3d v) { return Eigen::Vector3d(v.x - origin.x, v.y - origin.y, v.z - origin.z); };
    for (const Corners& t : triangles) {
        const double a = norm(cross(t[1] - t[0], t[2] - t[0])) / 2;
        const Eigen::Vector3d p = eigen(t[0]), q = eigen(t[1]), r = eigen(t[2]), s = p + q + r;
        const Eigen::Matrix3d corners = p * p.transpose() + q * q.transpose() + r * r.transpose();
        moment += a / 12 * (corners + s * s.transpose());
        first += a / 3 * s;
        area += a;
        corner_moment += corners;
        corner_first += s;
    }
    // Corners keep a say, so that triangles without area have axes too.
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    if (area > 0) covariance = moment / area - first * first.transpose() / (area * area);
    const double count = 3.0 * static_cast<double>(std::max<std::size_t>(1, triangles.size()));
    covariance += 1e-3 * (corner_moment / count - corner_first * corner_first.transpose() / (count * count));
    const double trace = covariance.trace();
    if (!(trace > 0) || !std::isfinite(trace)) return {};

    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(Eigen::Matrix3d(covariance / trace));
    const Eigen::Matrix3d axes = solver.eigenvectors();
    Mat3d frame;
    for (int i = 0; i < 3; ++i) frame.row[i] = {axes(0, 2 - i), axes(1, 2 - i), axes(2, 2 - i)};
    for (int i = 0; i < 2; ++i) {  // an eigenvector's sign means nothing: make it the same on every machine
        const Vec3d v = frame.row[i];
        const double largest =
            std::abs(v.x) >= std::abs(v.y) && std::abs(v.x) >= std::abs(v.z) ? v.x : (std::abs(v.y) >= std::abs(v.z) ? v.y : v.z);
        if (largest < 0) frame.row[i] = -v;
    }
    frame.row[2] = cross(frame.row[0], frame.row[1]);
    return frame;
}

/// Stratified by area in the order of the triangles, with the R2 sequence within them.
std::vector<Sample> sample(std::span<const Corners> triangles, int count)
{
    std::vector<double> sum;
    double area = 0;
    for (const Corners& t : triangles) sum.push_back(area += norm(cross(t[1] - t[0], t[2] - t[0])) / 2);
    std::vector<Sample> samples;
    if (!(area > 0)) {
        for (const Corners& t : triangles) {
            if (static_cast<int>(samples.size()) >= count) break;
            for (const Vec3d& v : t) samples.push_back({v, 1});
        }
    } else {
        std::size_t at = 0;
        double u = 0.5, v = 0.5;
        for (int i = 0; i < count; ++i) {
            while (at + 1 < triangles.size() && sum[at] < area * (i + 0.5) / count) ++at;
            u = u + 0.7548776662466927 - (u + 0.7548776662466927 >= 1);
            v = v + 0.5698402909980532 - (v + 0.5698402909980532 >= 1);
            const bool fold = u + v > 1;
            const double b1 = fold ? 1 - u : u, b2 = fold ? 1 - v : v;
            samples.push_back(
                {triangles[at][0] + b1 * (triangles[at][1] - triangles[at][0]) + b2 * (triangles[at][2] - triangles[at][0]), 1});
        }
    }
    for (Sample& s : samples) s.weight = 1 / std::sqrt(static_cast<double>(samples.size()));
    return samples;
}
/// Points that lie farthest in some of many directions, the directions stretched with the box so that needles and sheets
/// are covered as evenly as balls.
std::vector<Vec3d> extreme_points(std::span<const Vec3d> points, const Mat3d& frame, Vec3d half, int directions)
{
    std::vector<std::size_t> chosen;
    for (int i = 0; i < directions; ++i) {
        const double z = 1 - (2 * i + 1.0) / directions, r = std::sqrt(1 - z * z);
        const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
        const Vec3d d = transpose_mul(frame, Vec3d{r * std::cos(angle) / half.x, r * std::sin(angle) / half.y, z / half.z});
        std::size_t best = 0;
        double reach = -std::numeric_limits<double>::infinity();
        for (std::size_t k = 0; k < points.size(); ++k) {
            const double along = dot(d, points[k]);
            if (along > reach) {
                reach = along;
                best = k;
            }
        }
        chosen.push_back(best);
    }
    std::sort(chosen.begin(), chosen.end());
    chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
    std::vector<Vec3d> extreme;
    for (const std::size_t k : chosen) extreme.push_back(points[k]);
    return extreme;
}

void add_inner_points(const Corners& t, Vec3d middle, double size, std::vector<Vec3d>& points)
{
    const double longest = std::max({norm(t[1] - t[0]), norm(t[2] - t[1]), norm(t[0] - t[2])}) / size;
    const int n = std::min(4, static_cast<int>(longest / 0.2));
    for (int i = 0; n >= 2 && i <= n; ++i)
        for (int j = 0; i + j <= n; ++j)
            if (i != n && j != n && i + j != 0)
                points.push_back((t[0] + (double(i) / n) * (t[1] - t[0]) + (double(j) / n) * (t[2] - t[0]) - middle) / size);
}

/// Triangles, their corners and the faces between those, model space.
void gather(const mesh::Mesh& mesh, std::span<const std::uint32_t> triangles, std::span<const Corners> caps, ScaledPart& part)
{
    for (const std::uint32_t t : triangles)
        part.triangles.push_back(
            {mesh.vertices[mesh.triangles[t][0]], mesh.vertices[mesh.triangles[t][1]], mesh.vertices[mesh.triangles[t][2]]});
    part.triangles.insert(part.triangles.end(), caps.begin(), caps.end());

    std::vector<std::uint32_t> corners;
    for (const std::uint32_t t : triangles) corners.insert(corners.end(), mesh.triangles[t].begin(), mesh.triangles[t].end());
    std::sort(corners.begin(), corners.end());
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    for (const std::uint32_t v : corners) part.points.push_back(mesh.vertices[v]);
    for (const std::uint32_t t : triangles) {
        mesh::Triangle& face = part.faces.emplace_back();
        for (std::size_t k = 0; k < 3; ++k)
            face[k] = static_cast<std::uint32_t>(std::lower_bound(corners.begin(), corners.end(), mesh.triangles[t][k]) -
                                                 corners.begin());
    }
    for (const Corners& t : caps) {
        const auto first = static_cast<std::uint32_t>(part.points.size());
        part.faces.push_back({first, first + 1, first + 2});
        part.points.insert(part.points.end(), t.begin(), t.end());
    }
    part.corners = part.points;
    if (part.points.empty()) part.points.push_back({});
}

}  // namespace

OrientedBox box_of(const Mat3d& frame, std::span<const Vec3d> points)
{
    Box box;
    for (const Vec3d& p : points) extend(box, frame * p);
    return {transpose_mul(frame, centre(box)), 0.5 * size(box)};
}

ScaledPart scaled_part(const mesh::Mesh& mesh, std::span<const std::uint32_t> triangles, std::span<const Corners> caps,
                       const FitOptions& options)
{
    ScaledPart part;
    gather(mesh, triangles, caps, part);
    part.frame = principal_frame(part.triangles, part.points[0]);
    part.middle = box_of(part.frame, part.points).middle;
    double size = 0;
    for (const Vec3d& p : part.points) size = std::max(size, norm(p - part.middle));
    // Not thinner than float coordinates can distinguish from the middle.
    const double least = std::max(2e-3 * size, std::max(5e-5 * norm(part.middle), 1e-30));
    part.size = std::max(size, 2 * least);
    part.min_a = least / part.size;

    std::vector<Corners> local;
    for (Vec3d& p : part.points) p = (p - part.middle) / part.size;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        Corners t = part.triangles[i];
        for (Vec3d& v : t) v = (v - part.middle) / part.size;
        local.push_back(t);
    }
    part.points_inner = part.points;
    for (const Corners& t : part.triangles) add_inner_points(t, part.middle, part.size, part.points_inner);
    part.samples = sample(local, std::max(options.max_samples, 1));
    Vec3d half = box_of(part.frame, part.points).half;
    for (int k = 0; k < 3; ++k) half[k] = std::max(half[k], part.min_a);
    part.extreme = part.points.size() > 200 ? extreme_points(part.points, part.frame, half, 200) : part.points;
    part.extreme_inner = part.extreme;
    const std::size_t inner = part.points_inner.size() - part.points.size(), step = 1 + inner / 80;
    for (std::size_t i = part.points.size(); i < part.points_inner.size(); i += step)
        part.extreme_inner.push_back(part.points_inner[i]);
    const std::size_t thin = 1 + part.points_inner.size() / 500;
    for (std::size_t i = 0; i < part.points_inner.size(); i += thin) part.check.push_back(part.points_inner[i]);
    return part;
}

Chart chart_of(const ScaledPart& part, const FitOptions& options)
{
    Chart chart;
    chart.min_a = part.min_a * 0.999;
    chart.max_a = 2;
    chart.min_eps = options.min_exponent;
    chart.max_eps = std::max(options.max_exponent, options.min_exponent + 1e-6);
    return chart;
}

}  // namespace sqmap::fit
