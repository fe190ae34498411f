// Capsules that melt into each other, and their surface. Marching tetrahedra: Doi and Koide 1991, on the Freudenthal split of a
// grid, whose six tetrahedra a cell match across cells, so the result is closed and manifold.
#include "sqmap/mesh/shapes.h"

#include "sqmap/math/box.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

namespace sqmap::mesh {
namespace {

/// Capsules this many blends farther than the nearest one add less to the sum than its last bit.
constexpr double k_far = 40;

double distance(const Capsule& c, Vec3d p)
{
    const Vec3d axis = c.b - c.a;
    const double length_sq = norm_sq(axis);
    const double t = length_sq > 0 ? std::clamp(dot(p - c.a, axis) / length_sq, 0.0, 1.0) : 0.0;
    return norm(p - c.a - t * axis) - (c.radius_a + t * (c.radius_b - c.radius_a));
}

/// field() of some of a solid's capsules.
double field(std::span<const Capsule> capsules, double blend, Vec3d p)
{
    thread_local std::vector<double> apart;
    apart.resize(capsules.size());
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < apart.size(); ++i) least = std::min(least, apart[i] = distance(capsules[i], p));
    double sum = 0;
    for (const double d : apart)
        if (d - least < k_far * blend) sum += std::exp((least - d) / blend);
    return least - blend * std::log(sum);
}

/// The field near a point, of the capsules that add to it there: the same bits, in less time.
class NearField {
public:
    /// reach: up to where the capsules of one point serve for others.
    NearField(const CapsuleSolid& solid, double reach) : solid_(solid), reach_(reach)
    {
        // A capsule's distance changes by one across its axis, and by its taper along it.
        for (const Capsule& c : solid.capsules) {
            const double length = norm(c.b - c.a), taper = length > 0 ? (c.radius_b - c.radius_a) / length : 0;
            steepest_ = std::max(steepest_, std::sqrt(1 + taper * taper));
        }
    }

    double operator()(Vec3d p)
    {
        if (near_.empty() || !(norm(p - middle_) <= reach_)) gather(p);
        return field(near_, solid_.blend, p);
    }
    Vec3d gradient(Vec3d p, double step)
    {
        Vec3d g;
        for (int i = 0; i < 3; ++i) {
            Vec3d lo = p, hi = p;
            lo[i] -= step;
            hi[i] += step;
            g[i] = ((*this)(hi) - (*this)(lo)) / (2 * step);
        }
        return g;
    }

private:
    void gather(Vec3d p)
    {
        middle_ = p;
        double least = std::numeric_limits<double>::infinity();
        for (const Capsule& c : solid_.capsules) least = std::min(least, distance(c, p));
        near_.clear();
        for (const Capsule& c : solid_.capsules)
            if (distance(c, p) - least < 1.001 * (k_far * solid_.blend + 2 * steepest_ * reach_)) near_.push_back(c);
    }

    const CapsuleSolid& solid_;
    double reach_, steepest_ = 1;
    Vec3d middle_{};
    std::vector<Capsule> near_;
};

/// Moves vertices along the surface towards the mean of their neighbours and back onto it: marching tetrahedra leave
/// slivers, and slivers make poor normals.
void spread_evenly(const CapsuleSolid& solid, double spacing, Mesh& mesh)
{
    constexpr int k_rounds = 12;
    const double step = 1e-4 * spacing;
    NearField near(solid, spacing);
    std::vector<Vec3d> sum(mesh.vertices.size());
    std::vector<int> count(mesh.vertices.size());
    for (int round = 0; round < k_rounds; ++round) {
        std::fill(sum.begin(), sum.end(), Vec3d{});
        std::fill(count.begin(), count.end(), 0);
        for (const Triangle& t : mesh.triangles)
            for (int i = 0; i < 3; ++i) {
                sum[t[i]] += mesh.vertices[t[(i + 1) % 3]];
                ++count[t[i]];
            }
        for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
            Vec3d& p = mesh.vertices[v];
            const Vec3d normal = sqmap::normalized(near.gradient(p, step));
            const Vec3d move = sum[v] / static_cast<double>(count[v]) - p;
            p += 0.6 * (move - dot(move, normal) * normal);
            for (int newton = 0; newton < 3; ++newton) {
                const Vec3d g = near.gradient(p, step);
                p -= near(p) / std::max(norm_sq(g), 1e-12) * g;
            }
        }
    }
}

