// Frisken, Perry, Rockwood, Jones, "Adaptively Sampled Distance Fields" (SIGGRAPH 2000); McNeely, Puterbaugh, Troy, "Six
// Degree-of-Freedom Haptic Rendering Using Voxel Sampling" (SIGGRAPH 1999).
#include "field_bytes.h"

#include "distance_grid.h"
#include "sqmap/bake/evaluate.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace sqmap::bench {
namespace {

constexpr std::size_t k_link = 4, k_value = 4;

struct FieldBox {
    Vec3d lo, hi;
};

FieldBox box_of(const mesh::Mesh& mesh)
{
    FieldBox box{mesh.vertices.front(), mesh.vertices.front()};
    for (const Vec3d& v : mesh.vertices)
        for (int k = 0; k < 3; ++k) {
            box.lo[k] = std::min(box.lo[k], v[k]);
            box.hi[k] = std::max(box.hi[k], v[k]);
        }
    return box;
}

double longest(const FieldBox& box) { return std::max({box.hi.x - box.lo.x, box.hi.y - box.lo.y, box.hi.z - box.lo.z}); }

/// True if the cube's circumscribed ball meets the surface.
bool reaches(const mesh::Solid& solid, Vec3d lo, double side)
{
    const double radius = 0.5 * std::sqrt(3.0) * side;
    return solid.closest_boundary(lo + 0.5 * side * Vec3d{1, 1, 1}, radius).distance < radius;
}

struct Cube {
    Vec3d lo;
    double side;

    [[nodiscard]] Cube child(int i, int j, int k, int along) const
    {
        const double s = side / along;
        return {lo + s * Vec3d{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)}, s};
    }
};

/// Cells that are split on the way down to `levels` more levels of along^3 children, this one included.
std::size_t split_cells(const mesh::Solid& solid, const Cube& cube, int along, int levels)
{
    if (levels == 0 || !reaches(solid, cube.lo, cube.side)) return 0;
    std::size_t count = 1;
    if (levels == 1) return count;
    for (int i = 0; i < along; ++i)
        for (int j = 0; j < along; ++j)
            for (int k = 0; k < along; ++k) count += split_cells(solid, cube.child(i, j, k, along), along, levels - 1);
    return count;
}

/// The same of the cells at the last of these levels alone.
std::size_t lowest_cells(const mesh::Solid& solid, const Cube& cube, int along, int levels)
{
    return split_cells(solid, cube, along, levels) - split_cells(solid, cube, along, levels - 1);
}

}  // namespace

double cell_side(const Setting& setting, FieldDensity density) { return longest(box_of(setting.object)) / density.cells; }

std::size_t dense_bytes(const Setting& setting, FieldDensity density)
{
    const FieldBox box = box_of(setting.object);
    const double side = cell_side(setting, density);
    std::size_t samples = 1;
    for (int k = 0; k < 3; ++k) samples *= static_cast<std::size_t>(std::ceil((box.hi[k] - box.lo[k]) / side - 1e-9)) + 3;
    return k_value * samples;
}

std::size_t full_octree_bytes(const Setting& setting, FieldDensity density)
{
    const FieldBox box = box_of(setting.object);
    const Cube root{box.lo, longest(box)};
    // Splitting a cell turns one leaf into eight.
    const std::size_t splits = split_cells(setting.solid, root, 2, std::countr_zero(density.cells));
    return (8 * splits + 1) * k_link + (7 * splits + 1) * 8 * k_value;
}

std::size_t tree512_bytes(const Setting& setting, FieldDensity density)
{
    const FieldBox box = box_of(setting.object);
    const Cube root{box.lo, 512 * cell_side(setting, density)};
    const std::size_t blocks = split_cells(setting.solid, root, 8, 3), leaves = lowest_cells(setting.solid, root, 8, 3);
    return 512 * ((blocks - leaves) * k_link + leaves * k_value);
}

double field_error(const Setting& setting, FieldDensity density, std::uint32_t points)
{
    const FieldBox box = box_of(setting.object);
    const double side = cell_side(setting, density);
    double sum = 0;
    std::size_t inside = 0;
    for (const Vec3d& p : bake::sample_points(setting.object, setting.r_max, {.points = points})) {
        const double exact = signed_distance(setting.solid, p);
        if (!(exact < 0) || exact < -0.04 * setting.r_max) continue;
        Vec3d cell, f;
        for (int k = 0; k < 3; ++k) {
            const double at = (p[k] - box.lo[k]) / side;
            cell[k] = std::floor(at);
            f[k] = at - cell[k];
        }
        double value = 0;
        for (int c = 0; c < 8; ++c) {
            const Vec3d corner{static_cast<double>(c & 1), static_cast<double>(c >> 1 & 1), static_cast<double>(c >> 2)};
            double weight = 1;
            for (int k = 0; k < 3; ++k) weight *= corner[k] > 0 ? f[k] : 1 - f[k];
            value += weight * signed_distance(setting.solid, box.lo + side * (cell + corner));
        }
        sum += std::abs(value - exact);
        ++inside;
    }
    return inside == 0 ? 0 : 100 * sum / (static_cast<double>(inside) * setting.r_max);
}

}  // namespace sqmap::bench
