#include "fit.h"

#include "bake/central/chart.h"
#include "bake/parts/bound_figures.h"
#include "fit/polytope.h"
#include "mesh/convex_hull.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <tuple>
#include <utility>

namespace sqmap::bake {

namespace {

constexpr std::size_t k_few_parts = 4;  ///< turning the sides of each takes as long as four fits
constexpr double k_near_enough = 0.01;  ///< of the part's extent: bounds that reach no farther beyond its hull stay as they are

/// The patch's triangles by their rank in the canonical mesh.
std::vector<std::uint32_t> ordered_in(const CanonicalMesh& canonical, const Patch& patch)
{
    std::vector<std::uint32_t> ordered = patch.triangles;
    const std::vector<mesh::Triangle>& triangles = canonical.mesh.triangles;
    std::sort(ordered.begin(), ordered.end(), [&](std::uint32_t l, std::uint32_t r) { return triangles[l] < triangles[r]; });
    return ordered;
}

/// Share of a part's area that other surface hides from its projection centre (section 5's Q2 for this projection).
double hidden_share(const mesh::Solid& solid, std::span<const std::uint32_t> ordered, Vec3d centre)
{
    const int start = solid.bvh().winding_number(centre);
    double hidden = 0, seen = 0;
    std::vector<mesh::Bvh::Crossing> crossings;
    const std::size_t stride = std::max<std::size_t>(1, ordered.size() / 200);
    for (std::size_t i = 0; i < ordered.size(); i += stride) {
        const std::uint32_t t = ordered[i];
        const Vec3d to = mesh::triangle_centroid(solid.mesh(), t) - centre;
        if (!solid.bvh().ray_crossings(centre, to, crossings)) continue;
        // Visible if the first change of verdict on the ray is at the triangle itself.
        int winding = start;
        bool visible = false;
        for (const mesh::Bvh::Crossing& c : crossings) {
            const int next = winding - c.sign;
            if ((next > 0) != (winding > 0)) {
                visible = c.triangle == t;
                break;
            }
            winding = next;
        }
        (visible ? seen : hidden) += mesh::triangle_area(solid.mesh(), t);
    }
    return hidden + seen > 0 ? hidden / (hidden + seen) : 0;
}

/// The fit, made in the canonical frame so that turning the mesh changes it by rounding only, and certified in the
/// model's: turned back, rounded to float, and enlarged by the rounding.
fit::FitReport certified_fit(const mesh::Mesh& mesh, const CanonicalMesh& canonical, const Patch& patch,
                             const fit::FitOptions& options)
{
    std::vector<CapTriangle> turned = patch.caps;
    for (CapTriangle& t : turned)
        for (Vec3d& p : t) p = canonical.frame * p;
    const auto key = [](const CapTriangle& t) {
        const Vec3d c = t[0] + t[1] + t[2];
        return std::tuple(c.x, c.y, c.z);
    };
    std::stable_sort(turned.begin(), turned.end(), [&](const CapTriangle& l, const CapTriangle& r) { return key(l) < key(r); });
    fit::FitReport report = fit::fit_bounding(canonical.mesh, ordered_in(canonical, patch), turned, options);

    const HeldSurface held = held_by(mesh, patch);
    const auto narrow = [](double v) { return static_cast<double>(static_cast<float>(v)); };
    const shape::Superquadricd fitted = report.superquadric;
    for (double slack = 0; slack<0.1; slack = slack> 0 ? 2 * slack : 1e-6) {
        shape::Superquadricd sq = fitted;
        const Mat3d rotation = fitted.rotation * canonical.frame;
        const Vec3d translation = transpose_mul(canonical.frame, fitted.translation);
        for (int i = 0; i < 3; ++i) {
            for (int k = 0; k < 3; ++k) sq.rotation.row[i][k] = narrow(rotation.row[i][k]);
            sq.translation[i] = narrow(translation[i]);
            sq.a[i] = narrow(fitted.a[i] * (1 + slack));
        }
        sq.bend = narrow(fitted.bend / (1 + slack));
        const fit::Certificate certificate = fit::certify(sq, held.points, held.triangles);
        if (certificate.largest_f > 1 - fit::float_margin(sq)) continue;
        report.superquadric = sq;
        report.certificate = certificate;
        report.certificate.bounding = true;
        report.volume = fit::volume(sq);
        return report;
    }
    // Turning cost more than a tenth: fit in the model's own frame instead.
    return fit::fit_bounding(mesh, patch.triangles, patch.caps, options);
}

}  // namespace

HeldSurface held_by(const mesh::Mesh& mesh, const Patch& patch)
{
    HeldSurface held;
    for (const CapTriangle& t : patch.caps) {
        const auto first = static_cast<std::uint32_t>(held.points.size());
        held.triangles.push_back({first, first + 1, first + 2});
        held.points.insert(held.points.end(), t.begin(), t.end());
    }
    std::vector<std::uint32_t> vertices;
    for (const std::uint32_t t : patch.triangles)
        vertices.insert(vertices.end(), mesh.triangles[t].begin(), mesh.triangles[t].end());
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    const auto first = static_cast<std::uint32_t>(held.points.size());
    for (const std::uint32_t v : vertices) held.points.push_back(mesh.vertices[v]);
    for (const std::uint32_t t : patch.triangles) {
        mesh::Triangle& triangle = held.triangles.emplace_back();
        for (std::size_t k = 0; k < 3; ++k)
            triangle[k] =
                first + static_cast<std::uint32_t>(std::lower_bound(vertices.begin(), vertices.end(), mesh.triangles[t][k]) -
                                                   vertices.begin());
    }
    return held;
}

fit::Certificate certify_patch(const mesh::Mesh& mesh, const Patch& patch, const shape::Superquadricd& superquadric)
{
    const HeldSurface held = held_by(mesh, patch);
    return fit::certify(superquadric, held.points, held.triangles);
}

FittedPart fit_patch(const mesh::Solid& solid, const CanonicalMesh& canonical, Patch patch, const fit::FitOptions& options)
{
    FittedPart part{std::move(patch), {}, {}};
    part.fit = certified_fit(solid.mesh(), canonical, part.patch, options);
    part.centre = choose_centre(solid, part.fit.superquadric, ordered_in(canonical, part.patch));
    return part;
}

std::vector<HalfSpacef> fit_polytope(const mesh::Mesh& mesh, const FittedPart& part, std::size_t part_count)
{
    const HeldSurface held = held_by(mesh, part.patch);
    const mesh::Mesh hull = mesh::convex_hull(held.points);
    const shape::Superquadricd& sq = part.fit.superquadric;
    std::vector<HalfSpacef> sides = fit::bounding_polytope(hull, held.points, sq);
    if (part_count > k_few_parts || hull.triangles.empty()) return sides;
    const double excess = excess_of_both(hull, sq, sides);
    if (excess < k_near_enough * mesh::largest_vertex_distance(hull)) return sides;
    std::vector<HalfSpacef> nearer = fit::nearer_polytope(hull, held.points, sides, sq.rotation);
    return nearer.empty() || excess_of_both(hull, sq, nearer) > excess ? sides : nearer;
}

PartQuality quality_of(const PartsInput& input, const FittedPart& part)
{
    PartQuality quality;
    const mesh::Solid& solid = input.solid;
    for (const std::uint32_t t : part.patch.triangles) quality.area += mesh::triangle_area(solid.mesh(), t);
    quality.solid_volume = enclosed_volume(solid.mesh(), part.patch);
    const std::vector<std::uint32_t> ordered = ordered_in(input.canonical, part.patch);
    quality.q2_share =
        input.hidden ? input.hidden(solid, ordered, part) : hidden_share(solid, ordered, cast<double>(part.centre));
    return quality;
}

}  // namespace sqmap::bake
