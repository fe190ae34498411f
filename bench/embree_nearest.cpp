// Exact closest points with Embree's point query, sign by angle-weighted pseudonormals: Baerentzen and Aanaes, "Signed
// distance computation using the angle weighted pseudonormal" (2005). Exact up to float rounding for a mesh that does not
// cross itself.
#include "embree_nearest.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace sqmap::bench {
namespace {

struct Nearest {
    const std::vector<Vec3f>* vertices;
    const std::vector<mesh::Triangle>* triangles;
    float distance_sq = std::numeric_limits<float>::infinity();
    std::uint32_t triangle = 0;
    int feature = 0;  ///< 0 the face, 1 to 3 a vertex, 4 to 6 the edge after it
    Vec3f point{};
};

/// Closest point of a triangle and the feature that it lies on (Ericson, Real-Time Collision Detection, 5.1.5).
std::pair<Vec3f, int> closest(Vec3f p, Vec3f a, Vec3f b, Vec3f c)
{
    const Vec3f ab = b - a, ac = c - a, ap = p - a;
    const float d1 = dot(ab, ap), d2 = dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return {a, 1};
    const Vec3f bp = p - b;
    const float d3 = dot(ab, bp), d4 = dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return {b, 2};
    const float vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return {a + (d1 / (d1 - d3)) * ab, 4};
    const Vec3f cp = p - c;
    const float d5 = dot(ab, cp), d6 = dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return {c, 3};
    const float vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return {a + (d2 / (d2 - d6)) * ac, 6};
    const float va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return {b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b), 5};
    const float scale = 1 / (va + vb + vc);
    return {a + (vb * scale) * ab + (vc * scale) * ac, 0};
}

bool visit(RTCPointQueryFunctionArguments* arguments)
{
    auto& nearest = *static_cast<Nearest*>(arguments->userPtr);
    const mesh::Triangle& t = (*nearest.triangles)[arguments->primID];
    const Vec3f p{arguments->query->x, arguments->query->y, arguments->query->z};
    const auto [q, feature] = closest(p, (*nearest.vertices)[t[0]], (*nearest.vertices)[t[1]], (*nearest.vertices)[t[2]]);
    const float distance_sq = norm_sq(q - p);
    if (!(distance_sq < nearest.distance_sq)) return false;
    nearest.distance_sq = distance_sq;
    nearest.triangle = arguments->primID;
    nearest.feature = feature;
    nearest.point = q;
    arguments->query->radius = std::sqrt(distance_sq);
    return true;
}

/// Bytes that Embree holds, as its memory monitor reports them.
bool count_memory(void* total, ssize_t bytes, bool)
{
    *static_cast<std::int64_t*>(total) += bytes;
    return true;
}

}  // namespace

EmbreeNearest::EmbreeNearest(const mesh::Mesh& mesh) : triangles_(mesh.triangles)
{
    for (const Vec3d& v : mesh.vertices) vertices_.push_back(cast<float>(v));
    set_normals(mesh);
    device_ = rtcNewDevice("threads=1");
    rtcSetDeviceMemoryMonitorFunction(device_, count_memory, &embree_bytes_);
    scene_ = rtcNewScene(device_);
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* v = static_cast<Vec3f*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3f), vertices_.size()));
    std::copy(vertices_.begin(), vertices_.end(), v);
    auto* t = static_cast<mesh::Triangle*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(mesh::Triangle), triangles_.size()));
    std::copy(triangles_.begin(), triangles_.end(), t);
    rtcSetGeometryPointQueryFunction(geometry, visit);
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
}

EmbreeNearest::~EmbreeNearest()
{
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
}

float EmbreeNearest::signed_distance(Vec3f p) const
{
    Nearest nearest{&vertices_, &triangles_};
    RTCPointQuery query{p.x, p.y, p.z, 0, std::numeric_limits<float>::infinity()};
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene_, &query, &context, nullptr, &nearest);
    const Vec3f normal = normals_[7 * nearest.triangle + nearest.feature];
    const float distance = std::sqrt(nearest.distance_sq);
    return dot(p - nearest.point, normal) < 0 ? -distance : distance;
}

std::size_t EmbreeNearest::bytes() const
{
    return static_cast<std::size_t>(embree_bytes_) + normals_.size() * sizeof normals_[0];
}

/// Seven a triangle: of its face, vertices and edges.
void EmbreeNearest::set_normals(const mesh::Mesh& mesh)
{
    const auto& v = mesh.vertices;
    std::vector<Vec3d> of_vertex(v.size());
    std::map<std::pair<std::uint32_t, std::uint32_t>, Vec3d> of_edge;
    const auto face = [&](const mesh::Triangle& t) { return normalized(cross(v[t[1]] - v[t[0]], v[t[2]] - v[t[0]])); };
    const auto key = [](std::uint32_t a, std::uint32_t b) { return std::pair(std::min(a, b), std::max(a, b)); };
    for (const mesh::Triangle& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) {
            const Vec3d next = normalized(v[t[(k + 1) % 3]] - v[t[k]]), before = normalized(v[t[(k + 2) % 3]] - v[t[k]]);
            of_vertex[t[k]] += std::acos(std::clamp(dot(next, before), -1.0, 1.0)) * face(t);
            of_edge[key(t[k], t[(k + 1) % 3])] += face(t);
        }
    for (const mesh::Triangle& t : mesh.triangles) {
        normals_.push_back(cast<float>(face(t)));
        for (int k = 0; k < 3; ++k) normals_.push_back(cast<float>(of_vertex[t[k]]));
        for (int k = 0; k < 3; ++k) normals_.push_back(cast<float>(of_edge[key(t[k], t[(k + 1) % 3])]));
    }
}

}  // namespace sqmap::bench
