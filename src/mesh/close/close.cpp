#include "close.h"

#include "steps.h"

#include <cstdio>
#include <numeric>
#include <tuple>
#include <utility>

namespace sqmap::mesh {
namespace {

constexpr double k_stitch = 1e-3;           // of the diagonal: boundaries so near each other are joined
constexpr double k_max_loose = 0.05;        // of the input's area: loose sheets beyond that are part of the shape
constexpr std::size_t k_min_made = 20'000;  // triangles that fillings may have, whatever the surface has

double area_of(const Surface& surface, bool only_made_up)
{
    double area = 0;
    for (const Face& f : surface.faces) {
        if (only_made_up && f.polygon != k_none) continue;
        const Vec3d a = surface.points[f.v[0]];
        area += 0.5 * norm(cross(surface.points[f.v[1]] - a, surface.points[f.v[2]] - a));
    }
    return area;
}

/// Vertices and faces by position, so that the file's order has no say in how sums are rounded.
Surface in_canonical_order(const Surface& surface)
{
    const auto key = [&](std::uint32_t v) {
        const Vec3d p = surface.points[v];
        return std::tuple(p.x, p.y, p.z, v);
    };
    std::vector<std::uint32_t> order(surface.points.size()), rank(surface.points.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
    Surface out;
    for (std::uint32_t i = 0; i < order.size(); ++i) {
        rank[order[i]] = i;
        out.points.push_back(surface.points[order[i]]);
        out.source.push_back(surface.source[order[i]]);
    }
    for (Face f : surface.faces) {
        for (std::uint32_t& v : f.v) v = rank[v];
        std::rotate(f.v.begin(), std::min_element(f.v.begin(), f.v.end()), f.v.end());
        out.faces.push_back(f);
    }
    std::sort(out.faces.begin(), out.faces.end(),
              [](const Face& a, const Face& b) { return std::tie(a.v, a.polygon) < std::tie(b.v, b.polygon); });
    return out;
}

std::string percent(double share)
{
    char text[32];
    std::snprintf(text, sizeof text, "%.3g %%", 100 * share);
    return text;
}

}  // namespace

Closing close(const Surface& input, const CloseOptions& options)
{
    Surface surface = in_canonical_order(input);
    Closing out;
    const auto note = [&](RepairKind kind, std::uint64_t count) {
        if (count > 0) out.notes.push_back({kind, count});
    };
    const double area = area_of(surface, false), tolerance = k_stitch * options.diagonal;
    note(RepairKind::Stitched, stitch(surface, tolerance));
    const Resolved resolved = resolve_edges(surface);
    note(RepairKind::Reoriented, resolved.turned_faces);
    note(RepairKind::DroppedWalls, resolved.wall_faces);
    note(RepairKind::DroppedFaces, resolved.fin_faces + resolved.stuck_faces);
    note(RepairKind::CutEdges, resolved.cut_edges);
    const std::size_t budget = std::max(2 * surface.faces.size(), k_min_made);
    const std::uint32_t filled = fill_holes(surface, options.refine ? budget : 0);
    const Sheets sheets = drop_sheets(surface, tolerance);
    note(RepairKind::DroppedSheets, sheets.dropped_faces);
    note(RepairKind::FilledHoles, filled);
    const double share = area_of(surface, true) / area_of(surface, false);
    if (sheets.all)
        out.failure = "it consists of loose sheets";
    else if (sheets.outside_area > k_max_loose * area)
        out.failure = "loose sheets are " + percent(sheets.outside_area / area) + " of the area";
    else if (share > options.max_filled)
        out.failure = "fillings would be " + percent(share) + " of the area";
    out.surface = std::move(surface);
    return out;
}

}  // namespace sqmap::mesh
