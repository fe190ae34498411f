// One point and one part, for what is compiled with one lane. Included once by such a source, after HWY_COMPILE_ONLY_SCALAR.
#pragma once

#include "paper/query/part-inl.h"

namespace sqmap::paper {

using namespace HWY_NAMESPACE;

namespace {

V3 lanes(Vec3f v) { return {set(v.x), set(v.y), set(v.z)}; }
M all() { return hn::Not(none()); }

/// A point that a part may hold.
struct OnePoint {
    PartLanes part;
    V3 p;
    HeldLanes held;
    bool is_held = false;

    OnePoint(const MapView& map, Vec3f point, const ProjectionOptions& options) : part(map, options, nullptr), p(lanes(point))
    {
        if (!is_finite(point)) return;
        held.q = part.shape().to_local(p);
        held.unit = part.shape().to_unit(held.q);
        is_held = any(in_box(held.unit)) && any(holds(part.shape(), held));
    }
};

}  // namespace

}  // namespace sqmap::paper
