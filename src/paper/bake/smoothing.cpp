// Smoothed maps (section 6). The surface's own smoothing is implicit diffusion: M. Desbrun, M. Meyer, P. Schroeder, A. Barr,
// "Implicit fairing of irregular meshes using diffusion and curvature flow", 1999.
#include "paper/bake/grid.h"

#include "model/octahedral.h"
#include "paper/model/codes.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

namespace sqmap::paper {

namespace {

// Weights at 0 to radius samples from the middle.
std::vector<double> kernel_of(SmoothingKernel kernel, int radius)
{
    std::vector<double> weights(static_cast<std::size_t>(radius) + 1, 1.0);
    for (int d = 1; d <= radius; ++d) {
        double& weight = weights[static_cast<std::size_t>(d)];
        if (kernel == SmoothingKernel::Binomial)  // C(2 r, r + d) over C(2 r, r)
            weight = weights[static_cast<std::size_t>(d) - 1] * (radius - d + 1) / (radius + d);
        if (kernel == SmoothingKernel::Gaussian) weight = std::exp(-2.0 * d * d / (radius * radius));
    }
    return weights;
}

/// Areas about the vertices plus t times the cotangent Laplacian: symmetric, and positive since every weight is.
class Diffusion {
public:
    Diffusion(const mesh::Mesh& mesh, double t) : diagonal_(mesh.vertices.size(), 0.0), area_(diagonal_)
    {
        constexpr double k_min = 0.05, k_max = 10;  // cotangents of slivers mean nothing
        for (const mesh::Triangle& triangle : mesh.triangles)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = triangle[(k + 1) % 3], b = triangle[(k + 2) % 3];
                const Vec3d to_a = mesh.vertices[a] - mesh.vertices[triangle[k]],
                            to_b = mesh.vertices[b] - mesh.vertices[triangle[k]];
                const double twice_area = std::max(norm(cross(to_a, to_b)), 1e-300);
                const double weight = 0.5 * t * std::clamp(dot(to_a, to_b) / twice_area, k_min, k_max);
                edges_.push_back({a, b, weight});
                diagonal_[a] += weight;
                diagonal_[b] += weight;
                area_[triangle[k]] += twice_area / 6;
            }
        for (std::size_t v = 0; v < area_.size(); ++v) diagonal_[v] += area_[v] = std::max(area_[v], 1e-300);
    }

    /// By conjugate gradients, from the values themselves on.
    [[nodiscard]] std::vector<Vec3d> operator()(const std::vector<Vec3d>& values) const
    {
        constexpr int k_steps = 200;
        constexpr double k_tolerance = 1e-6;
        std::vector<Vec3d> x = values, residual = times(x), step(x.size());
        double scale = 0, product = 0;
        for (std::size_t v = 0; v < x.size(); ++v) {
            residual[v] = area_[v] * values[v] - residual[v];
            step[v] = residual[v] / diagonal_[v];
            product += dot(residual[v], step[v]);
        }
        scale = product;
        for (int i = 0; i < k_steps && product > k_tolerance * k_tolerance * scale; ++i) {
            const std::vector<Vec3d> image = times(step);
            double along = 0;
            for (std::size_t v = 0; v < x.size(); ++v) along += dot(step[v], image[v]);
            double next = 0;
            for (std::size_t v = 0; v < x.size(); ++v) {
                x[v] += product / along * step[v];
                residual[v] -= product / along * image[v];
                next += norm_sq(residual[v]) / diagonal_[v];
            }
            for (std::size_t v = 0; v < x.size(); ++v) step[v] = residual[v] / diagonal_[v] + next / product * step[v];
            product = next;
        }
        return x;
    }

private:
    [[nodiscard]] std::vector<Vec3d> times(const std::vector<Vec3d>& x) const
    {
        std::vector<Vec3d> out(x.size());
        for (std::size_t v = 0; v < x.size(); ++v) out[v] = diagonal_[v] * x[v];
        for (const Edge& e : edges_) {
            out[e.a] -= e.weight * x[e.b];
            out[e.b] -= e.weight * x[e.a];
        }
        return out;
    }

