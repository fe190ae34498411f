// Bullet's GImpact: a mesh against a mesh by the algorithm that a world would keep for the pair, every contact point taken.
#include "clock.h"
#include "method.h"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletCollisionCommon.h>

#include <bit>
#include <utility>

namespace sqmap::bench {
namespace {

/// Triangles in Bullet's form, with the shape over them.
class GImpactMesh {
public:
    explicit GImpactMesh(const mesh::Mesh& mesh)
    {
        for (const Vec3d& v : mesh.vertices)
            for (int k = 0; k < 3; ++k) points_.push_back(static_cast<btScalar>(v[k]));
        for (const mesh::Triangle& t : mesh.triangles)
            for (const std::uint32_t v : t) indices_.push_back(static_cast<int>(v));
        array_ = std::make_unique<btTriangleIndexVertexArray>(
            static_cast<int>(indices_.size() / 3), indices_.data(), static_cast<int>(3 * sizeof(int)),
            static_cast<int>(points_.size() / 3), points_.data(), static_cast<int>(3 * sizeof(btScalar)));
        shape_ = std::make_unique<btGImpactMeshShape>(array_.get());
        shape_->setMargin(0);
        shape_->updateBound();
        object_.setCollisionShape(shape_.get());
    }
    [[nodiscard]] btCollisionObject& object() { return object_; }
    [[nodiscard]] std::size_t bytes() const
    {
        std::size_t nodes = 0;
        for (int i = 0; i < shape_->getMeshPartCount(); ++i)
            nodes += static_cast<std::size_t>(shape_->getMeshPart(i)->getBoxSet()->getNodeCount());
        return points_.size() * sizeof points_[0] + indices_.size() * sizeof indices_[0] + nodes * sizeof(BT_QUANTIZED_BVH_NODE);
    }

private:
    std::vector<btScalar> points_;
    std::vector<int> indices_;
    std::unique_ptr<btTriangleIndexVertexArray> array_;
    std::unique_ptr<btGImpactMeshShape> shape_;
    btCollisionObject object_;
};

/// Takes the contact points as they come; a world would keep at most four of them.
struct Collector final : btManifoldResult {
    using btManifoldResult::btManifoldResult;
    struct Point {
        int object_triangle, probe_triangle;
        btScalar distance;
    };
    std::vector<Point> points;

    void addContactPoint(const btVector3&, const btVector3&, btScalar distance) override
    {
        points.push_back({m_index0, m_index1, distance});
    }
};

class Bullet final : public Method {
public:
    explicit Bullet(const Setting& setting) : dispatcher_(&configuration_)
    {
        btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher_);
        const double start = process_seconds();
        object_ = std::make_unique<GImpactMesh>(setting.object);
        build_s = process_seconds() - start;
        probe_ = std::make_unique<GImpactMesh>(setting.probe);
        bytes = object_->bytes();
        probe_bytes = probe_->bytes();
        const btCollisionObjectWrapper object = wrap(*object_), probe = wrap(*probe_);
        algorithm_ = dispatcher_.findAlgorithm(&object, &probe, nullptr, BT_CONTACT_POINT_ALGORITHMS);
    }
    ~Bullet() override
    {
        algorithm_->~btCollisionAlgorithm();
        dispatcher_.freeCollisionAlgorithm(algorithm_);
    }
    Bullet(const Bullet&) = delete;
    Bullet& operator=(const Bullet&) = delete;

    void run(const Pose& pose) override
    {
        const auto& r = pose.rotation.row;
        const auto s = [](double v) { return static_cast<btScalar>(v); };
        const btMatrix3x3 rotation(s(r[0].x), s(r[0].y), s(r[0].z), s(r[1].x), s(r[1].y), s(r[1].z), s(r[2].x), s(r[2].y),
                                   s(r[2].z));
        const btVector3 translation(s(pose.translation.x), s(pose.translation.y), s(pose.translation.z));
        probe_->object().setWorldTransform(btTransform(rotation, translation));
        const btCollisionObjectWrapper object = wrap(*object_), probe = wrap(*probe_);
        Collector collector(&object, &probe);
        collector.points = std::move(points_);
        collector.points.clear();
        algorithm_->processCollision(&object, &probe, info_, &collector);
        points_ = std::move(collector.points);
    }

    void read(FrameAnswer& out) const override
    {
        Hash hash;
        for (const Collector::Point& p : points_) {
            hash.add(static_cast<std::uint64_t>(static_cast<std::uint32_t>(p.object_triangle)) << 32 |
                     static_cast<std::uint32_t>(p.probe_triangle));
            hash.add(std::bit_cast<std::uint64_t>(static_cast<double>(p.distance)));
        }
        out.pairs = points_.size();
        out.pairs_hash = hash.value();
    }

private:
    static btCollisionObjectWrapper wrap(GImpactMesh& mesh)
    {
        btCollisionObject& object = mesh.object();
        return {nullptr, object.getCollisionShape(), &object, object.getWorldTransform(), -1, -1};
    }

    btDefaultCollisionConfiguration configuration_;
    btCollisionDispatcher dispatcher_;
    btDispatcherInfo info_;
    std::unique_ptr<GImpactMesh> object_, probe_;
    btCollisionAlgorithm* algorithm_ = nullptr;
    std::vector<Collector::Point> points_;
};

}  // namespace

std::unique_ptr<Method> make_bullet(const Setting& setting, int) { return std::make_unique<Bullet>(setting); }

}  // namespace sqmap::bench
