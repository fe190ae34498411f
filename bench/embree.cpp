// Exact closest points with Embree's point query, signed: see embree_nearest.cpp.
#include "clock.h"
#include "embree_nearest.h"
#include "method.h"

#include <algorithm>

namespace sqmap::bench {
namespace {

class Embree final : public Method {
public:
    explicit Embree(const Setting& setting)
        : start_(process_seconds()), nearest_(setting.object), depths_(setting.probe.vertices.size())
    {
        build_s = process_seconds() - start_;
        for (const Vec3d& v : setting.probe.vertices) probe_.push_back(cast<float>(v));
        bytes = nearest_.bytes();
    }

    void run(const Pose& pose) override
    {
        Mat3f rotation;
        for (int i = 0; i < 3; ++i) rotation.row[i] = cast<float>(pose.rotation.row[i]);
        const Vec3f translation = cast<float>(pose.translation);
        for (std::size_t i = 0; i < probe_.size(); ++i)
            depths_[i] = std::max(-nearest_.signed_distance(rotation * probe_[i] + translation), 0.f);
    }

    void read(FrameAnswer& out) const override
    {
        for (std::uint32_t i = 0; i < depths_.size(); ++i)
            if (depths_[i] > 0) out.vertices.push_back({i, depths_[i]});
    }

private:
    double start_;
    EmbreeNearest nearest_;
    std::vector<Vec3f> probe_;
    std::vector<float> depths_;
};

}  // namespace

std::unique_ptr<Method> make_embree(const Setting& setting, int) { return std::make_unique<Embree>(setting); }

}  // namespace sqmap::bench
