#include "mixed_cells.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace sqmap::bake {

namespace {

constexpr double k_division_share = 0.6;  // a mixed cell is divided where that leaves at most this share of its misfit

/// A ray through a cell, with its crossings inside the cell's band.
struct CellRay {
    FacePoint at;
    RaySample sample;
    std::array<double, 16> radius{};  ///< of the crossings
};

/// A lattice of rays over a cell.
constexpr int k_side = 4, k_row = k_side + 1, k_ring = 4 * k_side;
constexpr std::size_t k_rays = k_row * k_row;

/// The lattice point at a number along the border, counted from the corner of least s and t towards greater s.
std::size_t on_ring(int k)
{
    const int along = k % k_side;
    switch (k / k_side % 4) {
        case 0:
            return static_cast<std::size_t>(along);
        case 1:
            return static_cast<std::size_t>(k_side + along * k_row);
        case 2:
            return static_cast<std::size_t>(k_side * k_row + k_side - along);
        default:
            return static_cast<std::size_t>((k_side - along) * k_row);
    }
}

/// Finds what describes one mixed cell.
class MixedCellBaker {
public:
    MixedCellBaker(const Projection& projection, const Cell& cell, const CentralOptions& options, double w_step)
        : projection_(projection),
          cell_(cell),
          triangles_(projection, cell.square.face, cell.footprints),
          options_(options),
          w_step_(w_step)
    {
        for (const Polygon& p : cell.footprints) {
            if (projection.is_buried(p.triangle)) continue;
            for (int i = 0; i < p.count; ++i) {
                lo_ = std::min(lo_, p.corner[static_cast<std::size_t>(i)].w);
                hi_ = std::max(hi_, p.corner[static_cast<std::size_t>(i)].w);
            }
        }
    }

    MixedCell run() const
    {
        const RayPlanes first = planes_through(middle_ray());
        return {lo_, hi_, first, divide(first)};
    }

private:
    /// A ray near the middle whose point beyond the band lies in the chart's domain tells the verdict there. Where no ray reaches
    /// past the band, no point of the domain is there.
    CellRay middle_ray() const
    {
        static constexpr double k_positions[][2] = {{.5, .5},   {.25, .25}, {.75, .75}, {.25, .75}, {.75, .25},
                                                    {.05, .05}, {.95, .95}, {.05, .95}, {.95, .05}};
        CellRay chosen;
        for (const auto& position : k_positions) {
            const CellRay ray = cast(cell_.square.at(position[0], position[1]));
            if (!ray.sample.valid) continue;
            const bool reaches = projection_.is_in_domain(ray.at, lo_ * (1 - 1e-6));
            if (!chosen.sample.valid || reaches) chosen = ray;
            if (reaches) break;
        }
        return chosen;
    }

    CellRay cast(FacePoint at) const
    {
        CellRay ray{at, triangles_.crossings(at), {}};
        int kept = 0;
        while (kept < ray.sample.count && ray.sample.w[static_cast<std::size_t>(kept)] >= lo_ * (1 - 1e-9)) ++kept;
        ray.sample.count = kept;
        for (std::size_t i = 0; i < static_cast<std::size_t>(kept); ++i) ray.radius[i] = 1 / ray.sample.w[i];
        return ray;
    }

    RayPlanes planes_through(const CellRay& ray) const
    {
        RayPlanes planes;
        planes.s = ray.at.s;
        planes.t = ray.at.t;
        planes.count = std::min(ray.sample.count, model::k_max_sheets);
        if ((planes.count & 1) != (ray.sample.count & 1)) --planes.count;
        for (int j = 0; j < planes.count; ++j) {
            const auto i = static_cast<std::size_t>(j);
            const double w = ray.sample.w[i];
            const auto [same_w, ws, wt] = triangles_.plane_at(ray.at, w);
            // Slopes that would cross another sheet or leave the band are flattened.
            double limit = std::max(hi_ - lo_, w_step_);
            if (j > 0) limit = std::min(limit, 0.45 * (ray.sample.w[i - 1] - w));
            if (j + 1 < ray.sample.count) limit = std::min(limit, 0.45 * (w - ray.sample.w[i + 1]));
            const double steep = (std::abs(ws) + std::abs(wt)) * 0.5 * cell_.square.size;
            const double flatten = steep > limit ? limit / steep : 1;
            planes.plane[i] = {same_w, ws * flatten, wt * flatten};
        }
        return planes;
    }

    /// How far, as radii in the chart, planes are from what a ray meets: from every crossing to the nearest plane and from every
    /// plane to the nearest crossing; all of the band where there is none.
    double misfit(const RayPlanes& planes, const CellRay& ray) const
    {
        const RaySample& r = ray.sample;
        const double whole = 1 / lo_ - 1 / hi_;
        std::array<double, model::k_max_sheets> radius;
        for (int j = 0; j < planes.count; ++j) radius[static_cast<std::size_t>(j)] = 1 / planes.w_at(j, ray.at);
        const auto apart = [&](int i, int j) {
            return std::abs(radius[static_cast<std::size_t>(j)] - ray.radius[static_cast<std::size_t>(i)]);
        };
        double sum = 0;
        for (int i = 0; i < r.count; ++i) {
            double least = whole;
            for (int j = 0; j < planes.count; ++j) least = std::min(least, apart(i, j));
            sum += least;
        }
        for (int j = 0; j < planes.count; ++j) {
            double least = whole;
            for (int i = 0; i < r.count; ++i) least = std::min(least, apart(i, j));
            sum += least;
        }
        return sum;
    }

