#include "bound_figures.h"

#include "bake/parts/fit.h"
#include "fit/polytope.h"
#include "mesh/convex_hull.h"
#include "parallel/for_each.h"
#include "sqmap/fit/fit.h"
#include "sqmap/math/box.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/shape/surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace sqmap::bake {

namespace {

using shape::Superquadricd;

constexpr std::size_t k_tries = 2048;  ///< points of a box, of which those in the bound count
constexpr int k_rows = 16, k_columns = 32;
constexpr int k_halvings = 16;

constexpr auto k_superquadric = static_cast<std::size_t>(model::Bound::Superquadric),
               k_polytope = static_cast<std::size_t>(model::Bound::Polytope),
               k_both = static_cast<std::size_t>(model::Bound::Both);

/// The bounds of one part.
struct PartBounds {
    Superquadricd superquadric;
    std::vector<HalfSpaced> sides;
    std::vector<Vec3d> corners;  ///< of the polytope
    double polytope_volume = 0;

    [[nodiscard]] bool superquadric_holds(Vec3d p) const
    {
        const Superquadricd& sq = superquadric;
        const Vec3d q = shape::undeform(sq, shape::to_local(sq, p));
        // Most points are outside the box before any power is raised.
        return std::abs(q.x) <= sq.a.x && std::abs(q.y) <= sq.a.y && std::abs(q.z) <= sq.a.z &&
               shape::implicit_undeformed(sq.a, sq.eps1, sq.eps2, q) <= 1;
    }
    [[nodiscard]] bool polytope_holds(Vec3d p) const { return sqmap::holds(sides, p); }
};

PartBounds bounds_of(const Superquadricd& superquadric, std::span<const HalfSpacef> polytope)
{
    PartBounds bounds{superquadric, {}, {}};
    for (const HalfSpacef& side : polytope) bounds.sides.push_back(cast<double>(side));
    bounds.corners = mesh::polytope_corners(bounds.sides);
    bounds.polytope_volume = mesh::volume(mesh::convex_hull(bounds.corners));
    return bounds;
}

/// The point nearest the surface on the way that an inner point takes there when the shape deforms, which the polytope holds.
bool pull_into(const PartBounds& bounds, Vec3d surface, Vec3d& pulled)
{
    const Superquadricd& sq = bounds.superquadric;
    const Vec3d q = shape::undeform(sq, shape::to_local(sq, surface));
    const auto at = [&](double share) { return shape::to_model(sq, shape::deform(sq, share * q)); };
    if (!bounds.polytope_holds(at(0))) return false;
    double in = 0, out = 1;
    for (int i = 0; i < k_halvings; ++i) {
        const double middle = 0.5 * (in + out);
        (bounds.polytope_holds(at(middle)) ? in : out) = middle;
    }
    pulled = at(in);
    return true;
}

/// Points among which the farthest of each bound are.
struct FarPoints {
    std::array<std::vector<Vec3d>, 3> of;
};

FarPoints far_points(const PartBounds& bounds)
{
    FarPoints points;
    for (int row = 0; row <= k_rows; ++row)
        for (int column = 0; column < k_columns; ++column) {
            const double eta = std::numbers::pi * (static_cast<double>(row) / k_rows - 0.5);
            const double omega = std::numbers::pi * (2 * static_cast<double>(column) / k_columns - 1);
            const Vec3d p = shape::surface_point(bounds.superquadric, shape::SurfaceAngles<double>{eta, omega}).point;
            points.of[k_superquadric].push_back(p);
            if (bounds.polytope_holds(p))
                points.of[k_both].push_back(p);
            else if (Vec3d pulled; pull_into(bounds, p, pulled))
                points.of[k_both].push_back(pulled);
        }
    points.of[k_polytope] = bounds.corners;
    for (const Vec3d& p : bounds.corners)
        if (bounds.superquadric_holds(p)) points.of[k_both].push_back(p);
    return points;
}

/// Points spread over a part's polytope; their weights sum to its volume.
std::vector<fit::InteriorPoint> points_of_polytope(const PartBounds& bounds)
{
    std::vector<Vec3d> turned;
    for (const Vec3d& p : bounds.corners) turned.push_back(bounds.superquadric.rotation * p);
    const Box extent = box_of(turned);
    std::vector<fit::InteriorPoint> points;
    if (is_empty(extent)) return points;
    for (const Vec3d& at : fit::spread_points(k_tries)) {
        Vec3d q;
        for (int k = 0; k < 3; ++k) q[k] = extent.lo[k] + at[k] * (extent.hi[k] - extent.lo[k]);
        const Vec3d p = transpose_mul(bounds.superquadric.rotation, q);
        if (bounds.polytope_holds(p)) points.push_back({p, 0});
    }
    for (fit::InteriorPoint& p : points) p.weight = bounds.polytope_volume / static_cast<double>(points.size());
    return points;
}

/// A part's own figures, and its share of the union's volumes.
struct PartFigures {
    model::BoundFigures own{};
    double share[3] = {};
    FarPoints far;
};

/// The bounds of all parts.
class Union {
public:
    explicit Union(const std::vector<PartBounds>& all) : all_(all) {}

