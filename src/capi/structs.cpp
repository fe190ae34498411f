#include "structs.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <string>

namespace sqmap::capi {
namespace {

constexpr unsigned k_max_threads = 1024;
constexpr double k_orthonormal = 1e-6;  ///< a rotation whose rows are nearer to unit and square keeps its bits
constexpr double k_mendable = 1e-4;     ///< one that is farther is refused

/// Largest difference between m m' and the identity; NaN where a number is.
double off_orthonormal(const Mat3d& m)
{
    double off = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j) {
            const double here = std::abs(dot(m.row[i], m.row[j]) - (i == j ? 1 : 0));
            if (std::isnan(here)) return here;
            off = std::max(off, here);
        }
    return off;
}

/// The nearest orthonormal matrix, by two Newton-Schulz steps m (3 - m' m) / 2: each squares what m is off by.
Mat3d mended(Mat3d m)
{
    for (int step = 0; step < 2; ++step) {
        Mat3d next;
        for (int i = 0; i < 3; ++i) {
            next.row[i] = 1.5 * m.row[i];
            for (int j = 0; j < 3; ++j) next.row[i] = next.row[i] - 0.5 * dot(m.row[i], m.row[j]) * m.row[j];
        }
        m = next;
    }
    return m;
}

std::string text_of(double v)
{
    std::array<char, 32> line{};
    std::snprintf(line.data(), line.size(), "%g", v);
    return line.data();
}

/// Refuses numbers[i] that are not finite; element: names the array.
void check_numbers(std::span<const double> numbers, const std::string& element)
{
    for (std::size_t i = 0; i < numbers.size(); ++i)
        if (!std::isfinite(numbers[i]))
            throw Failure{SQMAP_E_ARGUMENT, element + "[" + std::to_string(i) + "]",
                          std::isnan(numbers[i]) ? "is NaN" : "is infinite", "give finite numbers"};
}

Pose as_given(const sqmap_pose& pose)
{
    Pose out;
    const double* r = pose.rotation;
    for (int i = 0; i < 3; ++i) out.rotation.row[i] = {r[3 * i], r[3 * i + 1], r[3 * i + 2]};
    out.translation = {pose.translation[0], pose.translation[1], pose.translation[2]};
    return out;
}

/// Makes a rotation orthonormal where it is off by no more than that can be; false where it is none.
bool mend(Mat3d& m)
{
    const double off = off_orthonormal(m);
    if (!(off < k_mendable) || !(dot(cross(m.row[0], m.row[1]), m.row[2]) > 0)) return false;
    if (!(off < k_orthonormal)) m = mended(m);
    return true;
}

/// Says why a rotation is refused. @throw Failure
[[noreturn]] void refuse_rotation(const sqmap_pose& pose, const Mat3d& m, const std::string& element)
{
    check_numbers(pose.rotation, element + ".rotation");
    const double off = off_orthonormal(m);
    throw Failure{SQMAP_E_ARGUMENT, element + ".rotation",
                  off < k_mendable ? "mirrors: its determinant is -1"
                                   : "is no rotation: its rows are off unit and square by " + text_of(off) +
                                         ", and the tolerance is " + text_of(k_mendable),
                  "give the rows of an orthonormal matrix of determinant one"};
}

}  // namespace

void check_struct(const void* given, std::size_t known, const char* element)
{
    std::size_t size = 0;
    std::memcpy(&size, given, sizeof size);
    if (size < sizeof(std::size_t) || size > k_max_struct || size % alignof(std::size_t) != 0)  // else it cuts a member
        throw Failure{SQMAP_E_ARGUMENT, std::string(element) + ".size", "is " + std::to_string(size),
                      "set it to sizeof the struct"};
    const auto* bytes = static_cast<const unsigned char*>(given);
    for (std::size_t i = known; i < size; ++i)
        if (bytes[i] != 0)
            throw Failure{SQMAP_E_ARGUMENT, element, "has a member that this library does not know",
                          "set it to zero, or take the library of the header"};
}

double checked(double value, double min, double max, const char* element)
{
    if (value >= min && value <= max) return value;
    throw Failure{SQMAP_E_ARGUMENT, element, std::isnan(value) ? "is NaN" : "is " + text_of(value),
                  "give a number from " + text_of(min) + " to " + text_of(max)};
}

