// FCL, whose OBB tree descends from RAPID (the paper's reference [3]): pairs of intersecting triangles.
#include "clock.h"
#include "method.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/narrowphase/collision.h>

#include <algorithm>
#include <limits>

namespace sqmap::bench {
namespace {

template <class Box>
class Fcl final : public Method {
public:
    /// pairs: how many intersecting pairs to find before stopping.
    Fcl(const Setting& setting, std::size_t pairs) : request_(pairs, /*enable_contact=*/false)
    {
        const double start = process_seconds();
        object_ = build(setting.object);
        build_s = process_seconds() - start;
        probe_ = build(setting.probe);
        bytes = bytes_of(*object_);
        probe_bytes = bytes_of(*probe_);
    }

    void run(const Pose& pose) override
    {
        fcl::Transform3d transform = fcl::Transform3d::Identity();
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) transform.linear()(i, j) = pose.rotation.row[i][j];
            transform.translation()[i] = pose.translation[i];
        }
        result_.clear();
        fcl::collide(object_.get(), fcl::Transform3d::Identity(), probe_.get(), transform, request_, result_);
    }

    void read(FrameAnswer& out) const override
    {
        out.pairs = result_.numContacts();
        std::vector<std::uint64_t> pairs;
        for (std::size_t i = 0; i < result_.numContacts(); ++i) {
            const fcl::Contactd& contact = result_.getContact(i);
            pairs.push_back(static_cast<std::uint64_t>(contact.b1) << 32 | static_cast<std::uint32_t>(contact.b2));
        }
        std::sort(pairs.begin(), pairs.end());
        Hash hash;
        for (const std::uint64_t pair : pairs) hash.add(pair);
        out.pairs_hash = hash.value();
    }

private:
    using Model = fcl::BVHModel<Box>;

    /// The value that memUsage() should return.
    static std::size_t bytes_of(const Model& model)
    {
        return static_cast<std::size_t>(model.getNumBVs()) * sizeof(fcl::BVNode<Box>) +
               static_cast<std::size_t>(model.num_tris) * sizeof(fcl::Triangle) +
               static_cast<std::size_t>(model.num_vertices) * sizeof(fcl::Vector3d);
    }

    static std::shared_ptr<Model> build(const mesh::Mesh& mesh)
    {
        auto model = std::make_shared<Model>();
        std::vector<fcl::Vector3d> points;
        for (const Vec3d& v : mesh.vertices) points.emplace_back(v.x, v.y, v.z);
        std::vector<fcl::Triangle> triangles;
        for (const mesh::Triangle& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
        model->beginModel(static_cast<int>(triangles.size()), static_cast<int>(points.size()));
        model->addSubModel(points, triangles);
        model->endModel();
        return model;
    }

    fcl::CollisionRequestd request_;
    fcl::CollisionResultd result_;
    std::shared_ptr<Model> object_, probe_;
};

}  // namespace

std::unique_ptr<Method> make_fcl(const Setting& setting, int kind)
{
    constexpr std::size_t k_all = std::numeric_limits<int>::max();
    if (kind == 2) return std::make_unique<Fcl<fcl::KDOP<double, 16>>>(setting, k_all);
    return std::make_unique<Fcl<fcl::OBB<double>>>(setting, kind == 0 ? k_all : 1);
}

}  // namespace sqmap::bench
