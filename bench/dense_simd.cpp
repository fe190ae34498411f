// The rival at its best: 16-bit values, vertices in clusters of 16 and groups of 256 that are culled by the field's own
// value at their spheres' centres, sixteen trilinear look-ups at a time with pairs of values a gather, contacts packed.
#include "clock.h"
#include "clusters.h"
#include "dense_simd_kernel.h"
#include "distance_grid.h"
#include "method.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace sqmap::bench {
namespace {

DenseKernel best_kernel()
{
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) return dense_kernel_avx512;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return dense_kernel_avx2;
#endif
    return dense_kernel_plain;
}

using Values = std::vector<std::int16_t>;

/// Greatest slope of the stored field: in a cell each component of a trilinear function's gradient is a mean of the
/// differences along four edges.
double steepest(const Values& values, const DistanceGrid& grid, double step)
{
    const std::uint32_t n = grid.samples;
    const std::size_t stride[3] = {1, n, std::size_t{n} * n};
    double steepest_sq = 0;
    for (std::uint32_t k = 0; k + 1 < n; ++k)
        for (std::uint32_t j = 0; j + 1 < n; ++j)
            for (std::uint32_t i = 0; i + 1 < n; ++i) {
                const std::int16_t* v = &values[grid.index(i, j, k)];
                double sum = 0;
                for (int axis = 0; axis < 3; ++axis) {
                    const std::size_t a = stride[axis], b = stride[(axis + 1) % 3], c = stride[(axis + 2) % 3];
                    const int rise = std::max({std::abs(v[a] - v[0]), std::abs(v[a + b] - v[b]), std::abs(v[a + c] - v[c]),
                                               std::abs(v[a + b + c] - v[b + c])});
                    const double slope = rise * step / grid.spacing[axis];
                    sum += slope * slope;
                }
                steepest_sq = std::max(steepest_sq, sum);
            }
    return std::sqrt(steepest_sq);
}

int coarse_count(int n, int stride) { return (n - 1 + stride - 1) / stride + 1; }

/// Every stride-th point of a grid of n^3 values, lowered until trilinear interpolation is nowhere above that of all points:
/// over a cell of the fine grid both are trilinear, so that comparing them at its corners is enough.
Values lowered(const Values& fine, int n, int stride)
{
    const int m = coarse_count(n, stride);
    const auto fine_at = [&](int i, int j, int k) {
        const auto clamped = [n](int x) { return static_cast<std::size_t>(std::min(x, n - 1)); };
        return fine[(clamped(k) * n + clamped(j)) * n + clamped(i)];
    };
    const auto coarse_at = [m](int i, int j, int k) { return (static_cast<std::size_t>(k) * m + j) * m + i; };
    std::vector<double> lower(static_cast<std::size_t>(m) * m * m, 0.0);  // by how much each coarse point must go down
    for (int k = 0; k + 1 < m; ++k)
        for (int j = 0; j + 1 < m; ++j)
            for (int i = 0; i + 1 < m; ++i) {
                double above = 0;
                for (int z = 0; z <= stride; ++z)
                    for (int y = 0; y <= stride; ++y)
                        for (int x = 0; x <= stride; ++x) {
                            if (std::max({stride * i + x, stride * j + y, stride * k + z}) >= n) continue;
                            double interpolated = 0;
                            for (int c = 0; c < 8; ++c)
                                interpolated +=
                                    (c & 1 ? x : stride - x) * (c >> 1 & 1 ? y : stride - y) * (c >> 2 ? z : stride - z) *
                                    fine_at(stride * (i + (c & 1)), stride * (j + (c >> 1 & 1)), stride * (k + (c >> 2)));
                            above = std::max(above, interpolated / (stride * stride * stride) -
                                                        fine_at(stride * i + x, stride * j + y, stride * k + z));
                        }
                for (int c = 0; c < 8; ++c) {
                    double& down = lower[coarse_at(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2))];
                    down = std::max(down, above);
                }
            }
    Values coarse(lower.size());
    for (int k = 0; k < m; ++k)
        for (int j = 0; j < m; ++j)
            for (int i = 0; i < m; ++i)
                coarse[coarse_at(i, j, k)] = static_cast<std::int16_t>(
                    std::max(-32768.0, std::floor(fine_at(stride * i, stride * j, stride * k) - lower[coarse_at(i, j, k)])));
    return coarse;
}

