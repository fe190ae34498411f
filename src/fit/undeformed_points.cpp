#include "math/double_targets.h"  // before Highway

#include "undeformed_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fit/undeformed_points.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "math/double_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::fit::HWY_NAMESPACE {
namespace {

using namespace sqmap::HWY_NAMESPACE;

HWY_INLINE D set(double v) { return hn::Set(dd, v); }

/// std::atan2 lane by lane: vectors have none that gives every machine the same bits.
HWY_INLINE D atan2_of(D y, D x)
{
    alignas(64) double up[8], along[8];
    hn::Store(y, dd, up);
    hn::Store(x, dd, along);
    for (std::size_t i = 0; i < hn::Lanes(dd); ++i) up[i] = std::atan2(up[i], along[i]);
    return hn::Load(dd, up);
}

/// One superquadric, as vectors of points need it.
class Undeforming {
public:
    HWY_INLINE Undeforming(const shape::Superquadricd& sq, const PowerFreeBound& bound)
        : sq_(sq), bound_(bound), ca_(std::cos(sq.bend_angle)), sa_(std::sin(sq.bend_angle))
    {
    }

    /// As to_local and undeform compute it for one point.
    HWY_INLINE D3 operator()(const D3& p) const
    {
        const D3 arm = minus(p, all(sq_.translation));
        D3 q{dot(all(sq_.rotation.row[0]), arm), dot(all(sq_.rotation.row[1]), arm), dot(all(sq_.rotation.row[2]), arm)};
        if (sq_.is_bent()) q = straightened(q);
        if (sq_.is_tapered()) {
            q.x = hn::Div(q.x, taper_at(sq_.taper_x, q.z));
            q.y = hn::Div(q.y, taper_at(sq_.taper_y, q.z));
        }
        return q;
    }

    /// As PowerFreeBound computes it for one point.
    HWY_INLINE D bound(const D3& u) const
    {
        const D x = hn::Abs(hn::Div(u.x, set(sq_.a.x))), y = hn::Abs(hn::Div(u.y, set(sq_.a.y)));
        return blend(bound_.z(), blend(bound_.xy(), x, y), hn::Abs(hn::Div(u.z, set(sq_.a.z))));
    }

private:
    HWY_INLINE D3 straightened(const D3& q) const
    {
        const D ca = set(ca_), sa = set(sa_), k = set(sq_.bend), one = set(1);
        const D across = hn::Add(hn::Mul(ca, q.x), hn::Mul(sa, q.y)), up = hn::Mul(k, q.z);
        const D from_centre = hn::Sub(one, hn::Mul(k, across)), gamma = atan2_of(up, from_centre);
        const D radius = hn::Sqrt(hn::Add(hn::Mul(up, up), hn::Mul(from_centre, from_centre)));
        const D square = hn::Add(hn::Mul(across, across), hn::Mul(q.z, q.z));
        const D bent = hn::Sub(hn::Mul(set(2), across), hn::Mul(k, square));
        const D shift = hn::Sub(across, hn::Div(bent, hn::Add(one, radius)));
        return {hn::Sub(q.x, hn::Mul(ca, shift)), hn::Sub(q.y, hn::Mul(sa, shift)), hn::Div(gamma, k)};
    }
    HWY_INLINE D taper_at(double factor, D z) const
    {
        const D f = hn::Add(hn::Div(hn::Mul(set(factor), z), set(sq_.a.z)), set(1)), tiny = set(1e-6);
        return hn::IfThenElse(hn::Gt(f, tiny), f, tiny);
    }
    static HWY_INLINE D blend(const PowerFreeBound::Blend& of, D u, D v)
    {
        const auto u_is_big = hn::Gt(u, v);
        const D big = hn::IfThenElse(u_is_big, u, v), small = hn::IfThenElse(u_is_big, v, u);
        D r = hn::Div(small, big);
        for (int i = 0; i < of.squarings; ++i) r = hn::Mul(r, r);
        const D x = hn::Add(r, hn::Mul(set(of.weight), hn::Sub(hn::Mul(r, r), r)));
        D least = hn::Add(set(of.tangents[0].at_0), hn::Mul(set(of.tangents[0].slope), x));
        for (std::size_t i = 1; i < std::size(of.tangents); ++i) {
            const D above = hn::Add(set(of.tangents[i].at_0), hn::Mul(set(of.tangents[i].slope), x));
            least = hn::IfThenElse(hn::Lt(above, least), above, least);
        }
        return hn::IfThenElse(hn::Gt(small, hn::Zero(dd)), hn::Mul(big, least), big);
    }

    const shape::Superquadricd& sq_;
    const PowerFreeBound& bound_;
    double ca_, sa_;
};

}  // namespace

/// @pre u and bounds are as long as points, which are whole vectors.
void undeform_points(const shape::Superquadricd& sq, const PowerFreeBound& bound, std::span<const Vec3d> points, Vec3d* u,
                     double* bounds)
{
    const Undeforming undeforming(sq, bound);
    for (std::size_t i = 0; i < points.size(); i += hn::Lanes(dd)) {
        D3 p;
        hn::LoadInterleaved3(dd, &points[i].x, p.x, p.y, p.z);
        const D3 q = undeforming(p);
        hn::StoreInterleaved3(q.x, q.y, q.z, dd, &u[i].x);
        hn::StoreU(undeforming.bound(q), dd, bounds + i);
    }
}

}  // namespace sqmap::fit::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sqmap::fit {

HWY_EXPORT(undeform_points);

void UndeformedPoints::take(const shape::Superquadricd& sq, std::span<const Vec3d> points)
{
    constexpr std::size_t k_lanes = 8;  // at most, and every vector's length divides it
    points_.resize(points.size());
    bounds_.resize(points.size());
    const PowerFreeBound bound(sq);
    const std::size_t whole = points.size() / k_lanes * k_lanes, rest = points.size() - whole;
    const auto kernel = HWY_DYNAMIC_DISPATCH(undeform_points);
    kernel(sq, bound, points.first(whole), points_.data(), bounds_.data());
    if (rest == 0) return;
    std::array<Vec3d, k_lanes> last{}, u;
    std::array<double, k_lanes> bounds;
    std::copy(points.begin() + static_cast<std::ptrdiff_t>(whole), points.end(), last.begin());
    kernel(sq, bound, last, u.data(), bounds.data());
    std::copy_n(u.begin(), rest, points_.begin() + static_cast<std::ptrdiff_t>(whole));
    std::copy_n(bounds.begin(), rest, bounds_.begin() + static_cast<std::ptrdiff_t>(whole));
}

}  // namespace sqmap::fit
#endif
