#include "interiors.h"

#include "contacts.h"

#include <algorithm>
#include <cmath>

namespace sqmap::sim {

namespace {

constexpr std::size_t k_most = 512;     ///< places held at once
constexpr std::size_t k_samples = 4;    ///< of a triangle: its centroid and the middles of its edges
constexpr Vec3f k_weights[k_samples] = {{1.f / 3, 1.f / 3, 1.f / 3}, {.5f, .5f, 0}, {0, .5f, .5f}, {.5f, 0, .5f}};
constexpr double k_rise = 0.25, k_below = 0.5;  ///< times thickness: how far off the surface places are held, and are asked below
constexpr double k_raise = 1;           ///< times thickness: how far a place is raised in a step where it is pierced
constexpr double k_creep = 0.1;         ///< times thickness
constexpr float k_part = 0.5f;          ///< cosine
constexpr double k_along = 0.5;         ///< cosine

Vec3d apply(const query::Pose& pose, Vec3d p) { return pose.rotation * p + pose.translation; }

Vec3d place_of(const InteriorSpace& s, std::span<const Vec3d> now)
{
    return static_cast<double>(s.weights.x) * now[s.nodes[0]] + static_cast<double>(s.weights.y) * now[s.nodes[1]] +
           static_cast<double>(s.weights.z) * now[s.nodes[2]];
}

}  // namespace

Interiors::Interiors(std::span<const std::array<std::uint32_t, 3>> triangles, std::size_t, double thickness, query::Layer layer)
    : triangles_(triangles.begin(), triangles.end()), spaces_(k_most), held_(k_samples * triangles.size()), thickness_(thickness), layer_(layer)
{
}

bool Interiors::ask(InteriorSpace& space, std::span<const Vec3d> now, std::span<const Vec3f> touched,
                    std::span<const Solid> solids) const noexcept
{
    const Vec3d p = place_of(space, now);
    const auto& n = space.nodes;
    const Vec3f felt = touched[n[0]] + touched[n[1]] + touched[n[2]];
    Vec3d out = cross(now[n[1]] - now[n[0]], now[n[2]] - now[n[0]]);
    const double length = norm(out);
    if (!(length > 0) || !(norm_sq(felt) > 0)) return false;
    out = (dot(out, cast<double>(felt)) < 0 ? -1 / length : 1 / length) * out;
    const Vec3d asked = p - k_below * thickness_ * out;
    double deepest = 0;
    for (std::size_t k = 0; k < solids.size(); ++k) {
        const Solid& solid = solids[k];
        if (solid.model == nullptr || solid.skin != nullptr) continue;
        const auto& header = solid.model->header;
        const query::Pose to = query::inverse(solid.pose);
        const Vec3d origin{header.origin[0], header.origin[1], header.origin[2]};
        const Vec3d in_model = (to.rotation * asked + to.translation - origin) / header.unit;
        const query::Contact c = query::query_point(*solid.model, cast<float>(in_model), layer_);
        const double depth = header.unit * static_cast<double>(c.depth);
        if (!c.contact || (c.status & query::k_no_surface) != 0 || depth <= deepest) continue;
        deepest = depth;
        const Vec3d in_mesh = origin + header.unit * cast<double>(c.point);
        const Vec3d normal = solid.pose.rotation * cast<double>(c.normal);
        const bool along = dot(normal, out) >= k_along;
        const Vec3d direction = along ? normal : out;
        const Vec3d at = along ? apply(solid.pose, in_mesh) + k_rise * thickness_ * normal
                               : p + std::min(k_raise * thickness_, depth + k_rise * thickness_) * out;
        space.normal = cast<float>(direction);
        space.offset = static_cast<float>(dot(direction, at));
        const Vec3d place = apply(query::inverse(solid.pose), at);
        space.place = cast<float>(place);
        space.direction = cast<float>(to.rotation * direction);
        space.motion = cast<float>(at - apply(solid.previous, place));
        space.solid = static_cast<std::uint32_t>(k);
        space.asked_from = p;
    }
    return deepest > 0;
}

void Interiors::find(std::span<const Vec3d> now, std::span<const Vec3f> touched, std::span<const Solid> solids) noexcept
{
    bool still = true;
    for (const Solid& s : solids) still = still && stands(s);
    std::size_t kept = 0;
    const double creep_sq = k_creep * thickness_ * k_creep * thickness_;
    for (std::size_t i = 0; i < count_; ++i) {
        InteriorSpace& s = spaces_[i];
        if ((still && norm_sq(place_of(s, now) - s.asked_from) <= creep_sq) || ask(s, now, touched, solids))
            spaces_[kept++] = s;
        else
            held_[s.sample] = 0;
    }
    count_ = kept;
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
        const auto& n = triangles_[t];
        const Vec3f a = touched[n[0]], b = touched[n[1]], c = touched[n[2]];
        if (dot(a, b) > k_part && dot(b, c) > k_part && dot(c, a) > k_part) continue;
        if (norm_sq(a + b + c) == 0) continue;
        for (std::size_t k = 0; k < k_samples; ++k) {
            const auto sample = static_cast<std::uint32_t>(k_samples * t + k);
            if (held_[sample] != 0 || count_ == spaces_.size()) continue;
            InteriorSpace s;
            s.nodes = n;
            s.weights = k_weights[k];
            s.sample = sample;
            if (!ask(s, now, touched, solids)) continue;
            held_[sample] = 1;
            spaces_[count_++] = s;
        }
    }
}

void Interiors::ride(std::span<const Solid> solids) noexcept
{
    for (InteriorSpace& s : all()) {
        s.push = 0;
        if (s.solid >= solids.size()) continue;
        const Solid& solid = solids[s.solid];
        const Vec3d place = cast<double>(s.place), at = apply(solid.pose, place);
        const Vec3d normal = solid.pose.rotation * cast<double>(s.direction);
        s.normal = cast<float>(normal);
        s.offset = static_cast<float>(dot(normal, at));
        s.motion = cast<float>(at - apply(solid.previous, place));
    }
}

}  // namespace sqmap::sim