Pose pose_or_nan(const sqmap_pose& pose) noexcept
{
    constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();
    constexpr Vec3d k_none{k_nan, k_nan, k_nan};
    Pose out = as_given(pose);
    if (!mend(out.rotation) || !is_finite(out.translation)) out = {{{k_none, k_none, k_none}}, k_none};
    return out;
}

Pose pose_of(const sqmap_pose* pose, const char* element)
{
    if (pose == nullptr) return {};
    Pose out = as_given(*pose);
    if (!is_finite(out.translation)) check_numbers(pose->translation, element + std::string(".translation"));
    if (!mend(out.rotation)) refuse_rotation(*pose, out.rotation, element);
    return out;
}

std::vector<Pose> poses_of(const sqmap_pose* poses, std::size_t count, const std::string& element)
{
    if (count > 0) (void)needed(poses, element.c_str());
    std::vector<Pose> out;
    out.reserve(count);
    for (std::size_t i = 0; i < count; ++i)
        out.push_back(is_finite(as_given(poses[i])) ? pose_of(&poses[i], (element + "[" + std::to_string(i) + "]").c_str())
                                                    : pose_or_nan(poses[i]));
    return out;
}

query::Layer layer_of(int layer)
{
    switch (layer) {
        case SQMAP_LAYER_1:
            return query::Layer::One;
        case SQMAP_LAYER_2:
            return query::Layer::Two;
        case SQMAP_LAYER_DEFAULT:
        case SQMAP_LAYER_3:
            return query::Layer::Three;
        case SQMAP_LAYER_EXACT:
            return query::Layer::Exact;
        case SQMAP_LAYER_AUTO:
            return query::Layer::Auto;
        case SQMAP_LAYER_GATE:
            return query::Layer::Gate;
        default:
            throw Failure{SQMAP_E_ARGUMENT, "options.layer", "is " + std::to_string(layer), "take one of sqmap_layer"};
    }
}

query::QueryOptions query_options(const sqmap_query_options& o)
{
    constexpr double k_largest = std::numeric_limits<double>::max();
    query::QueryOptions out;
    out.layer = layer_of(o.layer);
    out.tolerance = checked(o.tolerance, 0, k_largest, "options.tolerance");
    out.margin = checked(o.margin, 0, k_largest, "options.margin");
    if (o.gate != 0) out.gate = o.gate;
    out.offset = o.has_offset != 0;
    out.smoothed_map = o.is_smooth != 0;
    out.first_only = o.is_first_only != 0;
    return out;
}

unsigned threads_of(std::uint32_t threads, const char* element)
{
    if (threads > k_max_threads) throw Failure{SQMAP_E_ARGUMENT, element, "is " + std::to_string(threads), "give at most 1024"};
    return std::max(1u, threads);
}

std::span<const Vec3d> rows(const sqmap_points& points, const char* element)
{
    static_assert(sizeof(Vec3d) == 3 * sizeof(double) && alignof(Vec3d) == alignof(double));
    if (points.count == 0) return {};
    if (points.count > std::numeric_limits<std::size_t>::max() / sizeof(Vec3d))
        throw Failure{SQMAP_E_ARGUMENT, std::string(element) + ".count", "is more than memory holds", "give the number of rows"};
    return {reinterpret_cast<const Vec3d*>(&needed(points.xyz, element)), points.count};
}

void check_finite(std::span<const Vec3d> rows, const char* element, const char* cure)
{
    for (std::size_t i = 0; i < rows.size(); ++i)
        if (!is_finite(rows[i]))
            throw Failure{SQMAP_E_ARGUMENT, element + ("[" + std::to_string(i) + "]"), "is not finite", cure};
}

void give_text(sqmap_text* target, std::string_view text, const char* element)
{
    sqmap_text out = taken(&needed(target, element), element);
    if (out.text == nullptr && out.capacity > 0) refuse_null((element + std::string(".text")).c_str());
    if (out.capacity > 0) {
        const std::size_t count = std::min(text.size(), out.capacity - 1);
        std::memcpy(out.text, text.data(), count);
        out.text[count] = '\0';
    }
    out.needed = text.size() + 1;
    give(target, out);
}

}  // namespace sqmap::capi
