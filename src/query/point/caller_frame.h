// From model space to the frame in which a query's poses are given.
#pragma once

#include "sqmap/query/body.h"
#include "sqmap/query/contact.h"

namespace sqmap::query {

/// In float, from an anchor in double. The kernels' ContactWriter does the same to vectors of contacts, in the same order of
/// operations, so that points and probes keep the same bits.
struct CallerFrame {
    float rotation[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< row by row
    float translation[3] = {};                        ///< of model space's origin, from the anchor
    float unit = 1;                                   ///< length of model space's unit
    Vec3d anchor{};

    /// Model space itself.
    CallerFrame() = default;
    /// touched: mesh frame -> the caller's.
    CallerFrame(const model::Header& header, const Pose& touched) noexcept;

    [[nodiscard]] Contact convert(const Contact& c) const noexcept
    {
        const float* r = rotation;
        const Vec3f p = unit * c.point, n = c.normal;
        const auto turned = [r](Vec3f v, int row) { return r[row] * v.x + (r[row + 1] * v.y + r[row + 2] * v.z); };
        Contact out = c;
        out.point = {turned(p, 0) + translation[0], turned(p, 3) + translation[1], turned(p, 6) + translation[2]};
        out.normal = {turned(n, 0), turned(n, 3), turned(n, 6)};
        out.depth = unit * c.depth;
        return out;
    }
};

}  // namespace sqmap::query
