#include "structs.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

namespace sqmap::capi {
namespace {

constexpr unsigned k_max_threads = 1024;
constexpr double k_orthonormal = 1e-6;  ///< how far the rows of a rotation may be from unit and square

bool is_rotation(const Mat3d& m)
{
    for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j)
            if (!(std::abs(dot(m.row[i], m.row[j]) - (i == j ? 1 : 0)) < k_orthonormal)) return false;
    return dot(cross(m.row[0], m.row[1]), m.row[2]) > 0;
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
    const auto text = [](double v) {
        char line[32];
        std::snprintf(line, sizeof line, "%g", v);
        return std::string(line);
    };
    throw Failure{SQMAP_E_ARGUMENT, element, "is " + text(value), "give a number from " + text(min) + " to " + text(max)};
}

Pose pose_as_given(const sqmap_pose& pose)
{
    Pose out;
    const double* r = pose.rotation;
    for (int i = 0; i < 3; ++i) out.rotation.row[i] = {r[3 * i], r[3 * i + 1], r[3 * i + 2]};
    out.translation = {pose.translation[0], pose.translation[1], pose.translation[2]};
    return out;
}

Pose pose_of(const sqmap_pose* pose)
{
    if (pose == nullptr) return {};
    const Pose out = pose_as_given(*pose);
    if (!is_finite(out.translation))
        throw Failure{SQMAP_E_ARGUMENT, "pose.translation", "is not finite", "give three finite numbers"};
    if (!is_rotation(out.rotation))
        throw Failure{SQMAP_E_ARGUMENT, "pose.rotation", "is no proper rotation",
                      "give the rows of an orthonormal matrix of determinant one"};
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
    out.smoothing = o.is_smooth != 0;
    out.first_only = o.is_first_only != 0;
    return out;
}

unsigned threads_of(const sqmap_query_options& o)
{
    if (o.threads > k_max_threads)
        throw Failure{SQMAP_E_ARGUMENT, "options.threads", "is " + std::to_string(o.threads), "give at most 1024"};
    return std::max(1u, o.threads);
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
        if (!is_finite(rows[i])) throw Failure{SQMAP_E_ARGUMENT, element + std::to_string(i), "is not finite", cure};
}

void give_text(sqmap_text* target, std::string_view text)
{
    sqmap_text out = taken(&needed(target, "text"), "text");
    if (out.text == nullptr && out.capacity > 0) refuse_null("text.text");
    if (out.capacity > 0) {
        const std::size_t count = std::min(text.size(), out.capacity - 1);
        std::memcpy(out.text, text.data(), count);
        out.text[count] = '\0';
    }
    out.needed = text.size() + 1;
    give(target, out);
}

}  // namespace sqmap::capi
