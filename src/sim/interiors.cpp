#include "interiors.h"

#include "contacts.h"
#include "sqmap/query/point.h"

#include <algorithm>
#include <cmath>

namespace sqmap::sim {

namespace {

constexpr std::size_t k_max = 512;  ///< points held at once
// In a step: triangles examined, and points queried, held ones before new ones. A cloth at rest has little new; among bones that
// move a point is queried on several, which costs more.
constexpr std::size_t k_looked_at = 1250, k_looked_at_resting = 300, k_queries = 32, k_queries_moving = 1;
// Points of a triangle, a quarter of an edge apart; how many of them are queried in a visit, and how far on the next visit
// begins.
constexpr std::size_t k_points = 12, k_visit = 4, k_next = 5;
constexpr Vec3f k_weights[k_points] = {{.5f, .5f, 0},   {0, .5f, .5f},   {.5f, 0, .5f},   {.5f, .25f, .25f},
                                       {.75f, .25f, 0}, {0, .75f, .25f}, {.25f, 0, .75f}, {.25f, .5f, .25f},
                                       {.25f, .75f, 0}, {0, .25f, .75f}, {.75f, 0, .25f}, {.25f, .25f, .5f}};
constexpr float k_parting = 0.5f;  ///< cosine between nodes' normals: below it something sharp may be between them
// In thicknesses: height at which a point is held above the surface, depth of the query below it, the most that a step raises it,
// also at rest, and how far it may creep until its next query.
constexpr double k_off = 0.25, k_below = 0.5, k_raise = 1, k_raise_resting = 0.05, k_creep = 0.1;
constexpr std::size_t k_skin_every = 4;  ///< steps between two queries of a skin
constexpr double k_along = 0.5;          ///< cosine between the surface's normal and the cloth's: below it the cloth is pierced

Vec3d point_of(const InteriorSpace& s, std::span<const Vec3d> now)
{
    return static_cast<double>(s.weights.x) * now[s.nodes[0]] + static_cast<double>(s.weights.y) * now[s.nodes[1]] +
           static_cast<double>(s.weights.z) * now[s.nodes[2]];
}

}  // namespace

Interiors::Interiors(std::span<const std::array<std::uint32_t, 3>> triangles, double thickness, query::Layer layer)
    : triangles_(triangles.begin(), triangles.end()),
      spaces_(k_max),
      held_(k_points * triangles.size()),
      thickness_(thickness),
      layer_(layer)
{
}

bool Interiors::hold(InteriorSpace& space, const TouchingNodes& nodes, std::span<const Collider> colliders) const noexcept
{
    const std::span<const Vec3d> now = nodes.now;
    const Vec3d p = point_of(space, now);
    const auto& n = space.nodes;
    const Vec3f normals = nodes.normals[n[0]] + nodes.normals[n[1]] + nodes.normals[n[2]];
    Vec3d out = cross(now[n[1]] - now[n[0]], now[n[2]] - now[n[0]]);
    const double length = norm(out);
    if (!(length > 0) || !(norm_sq(normals) > 0)) return false;
    out = (dot(out, cast<double>(normals)) < 0 ? -1 / length : 1 / length) * out;
    const Vec3d below = p - k_below * thickness_ * out;
    double deepest = 0;
    for (std::size_t k = 0; k < colliders.size(); ++k) {
        const Collider& collider = colliders[k];
        if (collider.model == nullptr || collider.skin != nullptr) continue;
        const Sphere sphere = query::sphere_of({collider.model, nullptr, collider.pose});
        if (!(norm_sq(below - sphere.centre) <= sphere.radius * sphere.radius)) continue;
        const Pose to = inverse(collider.pose);
        const query::Body touched{collider.model, nullptr, collider.pose};
        const query::PointResult c = query::query_point(touched, below, {.layer = layer_});
        if (!c.contact || (c.status & query::k_no_surface) != 0 || c.depth <= deepest) continue;
        deepest = c.depth;
        // Something thin that has gone through the cloth has its surface beside the point: outwards is then along the cloth's own
        // normal, back to the tip.
        const bool pierced = dot(c.normal, out) < k_along;
        const Vec3d direction = pierced ? out : c.normal;
        const double off = k_off * thickness_;
        const double rise = pierced ? c.depth + off : dot(direction, c.witness - p) + off;
        const double max_rise = (nodes.rests ? k_raise_resting : k_raise) * thickness_;
        const Vec3d at = p + std::min(rise, max_rise) * direction;
        const Vec3d local = apply(to, at);
        space.normal = cast<float>(direction);
        space.offset = static_cast<float>(dot(direction, at));
        space.local_at = cast<float>(local);
        space.local_normal = cast<float>(to.rotation * direction);
        space.motion = cast<float>(at - apply(collider.previous, local));
        space.collider = static_cast<std::uint32_t>(k);
        space.settled = rise <= max_rise;
        space.queried_from = p;
    }
    return deepest > 0;
}

void Interiors::expect(const query::SkinLattice& lattice, std::span<const Vec3d> points)
{
    middles_.resize(triangles_.size());
    outward_.resize(triangles_.size());
    skin_found_.resize(triangles_.size());
    for (std::size_t t = 0; t < triangles_.size(); ++t)
        middles_[t] = (points[triangles_[t][0]] + points[triangles_[t][1]] + points[triangles_[t][2]]) / 3.0;
    skin_workspace_ = std::make_unique<query::SkinWorkspace>(lattice, middles_);
}

void Interiors::find_skinned(const TouchingNodes& nodes, std::span<const Collider> colliders, std::size_t number) noexcept
{
    const Collider& collider = colliders[number];
    for (std::size_t i = 0; i < count_;) {
        if (spaces_[i].collider != number) {
            ++i;
            continue;
        }
        held_[spaces_[i].number] = 0;
        spaces_[i] = spaces_[--count_];
    }
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
        const auto& n = triangles_[t];
        const Vec3f normals = nodes.normals[n[0]] + nodes.normals[n[1]] + nodes.normals[n[2]];
        middles_[t] = (nodes.now[n[0]] + nodes.now[n[1]] + nodes.now[n[2]]) / 3.0;
        outward_[t] = {};
        if (!(norm_sq(normals) > 0)) continue;
        Vec3d out = cross(nodes.now[n[1]] - nodes.now[n[0]], nodes.now[n[2]] - nodes.now[n[0]]);
        const double length = norm(out);
        if (!(length > 0)) continue;
        outward_[t] = (dot(out, cast<double>(normals)) < 0 ? -1 / length : 1 / length) * out;
        middles_[t] -= k_below * thickness_ * outward_[t];
    }
    const auto found =
        query::query_skin({collider.model, &collider.skin->to(), middles_, {}}, {.layer = layer_}, *skin_workspace_, skin_found_);
    for (const query::SkinContact& c : std::span(skin_found_).first(std::min(found.contacts, skin_found_.size()))) {
        if ((c.status & query::k_no_surface) != 0 || count_ == spaces_.size()) continue;
        Affine was, is;
        if (!collider.skin->from().carry_forward(c.bound_witness, was) || !collider.skin->to().carry_forward(c.bound_witness, is))
            continue;
        InteriorSpace& s = spaces_[count_++];
        s = {};
        s.nodes = triangles_[c.index];
        s.weights = {1.f / 3, 1.f / 3, 1.f / 3};
        s.number = static_cast<std::uint32_t>(k_points * c.index);
        s.collider = static_cast<std::uint32_t>(number);
        held_[s.number] = 1;
        const Vec3d p = point_of(s, nodes.now), out = outward_[c.index];
        // As in hold(): through cloth that is pierced the thin part's tip is along the cloth's own normal.
        const bool pierced = norm_sq(out) > 0 && dot(c.normal, out) < k_along;
        const Vec3d direction = pierced ? out : c.normal;
        const double off = k_off * thickness_, rise = pierced ? c.depth + off : dot(direction, c.witness - p) + off;
        const Vec3d at = p + std::min(rise, k_raise * thickness_) * direction;
        s.normal = cast<float>(direction);
        s.offset = static_cast<float>(dot(direction, at));
        s.local_at = cast<float>(c.bound_witness);
        s.motion = cast<float>(sqmap::apply(is, c.bound_witness) - sqmap::apply(was, c.bound_witness));
        s.settled = false;
    }
}

