// OpenVDB: a level set with the whole interior filled, read by its BoxSampler (trilinear).
#include "clock.h"
#include "method.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/MeshToVolume.h>

#include <algorithm>
#include <limits>

namespace sqmap::bench {
namespace {

class OpenVdb final : public Method {
public:
    OpenVdb(const Setting& setting, int voxels) : depths_(setting.probe.vertices.size())
    {
        for (const Vec3d& v : setting.probe.vertices) vertices_.push_back(cast<float>(v));
        const double start = process_seconds();
        openvdb::initialize();
        Vec3d lo = setting.object.vertices.front(), hi = lo;
        std::vector<openvdb::Vec3s> points;
        for (const Vec3d& v : setting.object.vertices) {
            points.emplace_back(static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z));
            for (int k = 0; k < 3; ++k) {
                lo[k] = std::min(lo[k], v[k]);
                hi[k] = std::max(hi[k], v[k]);
            }
        }
        std::vector<openvdb::Vec3I> triangles;
        for (const mesh::Triangle& t : setting.object.triangles) triangles.emplace_back(t[0], t[1], t[2]);
        const double voxel = std::max({hi.x - lo.x, hi.y - lo.y, hi.z - lo.z}) / voxels;
        const openvdb::math::Transform::Ptr transform = openvdb::math::Transform::createLinearTransform(voxel);
        for (openvdb::Vec3s& p : points) p = openvdb::Vec3s(transform->worldToIndex(p));
        const openvdb::tools::QuadAndTriangleDataAdapter<openvdb::Vec3s, openvdb::Vec3I> mesh(points, triangles);
        constexpr float k_exterior_voxels = 3;
        grid_ = openvdb::tools::meshToVolume<openvdb::FloatGrid>(mesh, *transform, k_exterior_voxels,
                                                                 std::numeric_limits<float>::max());
        build_s = process_seconds() - start;
        bytes = grid_->memUsage();
        voxel_ = voxel;
    }

    void run(const Pose& pose) override
    {
        Mat3d to_index;
        for (int i = 0; i < 3; ++i) to_index.row[i] = pose.rotation.row[i] / voxel_;
        const Vec3d origin = pose.translation / voxel_;
        const openvdb::FloatGrid::ConstAccessor accessor = grid_->getConstAccessor();
        for (std::size_t i = 0; i < vertices_.size(); ++i) {
            const Vec3d p = to_index * cast<double>(vertices_[i]) + origin;
            const float distance = openvdb::tools::BoxSampler::sample(accessor, openvdb::Vec3d(p.x, p.y, p.z));
            depths_[i] = distance < 0 ? -distance : 0;
        }
    }

    void read(FrameAnswer& out) const override
    {
        for (std::uint32_t i = 0; i < depths_.size(); ++i)
            if (depths_[i] > 0) out.vertices.push_back({i, depths_[i]});
    }

private:
    openvdb::FloatGrid::Ptr grid_;
    double voxel_ = 0;
    std::vector<Vec3f> vertices_;
    std::vector<float> depths_;
};

}  // namespace

std::unique_ptr<Method> make_openvdb(const Setting& setting, int voxels) { return std::make_unique<OpenVdb>(setting, voxels); }

}  // namespace sqmap::bench
