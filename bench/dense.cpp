// A dense distance field as one writes it in an afternoon: float values, a trilinear look-up for every probe vertex.
#include "distance_grid.h"
#include "method.h"

#include <utility>

namespace sqmap::bench {
namespace {

class Dense final : public Method {
public:
    Dense(const Setting& setting, std::uint32_t samples)
        : grid_(distance_grid(setting, samples)), depths_(setting.probe.vertices.size())
    {
        for (const Vec3d& v : setting.probe.vertices) vertices_.push_back(cast<float>(v));
        bytes = grid_.values.size() * sizeof(float);
        build_s = grid_.build_s;
    }

    void run(const Pose& pose) override
    {
        Mat3f to_cells;  // straight from the probe's frame to cells of the grid
        Vec3f origin;
        for (int i = 0; i < 3; ++i) {
            to_cells.row[i] = cast<float>(pose.rotation.row[i] / grid_.spacing[i]);
            origin[i] = static_cast<float>((pose.translation[i] - grid_.lo[i]) / grid_.spacing[i]);
        }
        const std::uint32_t n = grid_.samples;
        const std::size_t dy = n, dz = dy * dy;
        const auto last = static_cast<float>(n - 1);
        for (std::size_t i = 0; i < vertices_.size(); ++i) {
            const Vec3f p = to_cells * vertices_[i] + origin;
            depths_[i] = 0;
            if (!(p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x < last && p.y < last && p.z < last)) continue;
            const auto cx = static_cast<std::uint32_t>(p.x), cy = static_cast<std::uint32_t>(p.y),
                       cz = static_cast<std::uint32_t>(p.z);
            const float fx = p.x - static_cast<float>(cx), fy = p.y - static_cast<float>(cy), fz = p.z - static_cast<float>(cz);
            const float* v = &grid_.values[grid_.index(cx, cy, cz)];
            const auto row = [fx](const float* r) { return r[0] + fx * (r[1] - r[0]); };
            const float near = row(v) + fy * (row(v + dy) - row(v));
            const float far = row(v + dz) + fy * (row(v + dz + dy) - row(v + dz));
            const float distance = near + fz * (far - near);
            if (distance < 0) depths_[i] = -distance;
        }
    }

    void read(FrameAnswer& out) const override
    {
        for (std::uint32_t i = 0; i < depths_.size(); ++i)
            if (depths_[i] > 0) out.vertices.push_back({i, depths_[i]});
    }

private:
    DistanceGrid grid_;
    std::vector<Vec3f> vertices_;
    std::vector<float> depths_;
};

}  // namespace

std::unique_ptr<Method> make_dense(const Setting& setting, int samples)
{
    return std::make_unique<Dense>(setting, static_cast<std::uint32_t>(samples));
}

}  // namespace sqmap::bench
