#include "admit_steps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace sqmap::mesh {
namespace {

constexpr double k_range_ratio = 1e15;       // double has 16 digits
constexpr double k_range_size = 1e100;       // cubes of larger or (inverted) smaller sizes leave double's range
constexpr std::size_t k_max_polygon = 1024;  // cutting ears takes the cube of it

/// A vertex in use so far from the others that their differences have no digits left. along: the coordinates in use by axis.
std::optional<std::size_t> stray_vertex(std::span<const Vec3d> positions, const std::vector<bool>& used,
                                        std::array<std::vector<double>, 3> along, double extent)
{
    // Median extent: half of the vertices are within it of the median vertex. One stray vertex does not change it.
    const auto median = [](std::vector<double>& values) {
        const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
        std::nth_element(values.begin(), middle, values.end());
        return *middle;
    };
    Vec3d centre;
    for (int k = 0; k < 3; ++k) centre[k] = median(along[static_cast<std::size_t>(k)]);
    const auto distance = [](Vec3d a) { return std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)}); };
    std::vector<double> distances;
    for (std::size_t v = 0; v < used.size(); ++v)
        if (used[v]) distances.push_back(distance(positions[v] - centre));
    double median_extent = median(distances);
    if (median_extent == 0) median_extent = extent;
    for (std::size_t v = 0; v < used.size(); ++v)
        if (used[v] && distance(positions[v]) > k_range_ratio * median_extent) return v;
    return {};
}

/// Marks the vertices that some corner names; all corners must name one.
std::vector<bool> used_vertices(const PolygonView& in)
{
    std::vector<bool> used(in.positions.size(), false);
    for (std::size_t f = 0; f + 1 < in.offsets.size(); ++f)
        for (std::uint32_t i = in.offsets[f]; i < in.offsets[f + 1]; ++i) {
            const std::int64_t v = in.indices[i];
            if (v < 0 || static_cast<std::uint64_t>(v) >= in.positions.size())
                refuse(Refusal::Index, element("face", f),
                       "a corner names a vertex that is not there; there are " + number(in.positions.size()),
                       "export the mesh again");
            used[static_cast<std::size_t>(v)] = true;
        }
    return used;
}

void check_numbers(const PolygonView& in)
{
    for (std::size_t v = 0; v < in.positions.size(); ++v) {
        const Vec3d p = in.positions[v];
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
            refuse(Refusal::NonFinite, element("vertex", v), "a coordinate is not a finite number",
                   "correct or remove the vertex");
    }
    if (in.offsets.size() < 2)
        refuse(Refusal::Empty, "mesh", number(in.positions.size()) + " vertices and no face",
               "give a mesh with faces, not points");
}

/// The box of the vertices in use.
Box checked_box(std::span<const Vec3d> positions, const std::vector<bool>& used)
{
    Box box;
    std::array<std::vector<double>, 3> along;
    for (std::size_t v = 0; v < used.size(); ++v) {
        if (!used[v]) continue;
        extend(box, positions[v]);
        for (int k = 0; k < 3; ++k) along[static_cast<std::size_t>(k)].push_back(positions[v][k]);
    }
    const char* cure = "remove stray vertices, or move and scale the mesh towards unit size at the origin";
    if (along[0].empty()) refuse(Refusal::Range, "mesh", "the faces have no corners", cure);
    // The largest side, not the diagonal: squares may overflow where the size does not.
    const Vec3d sides = size(box);
    const double extent = std::max({sides.x, sides.y, sides.z});
    if (!(extent > 0)) refuse(Refusal::Range, "mesh", "all vertices lie in one point", cure);
    if (!(extent < k_range_size) || extent < 1 / k_range_size)
        refuse(Refusal::Range, "mesh", "the size is beyond what double precision can cube", cure);
    if (const auto v = stray_vertex(positions, used, std::move(along), extent))
        refuse(Refusal::Range, element("vertex", *v), "a coordinate is more than 1e15 times the size of the rest", cure);
    return box;
}

/// new_number: of each vertex in use, in the surface.
void cut_polygons(const PolygonView& in, const std::vector<std::uint32_t>& new_number, Soup& out)
{
    const auto polygon_count = static_cast<std::uint32_t>(in.offsets.size() - 1);
    out.surface.faces.reserve(polygon_count);
    std::vector<std::uint32_t> corners;
    std::vector<Vec3d> polygon;
    for (std::uint32_t f = 0; f < polygon_count; ++f) {
        corners.clear();
        const std::size_t degree = in.offsets[f + 1] - in.offsets[f];
        if (degree > k_max_polygon)
            refuse(Refusal::Limit, element("face", f),
                   "a polygon of " + number(degree) + " corners; the limit is " + number(k_max_polygon),
                   "cut large polygons into triangles");
        for (std::uint32_t i = in.offsets[f]; i < in.offsets[f + 1]; ++i) {
            const std::uint32_t v = new_number[static_cast<std::size_t>(in.indices[i])];
            if (corners.empty() || corners.back() != v) corners.push_back(v);
        }
        while (corners.size() > 1 && corners.front() == corners.back()) corners.pop_back();
        const bool repeats = corners.size() < degree;
        if (corners.size() < 3 || repeats) ++out.degenerate_polygons;
        if (corners.size() < 3) continue;
        if (corners.size() == 3) {
            out.surface.faces.push_back({{corners[0], corners[1], corners[2]}, f});
            continue;
        }
        polygon.clear();
        for (const std::uint32_t v : corners) polygon.push_back(out.surface.points[v]);
        for (const auto& t : triangulated(polygon))
            out.surface.faces.push_back({{corners[t[0]], corners[t[1]], corners[t[2]]}, f});
        ++out.cut_polygons;
    }
}

}  // namespace

Soup soup_of(const PolygonView& polygons)
{
    const std::vector<bool> used = used_vertices(polygons);
    check_numbers(polygons);
    Soup out;
    out.box = checked_box(polygons.positions, used);
    std::vector<std::uint32_t> new_number(used.size(), k_none);
    for (std::uint32_t v = 0; v < used.size(); ++v)
        if (used[v]) {
            new_number[v] = static_cast<std::uint32_t>(out.surface.points.size());
            const Vec3d p = polygons.positions[v];
            out.surface.points.push_back({p.x + 0.0, p.y + 0.0, p.z + 0.0});  // -0 is 0, or equal positions would differ
            out.surface.source.push_back(v);
        }
    out.unused_vertices = used.size() - out.surface.points.size();
    cut_polygons(polygons, new_number, out);
    return out;
}

}  // namespace sqmap::mesh