class DenseSimd final : public Method {
public:
    DenseSimd(const Setting& setting, std::uint32_t samples, bool with_normal)
        : kernel_(best_kernel()),
          probe_(cluster(setting.probe.vertices)),
          vertex_(setting.probe.vertices.size() + k_lanes),
          depth_(vertex_.size())
    {
        if (with_normal)
            for (std::vector<float>& normal : normal_) normal.resize(vertex_.size());
        const DistanceGrid grid = distance_grid(setting, samples);
        const double start = process_seconds();
        lo_ = grid.lo;
        spacing_ = grid.spacing;
        // Values saturate outside, where they only serve culling: no sphere of a probe is wider than this.
        double band = 0.5 * k_probe_diagonal;
        for (const float v : grid.values) band = std::max(band, -static_cast<double>(v));
        const double step = band / 32767;
        values_.resize(grid.values.size());
        std::transform(grid.values.begin(), grid.values.end(), values_.begin(), [&](float v) {
            return static_cast<std::int16_t>(std::lround(std::min(static_cast<double>(v), band) / step));
        });
        const auto n = static_cast<int>(samples);
        // Culling by a field that stays in the innermost caches; the smallest one is that already.
        const int stride = samples > 64 ? n / 32 : 1;
        if (stride > 1) coarse_ = lowered(values_, n, stride);
        field_ = {{values_.data(), n},
                  {stride > 1 ? coarse_.data() : values_.data(), coarse_count(n, stride)},
                  1.0f / static_cast<float>(stride),
                  static_cast<float>(step),
                  {static_cast<float>(spacing_.x), static_cast<float>(spacing_.y), static_cast<float>(spacing_.z)}};
        set_reach(steepest(values_, grid, step), step);
        bytes = (values_.size() + coarse_.size()) * sizeof values_[0];
        probe_bytes = probe_.bytes();
        build_s = grid.build_s + process_seconds() - start;
    }

    void run(const Pose& pose) override
    {
        CellPose cells;
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) cells.m[i][j] = static_cast<float>(pose.rotation.row[i][j] / spacing_[i]);
            cells.m[i][3] = static_cast<float>((pose.translation[i] - lo_[i]) / spacing_[i]);
        }
        count_ = kernel_(field_, probe_.view(), cells,
                         {vertex_.data(), depth_.data(), {normal_[0].data(), normal_[1].data(), normal_[2].data()}});
    }

    void read(FrameAnswer& out) const override
    {
        for (std::uint32_t i = 0; i < count_; ++i) out.vertices.push_back({vertex_[i], depth_[i]});
        std::sort(out.vertices.begin(), out.vertices.end(),
                  [](const VertexContact& a, const VertexContact& b) { return a.vertex < b.vertex; });
    }

private:
    /// Two bounds on how far the interpolated field falls within radius r. By its own slope: slope r. And because exact
    /// distances differ by no more than two points are apart: with weights w_i over the corners x_i of the cell of q, the
    /// value at q is at least D - sum w_i |x_i - c|, D the exact distance at the centre c; by Jensen's inequality that sum
    /// is at most sqrt(r^2 + h^2), h half a cell's diagonal; likewise D is at most h below the value at c.
    void set_reach(double slope, double step)
    {
        const double h = 0.5 * norm(spacing_);
        for (std::vector<SphereBlock>* blocks : {&probe_.groups, &probe_.clusters})
            for (SphereBlock& block : *blocks)
                for (std::uint32_t i = 0; i < k_lanes; ++i) {
                    const double r = static_cast<double>(block.radius[i]);
                    block.reach[i] = static_cast<float>(std::min(slope * r, std::sqrt(r * r + h * h) + h) + 2 * step);
                }
    }

    DenseKernel kernel_;
    ClusteredProbe probe_;
    Values values_, coarse_;
    Vec3d lo_, spacing_;
    FieldView field_{};
    std::vector<std::uint32_t> vertex_;
    std::vector<float> depth_;
    std::array<std::vector<float>, 3> normal_;  ///< empty where none are asked for
    std::uint32_t count_ = 0;
};

}  // namespace

std::unique_ptr<Method> make_dense_simd(const Setting& setting, int samples)
{
    return std::make_unique<DenseSimd>(setting, static_cast<std::uint32_t>(samples), false);
}

std::unique_ptr<Method> make_dense_simd_normal(const Setting& setting, int samples)
{
    return std::make_unique<DenseSimd>(setting, static_cast<std::uint32_t>(samples), true);
}

}  // namespace sqmap::bench
