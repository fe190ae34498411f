// K. Takayama, A. Jacobson, L. Kavan and O. Sorkine-Hornung, "A simple method for correcting facet orientations in polygon meshes
// based on ray casting", 2014: rays from points of a patch vote for the side that sees the outside.
#include "steps.h"

#include "sqmap/math/box.h"
#include "sqmap/mesh/bvh.h"

#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

namespace sqmap::mesh {
namespace {

constexpr double k_rays = 20'000;  // a side, spread by area
constexpr double k_min_rays = 8;   // of a region
constexpr double k_lift = 1e-7;    // of the diagonal: how far from its face a ray begins
constexpr int k_tries = 4;         // of directions that pass no edge too closely
constexpr double k_golden = 1.618033988749895;

/// Four numbers in [0, 1) that fill their cube evenly as i grows: the R4 sequence.
std::array<double, 4> evenly(std::uint64_t i)
{
    constexpr std::array<double, 4> k_steps{0.8566748838545029, 0.7338918566271260, 0.6287067210378087, 0.5385972572236101};
    std::array<double, 4> out;
    for (std::size_t k = 0; k < 4; ++k) out[k] = std::fmod(0.5 + k_steps[k] * static_cast<double>(i + 1), 1.0);
    return out;
}

/// Any two directions across n.
std::pair<Vec3d, Vec3d> across(Vec3d n)
{
    const Vec3d other = std::abs(n.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
    const Vec3d x = normalized(cross(n, other));
    return {x, cross(n, x)};
}

class Caster {
public:
    explicit Caster(const Mesh& mesh) : mesh_(mesh), bvh_(mesh), lift_(k_lift * norm(size(box_of(mesh.vertices)))) {}

    /// True if the i-th ray from a face, on the side of sign, leaves; nothing if that cannot be decided.
    std::optional<bool> leaves(std::uint32_t face, std::uint64_t i, double sign)
    {
        const Triangle& t = mesh_.triangles[face];
        const Vec3d a = mesh_.vertices[t[0]], u = mesh_.vertices[t[1]] - a, v = mesh_.vertices[t[2]] - a;
        const Vec3d n = sign * normalized(cross(u, v));
        const auto [x, y] = across(n);
        for (int attempt = 0; attempt < k_tries; ++attempt) {
            auto [s, r, turn, height] = evenly(i);
            if (s + r > 1) s = 1 - s, r = 1 - r;
            const double angle = 2 * std::numbers::pi * std::fmod(turn + attempt * k_golden, 1.0);
            const double out = std::sqrt(1 - height),
                         along = std::sqrt(height);  // density like the cosine, since grazing rays say little
            const Vec3d direction = out * n + along * (std::cos(angle) * x + std::sin(angle) * y);
            if (bvh_.ray_crossings(a + s * u + r * v + lift_ * n, direction, crossings_)) return crossings_.empty();
        }
        return {};
    }

private:
    const Mesh& mesh_;
    Bvh bvh_;
    double lift_;
    std::vector<Bvh::Crossing> crossings_;
};

}  // namespace

std::vector<Seen> seen_from_outside(const Surface& surface, std::span<const std::uint32_t> region)
{
    Mesh mesh{surface.points, {}};
    for (const Face& f : surface.faces) mesh.triangles.push_back(f.v);
    std::vector<double> area(mesh.triangles.size(), 0), region_area(mesh.triangles.size(), 0), passed(mesh.triangles.size(), 0);
    double total = 0;
    for (std::uint32_t t = 0; t < area.size(); ++t) {
        area[t] = triangle_area(mesh, t);
        region_area[region[t]] += area[t];
        total += area[t];
    }
    struct Votes {
        double cast = 0, left = 0;
    };
    std::vector<std::array<Votes, 2>> votes(area.size());
    Caster caster(mesh);
    std::uint64_t ray = 0;
    for (std::uint32_t t = 0; t < area.size(); ++t) {
        const std::uint32_t r = region[t];
        if (!(area[t] > 0)) continue;
        const double rays = std::max(k_rays * region_area[r] / total, k_min_rays);
        const double before = passed[r];
        passed[r] += rays * area[t] / region_area[r];
        // Sends a ray wherever the count passes a half.
        for (double i = std::ceil(before - 0.5) + 0.5; i < passed[r]; i += 1, ++ray)
            for (const std::size_t side : {0u, 1u})
                if (const auto left = caster.leaves(t, ray, side == 0 ? 1 : -1)) {
                    votes[r][side].cast += 1;
                    votes[r][side].left += *left ? 1 : 0;
                }
    }
    std::vector<Seen> out(area.size());
    const auto share = [](const Votes& v) { return v.cast > 0 ? v.left / v.cast : 0; };
    for (std::size_t r = 0; r < out.size(); ++r) out[r] = {share(votes[r][0]), share(votes[r][1])};
    return out;
}

}  // namespace sqmap::mesh
