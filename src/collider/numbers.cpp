#include "collider/numbers.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>

namespace sqmap::collider {
namespace {

constexpr int k_digits = 9;

double read_back(const char* format, double value)
{
    std::array<char, 40> buffer{};
    std::snprintf(buffer.data(), buffer.size(), format, k_digits, value);
    return std::strtod(buffer.data(), nullptr);
}

}  // namespace

double rounded(double value) { return read_back("%.*g", value) + 0.0; }  // -0 becomes 0

Vec3d rounded(Vec3d v) { return {rounded(v.x), rounded(v.y), rounded(v.z)}; }

double rounded_up(double value)
{
    if (!(value > 0)) return 0;
    // A unit of the last digit more, where rounding went down: the sum is rounded to nine digits again, which may not go down.
    const double step = std::pow(10, std::floor(std::log10(value)) - (k_digits - 1));
    for (double candidate = value;; candidate += step / 2)
        if (const double up = rounded(candidate); up >= value) return up;
}

std::string text(double value)
{
    std::array<char, 40> buffer{};
#ifdef __cpp_lib_to_chars
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
    return {buffer.data(), end};
#else  // Emscripten's library of LLVM 14 has it for integers alone
    for (int digits = 1; digits <= std::numeric_limits<double>::max_digits10; ++digits) {
        std::snprintf(buffer.data(), buffer.size(), "%.*g", digits, value);
        if (std::strtod(buffer.data(), nullptr) == value) break;
    }
    return buffer.data();
#endif
}

std::string text(Vec3d v, const char* separator) { return text(v.x) + separator + text(v.y) + separator + text(v.z); }

}  // namespace sqmap::collider
