// FCL, whose OBB tree descends from RAPID (the paper's reference [3]): pairs of intersecting triangles.
#include "clock.h"
#include "fcl_tree.h"
#include "method.h"

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
        object_ = fcl_tree<Box>(setting.object.vertices, setting.object.triangles);
        build_s = process_seconds() - start;
        probe_ = fcl_tree<Box>(setting.probe.vertices, setting.probe.triangles);
        bytes = bytes_of(*object_);
        probe_bytes = bytes_of(*probe_);
    }

    void run(const Pose& pose) override
    {
        result_.clear();
        fcl::collide(object_.get(), fcl::Transform3d::Identity(), probe_.get(), fcl_transform(pose), request_, result_);
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
