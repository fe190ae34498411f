// Ray casting by Embree 3 (Wald et al. 2014) in its robust mode, single precision: enough for 16-bit distances. Which
// side of the surface a ray starts on is never left to it where its crossings contradict each other.
#include "sqmap/bake/normal_map.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace sqmap::bake {

struct MapRays::Implementation {
    explicit Implementation(const mesh::Mesh& m) : mesh(m), bvh(m)
    {
        device = rtcNewDevice("threads=1");
        if (!device) throw std::runtime_error("ray caster: no device");
        scene = rtcNewScene(device);
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* v = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                              3 * sizeof(float), m.vertices.size()));
        auto* t = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                                      3 * sizeof(std::uint32_t), m.triangles.size()));
        if (!v || !t) throw std::runtime_error("ray caster: out of memory");
        for (const Vec3d& p : m.vertices)
            for (int i = 0; i < 3; ++i) *v++ = static_cast<float>(p[i]);
        for (const mesh::Triangle& f : m.triangles)
            for (const std::uint32_t i : f) *t++ = i;
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene);
    }
    ~Implementation()
    {
        if (scene) rtcReleaseScene(scene);
        if (device) rtcReleaseDevice(device);
    }
    Implementation(const Implementation&) = delete;
    Implementation& operator=(const Implementation&) = delete;

    const mesh::Mesh& mesh;
    mesh::Bvh bvh;
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
};

MapRays::MapRays(const mesh::Mesh& mesh) : implementation_(std::make_unique<Implementation>(mesh)) {}
MapRays::~MapRays() = default;
MapRays::MapRays(MapRays&&) noexcept = default;
MapRays& MapRays::operator=(MapRays&&) noexcept = default;
const mesh::Mesh& MapRays::mesh() const { return implementation_->mesh; }
const mesh::Bvh& MapRays::bvh() const { return implementation_->bvh; }

std::optional<MapRays::Hit> MapRays::first_hit(Vec3d origin, Vec3d direction, double from, double to) const
{
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit r{};
    r.ray.org_x = static_cast<float>(origin.x);
    r.ray.org_y = static_cast<float>(origin.y);
    r.ray.org_z = static_cast<float>(origin.z);
    r.ray.dir_x = static_cast<float>(direction.x);
    r.ray.dir_y = static_cast<float>(direction.y);
    r.ray.dir_z = static_cast<float>(direction.z);
    r.ray.tnear = static_cast<float>(from);
    r.ray.tfar = static_cast<float>(to);
    r.ray.mask = ~0u;
    r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(implementation_->scene, &context, &r);
    if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    // The distance to the triangle's plane in double, and the side from the mesh's own orientation.
    const mesh::Mesh& m = implementation_->mesh;
    const mesh::Triangle& t = m.triangles[r.hit.primID];
    const Vec3d a = m.vertices[t[0]];
    const Vec3d normal = cross(m.vertices[t[1]] - a, m.vertices[t[2]] - a);
    const double along = dot(direction, normal);
    const double coarse = static_cast<double>(r.ray.tfar);
    const double fine = along != 0 ? dot(a - origin, normal) / along : coarse;
    const bool agree = std::abs(fine - coarse) <= 1e-4 * (1 + std::abs(coarse));
    return Hit{agree ? fine : coarse, r.hit.primID, along < 0};
}

MapRays::Surface MapRays::surface_along(Vec3d origin, Vec3d direction, Reach reach, std::vector<Gap>* gaps) const
{
    const auto [to, lift] = reach;
    constexpr int k_max_crossings = 64;
    constexpr double k_far = 1e6, k_step = 2e-6;
    const Vec3d start = origin - lift * direction;
    Hit hits[k_max_crossings];
    int count = 0, sum = 0;
    double from = 0;
    while (count < k_max_crossings) {
        const std::optional<Hit> hit = first_hit(start, direction, from, k_far);
        if (!hit) break;
        hits[count++] = *hit;
        sum += hit->entering ? 1 : -1;
        from = std::max(from, hit->distance) + k_step * (1 + hit->distance);
    }
    // Outside at the far end, so the start's winding number is minus the sum of what was crossed.
    int winding = -sum;
    const bool plausible = winding == 0 ? count == 0 || hits[0].entering : winding == 1 && count > 0 && !hits[0].entering;
    if (!plausible) winding = implementation_->bvh.winding_number(start);
    Surface first;
    bool inside = winding > 0, found = inside;
    if (inside) first.kind = Kind::Cap;
    for (int i = 0; i < count && hits[i].distance - lift <= to; ++i) {
        winding += hits[i].entering ? 1 : -1;
        const double distance = std::max(hits[i].distance - lift, 0.0);
        if (inside == (winding > 0)) continue;
        inside = winding > 0;
        if (!found) {
            found = true;
            first = {Kind::Hit, distance, hits[i].triangle};
        } else if (gaps) {
            if (!inside)
                gaps->push_back({distance, std::numeric_limits<double>::infinity()});
            else if (!gaps->empty())
                gaps->back().enter = distance;
        }
        if (!gaps) break;
    }
    return first;
}

}  // namespace sqmap::bake
