#include "interiors.h"

#include "contacts.h"

#include <algorithm>
#include <cmath>

namespace sqmap::sim {

namespace {

constexpr std::size_t k_max = 512;  ///< places held at once
// In a step: so many triangles are looked at, and so many places are asked, those that are held before new ones.
// Where the cloth rests there is little new; among bones that move a place is asked of several, and costs more.
constexpr std::size_t k_looked_at = 1250, k_looked_at_resting = 300, k_asked = 32, k_asked_of_moving = 1;
// Places of a triangle, a quarter of an edge apart; how many of them are asked in a visit, and how far on the next one begins.
constexpr std::size_t k_places = 12, k_visit = 4, k_next = 5;
constexpr Vec3f k_weights[k_places] = {{.5f, .5f, 0},   {0, .5f, .5f},   {.5f, 0, .5f},   {.5f, .25f, .25f},
                                       {.75f, .25f, 0}, {0, .75f, .25f}, {.25f, 0, .75f}, {.25f, .5f, .25f},
                                       {.25f, .75f, 0}, {0, .25f, .75f}, {.75f, 0, .25f}, {.25f, .25f, .5f}};
constexpr float k_parting = 0.5f;  ///< cosine between nodes' normals: below it something sharp may be between them
// In thicknesses: how far off the surface a place is held, how far below it the collider is asked, how far it is raised in a step
// at most, also where the cloth rests, how far it may creep until it is asked again.
constexpr double k_off = 0.25, k_below = 0.5, k_raise = 1, k_raise_resting = 0.05, k_creep = 0.1;
constexpr double k_along = 0.5;  ///< cosine between the surface's normal and the cloth's: below it the cloth is pierced

Vec3d place_of(const InteriorSpace& s, std::span<const Vec3d> now)
{
    return static_cast<double>(s.weights.x) * now[s.nodes[0]] + static_cast<double>(s.weights.y) * now[s.nodes[1]] +
           static_cast<double>(s.weights.z) * now[s.nodes[2]];
}

}  // namespace

Interiors::Interiors(std::span<const std::array<std::uint32_t, 3>> triangles, double thickness, query::Layer layer)
    : triangles_(triangles.begin(), triangles.end()),
      spaces_(k_max),
      held_(k_places * triangles.size()),
      thickness_(thickness),
      layer_(layer)
{
}

bool Interiors::ask(InteriorSpace& space, std::span<const Vec3d> now, std::span<const Vec3f> touched,
                    std::span<const Collider> colliders, bool rests) const noexcept
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
    for (std::size_t k = 0; k < colliders.size(); ++k) {
        const Collider& collider = colliders[k];
        if (collider.model == nullptr || collider.skin != nullptr) continue;
        const Sphere sphere = query::sphere_of({collider.model, nullptr, collider.pose});
        if (!(norm_sq(asked - sphere.centre) <= sphere.radius * sphere.radius)) continue;
        const auto& header = collider.model->header;
        const Pose to = inverse(collider.pose);
        const Vec3d origin{header.origin[0], header.origin[1], header.origin[2]};
        const Vec3d in_model = (to.rotation * asked + to.translation - origin) / header.unit;
        const query::Contact c = query::query_point(*collider.model, cast<float>(in_model), layer_);
        const double depth = header.unit * static_cast<double>(c.depth);
        if (!c.contact || (c.status & query::k_no_surface) != 0 || depth <= deepest) continue;
        deepest = depth;
        // Where something thin has gone through the cloth its surface is beside the place; the way out is along the cloth's own
        // normal, back to the tip.
        const Vec3d normal = collider.pose.rotation * cast<double>(c.normal);
        const bool pierced = dot(normal, out) < k_along;
        const Vec3d direction = pierced ? out : normal;
        const Vec3d surface = apply(collider.pose, origin + header.unit * cast<double>(c.point));
        const double off = k_off * thickness_;
        const double rise = pierced ? depth + off : dot(direction, surface - p) + off;
        const double most = (rests ? k_raise_resting : k_raise) * thickness_;
        const Vec3d at = p + std::min(rise, most) * direction;
        const Vec3d place = apply(to, at);
        space.normal = cast<float>(direction);
        space.offset = static_cast<float>(dot(direction, at));
        space.place = cast<float>(place);
        space.direction = cast<float>(to.rotation * direction);
        space.motion = cast<float>(at - apply(collider.previous, place));
        space.collider = static_cast<std::uint32_t>(k);
        space.settled = rise <= most;
        space.asked_from = p;
    }
    return deepest > 0;
}

void Interiors::find(std::span<const Vec3d> now, std::span<const Vec3f> touched, std::span<const Collider> colliders,
                     bool rests) noexcept
{
    bool stand = true;
    for (const Collider& s : colliders) stand = stand && stands(s);
    const double creep_sq = k_creep * thickness_ * k_creep * thickness_;
    const std::size_t max_asked = stand ? k_asked : k_asked_of_moving;
    std::size_t asked = 0;
    for (std::size_t i = 0; i < count_ && asked < max_asked; ++i) {
        first_ = first_ >= count_ ? 0 : first_;
        InteriorSpace& s = spaces_[first_];
        const bool same = stand && s.settled && norm_sq(place_of(s, now) - s.asked_from) <= creep_sq;
        asked += same ? 0 : 1;
        if (same || ask(s, now, touched, colliders, rests)) {
            ++first_;
        } else {
            held_[s.number] = 0;
            s = spaces_[--count_];
        }
    }
    const std::size_t looked_at = std::min(triangles_.size(), rests || !stand ? k_looked_at_resting : k_looked_at);
    for (std::size_t i = 0; i < looked_at && asked < max_asked; ++i) {
        const std::size_t t = next_;
        if (++next_ == triangles_.size()) {
            next_ = 0;
            visit_ = (visit_ + k_next) % k_places;
        }
        const auto& n = triangles_[t];
        const Vec3f a = touched[n[0]], b = touched[n[1]], c = touched[n[2]];
        const float has_a = norm_sq(a), has_b = norm_sq(b), has_c = norm_sq(c);  // 1, or 0 where the node feels nothing
        if (!(dot(a, b) < k_parting * has_a * has_b || dot(b, c) < k_parting * has_b * has_c ||
              dot(c, a) < k_parting * has_c * has_a))
            continue;
        for (std::size_t j = 0; j < k_visit && asked < max_asked && count_ < spaces_.size(); ++j) {
            const std::size_t k = (visit_ + t + j) % k_places, number = k_places * t + k;
            if (held_[number] != 0) continue;
            InteriorSpace& s = spaces_[count_];
            s = {};
            s.nodes = n;
            s.weights = k_weights[k];
            s.number = static_cast<std::uint32_t>(number);
            ++asked;
            if (!ask(s, now, touched, colliders, rests)) continue;
            held_[number] = 1;
            ++count_;
        }
    }
}

void Interiors::ride(std::span<const Collider> colliders) noexcept
{
    for (InteriorSpace& s : all()) {
        s.push = 0;
        if (s.collider >= colliders.size()) continue;
        const Collider& collider = colliders[s.collider];
        const Vec3d place = cast<double>(s.place), at = apply(collider.pose, place);
        const Vec3d normal = collider.pose.rotation * cast<double>(s.direction);
        s.normal = cast<float>(normal);
        s.offset = static_cast<float>(dot(normal, at));
        s.motion = cast<float>(at - apply(collider.previous, place));
    }
}

}  // namespace sqmap::sim
