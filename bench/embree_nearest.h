// Signed closest points of a mesh with Embree, in float.
#pragma once

#include "sqmap/mesh/mesh.h"

#include <cstdint>
#include <vector>

struct RTCDeviceTy;
struct RTCSceneTy;

namespace sqmap::bench {

/// One thread's: queries share nothing that they write.
class EmbreeNearest {
public:
    explicit EmbreeNearest(const mesh::Mesh& mesh);
    ~EmbreeNearest();
    EmbreeNearest(const EmbreeNearest&) = delete;
    EmbreeNearest& operator=(const EmbreeNearest&) = delete;

    /// Negative inside.
    [[nodiscard]] float signed_distance(Vec3f p) const;
    [[nodiscard]] std::size_t bytes() const;

private:
    void set_normals(const mesh::Mesh& mesh);

    std::vector<Vec3f> vertices_, normals_;
    std::vector<mesh::Triangle> triangles_;
    std::int64_t embree_bytes_ = 0;
    RTCDeviceTy* device_ = nullptr;
    RTCSceneTy* scene_ = nullptr;
};

}  // namespace sqmap::bench
