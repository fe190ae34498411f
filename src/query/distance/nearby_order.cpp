#include "query/distance/nearby_order.h"

#include "sqmap/math/rotation.h"
#include "sqmap/model/model.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace sqmap::query {

namespace {

constexpr std::size_t k_side = 16, k_cells = k_side * k_side * k_side;
constexpr double k_farthest = 16;  // times the object's radius: what is farther away goes into the outermost cells

/// The bits of a coordinate, three apart.
constexpr auto k_spread = [] {
    std::array<std::uint16_t, k_side> spread{};
    for (std::size_t i = 0; i < k_side; ++i)
        spread[i] = static_cast<std::uint16_t>((i & 1) | (i & 2) << 2 | (i & 4) << 4 | (i & 8) << 6);
    return spread;
}();

/// Cells divide the box of the points.
class PointGrid {
public:
    PointGrid(const Body& touched, std::span<const Vec3d> points)
    {
        const model::Header& h = touched.model->header;
        const Vec3d middle = apply(touched.pose, model::to_mesh_units(h, model::vec3(h.sphere)));
        const double widest = k_farthest * h.unit * static_cast<double>(h.sphere[3]);
        Vec3d hi;
        for (int k = 0; k < 3; ++k) {
            lo_[k] = middle[k] + widest;
            hi[k] = middle[k] - widest;
            for (const Vec3d& p : points) {
                lo_[k] = std::min(lo_[k], p[k]);
                hi[k] = std::max(hi[k], p[k]);
            }
            lo_[k] = std::max(lo_[k], middle[k] - widest);
            hi[k] = std::min(hi[k], middle[k] + widest);
            const double cells = static_cast<double>(k_side) / (hi[k] - lo_[k]);
            per_cell_[k] = cells > 0 && cells < 1e300 ? cells : 0;
        }
    }

    /// Along a curve of z-order.
    std::size_t cell_of(Vec3d p) const
    {
        std::size_t cell = 0;
        for (int k = 0; k < 3; ++k) {
            const double at = (p[k] - lo_[k]) * per_cell_[k];
            const std::size_t i = at > 0 ? static_cast<std::size_t>(std::min(at, k_side - 1.0)) : 0;  // 0 where it is no number
            cell |= std::size_t{k_spread[i]} << k;
        }
        return cell;
    }

private:
    Vec3d lo_, per_cell_;
};

}  // namespace

void put_near_together(const Body& touched, std::span<const Vec3d> points, std::span<std::uint16_t> order) noexcept
{
    const PointGrid grid(touched, points);
    std::uint32_t next[k_cells + 1] = {};
    for (const Vec3d& p : points) ++next[grid.cell_of(p) + 1];
    for (std::size_t c = 0; c < k_cells; ++c) next[c + 1] += next[c];
    for (std::size_t i = 0; i < points.size(); ++i) order[next[grid.cell_of(points[i])]++] = static_cast<std::uint16_t>(i);
}

}  // namespace sqmap::query
