#include "triangle_offsets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "math/triangle_offsets.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "triangles-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::HWY_NAMESPACE {

void offsets(std::span<const Vec3f> corners, const PointColumns& points, float* x, float* y, float* z, float* distance)
{
    TriangleBlock block;
    const std::size_t triangles = corners.size() / 3;
    for (std::size_t first = 0; first < triangles; first += TriangleBlock::k_max) {
        const std::size_t count = std::min(triangles - first, TriangleBlock::k_max);
        for (std::size_t k = 0; k < count; k += hn::Lanes(df)) {
            HWY_ALIGN float v[9][k_lanes];
            for (std::size_t i = 0; i < hn::Lanes(df); ++i)
                for (std::size_t j = 0; j < 9; ++j)
                    v[j][i] = corners[3 * (first + std::min(k + i, count - 1)) + j / 3][static_cast<int>(j % 3)];
            const auto corner = [&](std::size_t j) {
                return V3{hn::Load(df, v[3 * j]), hn::Load(df, v[3 * j + 1]), hn::Load(df, v[3 * j + 2])};
            };
            block.put(k, corner(0), corner(1), corner(2));
        }
        for (std::size_t k = 0; k < count; ++k)
            for (std::size_t i = 0; i < points.count; i += hn::Lanes(df)) {
                const TriangleBlock::Position q =
                    block.position(k, {hn::LoadU(df, points.x + i), hn::LoadU(df, points.y + i), hn::LoadU(df, points.z + i)});
                V3 offset = block.to_face(k, q);
                if (!hn::AllTrue(df, q.above)) {
                    F edge_sq;
                    const V3 to_edge = block.to_edges(k, q, edge_sq);
                    offset = blend(q.above, offset, to_edge);
                }
                const std::size_t at = (first + k) * points.count + i;
                hn::StoreU(offset.x, df, x + at);
                hn::StoreU(offset.y, df, y + at);
                hn::StoreU(offset.z, df, z + at);
                hn::StoreU(hn::Sqrt(dot(offset, offset)), df, distance + at);
            }
    }
}

}  // namespace sqmap::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sqmap {

HWY_EXPORT(offsets);

void triangle_offsets(std::span<const Vec3f> corners, const PointColumns& points, float* x, float* y, float* z,
                      float* distance) noexcept
{
    HWY_DYNAMIC_DISPATCH(offsets)(corners, points, x, y, z, distance);
}

}  // namespace sqmap
#endif