    struct Edge {
        std::uint32_t a, b;
        double weight;
    };
    std::vector<Edge> edges_;  // each side of an edge has one
    std::vector<double> diagonal_, area_;
};

/// The smoothed map of hits: their changes in model units, stored together once the greatest is known.
class SmoothedHits {
public:
    void add(double change, Vec3d normal)
    {
        samples_.push_back({0, model::octahedral_code<k_smoothed_normal_bits>(normal)});
        changes_.push_back(change);
        greatest_ = std::max(greatest_, std::abs(change));
    }
    void add_none()
    {
        samples_.push_back({k_not_smoothed, 0});
        changes_.push_back(0);
    }
    void store(Map& map)
    {
        map.change_scale = greatest_ > 1e-30 ? static_cast<float>(greatest_ / k_largest_change) : 1.0f;
        map.smoothed.assign(smoothed_bytes(samples_.size()), 0);
        for (std::size_t k = 0; k < samples_.size(); ++k) {
            SmoothedSample& sample = samples_[k];
            if (is_smoothed(sample)) sample.change = change_code(changes_[k] / static_cast<double>(map.change_scale));
            const std::uint32_t change = static_cast<std::uint32_t>(sample.change) & ((1u << k_change_bits) - 1u);
            const std::size_t bit = k * k_smoothed_bits;
            const std::uint32_t word = (change | sample.normal << k_change_bits) << bit % 8;
            for (std::size_t b = 0; b < 3; ++b)
                map.smoothed[bit / 8 + b] = static_cast<std::uint8_t>(map.smoothed[bit / 8 + b] | (word >> 8 * b & 255u));
        }
    }

private:
    std::vector<SmoothedSample> samples_;
    std::vector<double> changes_;
    double greatest_ = 0;
};

/// Each hit's plane of the smoothed surface, put back on the ray: one surface for all parts, whatever their grids, and whole
/// beside jumps.
void take_surface(const Caster& caster, const Grid& finest, const MapOptions& options, Map& map)
{
    const mesh::Mesh& mesh = caster.rays.mesh();
    const SmoothSurface& smooth = caster.rays.smoothed(options.smoothing_length);
    const int stride = 1 << map.subdivisions;
    SmoothedHits hits;
    for (int i = 0; i < finest.rows; i += stride)
        for (int j = 0; j < finest.columns; j += stride) {
            const Surface& here = finest.at(i, j);
            if (here.kind != Kind::Hit) continue;
            const shape::SurfacePoint<double> r = caster.at(finest.angles(i, j));
            const mesh::Triangle& t = mesh.triangles[here.triangle];
            const Vec3d a = mesh.vertices[t[0]], b = mesh.vertices[t[1]] - a, c = mesh.vertices[t[2]] - a, up = cross(b, c);
            const Vec3d hit = r.point - here.distance * r.normal - a;
            const double u = dot(cross(hit, c), up) / norm_sq(up), v = dot(cross(b, hit), up) / norm_sq(up);
            const auto within = [&](const std::vector<Vec3d>& of) {
                return (1 - u - v) * of[t[0]] + u * of[t[1]] + v * of[t[2]];
            };
            const Vec3d n = normalized(within(smooth.normals));
            if (!(dot(n, up) > 0)) {
                hits.add_none();
                continue;
            }
            // The ray meets a steep plane far off: there the plane goes through the end of what a sample may move.
            constexpr double k_steep = 0.2;
            const double rise = dot(a + hit - within(smooth.points), n) / std::max(dot(n, r.normal), k_steep);
            hits.add(std::max(rise, -here.distance), n);
        }
    hits.store(map);
}

}  // namespace

