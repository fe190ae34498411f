#include "contacts.h"

#include "sqmap/math/assert.h"

#include <algorithm>
#include <cmath>

namespace sqmap::sim {

namespace {

constexpr std::uint32_t k_none = 0xffffffffu;
constexpr double k_speed_matters = 1e-6;  ///< m a step: below it a motion has no direction
constexpr double k_deeper =
    1.25;  ///< times thickness: depth of the query point below a node in contact, so that rounding does not let it go
constexpr std::uint8_t k_remembered = 8;  ///< steps for which the query point of a node that left a surface is along its normal
constexpr double k_creep = 0.1;           ///< times thickness: how far a node may creep until its next query
// How fast the surface under a node that was held before may rise or fall: shares of thickness per step and of the node's path.
// Layer 3 is not continuous, and a node that rests where it jumps would go up and down for ever.
constexpr double k_settle = 0.01, k_settle_path = 0.25;
// How far beside a surface point, in thicknesses, a node may be held by its plane alone.
constexpr double k_beside = 1;
constexpr float k_same_surface = 0.97f;  ///< cosine between normals above which two contacts are of one surface
constexpr float k_facing = -0.5f;        ///< cosine between normals below which two surfaces face each other
constexpr std::size_t k_turned =
    2;  ///< with several colliders, one step in this many looks for a surface on the cloth's other side
constexpr std::uint8_t k_max_kept = 2;  ///< steps
constexpr std::size_t k_sample = 16;    ///< one node in this many decides whether it pays to examine each
constexpr std::size_t k_block = 32;
constexpr std::size_t k_fetched = 8;        ///< contacts ahead
constexpr std::size_t k_max_colliders = 4;  ///< average half-spaces per node that the memory holds

/// Bound of how far a collider's surface moves in the step, m.
double motion_bound(const Collider& collider)
{
    const Sphere sphere = query::sphere_of({collider.model, nullptr, {}});
    const Vec3d shift = apply(collider.pose, sphere.centre) - apply(collider.previous, sphere.centre);
    double turn_sq = 0;  // Frobenius norm, no less than the spectral
    for (int i = 0; i < 3; ++i) turn_sq += norm_sq(collider.pose.rotation.row[i] - collider.previous.rotation.row[i]);
    return norm(shift) + std::sqrt(turn_sq) * sphere.radius;
}

}  // namespace

Contacts::Contacts(std::span<const Vec3d> points, double thickness, double sweep_step, query::Layer layer)
    : probe_(points),
      workspace_(probe_),
      found_(points.size()),
      spaces_(k_max_colliders * points.size()),
      head_(points.size(), k_none),
      query_points_(points.size()),
      normals_(points.size()),
      free_for_(points.size()),
      queried_from_(points.size()),
      last_(spaces_.size()),
      last_head_(points.size(), k_none),
      stale_(points.size(), 1),
      thickness_(thickness),
      sweep_step_(std::max(sweep_step, 2 * thickness)),
      options_{.layer = layer}
{
}

void Contacts::expect(const query::SkinLattice& lattice, std::span<const Vec3d> points)
{
    skin_workspace_ = std::make_unique<query::SkinWorkspace>(lattice, points);
    skin_found_.resize(points.size());
}

bool Contacts::mark_stale(std::span<const Vec3d> now, bool still) noexcept
{
    stale_count_ = now.size();
    if (!still || kept_ == Kept::Nothing) {
        kept_ = still ? Kept::All : Kept::Nothing;
        return false;
    }
    const double max_sq = k_creep * thickness_ * k_creep * thickness_;
    std::size_t moved = 0;
    for (std::size_t i = 0; i < now.size(); i += k_sample) moved += norm_sq(now[i] - queried_from_[i]) <= max_sq ? 0 : 1;
    const bool few = 2 * k_sample * moved < now.size(), all_kept = kept_ == Kept::All;
    kept_ = few ? Kept::All : Kept::Samples;
    if (!few || !all_kept) return false;
    stale_count_ = 0;
    for (std::size_t i = 0; i < now.size(); ++i) {
        stale_[i] = norm_sq(now[i] - queried_from_[i]) <= max_sq ? 0 : 1;
        stale_count_ += stale_[i];
    }
    return true;
}

double Contacts::set_query_points(const Nodes& nodes, bool some, bool stand) noexcept
{
    const std::span<const Vec3d> previous = nodes.previous, now = nodes.now;
    // The surface that holds the nodes is thickness outside the model's. Instead of moving the surface, each node's query point
    // is that much below it: along the normal of its last contact, or ahead on its path where it had none. Where colliders move,
    // such a node's query point is its position: a thigh that comes up behind it, faster, is not ahead of it.
    constexpr auto k_min_sq = static_cast<float>(k_speed_matters * k_speed_matters);
    const auto deeper = static_cast<float>(k_deeper * thickness_), ahead_by = stand ? static_cast<float>(thickness_) : 0.f;
    const std::size_t keep_every = kept_ == Kept::All ? 1 : k_sample;
    float longest_sq = 0;
    for (std::size_t first = 0; first < now.size(); first += k_block) {
        // In blocks, so that the compiler takes several at once.
        const std::size_t count = std::min(k_block, now.size() - first);
        float path[3][k_block] = {}, normal[3][k_block] = {}, ahead[3][k_block], path_sq[k_block];
        for (std::size_t j = 0; j < count; ++j) {
            const Vec3d w = now[first + j] - previous[first + j];
            const Vec3f t = normals_[first + j];
            const float side = turned(first + j) ? -1.f : 1.f;
            for (int k = 0; k < 3; ++k) {
                path[k][j] = static_cast<float>(w[k]);
                normal[k][j] = side * t[k];
            }
        }
        for (std::size_t j = 0; j < k_block; ++j) {
            const float sq = path[0][j] * path[0][j] + path[1][j] * path[1][j] + path[2][j] * path[2][j];
            const float held =
                normal[0][j] * normal[0][j] + normal[1][j] * normal[1][j] + normal[2][j] * normal[2][j] > 0.f ? 1.f : 0.f;
            const float along = (1.f - held) * (sq > k_min_sq ? ahead_by : 0.f) / std::sqrt(sq > k_min_sq ? sq : 1.f);
            for (int k = 0; k < 3; ++k) ahead[k][j] = along * path[k][j] - deeper * normal[k][j];
            path_sq[j] = sq;
        }
        for (std::size_t j = 0; j < count; ++j) {
            const std::size_t i = first + j;
            if (some && stale_[i] == 0) continue;
            const Vec3d n = now[i];
            query_points_[i] = {n.x + static_cast<double>(ahead[0][j]), n.y + static_cast<double>(ahead[1][j]),
                                n.z + static_cast<double>(ahead[2][j])};
            longest_sq = std::max(longest_sq, path_sq[j]);
            if (kept_ != Kept::Nothing && i % keep_every == 0) queried_from_[i] = n;
        }
    }
    return std::sqrt(static_cast<double>(longest_sq)) * (1 + 1e-6);
}

void Contacts::turn_over(bool some) noexcept
{
    spaces_.swap(last_);
    head_.swap(last_head_);
    std::fill(head_.begin(), head_.end(), k_none);
    const std::size_t had = count_;
    count_ = 0;
    voided_ = false;
    for (std::size_t s = 0; s < had && some; ++s) {
        if (stale_[last_[s].node] != 0) continue;
        append(last_[s]);
    }
}

void Contacts::append(const HalfSpace& space) noexcept
{
    SQMAP_ASSERT(count_ < spaces_.size());
    spaces_[count_] = space;
    spaces_[count_].next = head_[space.node];
    head_[space.node] = static_cast<std::uint32_t>(count_++);
}

void Contacts::drop_void() noexcept
{
    const auto last = std::remove_if(spaces_.begin(), spaces_.begin() + static_cast<std::ptrdiff_t>(count_),
                                     [](const HalfSpace& s) { return s.push < 0.f; });
    count_ = static_cast<std::size_t>(last - spaces_.begin());
    std::fill(head_.begin(), head_.end(), k_none);
    for (std::size_t s = 0; s < count_; ++s) {
        spaces_[s].next = head_[spaces_[s].node];
        head_[spaces_[s].node] = static_cast<std::uint32_t>(s);
    }
}

void Contacts::keep_pressed(std::uint32_t node, Vec3d now) noexcept
{
    for (std::uint32_t s = last_head_[node]; s != k_none && count_ < spaces_.size(); s = last_[s].next) {
        const HalfSpace& was = last_[s];
        if (!(was.push > 0.f)) continue;
        const Vec3f d = cast<float>(now) - was.at, beside = d - dot(d, was.normal) * was.normal;
        if (!(norm_sq(beside) <= static_cast<float>(k_beside * thickness_ * k_beside * thickness_))) continue;
        append(was);
    }
}

bool Contacts::turned(std::size_t node) const noexcept { return colliders_ > 1 && (node + step_) % k_turned == 0; }

void Contacts::keep_unseen(std::uint32_t node, Vec3d now) noexcept
{
    const std::uint32_t found = head_[node];
    const bool other_side = turned(node);
    const Vec3f x = cast<float>(now);
    for (std::uint32_t s = last_head_[node]; s != k_none && count_ < spaces_.size(); s = last_[s].next) {
        const HalfSpace& was = last_[s];
        if (was.kept >= k_max_kept || dot(was.normal, x) - was.offset > static_cast<float>((k_deeper - 1) * thickness_)) continue;
        // A query looks in one direction: it does not see a surface that faces the one found there.
        const bool faces =
            found != k_none && was.collider != spaces_[found].collider && dot(was.normal, spaces_[found].normal) < k_facing;
        if (!faces && !(found == k_none && other_side)) continue;
        append(was);
        ++spaces_[head_[node]].kept;
        if (faces) break;
    }
}

void Contacts::squeeze(std::uint32_t node, Vec3d now) noexcept
{
    const Vec3f x = cast<float>(now);
    for (std::uint32_t s = head_[node]; s != k_none; s = spaces_[s].next)
        for (std::uint32_t t = spaces_[s].next; t != k_none; t = spaces_[t].next) {
            HalfSpace &a = spaces_[s], &b = spaces_[t];
            if (dot(a.normal, b.normal) > k_facing) continue;
            normals_[node] = a.normal;
            // If there is no space for the thickness, each surface yields half of the missing distance.
            const float missing = a.offset + b.offset - dot(a.normal + b.normal, x) + a.give + b.give;
            const float give = std::clamp(0.5f * missing, 0.f, static_cast<float>(thickness_));
            for (HalfSpace* side : {&a, &b}) {
                side->offset += side->give - give;
                side->give = give;
            }
        }
}

std::uint32_t Contacts::find(const Nodes& nodes, std::span<const Collider> colliders, StepReport& report) noexcept
{
    const std::span<const Vec3d> now = nodes.now;
    const double start = cpu_seconds();
    std::uint32_t status = k_cloth_ok;
    const bool stand = all_stand(colliders);
    const bool still = stand && colliders.size() == colliders_;
    colliders_ = colliders.size();
    ++step_;
    // A node within a hair of its last query has its answer, where the colliders stand still.
    const bool some = mark_stale(now, still);
    if (!some) std::fill(stale_.begin(), stale_.end(), std::uint8_t{1});
    double longest = 0;
    if (stale_count_ > 0) {
        longest = set_query_points(nodes, some, stand);
        if (some)
            probe_.move(query_points_, stale_);
        else
            probe_.move(query_points_);
    }
    const double moved = cpu_seconds();

    std::size_t held = 0;
    if (stale_count_ > 0) {
        turn_over(some);
        for (std::size_t k = 0; k < colliders.size(); ++k)
            status |= query_rigid(static_cast<std::uint32_t>(k), {nodes, colliders, longest}, report);
        if (voided_) drop_void();
        for (std::size_t i = 0; i < normals_.size(); ++i) {
            if (last_head_[i] != k_none && stale_[i] != 0) {
                if (colliders.size() > 1 && (head_[i] == k_none || spaces_[head_[i]].next == k_none))
                    keep_unseen(static_cast<std::uint32_t>(i), now[i]);
                if (head_[i] == k_none) keep_pressed(static_cast<std::uint32_t>(i), now[i]);
            }
            const std::uint32_t first = head_[i];
            if (first != k_none) {
                ++held;
                if (stale_[i] == 0) continue;
                Vec3f& touched = normals_[i];
                touched = spaces_[first].normal;
                free_for_[i] = 0;
                if (spaces_[first].next == k_none) continue;
                for (std::uint32_t s = spaces_[first].next; s != k_none; s = spaces_[s].next) touched += spaces_[s].normal;
                touched = normalized(touched);
                squeeze(static_cast<std::uint32_t>(i), now[i]);
            } else if (stale_[i] != 0 && free_for_[i] < k_remembered && ++free_for_[i] == k_remembered) {
                normals_[i] = {};
            }
        }
        held_ = held;
    }
    report.contacts = held_;
    report.seconds.move += moved - start;
    report.seconds.query += cpu_seconds() - moved;
    return status;
}

std::uint32_t Contacts::query_rigid(std::uint32_t number, const Search& search, StepReport& report) noexcept
{
    const Collider& collider = search.colliders[number];
    const std::span<const Vec3d> previous = search.nodes.previous, now = search.nodes.now;
    if (collider.model == nullptr) return k_cloth_ok;
    if (collider.skin != nullptr) return query_skinned(number, search, report);
    std::uint32_t status = k_cloth_ok;
    const double motion = motion_bound(collider);
    Sphere near = query::sphere_of({collider.model, nullptr, collider.pose});
    // Query points are as far ahead as a node is thick.
    near.radius += search.longest + motion + k_deeper * thickness_;
    if (!probe_.reaches(near)) return k_cloth_ok;
    // In the collider's own frame, in which contacts ride on it.
    const query::Body touched{collider.model, nullptr, {}};
    const Pose to = inverse(collider.pose);
    query::ProbeResult frame;
    if (search.longest + motion <= sweep_step_) {
        frame = query::query_probe(touched, {nullptr, &probe_, to}, options_, found_);
    } else {
        const query::SweptOptions swept{options_, sweep_step_, 64};
        const query::SweptResult result = query::query_swept(
            {touched, &probe_, inverse(collider.previous), to, previous, query_points_}, swept, workspace_, found_);
        frame = result.probe;
        report.caught += result.caught;
        if ((frame.status & query::k_coarse) != 0) status |= k_cloth_coarse_sweep;
    }
    if ((frame.status & query::k_full) != 0) status |= k_cloth_full;
    const auto contacts = frame.written(found_);
    for (std::size_t c = 0; c < contacts.size(); ++c) {
        const query::Contact& contact = contacts[c];
        // Nodes lie in another order than the contacts.
        if (c + k_fetched < contacts.size()) {
            const std::uint32_t next = contacts[c + k_fetched].index;
            __builtin_prefetch(&now[next]);
            __builtin_prefetch(&previous[next]);
            __builtin_prefetch(&last_head_[next]);
        }
        if ((contact.status & query::k_no_surface) != 0 || stale_[contact.index] == 0) continue;
        const Vec3d in_mesh = frame.position(contact);
        const Vec3d at = apply(collider.pose, in_mesh), direction = cast<double>(contact.normal);
        if (!add({contact.index, number, at, collider.pose.rotation * direction, at - apply(collider.previous, in_mesh),
                  static_cast<double>(contact.depth), in_mesh, direction},
                 search.nodes))
            status |= k_cloth_full;
    }
    return status;
}

std::uint32_t Contacts::query_skinned(std::uint32_t number, const Search& search, StepReport& report) noexcept
{
    const Collider& collider = search.colliders[number];
    std::uint32_t status = k_cloth_ok;
    const query::SweptResult result =
        query::query_swept_skin({collider.model, collider.skin, search.nodes.previous, query_points_, stale_},
                                {options_, sweep_step_, 64}, *skin_workspace_, skin_found_);
    report.caught += result.caught;
    if ((result.probe.status & query::k_coarse) != 0) status |= k_cloth_coarse_sweep;
    if ((result.probe.status & query::k_full) != 0) status |= k_cloth_full;
    if ((result.probe.status & query::k_crowded) != 0) status |= k_cloth_crowded;
    for (const query::SkinContact& c : std::span(skin_found_).first(std::min(result.probe.contacts, skin_found_.size()))) {
        if ((c.status & query::k_no_surface) != 0) continue;
        Affine was, is;
        if (!collider.skin->from().carry_forward(c.bound_witness, was) || !collider.skin->to().carry_forward(c.bound_witness, is))
            continue;
        if (!add({c.index, number, c.witness, c.normal, sqmap::apply(is, c.bound_witness) - sqmap::apply(was, c.bound_witness),
                  c.depth, c.bound_witness, c.bound_normal},
                 search.nodes))
            status |= k_cloth_full;
    }
    return status;
}

void Contacts::ride(std::span<const Collider> colliders) noexcept
{
    for (HalfSpace& s : all()) {
        s.push = 0;
        s.grip = {};
        if (s.collider >= colliders.size()) continue;
        const Collider& collider = colliders[s.collider];
        const Vec3d local = cast<double>(s.local_at);
        Vec3d at = apply(collider.pose, local), normal = collider.pose.rotation * cast<double>(s.local_normal);
        s.motion = cast<float>(at - apply(collider.previous, local));
        if (collider.skin != nullptr) {
            Affine was, is;
            if (!collider.skin->from().carry_forward(local, was) || !collider.skin->to().carry_forward(local, is)) continue;
            at = sqmap::apply(is, local);
            normal = query::carried_normal(is, cast<double>(s.local_normal));
            s.motion = cast<float>(at - sqmap::apply(was, local));
        }
        s.at = cast<float>(at);
        s.normal = cast<float>(normal);
        s.offset = static_cast<float>(dot(normal, at) + thickness_) - s.give;
    }
}

double Contacts::steadied(const HalfSpace& space, Vec3d previous, Vec3d now) const noexcept
{
    const std::uint32_t before = last_head_[space.node];
    if (before == k_none || last_[before].next != k_none) return 0;  // held by none, or several
    const HalfSpace& last = last_[before];
    if (last.collider != space.collider || dot(last.normal, space.normal) < k_same_surface) return 0;
    const auto height = [&](const auto& s) { return dot(cast<double>(s.normal), now) - static_cast<double>(s.offset); };
    const double fall = height(space) - height(last), max_fall = k_settle * thickness_ + k_settle_path * norm(now - previous);
    return fall - std::clamp(fall, -max_fall, max_fall);
}

bool Contacts::add(const Surface& surface, const Nodes& nodes) noexcept
{
    if (count_ == spaces_.size()) return false;
    const Vec3d at = surface.at, normal = surface.normal;
    HalfSpace space;
    space.normal = cast<float>(normal);
    space.offset = static_cast<float>(dot(normal, at) + thickness_);
    space.motion = cast<float>(surface.motion);
    space.depth = static_cast<float>(surface.depth);
    space.node = surface.node;
    space.collider = surface.collider;
    space.local_normal = cast<float>(surface.local_normal);
    space.at = cast<float>(at);
    const double shift = steadied(space, nodes.previous[space.node], nodes.now[space.node]);
    space.offset += static_cast<float>(shift);
    space.local_at = cast<float>(surface.local_at + shift * surface.local_normal);
    // Colliders form a union: a surface of one within another is none. Of two that hold the node, the one whose surface point
    // lies behind the other's tangent plane is left out; the deeper one stays where both do.
    const double slack = 0.05 * thickness_;
    for (std::uint32_t o = head_[space.node]; o != k_none; o = spaces_[o].next) {
        HalfSpace& other = spaces_[o];
        if (other.push < 0.f) continue;
        const Vec3d p = query_points_[space.node];
        const Vec3d other_at = p + static_cast<double>(other.depth) * cast<double>(other.normal);
        const bool hidden = dot(at, cast<double>(other.normal)) < dot(other_at, cast<double>(other.normal)) - slack;
        const bool hides = dot(other_at - at, normal) < -slack;
        if (hidden && hides && dot(other.normal, space.normal) < k_facing) continue;
        if (hidden && (!hides || space.depth <= other.depth)) return true;
        if (hides) {
            other.push = -1.f;  // void
            voided_ = true;
        }
    }
    append(space);
    return true;
}

}  // namespace sqmap::sim