Box box_around(std::span<const Capsule> capsules)
{
    Box box;
    for (const Capsule& c : capsules)
        for (const auto& [p, r] : {std::pair{c.a, c.radius_a}, std::pair{c.b, c.radius_b}}) {
            extend(box, p - Vec3d{r, r, r});
            extend(box, p + Vec3d{r, r, r});
        }
    return box;
}

}  // namespace

double field(const CapsuleSolid& solid, Vec3d p) { return field(solid.capsules, solid.blend, p); }

CapsuleSolid hand_capsules()
{
    CapsuleSolid hand;
    hand.blend = 0.014;
    // A relaxed hand: fingers bend towards the palm (-z), most at the middle joint, and spread in the xy plane; y points from
    // wrist to finger tips. A phalanx is thicker at its joints than between them.
    struct Finger {
        Vec3d root;                 // where the metacarpal starts, at the wrist
        Vec3d knuckle;              // base of the finger
        double spread;              // angle from +y towards +x, radians
        std::vector<double> bends;  // towards -z at the start of each phalanx, radians
        std::vector<double> lengths;
        double radius;  // at the knuckle; each joint is a little thinner
    };
    const std::vector<Finger> fingers{
        {{-0.055, 0.06, 0.000}, {-0.142, 0.436, 0.004}, -0.31, {0.20, 0.80, 0.45}, {0.195, 0.125, 0.090}, 0.046},  // index
        {{-0.020, 0.06, 0.004}, {-0.042, 0.465, 0.014}, -0.05, {0.24, 0.85, 0.50}, {0.215, 0.140, 0.095}, 0.048},  // middle
        {{0.020, 0.06, 0.004}, {0.058, 0.445, 0.010}, 0.18, {0.27, 0.88, 0.50}, {0.200, 0.130, 0.092}, 0.045},     // ring
        {{0.055, 0.06, 0.000}, {0.150, 0.396, -0.006}, 0.47, {0.30, 0.90, 0.50}, {0.155, 0.095, 0.078}, 0.040},    // little
        {{-0.055, 0.08, -0.012}, {-0.190, 0.205, -0.045}, -0.94, {0.20, 0.60}, {0.150, 0.115}, 0.050},             // thumb
    };
    for (const Finger& f : fingers) {
        hand.capsules.push_back({f.root, f.knuckle, 1.20 * f.radius, 1.12 * f.radius});
        Vec3d joint = f.knuckle;
        double radius = f.radius, pitch = 0;
        for (std::size_t i = 0; i < f.lengths.size(); ++i) {
            pitch += f.bends[i];
            const Vec3d along{std::sin(f.spread) * std::cos(pitch), std::cos(f.spread) * std::cos(pitch), -std::sin(pitch)};
            const Vec3d middle = joint + 0.5 * f.lengths[i] * along, end = joint + f.lengths[i] * along;
            hand.capsules.push_back({joint, middle, radius, 0.88 * radius});
            hand.capsules.push_back({middle, end, 0.88 * radius, 0.94 * radius});
            joint = end;
            radius *= 0.95;
        }
    }
    hand.capsules.push_back({{0.02, 0.12, -0.012}, {0.105, 0.34, -0.012}, 0.066, 0.052});    // heel of the little finger
    hand.capsules.push_back({{-0.05, 0.15, -0.020}, {-0.135, 0.21, -0.035}, 0.062, 0.060});  // ball of the thumb
    hand.capsules.push_back({{0.0, -0.18, -0.002}, {0.0, 0.06, -0.002}, 0.078, 0.074});      // wrist
    return hand;
}

