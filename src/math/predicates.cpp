// J. R. Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric predicates", 1997: his first
// error bounds as a filter, and the full expansion where the filter cannot tell.
#include "predicates.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace sqmap {
namespace {

constexpr double k_epsilon = std::numeric_limits<double>::epsilon() / 2;
constexpr double k_bound_2d = (3 + 16 * k_epsilon) * k_epsilon;

/// An exact sum of doubles that do not overlap, smallest first.
template <std::size_t N>
struct Expansion {
    std::array<double, N> term;
    std::size_t size = 0;

    /// Adds a number exactly (his Grow-Expansion), dropping zeros.
    void add(double b)
    {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < size; ++i) {
            const double sum = b + term[i], virtual_b = sum - term[i];
            const double rest = (term[i] - (sum - virtual_b)) + (b - virtual_b);
            b = sum;
            if (rest != 0) term[kept++] = rest;
        }
        if (b != 0) term[kept++] = b;
        size = kept;
    }
    [[nodiscard]] int sign() const { return size == 0 ? 0 : (term[size - 1] > 0 ? 1 : -1); }
};

Expansion<2> difference(double a, double b)
{
    Expansion<2> out;
    out.add(a);
    out.add(-b);
    return out;
}

template <std::size_t N, std::size_t M>
Expansion<2 * N * M> product(const Expansion<N>& a, const Expansion<M>& b)
{
    Expansion<2 * N * M> out;
    for (std::size_t i = 0; i < a.size; ++i)
        for (std::size_t j = 0; j < b.size; ++j) {
            const double p = a.term[i] * b.term[j];
            out.add(std::fma(a.term[i], b.term[j], -p));
            out.add(p);
        }
    return out;
}

template <std::size_t N, std::size_t M>
Expansion<N + M> sum(const Expansion<N>& a, const Expansion<M>& b, double sign)
{
    Expansion<N + M> out;
    for (std::size_t i = 0; i < a.size; ++i) out.add(a.term[i]);
    for (std::size_t i = 0; i < b.size; ++i) out.add(sign * b.term[i]);
    return out;
}

}  // namespace

int exact_orient3d(Vec3d a, Vec3d b, Vec3d c, Vec3d d) noexcept
{
    const auto ax = difference(a.x, d.x), ay = difference(a.y, d.y), az = difference(a.z, d.z);
    const auto bx = difference(b.x, d.x), by = difference(b.y, d.y), bz = difference(b.z, d.z);
    const auto cx = difference(c.x, d.x), cy = difference(c.y, d.y), cz = difference(c.z, d.z);
    const auto bc = product(sum(product(bx, cy), product(cx, by), -1), az);
    const auto ca = product(sum(product(cx, ay), product(ax, cy), -1), bz);
    const auto ab = product(sum(product(ax, by), product(bx, ay), -1), cz);
    return sum(sum(bc, ca, 1), ab, 1).sign();
}

int orient2d(Vec2d a, Vec2d b, Vec2d c) noexcept
{
    const double left = (a.x - c.x) * (b.y - c.y), right = (a.y - c.y) * (b.x - c.x);
    const double det = left - right, permanent = std::abs(left) + std::abs(right);
    if (std::abs(det) > k_bound_2d * permanent) return det > 0 ? 1 : -1;
    if (permanent == 0) return 0;
    return sum(product(difference(a.x, c.x), difference(b.y, c.y)), product(difference(a.y, c.y), difference(b.x, c.x)), -1)
        .sign();
}

}  // namespace sqmap
