#include "make_path.h"

#include "distance_grid.h"
#include "error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

namespace sqmap::bench {
namespace {

Mat3d turned(int axis, double angle)
{
    Mat3d m;
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    m.row[a][a] = m.row[b][b] = std::cos(angle);
    m.row[a][b] = -std::sin(angle);
    m.row[b][a] = std::sin(angle);
    return m;
}

/// Least signed distance of the probe's vertices; where none is in the field's box, how far the nearest is from it.
double least_distance(const Setting& setting, const DistanceGrid& grid, const Pose& pose)
{
    double least = std::numeric_limits<double>::infinity();
    for (const Vec3d& v : setting.probe.vertices) {
        const Vec3d p = apply(pose, v);
        double value = 0;
        Vec3d q = p;
        for (int k = 0; k < 3; ++k)
            q[k] = std::clamp(q[k], grid.lo[k], grid.lo[k] + grid.spacing[k] * (grid.samples - 1) * (1 - 1e-9));
        if (interpolate(grid, q, value)) least = std::min(least, p == q ? value : std::max(value, 0.0) + norm(p - q));
    }
    return least;
}

}  // namespace

std::vector<Pose> sliding_path(const Setting& setting, const PathOptions& options)
{
    const DistanceGrid grid = distance_grid(setting, options.field_samples);
    std::vector<Pose> path;
    double reach = std::numeric_limits<double>::infinity();  // from the centre, of the frame before
    for (std::uint32_t f = 0; f < options.frames; ++f) {
        const double t = 2 * std::numbers::pi * f / 1000;  // a round in 1000 frames
        const double height = 0.6 * std::sin(2 * t + 0.3), around = t;
        const Vec3d out{std::cos(height) * std::cos(around), std::cos(height) * std::sin(around), std::sin(height)};
        Pose pose{turned(2, t) * turned(1, 0.5 + 0.7 * std::sin(t)) * turned(0, 3 * t), {}};
        const auto excess = [&](double along) {  // above zero: not deep enough
            pose.translation = along * out;
            return least_distance(setting, grid, pose) + options.depth;
        };
        // From outside inwards by steps that cannot pass the first contact, starting a little outside the last frame.
        const double farthest = 0.5 * (k_object_diagonal + k_probe_diagonal) + std::max(0.0, -options.depth);
        double outer = std::min(farthest, reach + 0.02);
        if (excess(outer) <= 0) outer = farthest;
        double inner = outer;
        for (double e = excess(outer); e > 0; e = excess(inner)) {
            if (inner < -farthest)
                throw BenchError("pose " + std::to_string(f + 1) +
                                 " of the path passes the object without being so deep in it\n"
                                 "  cure: another probe or object: a part of it that is thicker than the depth asked for");
            outer = inner;
            inner -= std::max(0.9 * e, 1e-3);
        }
        for (int i = 0; i < 14 && inner < outer; ++i) {
            const double middle = 0.5 * (inner + outer);
            (excess(middle) > 0 ? outer : inner) = middle;
        }
        reach = 0.5 * (inner + outer);
        pose.translation = reach * out;
        path.push_back(pose);
    }
    return path;
}

}  // namespace sqmap::bench
