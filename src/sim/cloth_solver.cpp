// The parts of a step: threads, half-spaces, the speed limit, and the end of the step.
#include "cloth_state.h"
#include "contacts.h"

#include <algorithm>
#include <cmath>

namespace sqmap::sim {

namespace {

constexpr std::uint32_t k_looks_at_threads = 16;  ///< steps
constexpr double k_hard_push = 2;                 ///< times thickness: a node that is pushed farther stops where it is
// A node that threads and two surfaces throw to and fro is held on a leash, the farthest that it may go in a step: it counts as
// restless while it turns back more often than about every fifth step, faster than k_stirs.
constexpr double k_calm = 0.2;     ///< m / s: of the cloth as a whole, by its kinetic energy
constexpr double k_stirs = 0.015;  ///< m / s
constexpr float k_calms = 0.9f, k_restless = 1.5f, k_shorter = 0.25f, k_longer = 1.02f;

}  // namespace

void Cloth::State::take_nodes()
{
    for (std::size_t i = 0; i < moving.size(); ++i) {
        const btSoftBody::Node& n = node(i);
        moving[i] = {{n.m_x.x(), n.m_x.y(), n.m_x.z()}, n.m_im};
    }
}

void Cloth::State::take_links()
{
    for (std::size_t l = 0; l < threads.size(); ++l) {
        const btSoftBody::Link& link = body->m_links[static_cast<int>(l)];
        threads[l] = {number(link.m_n[0]), number(link.m_n[1]), link.m_c0, link.m_c1};
    }
}

void Cloth::State::solve_threads()
{
    for (const Thread& l : threads) {
        if (!(l.stiff > 0)) continue;
        Moving &a = moving[l.a], &b = moving[l.b];
        const Vec3f del = b.at - a.at;
        const float length_sq = norm_sq(del);
        if (!(l.rest_sq + length_sq > SIMD_EPSILON)) continue;
        const float k = (l.rest_sq - length_sq) / (l.stiff * (l.rest_sq + length_sq));
        a.at -= (k * a.inverse_mass) * del;
        b.at += (k * b.inverse_mass) * del;
    }
}

void Cloth::State::push_interiors_out()
{
    for (InteriorSpace& s : interiors.all()) {
        Moving* n[3];
        Vec3f x{};
        float give = 0;
        for (int k = 0; k < 3; ++k) {
            n[k] = &moving[s.nodes[static_cast<std::size_t>(k)]];
            x += s.weights[k] * n[k]->at;
            give += s.weights[k] * s.weights[k] * n[k]->inverse_mass;
        }
        const float below = s.offset - dot(s.normal, x);
        if (!(below > 0.f) || !(give > 0.f)) continue;
        s.push += below;
        for (int k = 0; k < 3; ++k) n[k]->at += (below / give * s.weights[k] * n[k]->inverse_mass) * s.normal;
    }
}

void Cloth::State::push_out(double dt, bool last)
{
    push_interiors_out();
    const float mu = static_cast<float>(fabric.friction);
    for (HalfSpace& s : contacts.all()) {
        Moving& n = moving[s.node];
        if (!(n.inverse_mass > 0)) continue;
        Vec3f x = n.at;
        const float height = dot(s.normal, x) - s.offset;
        if (height < 0.f) {
            x -= height * s.normal;
            s.push -= height;
        } else if (s.push <= 0.f) {
            continue;
        }
        if (last && options.friction == Friction::Paper) {  // eq. 33 acted earlier in this step, and does not grow with the push
            n.at = x;
            continue;
        }
        Vec3f slip = x - cast<float>(previous[s.node]) - s.motion;
        slip -= dot(slip, s.normal) * s.normal;
        // Friction's sum so far, less the slip, but no longer than the cone (or eq. 33) allows.
        float max_grip = mu * s.push;
        if (options.friction == Friction::None)
            max_grip = 0;
        else if (options.friction == Friction::Paper)
            max_grip =
                static_cast<float>(
                    friction_size({options.paper_friction, options.paper_stiffness}, static_cast<double>(s.depth)) * dt * dt) *
                n.inverse_mass;
        Vec3f grip = s.grip - slip;
        const float length = norm(grip);
        if (length > max_grip) grip = (max_grip / length) * grip;
        x += grip - s.grip;
        s.grip = grip;
        n.at = x;
    }
}

void Cloth::State::limit(double dt, StepReport& report)
{
    const double farthest = options.max_speed * dt;
    for (std::size_t i = 0; i < position.size(); ++i) {
        position[i] = cast<double>(moving[i].at);
        const Vec3d path = position[i] - previous[i];
        const double path_sq = norm_sq(path);
        if (!(path_sq > farthest * farthest) || !(moving[i].inverse_mass > 0)) continue;
        moving[i].at = cast<float>(previous[i] + (farthest / std::sqrt(path_sq)) * path);
        position[i] = cast<double>(moving[i].at);
        report.status |= k_cloth_slowed;
    }
}

void Cloth::State::still_restless(double dt, bool colliders_stand)
{
    double moving_mass = 0;
    for (std::size_t i = 0; i < position.size(); ++i)
        if (moving[i].inverse_mass > 0) moving_mass += 1 / static_cast<double>(moving[i].inverse_mass);
    const bool calm = colliders_stand && last_kinetic <= 0.5 * moving_mass * k_calm * k_calm;
    const auto stirs = static_cast<float>(k_stirs * dt);
    for (std::size_t i = 0; i < position.size(); ++i) {
        Restless& r = restless[i];
        if (!calm) {
            r = {};
            continue;
        }
        const Vec3f path = cast<float>(position[i] - previous[i]);
        const float length = norm(path);
        r.turns *= k_calms;
        r.leash *= k_longer;
        if (length > stirs) {
            if (dot(path, r.path) < 0) r.turns += 1;
            r.path = path;
            if (r.turns > k_restless) r.leash = std::max(0.5f * stirs, k_shorter * std::min(r.leash, length));
        }
        if (!(length > r.leash)) continue;
        position[i] = previous[i] + static_cast<double>(r.leash / length) * (position[i] - previous[i]);
    }
    // Held back within the cloth's thickness at most, not in the collider.
    for (const HalfSpace& s : contacts.all()) {
        if (!(restless[s.node].leash < static_cast<float>(fabric.thickness))) continue;
        const Vec3d normal = cast<double>(s.normal);
        const double below = static_cast<double>(s.offset) - fabric.thickness - dot(position[s.node], normal);
        if (below > 0) position[s.node] += below * normal;
    }
}

void Cloth::State::finish(double dt, bool colliders_stand, StepReport& report)
{
    const std::size_t n = position.size();
    const double keep = std::exp(-fabric.damping * dt);
    bool all_finite = true;
    for (std::size_t i = 0; i < n; ++i) {
        position[i] = cast<double>(moving[i].at);
        all_finite = all_finite && is_finite(position[i]);
    }
    if (stretched()) report.status |= k_cloth_stretched;
    if (all_finite) still_restless(dt, colliders_stand);
    if (all_finite && self) {
        const double mark = cpu_seconds();
        if (self->stop(previous, position, moving) > 0) report.status |= k_cloth_tangled;
        const double took = cpu_seconds() - mark;
        report.seconds.self += took;
        report.seconds.predict -= took;  // the time of predict includes that of the fabric's own contacts
    }
    for (std::size_t i = 0; i < n; ++i) velocity[i] = (keep / dt) * (position[i] - previous[i]);
    if (!all_finite) {
        report.status |= k_cloth_not_finite;
        position = previous = good;
        std::fill(velocity.begin(), velocity.end(), Vec3d{});
    } else {
        good = position;
        // Pushing out is no bounce: a node leaves a surface at the surface's own speed at most.
        for (const HalfSpace& s : contacts.all()) {
            if (s.push <= 0.f) continue;
            const Vec3d normal = cast<double>(s.normal);
            const double leaves = dot(velocity[s.node] - cast<double>(s.motion) / dt, normal);
            if (leaves > 0) velocity[s.node] -= leaves * normal;
            // A node that threads and a surface pull to and fro gains no speed by it.
            if (static_cast<double>(s.push) > k_hard_push * fabric.thickness) velocity[s.node] = cast<double>(s.motion) / dt;
            report.deepest =
                std::max(report.deepest, static_cast<double>(s.offset) - fabric.thickness - dot(position[s.node], normal));
        }
    }
    for (const InteriorSpace& s : interiors.all()) {
        if (s.push <= 0.f || !all_finite) continue;
        const Vec3d normal = cast<double>(s.normal), moves = cast<double>(s.motion) / dt;
        for (const std::uint32_t i : s.nodes) {
            const double leaves = dot(velocity[i] - moves, normal);
            if (leaves > 0) velocity[i] -= leaves * normal;
        }
    }
    for (const Pin& pin : pins) velocity[pin.node] = {};
    double fastest_sq = 0;
    for (std::size_t i = 0; i < n; ++i) {
        if (norm_sq(velocity[i]) > fastest_sq) {
            fastest_sq = norm_sq(velocity[i]);
            report.fastest_node = static_cast<std::uint32_t>(i);
        }
        btSoftBody::Node& b = node(i);
        b.m_x = to_bullet(position[i]);
        b.m_v = to_bullet(velocity[i]);
        b.m_f.setZero();
        if (moving[i].inverse_mass > 0) {
            const double mass = 1 / static_cast<double>(moving[i].inverse_mass);
            report.kinetic += 0.5 * mass * norm_sq(velocity[i]);
            report.potential -= mass * dot(options.gravity, position[i]);
        }
    }
    report.fastest = std::sqrt(fastest_sq);
    last_kinetic = report.kinetic;
}

bool Cloth::State::stretched()
{
    if (steps++ % k_looks_at_threads != 0) return was_stretched;
    std::size_t longer = 0, all = 0;
    const auto max_sq = static_cast<float>((1 + k_max_stretch) * (1 + k_max_stretch));
    for (std::size_t l = 0; l < threads.size(); ++l) {
        const Thread& t = threads[l];
        if (weak[l] != 0 || !(t.stiff > 0) || !(t.rest_sq > 0)) continue;
        ++all;
        longer += norm_sq(moving[t.a].at - moving[t.b].at) > max_sq * t.rest_sq ? 1 : 0;
    }
    was_stretched = 4 * longer > all;
    return was_stretched;
}

}  // namespace sqmap::sim