    /// A lattice of rays, and how far two sets of planes miss each of them.
    struct Sides {
        std::array<CellRay, k_rays> rays;
        std::array<double, k_rays> with_first{}, with_second{};  ///< misfits
        std::array<bool, k_rays> other{};                        ///< the second planes describe it better
        RayPlanes second;
    };

    /// Looks for the silhouette that makes a cell mixed: a lattice of rays is told apart by whether the planes of the first ray
    /// or those of the ray that they fit worst describe it better; the line goes through two points where that changes along the
    /// border.
    std::optional<Division> divide(const RayPlanes& first) const
    {
        Sides sides;
        double undivided = 0;
        std::size_t worst = 0;
        for (std::size_t i = 0; i < k_rays; ++i) {
            const auto column = static_cast<double>(i % k_row), row = static_cast<double>(i / k_row);
            sides.rays[i] = cast(cell_.square.at(column / k_side, row / k_side));
            if (!sides.rays[i].sample.valid) continue;
            sides.with_first[i] = misfit(first, sides.rays[i]);
            undivided += sides.with_first[i];
            if (sides.with_first[i] > sides.with_first[worst]) worst = i;
        }
        if (!(undivided > 0)) return std::nullopt;
        separate(worst, sides);
        const double worthwhile = options_.division * options_.r_max * static_cast<double>(k_rays) / longest_axis();
        return best_line(changes_along_border(first, sides), sides,
                         std::min(k_division_share * undivided, undivided - worthwhile));
    }

    double longest_axis() const
    {
        const Vec3d axes = projection_.chart().superquadric.a;
        return std::max({axes.x, axes.y, axes.z});
    }

    /// Twice: the second time through the ray in the middle of those that the first attempt won.
    void separate(std::size_t through, Sides& sides) const
    {
        for (int pass = 0; pass < 2; ++pass) {
            sides.second = planes_through(sides.rays[through]);
            double s = 0, t = 0, n = 0;
            for (std::size_t i = 0; i < k_rays; ++i) {
                const CellRay& ray = sides.rays[i];
                sides.with_second[i] = ray.sample.valid ? misfit(sides.second, ray) : 0;
                sides.other[i] = sides.with_second[i] < sides.with_first[i];
                if (!sides.other[i]) continue;
                s += ray.at.s;
                t += ray.at.t;
                n += 1;
            }
            double nearest = std::numeric_limits<double>::infinity();
            for (std::size_t i = 0; i < k_rays; ++i) {
                const double d = norm(Vec3d{sides.rays[i].at.s - s / n, sides.rays[i].at.t - t / n, 0});
                if (!sides.other[i] || !(d < nearest)) continue;
                nearest = d;
                through = i;
            }
        }
    }

    /// Codes of the border points where the better planes are others: by halves between two rays of the lattice.
    std::vector<std::uint32_t> changes_along_border(const RayPlanes& first, const Sides& sides) const
    {
        std::vector<std::uint32_t> changes;
        for (int k = 0; k < k_ring; ++k) {
            const bool before = sides.other[on_ring(k)];
            if (before == sides.other[on_ring((k + 1) % k_ring)]) continue;
            constexpr std::uint32_t k_step = 256 / k_ring;
            std::uint32_t first_code = static_cast<std::uint32_t>(k) * k_step, last_code = first_code + k_step;
            while (last_code - first_code > 2) {
                const std::uint32_t middle = (first_code + last_code) / 2;
                const model::BorderPoint p = model::border_point(middle);
                const CellRay ray = cast(cell_.square.at(static_cast<double>(p.u), static_cast<double>(p.v)));
                const bool here = misfit(sides.second, ray) < misfit(first, ray);
                (here == before ? first_code : last_code) = middle;
            }
            changes.push_back(((first_code + last_code) / 2) & 255u);
        }
        return changes;
    }

    /// The line between two of the changes that leaves the least misfit, if that is below a limit.
    std::optional<Division> best_line(const std::vector<std::uint32_t>& changes, const Sides& sides, double limit) const
    {
        std::optional<Division> best;
        double u[k_rays], v[k_rays];
        for (std::size_t k = 0; k < k_rays; ++k) {
            const FacePoint at = sides.rays[k].at;
            u[k] = (at.s - cell_.square.s) / cell_.square.size;
            v[k] = (at.t - cell_.square.t) / cell_.square.size;
        }
        for (const std::uint32_t from_code : changes)
            for (const std::uint32_t to_code : changes) {
                if (from_code == to_code) continue;
                const model::BorderPoint from = model::border_point(from_code), to = model::border_point(to_code);
                const auto du = static_cast<double>(to.u - from.u), dv = static_cast<double>(to.v - from.v);
                double sum = 0;
                for (std::size_t k = 0; k < k_rays && sum < limit; ++k) {
                    const bool left = du * (v[k] - static_cast<double>(from.v)) - dv * (u[k] - static_cast<double>(from.u)) >= 0;
                    sum += left ? sides.with_first[k] : sides.with_second[k];
                }
                if (!(sum < limit)) continue;
                limit = sum;
                best = Division{from_code, to_code, sides.second};
            }
        return best;
    }

    const Projection& projection_;
    const Cell& cell_;
    CellTriangles triangles_;
    const CentralOptions& options_;
    double w_step_;
    double lo_ = std::numeric_limits<double>::infinity(), hi_ = 0;
};

}  // namespace

const MixedCell& MixedCells::at(const Cell& cell)
{
    const CellSquare& square = cell.square;
    const auto number = [&](double from) { return std::lround((from + 1) / square.size); };
    const auto [at, is_new] =
        known_.try_emplace(Square{square.face, std::lround(2 / square.size), number(square.s), number(square.t)});
    if (is_new) at->second = MixedCellBaker(projection_, cell, options_, w_step_).run();
    return at->second;
}

}  // namespace sqmap::bake