    /// Sums over points of one part: each counts for as much as one of the parts that hold it.
    PartFigures measure(std::size_t part) const
    {
        const PartBounds& bounds = all_[part];
        PartFigures figures;
        const std::vector<fit::InteriorPoint> inside = fit::interior_points(bounds.superquadric, k_tries);
        double volume = 0, both = 0;
        for (const auto& [p, weight] : inside) {
            const bool is_in_both = bounds.polytope_holds(p);
            int superquadrics = 1, pairs = 1;
            for (std::size_t i = 0; i < all_.size(); ++i) {
                if (i == part || !all_[i].superquadric_holds(p)) continue;
                ++superquadrics;
                pairs += is_in_both && all_[i].polytope_holds(p) ? 1 : 0;
            }
            volume += weight;
            figures.share[k_superquadric] += weight / superquadrics;
            if (!is_in_both) continue;
            both += weight;
            figures.share[k_both] += weight / pairs;
        }
        for (const auto& [p, weight] : points_of_polytope(bounds)) {
            int polytopes = 1;
            for (std::size_t i = 0; i < all_.size(); ++i) polytopes += i != part && all_[i].polytope_holds(p) ? 1 : 0;
            figures.share[k_polytope] += weight / polytopes;
        }
        const double share = volume > 0 ? both / volume : 0;
        figures.own.volume[k_superquadric] = static_cast<float>(volume);
        figures.own.volume[k_polytope] = static_cast<float>(bounds.polytope_volume);
        // Sampled, it may come out above the polytope's, which is exact.
        figures.own.volume[k_both] = static_cast<float>(std::min(both, bounds.polytope_volume));
        figures.own.standard_error =
            static_cast<float>(volume * std::sqrt(share * (1 - share) / std::max<double>(1, static_cast<double>(inside.size()))));
        figures.far = far_points(bounds);
        return figures;
    }

private:
    const std::vector<PartBounds>& all_;
};

}  // namespace

double excess_of_both(const mesh::Mesh& hull, const Superquadricd& superquadric, std::span<const HalfSpacef> sides)
{
    return mesh::farthest_from_hull(hull, far_points(bounds_of(superquadric, sides)).of[k_both]);
}

std::vector<model::BoundFigures> measure_bounds(const mesh::Mesh& mesh, std::span<const Patch> patches,
                                                const model::ModelData& data, unsigned threads)
{
    const model::ModelView model = data.view();
    if (model.polytope_ends.empty()) return {};
    std::vector<PartBounds> bounds(patches.size());
    parallel::for_each(bounds.size(), threads, [&](std::size_t i) {
        bounds[i] = bounds_of(shape::cast<double>(model::superquadric_of(model.parts[i])), model::polytope_of(model, i));
    });
    const Union whole(bounds);
    const mesh::Mesh whole_hull = mesh::convex_hull(mesh.vertices);
    std::vector<PartFigures> parts(patches.size());
    std::vector<std::array<double, 3>> beyond(patches.size());
    parallel::for_each(bounds.size(), threads, [&](std::size_t i) {
        parts[i] = whole.measure(i);
        model::BoundFigures& own = parts[i].own;
        if (model.header.solid != 0) own.solid_volume = static_cast<float>(enclosed_volume(mesh, patches[i]));
        const mesh::Mesh hull = mesh::convex_hull(held_by(mesh, patches[i]).points);
        for (std::size_t k = 0; k < 3; ++k) {
            own.excess[k] = static_cast<float>(mesh::farthest_from_hull(hull, parts[i].far.of[k]));
            beyond[i][k] = mesh::farthest_from_hull(whole_hull, parts[i].far.of[k]);
        }
    });
    std::vector<model::BoundFigures> figures;
    model::BoundFigures all{};
    double volume[3] = {}, variance = 0;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        figures.push_back(parts[i].own);
        for (std::size_t k = 0; k < 3; ++k) {
            volume[k] += parts[i].share[k];
            all.excess[k] = std::max(all.excess[k], static_cast<float>(beyond[i][k]));
        }
        variance += static_cast<double>(parts[i].own.standard_error) * static_cast<double>(parts[i].own.standard_error);
    }
    if (model.header.solid != 0) all.solid_volume = static_cast<float>(mesh::volume(mesh));
    for (std::size_t k = 0; k < 3; ++k) all.volume[k] = static_cast<float>(volume[k]);
    all.standard_error = static_cast<float>(std::sqrt(variance));
    figures.push_back(all);
    return figures;
}

}  // namespace sqmap::bake
