// Numbers of twice a double's digits, for what double cannot decide.
// T. J. Dekker, "A floating-point technique for extending the available precision", Numer. Math. 18, 1971; errors below 2^-102 of
// the larger operand or the product. Pure functions and plain data: any number of threads.
#pragma once

#include <cmath>

namespace sqmap {

/// The unevaluated sum high + low; low is below half of high's last digit.
struct Twofold {
    double high = 0, low = 0;

    Twofold() = default;
    Twofold(double value) : high(value) {}  // NOLINT: a number is a number
    Twofold(double h, double l) : high(h), low(l) {}
};

/// The exact sum of two doubles (D. E. Knuth).
inline Twofold exact_sum(double a, double b)
{
    const double sum = a + b, other = sum - a;
    return {sum, (a - (sum - other)) + (b - other)};
}
inline Twofold operator-(const Twofold& a) { return {-a.high, -a.low}; }
inline Twofold operator+(const Twofold& a, const Twofold& b)
{
    const Twofold high = exact_sum(a.high, b.high), low = exact_sum(a.low, b.low);
    const Twofold first = exact_sum(high.high, high.low + low.high);
    return exact_sum(first.high, first.low + low.low);
}
inline Twofold operator-(const Twofold& a, const Twofold& b) { return a + -b; }
inline Twofold operator*(const Twofold& a, const Twofold& b)
{
    const double product = a.high * b.high;
    return exact_sum(product, std::fma(a.high, b.high, -product) + (a.high * b.low + a.low * b.high));
}
inline double rounded(const Twofold& a) { return a.high; }
inline double rounded(double a) { return a; }

}  // namespace sqmap
