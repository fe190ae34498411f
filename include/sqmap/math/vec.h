// Small fixed-size vectors, matrices and affine maps; plain structs, any real scalar.
// Pure functions and plain data: any number of threads.
#pragma once

#include <cmath>

namespace sqmap {

/// Three coordinates: a point or a vector.
template <class Real>
struct Vec3 {
    Real x{}, y{}, z{};

    /// Component 0, 1 or 2; any other number is taken for 2.
    constexpr Real operator[](int i) const { return i == 0 ? x : (i == 1 ? y : z); }
    /// Component 0, 1 or 2; any other number is taken for 2.
    constexpr Real& operator[](int i) { return i == 0 ? x : (i == 1 ? y : z); }
    friend constexpr bool operator==(const Vec3&, const Vec3&) = default;
};

/// In float.
using Vec3f = Vec3<float>;
/// In double.
using Vec3d = Vec3<double>;

/// Componentwise, and by a number.
template <class Real>
constexpr Vec3<Real> operator+(Vec3<Real> a, Vec3<Real> b)
{
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class Real>
constexpr Vec3<Real> operator-(Vec3<Real> a, Vec3<Real> b)
{
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class Real>
constexpr Vec3<Real> operator-(Vec3<Real> a)
{
    return {-a.x, -a.y, -a.z};
}
template <class Real>
constexpr Vec3<Real> operator*(Real s, Vec3<Real> a)
{
    return {s * a.x, s * a.y, s * a.z};
}
template <class Real>
constexpr Vec3<Real> operator*(Vec3<Real> a, Real s)
{
    return {a.x * s, a.y * s, a.z * s};
}
template <class Real>
constexpr Vec3<Real> operator/(Vec3<Real> a, Real s)
{
    return {a.x / s, a.y / s, a.z / s};
}
template <class Real>
constexpr Vec3<Real>& operator+=(Vec3<Real>& a, Vec3<Real> b)
{
    return a = a + b;
}
template <class Real>
constexpr Vec3<Real>& operator-=(Vec3<Real>& a, Vec3<Real> b)
{
    return a = a - b;
}

/// a . b
template <class Real>
constexpr Real dot(Vec3<Real> a, Vec3<Real> b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
/// a x b
template <class Real>
constexpr Vec3<Real> cross(Vec3<Real> a, Vec3<Real> b)
{
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// The square of the length.
template <class Real>
constexpr Real norm_sq(Vec3<Real> a)
{
    return dot(a, a);
}
/// The length.
template <class Real>
Real norm(Vec3<Real> a)
{
    using std::sqrt;
    return sqrt(dot(a, a));
}
/// Unit vector along a; a itself where its length is zero.
template <class Real>
Vec3<Real> normalized(Vec3<Real> a)
{
    const Real length = norm(a);
    return length > Real(0) ? a / length : a;
}
/// In another number type, rounded.
template <class To, class Real>
constexpr Vec3<To> cast(Vec3<Real> a)
{
    return {static_cast<To>(a.x), static_cast<To>(a.y), static_cast<To>(a.z)};
}

/// 3 by 3 matrix as three rows.
template <class Real>
struct Mat3 {
    Vec3<Real> row[3]{{Real(1), Real(0), Real(0)}, {Real(0), Real(1), Real(0)}, {Real(0), Real(0), Real(1)}};

    friend constexpr bool operator==(const Mat3&, const Mat3&) = default;
};

/// In float.
using Mat3f = Mat3<float>;
/// In double.
using Mat3d = Mat3<double>;

/// m v.
template <class Real>
constexpr Vec3<Real> operator*(const Mat3<Real>& m, Vec3<Real> v)
{
    return {dot(m.row[0], v), dot(m.row[1], v), dot(m.row[2], v)};
}
/// m transposed times v.
template <class Real>
constexpr Vec3<Real> transpose_mul(const Mat3<Real>& m, Vec3<Real> v)
{
    return v.x * m.row[0] + v.y * m.row[1] + v.z * m.row[2];
}
/// Rows and columns exchanged.
template <class Real>
constexpr Mat3<Real> transpose(const Mat3<Real>& m)
{
    return {{{m.row[0].x, m.row[1].x, m.row[2].x}, {m.row[0].y, m.row[1].y, m.row[2].y}, {m.row[0].z, m.row[1].z, m.row[2].z}}};
}
/// m n: x -> m(n(x)).
template <class Real>
constexpr Mat3<Real> operator*(const Mat3<Real>& a, const Mat3<Real>& b)
{
    return {{transpose_mul(b, a.row[0]), transpose_mul(b, a.row[1]), transpose_mul(b, a.row[2])}};
}

/// True if all components are finite.
template <class Real>
[[nodiscard]] bool is_finite(Vec3<Real> v) noexcept
{
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// x -> linear x + shift.
struct Affine {
    Mat3d linear{};
    Vec3d shift{};
};

/// The image of p.
constexpr Vec3d apply(const Affine& map, Vec3d p) { return map.linear * p + map.shift; }
/// a after b: x -> a(b(x)).
constexpr Affine operator*(const Affine& a, const Affine& b) { return {a.linear * b.linear, a.linear * b.shift + a.shift}; }

}  // namespace sqmap
