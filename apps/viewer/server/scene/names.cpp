#include "viewer/server/scene/names.h"

#include "sqmap/math/box.h"
#include "sqmap/mesh/bvh.h"
#include "viewer/server/protocol/messages.h"
#include "viewer/server/protocol/text.h"
#include "viewer/server/scene/object.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

namespace sqmap::viewer {
namespace {

constexpr double k_farthest = 1e30;  // of a coordinate in a file of names

struct Middles {
    std::vector<Vec3d> centre;
    std::vector<double> area;
    Box box;
};

Middles middles_of(const mesh::Mesh& mesh, const decompose::Partition& partition)
{
    Middles out;
    out.centre.resize(partition.part_count);
    out.area.resize(partition.part_count);
    out.box = box_of(mesh.vertices);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const double a = mesh::triangle_area(mesh, t);
        const std::uint32_t p = partition.part_of_triangle[t];
        out.centre[p] += a * mesh::triangle_centroid(mesh, t);
        out.area[p] += a;
    }
    for (std::uint32_t p = 0; p < partition.part_count; ++p)
        if (out.area[p] > 0) out.centre[p] = out.centre[p] / out.area[p];
    return out;
}

std::string shape_and_position(const shape::Superquadricd& s, Vec3d centre, const Middles& m)
{
    std::array<double, 3> a{s.a.x, s.a.y, s.a.z};
    std::sort(a.begin(), a.end());
    const char* const name = a[2] > 1.7 * a[1] ? "long part" : a[0] < 0.45 * a[1] ? "flat part" : "round part";
    std::string position;
    const char* const words[3][2] = {{"left", "right"}, {"lower", "upper"}, {"back", "front"}};
    for (const int k : {1, 0, 2}) {
        const double extent = size(m.box)[k];
        const double at = extent > 0 ? (centre[k] - sqmap::centre(m.box)[k]) / extent : 0;
        if (std::abs(at) > 0.15) position += std::string(position.empty() ? "" : " ") + words[k][at > 0 ? 1 : 0];
    }
    return std::string(name) + ", " + (position.empty() ? "middle" : position);
}

/// Gives parts of one name different ones, by their order along the axis on which they are spread most.
void distinguish(std::vector<std::string>& names, const Middles& m, const Words& words)
{
    std::map<std::string, std::vector<std::uint32_t>> groups;
    for (std::uint32_t p = 0; p < names.size(); ++p) groups[names[p]].push_back(p);
    const Vec3d up = normalized(words.up), forward = normalized(words.forward), left = cross(up, forward);
    const struct {
        Vec3d axis;
        const char *low, *high;
    } axes[] = {{up, "lower", "upper"}, {forward, "back", "front"}, {left, "right", "left"}};
    for (auto& [name, parts] : groups) {
        if (parts.size() < 2) continue;
        double spread[3] = {}, max = 0;
        for (int k = 0; k < 3; ++k) {
            double lo = 1e300, hi = -1e300;
            for (const std::uint32_t p : parts) {
                lo = std::min(lo, dot(axes[k].axis, m.centre[p]));
                hi = std::max(hi, dot(axes[k].axis, m.centre[p]));
            }
            spread[k] = hi - lo;
            max = std::max(max, spread[k]);
        }
        // The loop takes the first axis that will do: "upper" says more than "left" of a left leg.
        const int best = spread[0] >= 0.5 * max ? 0 : spread[1] >= 0.5 * max ? 1 : 2;
        const Vec3d middle = centre(m.box);
        const auto across = [&](std::uint32_t p) { return dot(axes[best].axis, m.centre[p] - middle); };
        std::sort(parts.begin(), parts.end(), [&](std::uint32_t a, std::uint32_t b) { return across(a) < across(b); });
        const char *low = axes[best].low, *high = axes[best].high;
        if (best == 2 && (across(parts.front()) > 0) == (across(parts.back()) > 0)) {
            // All parts are on one side of the object.
            low = across(parts.front()) > 0 ? "inner" : "outer";
            high = across(parts.front()) > 0 ? "outer" : "inner";
        }
        const std::size_t n = parts.size();
        for (std::size_t i = 0; i < n; ++i) {
            if (n > 3)
                names[parts[i]] += ", " + std::to_string(i + 1) + " from " + (best == 0 ? "below" : low);
            else
                names[parts[i]] += std::string(", the ") + (i == 0 ? low : i + 1 == n ? high : "middle") + " one";
        }
    }
    // Names that are still alike, because somebody chose them so, get numbers.
    std::map<std::string, int> used;
    for (std::string& name : names)
        if (const int n = ++used[name]; n > 1) name += " (" + std::to_string(n) + ")";
}

}  // namespace

