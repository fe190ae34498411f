#include "math/double_targets.h"  // before Highway

#include "skin_kernels.h"

#include <bit>
#include <cmath>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/skin/skin_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "math/double_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
using namespace sqmap::HWY_NAMESPACE;
namespace {

using MD = hn::Mask<DD>;
constexpr std::size_t k_slots = 8;  ///< for six orders

HWY_INLINE std::uint32_t bits_of(MD mask)
{
    HWY_ALIGN std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(dd, mask, bytes);
    return bytes[0];
}

/// The box of a cluster's points that are there.
HWY_INLINE void extent(const double* v, double& lo, double& hi)
{
    D least = hn::Set(dd, INFINITY), greatest = hn::Set(dd, -INFINITY);
    for (std::size_t i = 0; i < SkinCluster::k_points; i += hn::Lanes(dd)) {
        const D at = hn::LoadU(dd, v + i);
        const MD there = hn::Eq(at, at);
        least = hn::Min(least, hn::IfThenElse(there, at, least));
        greatest = hn::Max(greatest, hn::IfThenElse(there, at, greatest));
    }
    lo = hn::GetLane(hn::MinOfLanes(dd, least));
    hi = hn::GetLane(hn::MaxOfLanes(dd, greatest));
}

HWY_INLINE std::uint32_t points_in(const PosedSkin::Box& box, double slack, const SkinCluster& c)
{
    std::uint32_t points = 0;
    const double* v[3] = {c.x, c.y, c.z};
    for (std::size_t i = 0; i < SkinCluster::k_points; i += hn::Lanes(dd)) {
        MD in = hn::FirstN(dd, hn::Lanes(dd));
        for (int k = 0; k < 3; ++k) {
            const D at = hn::LoadU(dd, v[k] + i);
            in = hn::And(in, hn::And(hn::Ge(at, hn::Set(dd, box.lo[k] - slack)), hn::Le(at, hn::Set(dd, box.hi[k] + slack))));
        }
        points |= bits_of(in) << i;
    }
    return points;
}

std::uint32_t leaves(std::span<const SkinLattice::Node> nodes, std::span<const PosedSkin::Box> boxes, double slack,
                     const SkinCluster& cluster, std::uint32_t from, std::span<SkinLeaf> found, std::size_t& count)
{
    double lo[3], hi[3];
    extent(cluster.x, lo[0], hi[0]);
    extent(cluster.y, lo[1], hi[1]);
    extent(cluster.z, lo[2], hi[2]);
    const auto end = static_cast<std::uint32_t>(boxes.size());
    std::uint32_t i = from;
    for (count = 0; i < end && count < found.size();) {
        const PosedSkin::Box& box = boxes[i];
        const bool reaches = hi[0] >= box.lo.x - slack && lo[0] <= box.hi.x + slack && hi[1] >= box.lo.y - slack &&
                             lo[1] <= box.hi.y + slack && hi[2] >= box.lo.z - slack && lo[2] <= box.hi.z + slack;
        const SkinLattice::Node& node = nodes[i];
        if (!reaches) {
            i = node.next;
            continue;
        }
        if (node.bone != SkinLattice::k_none || node.blend != SkinLattice::k_none)
            if (const std::uint32_t points = points_in(box, slack, cluster); points != 0) found[count++] = {i, points};
        ++i;
    }
    return i;
}

std::size_t hits(const std::array<Vec3d, 8>& corners, double least, double border, const SkinCluster& cluster,
                 std::uint32_t points, std::span<CellHit, k_max_cell_hits> found)
{
    // The second and third corners of each order's path; what fills the vectors is never asked.
    HWY_ALIGN double second[3][k_slots], third[3][k_slots];
    for (std::size_t o = 0; o < k_slots; ++o) {
        const KuhnOrder& order = k_kuhn_orders[o < 6 ? o : 0];
        const std::uint32_t one = 1u << order.axis[0], two = one | 1u << order.axis[1];
        for (int k = 0; k < 3; ++k) {
            second[k][o] = corners[one][k];
            third[k][o] = corners[two][k];
        }
    }
    HWY_ALIGN double rows[9][k_slots], inverse[k_slots];
    std::uint32_t holds = 0, positive = 0;
    for (std::size_t o = 0; o < k_slots; o += hn::Lanes(dd)) {
        const D3 p1{hn::Load(dd, second[0] + o), hn::Load(dd, second[1] + o), hn::Load(dd, second[2] + o)},
            p2{hn::Load(dd, third[0] + o), hn::Load(dd, third[1] + o), hn::Load(dd, third[2] + o)};
        const D3 a = minus(p1, all(corners[0])), b = minus(p2, p1), c = minus(all(corners[7]), p2);
        const D3 row[3] = {cross(b, c), cross(c, a), cross(a, b)};
        const D det = dot(a, row[0]);
        holds |= bits_of(hn::Gt(hn::Abs(det), hn::Set(dd, least))) << o;
        positive |= bits_of(hn::Gt(det, hn::Zero(dd))) << o;
        hn::Store(hn::Div(hn::Set(dd, 1.0), det), dd, inverse + o);
        for (int r = 0; r < 3; ++r) {
            hn::Store(row[r].x, dd, rows[3 * r] + o);
            hn::Store(row[r].y, dd, rows[3 * r + 1] + o);
            hn::Store(row[r].z, dd, rows[3 * r + 2] + o);
        }
    }
    holds &= 0x3f;
    std::size_t count = 0;
    if (holds == 0) return count;
    const D above = hn::Set(dd, 1 + border), slack = hn::Set(dd, border);
    for (; points != 0; points &= points - 1) {
        const auto point = static_cast<std::size_t>(std::countr_zero(points));
        const D3 d = all(Vec3d{cluster.x[point], cluster.y[point], cluster.z[point]} - corners[0]);
        HWY_ALIGN double along[3][k_slots];
        std::uint32_t in = 0;
        for (std::size_t o = 0; o < k_slots; o += hn::Lanes(dd)) {
            const D over = hn::Load(dd, inverse + o);
            D v[3];
            for (int r = 0; r < 3; ++r) {
                const D3 row{hn::Load(dd, rows[3 * r] + o), hn::Load(dd, rows[3 * r + 1] + o), hn::Load(dd, rows[3 * r + 2] + o)};
                v[r] = hn::Mul(over, dot(row, d));
                hn::Store(v[r], dd, along[r] + o);
            }
            const MD upper = hn::And(hn::Le(v[0], above), hn::Le(v[1], hn::Add(v[0], slack)));
            const MD lower = hn::And(hn::Le(v[2], hn::Add(v[1], slack)), hn::Ge(v[2], hn::Neg(slack)));
            in |= bits_of(hn::And(upper, lower)) << o;
        }
        for (in &= holds; in != 0; in &= in - 1) {
            const auto o = static_cast<std::size_t>(std::countr_zero(in));
            found[count++] = {{along[0][o], along[1][o], along[2][o]},
                              static_cast<std::uint8_t>(point),
                              static_cast<std::uint8_t>(o),
                              (positive >> o & 1u) != 0};
        }
    }
    return count;
}

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sqmap::query {

HWY_EXPORT(leaves);
HWY_EXPORT(hits);

std::uint32_t leaves_about(std::span<const SkinLattice::Node> nodes, std::span<const PosedSkin::Box> boxes, double slack,
                           const SkinCluster& cluster, std::uint32_t from, std::span<SkinLeaf> found, std::size_t& count) noexcept
{
    return HWY_DYNAMIC_DISPATCH(leaves)(nodes, boxes, slack, cluster, from, found, count);
}

std::size_t cell_hits(const std::array<Vec3d, 8>& corners, double least, double border, const SkinCluster& cluster,
                      std::uint32_t points, std::span<CellHit, k_max_cell_hits> found) noexcept
{
    return HWY_DYNAMIC_DISPATCH(hits)(corners, least, border, cluster, points, found);
}

}  // namespace sqmap::query
#endif
