// The kernel of layer One with one lane: the reference, and quicker for one point.
#undef HWY_COMPILE_ONLY_STATIC
#define HWY_COMPILE_ONLY_SCALAR
#include "layer_one.h"

#include <hwy/highway.h>

#include "layer_one-inl.h"
#include "sqmap/math/assert.h"

namespace sqmap::query {

using namespace HWY_NAMESPACE;

ModelContact query_layer_one(const model::ModelView& model, Vec3f point) noexcept
{
    SQMAP_ASSERT(is_finite(point));
    PointsOfLayerOne points(model);
    points.add({set(point.x), set(point.y), set(point.z)}, hn::Zero(di), hn::Not(none()));
    points.answer(false);
    ModelContact contact = free_at(point);
    points.each_contact([&](const ContactLanes& c, M) {
        contact = {{hn::GetLane(c.witness.x), hn::GetLane(c.witness.y), hn::GetLane(c.witness.z)},
                   {hn::GetLane(c.normal.x), hn::GetLane(c.normal.y), hn::GetLane(c.normal.z)},
                   hn::GetLane(c.depth),
                   hn::GetLane(c.part),
                   true,
                   false,
                   k_ok};
    });
    return contact;
}

}  // namespace sqmap::query
