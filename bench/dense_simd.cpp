// The rival at its best: 16-bit values, vertices in clusters of 16 and groups of 256 that are culled by the field's own
// value at their spheres' centres, sixteen trilinear look-ups at a time with pairs of values a gather, contacts packed.
#include "clusters.h"
#include "dense_simd_kernel.h"
#include "distance_grid.h"
#include "method.h"

#include <algorithm>
#include <cmath>

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

/// Greatest slope of the stored field: in a cell each component of a trilinear function's gradient is a mean of the
/// differences along four edges.
double steepest(const std::vector<std::int16_t>& values, const DistanceGrid& grid, double step)
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

class DenseSimd final : public Method {
public:
    DenseSimd(const Setting& setting, std::uint32_t samples)
        : kernel_(best_kernel()),
          probe_(cluster(setting.probe.vertices)),
          vertex_(setting.probe.vertices.size() + k_lanes),
          depth_(vertex_.size())
    {
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
        field_ = {values_.data(),
                  static_cast<std::int32_t>(samples),
                  static_cast<float>(step),
                  {static_cast<float>(spacing_.x), static_cast<float>(spacing_.y), static_cast<float>(spacing_.z)},
                  static_cast<float>(1.001 * steepest(values_, grid, step))};
        bytes = values_.size() * sizeof values_[0];
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
        count_ = kernel_(field_, probe_.view(), cells, {vertex_.data(), depth_.data()});
    }

    void read(FrameAnswer& out) const override
    {
        for (std::uint32_t i = 0; i < count_; ++i) out.vertices.push_back({vertex_[i], depth_[i]});
        std::sort(out.vertices.begin(), out.vertices.end(),
                  [](const VertexContact& a, const VertexContact& b) { return a.vertex < b.vertex; });
    }

private:
    DenseKernel kernel_;
    ClusteredProbe probe_;
    std::vector<std::int16_t> values_;
    Vec3d lo_, spacing_;
    FieldView field_{};
    std::vector<std::uint32_t> vertex_;
    std::vector<float> depth_;
    std::uint32_t count_ = 0;
};

}  // namespace

std::unique_ptr<Method> make_dense_simd(const Setting& setting, int samples)
{
    return std::make_unique<DenseSimd>(setting, static_cast<std::uint32_t>(samples));
}

}  // namespace sqmap::bench