Mesh polygonized(const CapsuleSolid& solid, double spacing)
{
    if (!(spacing > 0 && solid.blend > 0) || solid.capsules.empty())
        throw std::invalid_argument("polygonized: spacing and blend > 0, a capsule");
    Box box = box_around(solid.capsules);
    // Melting adds at most blend log(#capsules) outside the capsules.
    const double margin = spacing + solid.blend * std::log(static_cast<double>(solid.capsules.size()));
    std::array<std::size_t, 3> n{};
    for (int i = 0; i < 3; ++i) {
        box.lo[i] -= margin;
        n[i] = static_cast<std::size_t>(std::ceil((box.hi[i] + margin - box.lo[i]) / spacing)) + 1;
    }
    const std::array<std::size_t, 3> stride{1, n[0], n[0] * n[1]};
    std::vector<double> value(n[0] * n[1] * n[2]);
    const auto point = [&](std::size_t id) {
        return box.lo + spacing * Vec3d{static_cast<double>(id % n[0]), static_cast<double>(id / stride[1] % n[1]),
                                        static_cast<double>(id / stride[2])};
    };
    for (std::size_t id = 0; id < value.size(); ++id) value[id] = field(solid, point(id));

    Mesh mesh;
    // A tetrahedron's edge leads from a grid point in one of seven directions (bits: +x, +y, +z).
    constexpr std::uint32_t k_not_cut = 0xffffffffu;
    std::vector<std::uint32_t> vertex_of(8 * value.size(), k_not_cut);
    const auto crossing = [&](std::size_t u, std::size_t v) {
        if (u > v) std::swap(u, v);
        std::size_t direction = 0, rest = v - u;
        for (int i = 2; i >= 0; --i)
            if (rest >= stride[i]) {
                rest -= stride[i];
                direction |= std::size_t{1} << i;
            }
        std::uint32_t& index = vertex_of[8 * u + direction];
        if (index == k_not_cut) {
            index = static_cast<std::uint32_t>(mesh.vertices.size());
            // Away from the ends: a crossing at a grid point would fold the triangles around it to nothing.
            const double t = std::clamp(value[u] / (value[u] - value[v]), 0.05, 0.95);
            mesh.vertices.push_back(point(u) + t * (point(v) - point(u)));
        }
        return index;
    };
    const auto march = [&](std::array<std::size_t, 4> tet) {  // positively oriented corners
        std::array<std::size_t, 4> order{};                   // inside corners first, then outside ones
        std::size_t inside = 0, filled = 0;
        for (const bool want_inside : {true, false}) {
            for (std::size_t i = 0; i < 4; ++i)
                if ((value[tet[i]] < 0) == want_inside) order[filled++] = i;
            if (want_inside) inside = filled;
        }
        if (inside == 0 || inside == 4) return;
        int inversions = 0;
        for (std::size_t i = 0; i < 4; ++i)
            for (std::size_t j = i + 1; j < 4; ++j) inversions += order[i] > order[j];
        if (inversions % 2 == 1) std::swap(order[inside == 1 ? 1 : 0], order[inside == 1 ? 2 : 1]);
        const std::size_t a = tet[order[0]], b = tet[order[1]], c = tet[order[2]], d = tet[order[3]];
        if (inside == 1) {
            mesh.triangles.push_back({crossing(a, b), crossing(a, c), crossing(a, d)});
        } else if (inside == 3) {
            mesh.triangles.push_back({crossing(a, d), crossing(b, d), crossing(c, d)});
        } else {
            const std::uint32_t ac = crossing(a, c), ad = crossing(a, d), bd = crossing(b, d), bc = crossing(b, c);
            mesh.triangles.insert(mesh.triangles.end(), {{ac, ad, bd}, {ac, bd, bc}});
        }
    };
    for (std::size_t k = 0; k + 1 < n[2]; ++k)
        for (std::size_t j = 0; j + 1 < n[1]; ++j)
            for (std::size_t i = 0; i + 1 < n[0]; ++i) {
                const std::size_t base = i + j * stride[1] + k * stride[2];
                std::array<int, 3> axis{0, 1, 2};
                do {
                    const std::size_t p = base + stride[axis[0]], q = p + stride[axis[1]], r = q + stride[axis[2]];
                    const bool even_order = (axis[1] - axis[0] + 3) % 3 == 1;
                    march(even_order ? std::array{base, p, q, r} : std::array{base, q, p, r});
                } while (std::next_permutation(axis.begin(), axis.end()));
            }
    if (mesh.triangles.empty()) throw std::invalid_argument("polygonized: the spacing is too wide for the solid");
    spread_evenly(solid, spacing, mesh);
    return canonicalized(mesh);
}

}  // namespace sqmap::mesh
