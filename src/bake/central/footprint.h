// A triangle as a face of the chart sees it: convex polygons over which w is affine, clipped to cells.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace sqmap::bake {

inline constexpr int k_max_corners = 40;  // 3, one more for each of 18 + 5 + 4 planes at most, and room to clip

struct Stw {
    double s, t, w;
};

struct Extent {
    double lo_s = 2, hi_s = -2, lo_t = 2, hi_t = -2;
};

/// A triangle's footprint on a face, clipped; w is affine over it.
struct Polygon {
    std::uint32_t triangle = 0;
    int count = 0;
    Extent
        whole;  ///< of the whole triangle's projection, before any clipping; all of the face where it reaches behind the centre
    std::array<Stw, k_max_corners> corner;

    Polygon() = default;
    /// Copies only the corners in use. A polygon has about five, and copying polygons takes most of the time of baking.
    Polygon(const Polygon& other) { *this = other; }
    Polygon& operator=(const Polygon& other)
    {
        triangle = other.triangle;
        count = other.count;
        whole = other.whole;
        std::copy_n(other.corner.begin(), other.count, corner.begin());
        return *this;
    }
};

/// Keeps the side where value(corner) >= 0.
template <class Value>
void clip(Polygon& p, Value&& value)
{
    Polygon out;
    out.triangle = p.triangle;
    out.whole = p.whole;
    for (int i = 0; i < p.count; ++i) {
        const Stw& a = p.corner[static_cast<std::size_t>(i)];
        const Stw& b = p.corner[static_cast<std::size_t>((i + 1) % p.count)];
        const double va = value(a), vb = value(b);
        if (va >= 0) out.corner[static_cast<std::size_t>(out.count++)] = a;
        if ((va >= 0) != (vb >= 0)) {
            const double f = va / (va - vb);
            out.corner[static_cast<std::size_t>(out.count++)] = {a.s + f * (b.s - a.s), a.t + f * (b.t - a.t),
                                                                 a.w + f * (b.w - a.w)};
        }
        if (out.count >= k_max_corners - 2) break;
    }
    p = out;
}

inline Extent extent_of(const Polygon& p)
{
    Extent e;
    for (int i = 0; i < p.count; ++i) {
        const Stw& c = p.corner[static_cast<std::size_t>(i)];
        e.lo_s = std::min(e.lo_s, c.s);
        e.hi_s = std::max(e.hi_s, c.s);
        e.lo_t = std::min(e.lo_t, c.t);
        e.hi_t = std::max(e.hi_t, c.t);
    }
    return e;
}

inline void clip_to_cell(Polygon& p, double s0, double s1, double t0, double t1)
{
    const auto [lo_s, hi_s, lo_t, hi_t] = extent_of(p);
    if (hi_s < s0 || lo_s > s1 || hi_t < t0 || lo_t > t1) p.count = 0;
    if (p.count > 0 && lo_s < s0) clip(p, [&](const Stw& c) { return c.s - s0; });
    if (p.count > 0 && hi_s > s1) clip(p, [&](const Stw& c) { return s1 - c.s; });
    if (p.count > 0 && lo_t < t0) clip(p, [&](const Stw& c) { return c.t - t0; });
    if (p.count > 0 && hi_t > t1) clip(p, [&](const Stw& c) { return t1 - c.t; });
}

}  // namespace sqmap::bake
