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
    bool is_turned = false;                           ///< else the rotation is the identity
    Vec3d anchor{};

    /// Model space itself.
    CallerFrame() = default;
    /// touched: mesh frame -> the caller's.
    CallerFrame(const model::Header& header, const Pose& touched) noexcept;

    [[nodiscard]] Contact convert(const Contact& c) const noexcept
    {
        const float* r = rotation;
        const auto dotted = [r](Vec3f v, int row) { return r[row] * v.x + (r[row + 1] * v.y + r[row + 2] * v.z); };
        const auto turned = [&](Vec3f v) { return is_turned ? Vec3f{dotted(v, 0), dotted(v, 3), dotted(v, 6)} : v; };
        Contact out = c;
        out.witness = turned(unit * c.witness) + Vec3f{translation[0], translation[1], translation[2]};
        out.normal = turned(c.normal);
        out.depth = unit * c.depth;
        return out;
    }
};

}  // namespace sqmap::query
