#include "refit.h"

#include "sqmap/query/probe.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/probe/refit.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "math/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {

using namespace sqmap::HWY_NAMESPACE;

constexpr std::size_t k_ahead = 16;  ///< clusters whose points are fetched early

/// Fills all lanes with the least and the greatest of a cluster's values along an axis.
HWY_INLINE void extent(const float* v, F& least, F& greatest)
{
    least = greatest = hn::LoadU(df, v);
    for (std::size_t i = hn::Lanes(df); i < Probe::k_cluster; i += hn::Lanes(df)) {
        least = hn::Min(hn::LoadU(df, v + i), least);
        greatest = hn::Max(hn::LoadU(df, v + i), greatest);
    }
    least = hn::MinOfLanes(df, least);
    greatest = hn::MaxOfLanes(df, greatest);
}

void fill(const Vec3d* points, const std::uint32_t* index, Vec3d origin, const std::uint8_t* wanted, float far,
          const ClusterColumns& to)
{
    const F half = set(0.5f);
    for (std::size_t c = 0; c < to.clusters; ++c) {
        const std::uint32_t* own = index + c * Probe::k_cluster;
        float *x = to.x + c * Probe::k_cluster, *y = to.y + c * Probe::k_cluster, *z = to.z + c * Probe::k_cluster;
        // Points come in their own order, which no machine foresees.
        const std::size_t ahead = std::min(c + k_ahead, to.clusters - 1) * Probe::k_cluster;
        for (std::size_t i = 0; i < Probe::k_cluster; ++i)
            if (wanted == nullptr || wanted[index[ahead + i]] != 0) hwy::Prefetch(&points[index[ahead + i]]);
        std::size_t shown = 0;
        if (wanted != nullptr)
            while (shown < Probe::k_cluster && wanted[own[shown]] == 0) ++shown;
        if (shown == Probe::k_cluster) {
            if (to.centre_x[c] == far) continue;  // as it was
            for (std::size_t i = 0; i < Probe::k_cluster; ++i) x[i] = y[i] = z[i] = far;
            to.centre_x[c] = to.centre_y[c] = to.centre_z[c] = far;
            to.radius[c] = 0;
            continue;
        }
        for (std::size_t i = 0; i < Probe::k_cluster; ++i) {
            const std::uint32_t p = wanted == nullptr || wanted[own[i]] != 0 ? own[i] : own[shown];
            x[i] = static_cast<float>(points[p].x - origin.x);
            y[i] = static_cast<float>(points[p].y - origin.y);
            z[i] = static_cast<float>(points[p].z - origin.z);
        }
        F lo[3], hi[3];
        extent(x, lo[0], hi[0]);
        extent(y, lo[1], hi[1]);
        extent(z, lo[2], hi[2]);
        const F cx = hn::Mul(half, hn::Add(lo[0], hi[0])), cy = hn::Mul(half, hn::Add(lo[1], hi[1])),
                cz = hn::Mul(half, hn::Add(lo[2], hi[2]));
        F far_sq = hn::Zero(df);
        for (std::size_t i = 0; i < Probe::k_cluster; i += hn::Lanes(df)) {
            const F dx = hn::Sub(hn::LoadU(df, x + i), cx), dy = hn::Sub(hn::LoadU(df, y + i), cy),
                    dz = hn::Sub(hn::LoadU(df, z + i), cz);
            far_sq = hn::Max(mul_add(dz, dz, mul_add(dy, dy, hn::Mul(dx, dx))), far_sq);
        }
        to.centre_x[c] = hn::GetLane(cx);
        to.centre_y[c] = hn::GetLane(cy);
        to.centre_z[c] = hn::GetLane(cz);
        to.radius[c] = std::sqrt(hn::GetLane(hn::MaxOfLanes(df, far_sq))) * 1.00001f;
    }
}

}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sqmap::query {

HWY_EXPORT(fill);

void fill_clusters(const Vec3d* points, const std::uint32_t* index, Vec3d origin, const std::uint8_t* wanted, float far,
                   const ClusterColumns& to) noexcept
{
    HWY_DYNAMIC_DISPATCH(fill)(points, index, origin, wanted, far, to);
}

}  // namespace sqmap::query
#endif
