#include "steps.h"

#include "sqmap/mesh/bvh.h"

#include <cmath>
#include <utility>

namespace sqmap::mesh {
namespace {

constexpr double k_sheet_share = 0.4;    // of a component's area is filling: a sheet and its own cover have one half
constexpr double k_thin = 0.01;          // volume over area to the power of 3/2: half a ball has 0.07, a shallow lid 0.03
constexpr std::uint32_t k_samples = 64;  // faces of a sheet that are examined

double area_of(const Surface& surface, const Face& f)
{
    const Vec3d a = surface.points[f.v[0]];
    return 0.5 * norm(cross(surface.points[f.v[1]] - a, surface.points[f.v[2]] - a));
}

}  // namespace

Sheets drop_sheets(Surface& surface, double tolerance)
{
    Sheets out;
    const std::size_t count = surface.faces.size();
    UnionFind pieces(count);
    for_each_edge(edge_uses(surface.faces), [&](std::span<const EdgeUse> edge) {
        for (const EdgeUse& u : edge) pieces.unite(edge[0].half / 3, u.half / 3);
    });
    std::vector<double> own(count, 0), made(count, 0), six_volumes_of(count, 0);
    std::vector<std::vector<std::uint32_t>> faces(count);  // of the file, by component
    for (std::uint32_t f = 0; f < count; ++f) {
        const std::uint32_t piece = pieces.find(f);
        const bool made_up = surface.faces[f].polygon == k_none;
        (made_up ? made : own)[piece] += area_of(surface, surface.faces[f]);
        const Vec3d origin = surface.points[surface.faces[piece].v[0]];  // a corner of the piece: far from it volumes cancel
        const Triangle& v = surface.faces[f].v;
        six_volumes_of[piece] +=
            dot(surface.points[v[0]] - origin, cross(surface.points[v[1]] - origin, surface.points[v[2]] - origin));
        if (!made_up) faces[piece].push_back(f);
    }
    const auto is_sheet = [&](std::uint32_t piece) { return made[piece] > k_sheet_share * (made[piece] + own[piece]); };
    const auto is_thin = [&](std::uint32_t piece) {
        const double area = made[piece] + own[piece];
        return std::abs(six_volumes_of[piece]) / 6 < k_thin * area * std::sqrt(area);
    };
    Surface rest{surface.points, surface.source, {}};
    for (std::uint32_t f = 0; f < count; ++f)
        if (!is_sheet(pieces.find(f))) rest.faces.push_back(surface.faces[f]);
    if (rest.faces.size() == count) return out;
    if (rest.faces.empty()) {
        // In a mesh of sheets alone, those that hold a volume stay.
        for (std::uint32_t f = 0; f < count; ++f)
            if (!is_thin(pieces.find(f))) rest.faces.push_back(surface.faces[f]);
        out.all = rest.faces.empty();
        if (out.all || rest.faces.size() == count) return out;
    }

    Mesh mesh{surface.points, {}};
    for (const Face& f : rest.faces) mesh.triangles.push_back(f.v);
    const Bvh bvh(mesh);
    std::vector<bool> dropped(count, false);
    for (std::uint32_t piece = 0; piece < count; ++piece) {
        if (pieces.find(piece) != piece || !is_sheet(piece)) continue;
        const std::size_t stride = (faces[piece].size() + k_samples - 1) / k_samples;
        bool bounds_nothing = true;
        for (std::size_t i = 0; i < faces[piece].size() && bounds_nothing; i += stride) {
            const Triangle& v = surface.faces[faces[piece][i]].v;
            const Vec3d middle = (surface.points[v[0]] + surface.points[v[1]] + surface.points[v[2]]) / 3.0;
            bounds_nothing = bvh.winding_number(middle) != 0 || bvh.closest_point(middle).distance <= tolerance;
        }
        dropped[piece] = bounds_nothing || is_thin(piece);
        if (!dropped[piece]) continue;
        out.dropped_faces += faces[piece].size();
        if (!bounds_nothing) out.outside_area += own[piece];
    }
    std::vector<Face> kept;
    for (std::uint32_t f = 0; f < count; ++f)
        if (!dropped[pieces.find(f)]) kept.push_back(surface.faces[f]);
    surface.faces = std::move(kept);
    return out;
}

}  // namespace sqmap::mesh