SmoothSurface smooth_surface(const mesh::Mesh& mesh, double length)
{
    const Diffusion diffuse(mesh, 0.5 * length * length);
    SmoothSurface out{diffuse(mesh.vertices), std::vector<Vec3d>(mesh.vertices.size())};
    // Diffusion draws round parts in. The difference, diffused as well and added, restores nearly all of them and few of the
    // steps.
    std::vector<Vec3d> taken = mesh.vertices;
    for (std::size_t v = 0; v < taken.size(); ++v) taken[v] -= out.points[v];
    const std::vector<Vec3d> back = diffuse(taken);
    for (std::size_t v = 0; v < back.size(); ++v) out.points[v] += back[v];
    for (const mesh::Triangle& t : mesh.triangles) {
        const Vec3d up = cross(out.points[t[1]] - out.points[t[0]], out.points[t[2]] - out.points[t[0]]);
        for (const std::uint32_t v : t) out.normals[v] += up;
    }
    for (Vec3d& n : out.normals) n = norm(n) > 0 ? normalized(n) : Vec3d{0, 0, 1};
    return out;
}

void add_smoothing(const Caster& caster, const Grid& finest, const MapOptions& options, Map& map)
{
    if (options.smoothing_radius == 0) return;
    if (options.smoothing == Smoothing::Surface) {
        take_surface(caster, finest, options, map);
        return;
    }
    const std::vector<double> kernel = kernel_of(options.smoothing_kernel, options.smoothing_radius);
    const int radius = static_cast<int>(kernel.size()) - 1;
    const int stride = 1 << map.subdivisions;
    const int rows = (finest.rows - 1) / stride + 1, columns = finest.columns / stride;
    const auto at = [&](int i, int j) -> const Surface& { return finest.at(i * stride, (j + columns) % columns * stride); };
    const auto index = [&](int i, int j) { return static_cast<std::size_t>(i) * columns + (j + columns) % columns; };
    std::vector<Vec3d> points(static_cast<std::size_t>(rows) * columns);
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j) points[index(i, j)] = caster.at(finest.angles(i * stride, j * stride)).point;
    std::vector<double> smooth(points.size(), -1.0);
    for (int i = radius; i + radius < rows; ++i)
        for (int j = 0; j < columns; ++j) {
            const Surface& here = at(i, j);
            bool whole = here.kind == Kind::Hit;
            double sum = 0, weights = 0;
            for (int di = -radius; di <= radius && whole; ++di)
                for (int dj = -radius; dj <= radius && whole; ++dj) {
                    const Surface& there = at(i + di, j + dj);
                    const double weight =
                        kernel[static_cast<std::size_t>(std::abs(di))] * kernel[static_cast<std::size_t>(std::abs(dj))];
                    whole = there.kind == Kind::Hit &&
                            std::abs(there.distance - here.distance) <=
                                options.jump_slope * norm(points[index(i, j)] - points[index(i + di, j + dj)]);
                    sum += weight * there.distance;
                    weights += weight;
                }
            if (whole) smooth[index(i, j)] = sum / weights;
        }
    // By eq. 26, where all neighbours are smoothed too.
    const auto normal_of = [&](int i, int j) -> std::optional<Vec3d> {
        const double up = smooth[index(i + 1, j)], down = smooth[index(i - 1, j)], next = smooth[index(i, j + 1)],
                     last = smooth[index(i, j - 1)];
        if (std::min({up, down, next, last}) < 0) return std::nullopt;
        const auto jet = shape::surface_jet(caster.sq, shape::position_at(caster.sq, finest.angles(i * stride, j * stride)));
        const Vec3d n = normalized(shape::mapped_normal(jet, smooth[index(i, j)], (up - down) * (rows - 1) / (2 * k_pi),
                                                        (next - last) * columns / (4 * k_pi)));
        if (!(dot(n, face_normal(caster.rays.mesh(), at(i, j).triangle)) > 0)) return std::nullopt;
        return n;
    };
    SmoothedHits hits;
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j) {
            if (at(i, j).kind != Kind::Hit) continue;
            const double d = smooth[index(i, j)];
            const std::optional<Vec3d> n = d < 0 || i == 0 || i == rows - 1 ? std::nullopt : normal_of(i, j);
            if (n)
                hits.add(d - at(i, j).distance, *n);
            else
                hits.add_none();
        }
    hits.store(map);
}

}  // namespace sqmap::paper
