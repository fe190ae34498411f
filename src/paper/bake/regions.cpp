// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, section 5: convex regions, Q1 and Q2.
#include "paper/bake/regions.h"

#include "paper/bake/grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace sqmap::paper {

namespace {

struct HiddenArea {
    double hidden = 0, total = 0;
    [[nodiscard]] double share() const { return total > 0 ? hidden / total : 0; }
};

/// Looks at every stride-th triangle; calls visit(triangle) for those that are hidden.
template <class Visit>
double hidden_area(const PartSurface& part, const ExactFeet& feet, std::size_t stride, Visit visit)
{
    HiddenArea area;
    for (std::size_t i = 0; i < part.triangles.size(); i += stride) {
        const std::uint32_t t = part.triangles[i];
        const double own = mesh::triangle_area(part.mesh, t);
        area.total += own;
        if (!is_hidden(part.bvh, feet, feet.of(mesh::triangle_centroid(part.mesh, t)))) continue;
        area.hidden += own;
        visit(t);
    }
    return area.share();
}

constexpr int k_rows = 33, k_columns = 64;  // of the grid of starts
constexpr double k_searched_miss = 1e-5;    ///< of a foot that only the pattern search found; a tenth of is_hidden's margin

constexpr int k_sector_rows = 4, k_sectors = 32;

/// A superquadric may have edges between its octants (exponents near 2) and half-way between (near 0), nowhere within a sector.
constexpr std::size_t sector_of(int i, int j)
{
    const int row = std::min(i * k_sector_rows / (k_rows - 1), k_sector_rows - 1);
    return static_cast<std::size_t>(row * (k_sectors / k_sector_rows) + j * (k_sectors / k_sector_rows) / k_columns);
}

Vec3d perpendicular_to(Vec3d n)
{
    const Vec3d axis = std::abs(n.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
    return normalized(cross(n, axis));
}

/// Lengths of the steps of a search.
struct Steps {
    double first, last;
};

/// The least distance from p that steps along eight directions of the tangent plane reach.
shape::SurfacePosition<double> nearest_around(const shape::Superquadricd& sq, Vec3d p, shape::SurfacePosition<double> position,
                                              Steps steps)
{
    shape::SurfacePoint<double> at = shape::surface_point(sq, position);
    double least = norm_sq(at.point - p);
    for (double step = steps.first; step > steps.last;) {
        const Vec3d u = perpendicular_to(at.normal), v = cross(at.normal, u);
        bool is_nearer = false;
        for (int k = 0; k < 8 && !is_nearer; ++k) {
            const double angle = k * k_pi / 4;
            const Vec3d tried = at.point + step * (std::cos(angle) * u + std::sin(angle) * v);
            const shape::SurfacePosition<double> next = shape::position_through(sq, tried);
            const shape::SurfacePoint<double> there = shape::surface_point(sq, next);
            const double d = norm_sq(there.point - p);
            if (d >= least) continue;
            is_nearer = true;
            least = d;
            at = there;
            position = next;
        }
        if (!is_nearer) step /= 2;
    }
    return position;
}

}  // namespace

ExactFeet::ExactFeet(const shape::Superquadricd& superquadric) : superquadric_(superquadric)
{
    const Grid grid(k_rows, k_columns);
    for (int i = 0; i < k_rows; ++i)
        for (int j = 0; j < k_columns; ++j) {
            angles_.push_back(grid.angles(i, j));
            points_.push_back(shape::surface_point(superquadric_, angles_.back()).point);
        }
    for (int i = 0; i + 1 < k_rows; ++i)
        for (int j = 0; j < k_columns; ++j) {
            cell_ = std::max(cell_, norm(points_[grid.index(i + 1, j + 1)] - points_[grid.index(i, j)]));
            cell_ = std::max(cell_, norm(points_[grid.index(i + 1, j)] - points_[grid.index(i, j + 1)]));
        }
}

shape::Foot<double> ExactFeet::foot_from(Vec3d p, std::size_t sample) const
{
    // From a whole cell off, Newton's method may leave the basin for a saddle.
    const shape::SurfacePosition<double> close =
        nearest_around(superquadric_, p, shape::position_at(superquadric_, angles_[sample]), {cell_, cell_ / 32});
    const shape::Foot<double> foot = shape::polish_foot(superquadric_, p, close, {.max_iterations = 20, .tolerance = 1e-9});
    if (foot.converged) return foot;
    return shape::polish_foot(superquadric_, p,
                              nearest_around(superquadric_, p, close, {cell_ / 32, 1e-8 * largest_axis(superquadric_)}),
                              {.max_iterations = 20, .tolerance = k_searched_miss});
}

shape::Foot<double> ExactFeet::of(Vec3d p) const
{
    struct Start {
        double distance = std::numeric_limits<double>::infinity();
        std::size_t sample = 0;
    };
    std::array<Start, k_sectors> starts;
    for (int i = 0; i < k_rows; ++i)
        for (int j = 0; j < k_columns; ++j) {
            const std::size_t k = static_cast<std::size_t>(i) * k_columns + j;
            Start& start = starts[sector_of(i, j)];
            if (const double d = norm(points_[k] - p); d < start.distance) start = {d, k};
        }
    std::sort(starts.begin(), starts.end(),
              [](const Start& l, const Start& r) { return std::pair(l.distance, l.sample) < std::pair(r.distance, r.sample); });
    shape::Foot<double> best;
    double least = std::numeric_limits<double>::infinity();
    for (const Start& start : starts) {
        if (start.distance - cell_ > least) break;  // no point of the cells about the sample is nearer
        const shape::Foot<double> foot = foot_from(p, start.sample);
        const double d = norm(foot.point - p);
        if (best.converged && !(foot.converged && d < least)) continue;
        best = foot;
        least = d;
    }
    return best;
}

bool is_hidden(const mesh::Bvh& bvh, const ExactFeet& feet, const shape::Foot<double>& foot)
{
    if (!foot.converged) return true;
    const double margin = 1e-4 * largest_axis(feet.superquadric());
    if (foot.depth <= 2 * margin) return false;
    return bvh.meets_any({foot.point, -foot.normal, 0.0, foot.depth - margin});
}

double hidden_from_feet(const PartSurface& part, const ExactFeet& feet, std::size_t max_samples)
{
    const std::size_t stride = max_samples == 0 ? 1 : std::max<std::size_t>(1, part.triangles.size() / max_samples);
    return hidden_area(part, feet, stride, [](std::uint32_t) {});
}

double label_hidden(const PartSurface& part, const ExactFeet& feet, std::span<TriangleLabel> labels)
{
    return hidden_area(part, feet, 1, [&](std::uint32_t t) { labels[t].region = Region::Q2; });
}

void label_concave(const mesh::Mesh& mesh, std::span<TriangleLabel> labels)
{
    const double sine = std::sin(k_pi / 180);
    const mesh::DualGraph graph = mesh::dual_graph(mesh);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const Vec3d n = face_normal(mesh, t), c = mesh::triangle_centroid(mesh, t);
        for (const std::uint32_t o : graph.neighbours[t]) {
            if (o == mesh::k_no_triangle) continue;
            const Vec3d other = face_normal(mesh, o);
            const bool turns = norm(cross(n, other)) > sine || dot(n, other) < 0;
            if (turns && dot(n, mesh::triangle_centroid(mesh, o) - c) > 0) labels[t].region = Region::Q1;
        }
    }
}

}  // namespace sqmap::paper
