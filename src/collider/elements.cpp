#include "collider/elements.h"

#include "collider/numbers.h"

#include <nlohmann/json.hpp>

#include <cstdio>

namespace sqmap::collider {
namespace {

using nlohmann::ordered_json;

ordered_json as_json(Vec3d v) { return {v.x, v.y, v.z}; }
ordered_json as_json(const Mat3d& m) { return {as_json(m.row[0]), as_json(m.row[1]), as_json(m.row[2])}; }

constexpr const char* k_local = "; [x y z] = rotation transposed (p - xyz)";

ordered_json superquadric_parameters(const shape::Superquadricd& s, std::string_view name)
{
    return {{"name", name},
            {"shape", "superquadric"},
            {"a", as_json(s.a)},
            {"eps1", s.eps1},
            {"eps2", s.eps2},
            {"rotation", as_json(s.rotation)},
            {"translation", as_json(s.translation)},
            {"taper", {s.taper_x, s.taper_y}},
            {"bend", s.bend},
            {"bend_angle", s.bend_angle},
            {"equation",
             "((|x/a1|^(2/eps2) + |y/a2|^(2/eps2))^(eps2/eps1) + |z/a3|^(2/eps1))^eps1 <= 1; [x y z] = taper and bend undone of "
             "rotation (p - translation)"}};
}

}  // namespace

std::string escaped(std::string_view text)
{
    std::string out;
    for (const char c : text) {
        switch (c) {
            case '&':
                out += "&amp;";
                break;
            case '<':
                out += "&lt;";
                break;
            case '>':
                out += "&gt;";
                break;
            case '"':
                out += "&quot;";
                break;
            default:
                out += static_cast<unsigned char>(c) < 0x20 ? '_' : c;
        }
    }
    return out;
}

std::string words(const Figures& f)
{
    if (f.support_excess < 0) return "one of the balls that hold it together";
    char line[200];
    std::string out;
    if (f.volume_ratio >= 0) {
        std::snprintf(line, sizeof line, "volume %.4g of the solid's, ", f.volume_ratio);
        out += line;
    }
    std::snprintf(line, sizeof line, "support excess %.4g", f.support_excess);
    out += line;
    if (f.protrusion >= 0) {
        std::snprintf(line, sizeof line, ", protrusion %.4g, coverage %.4g", f.protrusion, f.coverage);
        out += line;
    }
    return out;
}

std::string obj_text(const mesh::Mesh& mesh, std::string_view name, std::size_t first)
{
    std::string out = "o " + std::string(name) + '\n';
    for (const Vec3d& v : mesh.vertices) out += "v " + text(v) + '\n';
    for (const mesh::Triangle& t : mesh.triangles) {
        out += 'f';
        for (const std::uint32_t v : t) out += ' ' + std::to_string(first + v);
        out += '\n';
    }
    return out;
}

std::string parameters_json(const Shape& s, std::string_view name)
{
    if (s.kind == Kind::Superquadric) return superquadric_parameters(s.superquadric, name).dump();
    ordered_json out{{"name", name}, {"shape", name_of(s.kind)}};
    if (s.kind == Kind::Hull) {
        out["vertices"] = ordered_json::array();
        for (const Vec3d& v : s.hull.vertices) out["vertices"].push_back(as_json(v));
        out["triangles"] = s.hull.triangles;
        out["equation"] = "dot(cross(b - a, c - a), p - a) <= 0 for every triangle a b c";
        return out.dump();
    }
    out["xyz"] = as_json(s.xyz);
    if (s.kind == Kind::Sphere) {
        out["radius"] = s.size.x;
        out["equation"] = "|p - xyz| <= radius";
        return out.dump();
    }
    const Quaternion q = quaternion_of_rpy(s.rpy);
    out["rpy"] = as_json(s.rpy);
    out["quaternion_wxyz"] = {q.w, q.x, q.y, q.z};
    out["rotation"] = as_json(rotation_of_rpy(s.rpy));
    if (s.kind == Kind::Box || s.kind == Kind::Ellipsoid) {
        out["half_lengths"] = as_json(s.size);
        out["equation"] =
            std::string(s.kind == Kind::Box ? "max(|x/h1|, |y/h2|, |z/h3|) <= 1" : "(x/h1)^2 + (y/h2)^2 + (z/h3)^2 <= 1") +
            k_local;
    } else {
        out["radius"] = s.size.x;
        out["half_length"] = s.size.z;
        out["equation"] = std::string(s.kind == Kind::Capsule ? "x^2 + y^2 + max(|z| - half_length, 0)^2 <= radius^2"
                                                              : "max(hypot(x, y) / radius, |z| / half_length) <= 1") +
                          k_local;
    }
    return out.dump();
}

}  // namespace sqmap::collider