void Interiors::find(const TouchingNodes& nodes, std::span<const Collider> colliders) noexcept
{
    ++step_;
    bool is_rigid = false;
    for (std::size_t k = 0; k < colliders.size(); ++k) {
        if (colliders[k].model == nullptr) continue;
        if (colliders[k].skin == nullptr)
            is_rigid = true;
        else if (skin_workspace_ && step_ % k_skin_every == 0)
            find_skinned(nodes, colliders, k);
    }
    if (!is_rigid) return;
    const std::span<const Vec3f> normals = nodes.normals;
    const bool stand = all_stand(colliders);
    const double creep_sq = k_creep * thickness_ * k_creep * thickness_;
    const std::size_t max_queries = stand ? k_queries : k_queries_moving;
    std::size_t queries = 0;
    for (std::size_t i = 0; i < count_ && queries < max_queries; ++i) {
        first_ = first_ >= count_ ? 0 : first_;
        InteriorSpace& s = spaces_[first_];
        const bool of_skin = s.collider < colliders.size() && colliders[s.collider].skin != nullptr;
        const bool same = of_skin || (stand && s.settled && norm_sq(point_of(s, nodes.now) - s.queried_from) <= creep_sq);
        queries += same ? 0 : 1;
        if (same || hold(s, nodes, colliders)) {
            ++first_;
        } else {
            held_[s.number] = 0;
            s = spaces_[--count_];
        }
    }
    const std::size_t looked_at = std::min(triangles_.size(), nodes.rests || !stand ? k_looked_at_resting : k_looked_at);
    for (std::size_t i = 0; i < looked_at && queries < max_queries; ++i) {
        const std::size_t t = next_;
        if (++next_ == triangles_.size()) {
            next_ = 0;
            visit_ = (visit_ + k_next) % k_points;
        }
        const auto& n = triangles_[t];
        const Vec3f a = normals[n[0]], b = normals[n[1]], c = normals[n[2]];
        const float has_a = norm_sq(a), has_b = norm_sq(b), has_c = norm_sq(c);  // 1, or 0 where the node is free
        if (!(dot(a, b) < k_parting * has_a * has_b || dot(b, c) < k_parting * has_b * has_c ||
              dot(c, a) < k_parting * has_c * has_a))
            continue;
        for (std::size_t j = 0; j < k_visit && queries < max_queries && count_ < spaces_.size(); ++j) {
            const std::size_t k = (visit_ + t + j) % k_points, number = k_points * t + k;
            if (held_[number] != 0) continue;
            InteriorSpace& s = spaces_[count_];
            s = {};
            s.nodes = n;
            s.weights = k_weights[k];
            s.number = static_cast<std::uint32_t>(number);
            ++queries;
            if (!hold(s, nodes, colliders)) continue;
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
        const Vec3d local = cast<double>(s.local_at);
        if (collider.skin != nullptr) {
            Affine was, is;
            if (!collider.skin->from().carry_forward(local, was) || !collider.skin->to().carry_forward(local, is)) continue;
            // The plane keeps its direction for the few steps until the next query.
            s.motion = cast<float>(sqmap::apply(is, local) - sqmap::apply(was, local));
            s.offset += dot(s.normal, s.motion);
            continue;
        }
        const Vec3d at = apply(collider.pose, local);
        const Vec3d normal = collider.pose.rotation * cast<double>(s.local_normal);
        s.normal = cast<float>(normal);
        s.offset = static_cast<float>(dot(normal, at));
        s.motion = cast<float>(at - apply(collider.previous, local));
    }
}

}  // namespace sqmap::sim