std::optional<Words> read_names(const std::string& text)
{
    using nlohmann::json;
    const std::optional<json> object = text.size() > 256 * 1024 ? std::nullopt : shallow_object(text, 5);
    if (!object) return std::nullopt;
    const json& in = *object;
    Words out;
    const auto names = in.find("names");
    if (names == in.end() || !names->is_array() || names->size() > k_max_landmarks) return std::nullopt;
    for (const json& entry : *names) {
        if (!entry.is_object()) return std::nullopt;
        const auto name = entry.find("name"), at = entry.find("at");
        if (name == entry.end() || !name->is_string() || at == entry.end()) return std::nullopt;
        const std::optional<Vec3d> position = vector_in(*at, k_farthest);
        if (!position || !is_name(name->get<std::string>())) return std::nullopt;
        out.landmarks.push_back({name->get<std::string>(), *position});
    }
    if (const auto whole = in.find("whole"); whole != in.end()) {
        if (!whole->is_boolean()) return std::nullopt;
        out.whole = whole->get<bool>();
    }
    for (const auto& [key, axis] : {std::pair{"forward", &out.forward}, {"up", &out.up}})
        if (const auto v = in.find(key); v != in.end()) {
            const std::optional<Vec3d> direction = vector_in(*v, k_farthest);
            if (!direction || !(norm(*direction) > 0)) return std::nullopt;
            *axis = *direction;
        }
    if (!(norm(cross(out.up, out.forward)) > 0)) return std::nullopt;
    return out;
}

nlohmann::ordered_json names_json(const Words& words)
{
    nlohmann::ordered_json out;
    out["about"] = "points of the mesh, in its own units, and what they are called: sqmap view reads them beside MODEL.sqmap";
    out["forward"] = {words.forward.x, words.forward.y, words.forward.z};
    out["up"] = {words.up.x, words.up.y, words.up.z};
    out["whole"] = words.whole;
    out["names"] = nlohmann::ordered_json::array();
    for (const Landmark& l : words.landmarks) out["names"].push_back({{"name", l.name}, {"at", {l.at.x, l.at.y, l.at.z}}});
    return out;
}

std::vector<std::string> part_names(const mesh::Mesh& mesh, const mesh::DualGraph& dual, const decompose::Partition& partition,
                                    const std::vector<shape::Superquadricd>& superquadrics, const Words& words,
                                    const Frame& frame)
{
    const Middles m = middles_of(mesh, partition);
    std::vector<std::string> names;
    for (std::uint32_t p = 0; p < partition.part_count; ++p)
        names.push_back(shape_and_position(superquadrics[p], m.centre[p], m));
    if (!words.landmarks.empty() && !mesh.triangles.empty()) {
        const mesh::Bvh bvh(mesh);
        std::vector<std::uint32_t> seeds;
        for (const Landmark& l : words.landmarks) seeds.push_back(bvh.closest_point((l.at - frame.origin) / frame.unit).triangle);
        const std::vector<std::uint32_t> owner = nearest_seeds(mesh, dual, seeds, [](std::uint32_t, double) { return true; });
        std::vector<std::map<std::uint32_t, double>> share(partition.part_count);
        for (std::uint32_t t = 0; t < owner.size(); ++t)
            if (owner[t] != k_no_seed) share[partition.part_of_triangle[t]][owner[t]] += mesh::triangle_area(mesh, t);
        for (std::uint32_t p = 0; p < partition.part_count; ++p) {
            std::vector<std::pair<double, std::uint32_t>> by_area;
            for (const auto& [landmark, area] : share[p]) by_area.emplace_back(-area, landmark);
            std::sort(by_area.begin(), by_area.end());
            std::vector<std::string> held;
            for (const auto& [area, landmark] : by_area)
                if (partition.part_of_triangle[seeds[landmark]] == p &&
                    std::find(held.begin(), held.end(), words.landmarks[landmark].name) == held.end())
                    held.push_back(words.landmarks[landmark].name);
            if (held.size() == 1)
                names[p] = held[0];
            else if (held.size() > 1)
                names[p] = held[0] + " and " + held[1];
            else if (words.whole && !by_area.empty())
                names[p] = words.landmarks[by_area[0].second].name;
        }
    }
    distinguish(names, m, words);
    return names;
}

Words renamed(const Words& words, const mesh::Mesh& mesh, const decompose::Partition& partition, std::uint32_t part,
              const std::string& name, const Frame& frame)
{
    Words out = words;
    const mesh::Bvh bvh(mesh);
    std::erase_if(out.landmarks, [&](const Landmark& l) {
        return partition.part_of_triangle[bvh.closest_point((l.at - frame.origin) / frame.unit).triangle] == part;
    });
    if (name.empty() || out.landmarks.size() >= k_max_landmarks) return out;
    const Vec3d middle = middles_of(mesh, partition).centre[part];
    Vec3d at{};
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        if (partition.part_of_triangle[t] != part) continue;
        const Vec3d c = mesh::triangle_centroid(mesh, t);
        if (norm(c - middle) < least) least = norm(c - middle), at = c;
    }
    out.landmarks.push_back({name, frame.origin + frame.unit * at});
    return out;
}

}  // namespace sqmap::viewer
