// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, section 5: convex regions, Q1 and Q2.
#include "paper/bake/regions.h"

#include "paper/bake/grid.h"

#include <algorithm>
#include <cmath>

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

}  // namespace

ExactFeet::ExactFeet(const shape::Superquadricd& superquadric) : superquadric_(superquadric)
{
    const Grid grid(5);
    for (int i = 0; i < grid.rows; ++i)
        for (int j = 0; j < grid.columns; ++j) {
            angles_.push_back(grid.angles(i, j));
            points_.push_back(shape::surface_point(superquadric_, angles_.back()).point);
        }
}

shape::Foot<double> ExactFeet::of(Vec3d p) const
{
    std::size_t best = 0;
    double least = norm_sq(points_[0] - p);
    for (std::size_t k = 1; k < points_.size(); ++k)
        if (const double d = norm_sq(points_[k] - p); d < least) {
            least = d;
            best = k;
        }
    return shape::polish_foot(superquadric_, p, shape::position_at(superquadric_, angles_[best]),
                              {.max_iterations = 20, .tolerance = 1e-9});
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
