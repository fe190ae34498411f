// The parts of a step: threads, half-spaces, the speed limit, and the end of the step.
#include "cloth_state.h"
#include "contacts.h"

#include <algorithm>
#include <cmath>

namespace sqmap::sim {

namespace {

constexpr std::uint32_t k_looks_at_threads = 16;  ///< steps
// Threads longer by this share than they should be are solved again, this often at most and this many solutions in a share of the
// step: they bear a hand's pull, and are few.
constexpr double k_tight = 0.03;
constexpr std::size_t k_max_tight_sweeps = 6, k_tight_solved = 1500;
// s: bending or shear that changes by its own size in this time resists twice as much. More loss in bending would take more than
// one solution in a share to keep its stiffness.
constexpr double k_bending_loss = 0.005, k_shear_loss = 0.05;
constexpr double k_hard_push = 2;  ///< times thickness: a node that is pushed farther stops where it is
// A node that threads and two surfaces throw to and fro is held on a leash, the farthest that it may go in a step: it counts as
// restless while it turns back more often than about every fifth step, faster than k_stirs.
constexpr double k_calm = 0.2;     ///< m / s: of the cloth as a whole, by its kinetic energy
constexpr double k_stirs = 0.015;  ///< m / s
constexpr float k_calms = 0.9f, k_restless = 1.5f, k_shorter = 0.25f, k_longer = 1.02f;

/// Three numbers and a fourth as one vector of the machine: the solver takes x, y and z at once.
using Lanes = float __attribute__((vector_size(16), aligned(4), may_alias));
using Bits = int __attribute__((vector_size(16)));

/// A node's position with its inverse mass, or a force with a compliance.
template <class Four>
Lanes& lanes(Four& four)
{
    static_assert(sizeof(Four) == sizeof(Lanes));
    return reinterpret_cast<Lanes&>(four);
}
template <class Four>
const Lanes& lanes(const Four& four)
{
    static_assert(sizeof(Four) == sizeof(Lanes));
    return reinterpret_cast<const Lanes&>(four);
}
/// Without the fourth.
Lanes vector_of(Lanes v) { return reinterpret_cast<Lanes>(reinterpret_cast<Bits>(v) & Bits{-1, -1, -1, 0}); }
float norm_sq(Lanes v)
{
    const Lanes sq = v * v;
    return sq[0] + sq[1] + sq[2];
}

template <class Thread>
void solve_thread(const Thread& l, std::vector<Moving>& moving)
{
    Moving &a = moving[l.a], &b = moving[l.b];
    const Lanes del = vector_of(lanes(b) - lanes(a));
    const float length_sq = norm_sq(del);
    if (!(l.rest_sq + length_sq > SIMD_EPSILON)) return;
    const float k = (l.rest_sq - length_sq) / (l.stiff * (l.rest_sq + length_sq));
    lanes(a) -= (k * a.inverse_mass) * del;
    lanes(b) += (k * b.inverse_mass) * del;
}

}  // namespace

void Cloth::State::take_nodes()
{
    for (std::size_t i = 0; i < moving.size(); ++i) moving[i] = {cast<float>(previous[i]), node(i).m_im};
}

void Cloth::State::take_links()
{
    if (!links_changed) return;
    links_changed = false;
    for (std::size_t l = 0; l < threads.size(); ++l) {
        const btSoftBody::Link& link = body->m_links[static_cast<int>(l)];
        const float mass = link.m_n[0]->m_im + link.m_n[1]->m_im;
        const float stiff = diagonal[l] == 0 ? mass / link.m_material->m_kLST : 0.f;
        threads[l] = {number(link.m_n[0]), number(link.m_n[1]), stiff, link.m_c1};
    }
    for (const SeamLinks& seam : seams)
        for (int i = 0; i < seam.count && !seam.sewn; ++i) threads[static_cast<std::size_t>(seam.first + i)].stiff = 0;
}

void Cloth::State::advance(const Share& share, Vec3d gravity)
{
    const auto h = static_cast<float>(share.dt);
    const Vec3f falls = cast<float>(share.dt * gravity);
    for (std::size_t i = 0; i < moving.size(); ++i) {
        before[i] = moving[i];
        if (moving[i].inverse_mass > 0) {
            speed[i] += falls;
            moving[i].at += h * speed[i];
        }
        predicted[i] = moving[i].at;
    }
    for (const Pin& pin : pins)
        predicted[pin.node] = moving[pin.node].at = cast<float>(pin.from + share.done * (pin.to - pin.from));
}

void Cloth::State::solve_threads()
{
    for (const Thread& l : threads)
        if (l.stiff > 0) solve_thread(l, moving);
}

void Cloth::State::find_tight()
{
    const auto max_sq = static_cast<float>((1 + k_tight) * (1 + k_tight));
    tight.clear();
    for (std::size_t l = 0; l < threads.size(); ++l) {
        const Thread& t = threads[l];
        if (weak[l] == 0 && t.stiff > 0 && norm_sq(moving[t.a].at - moving[t.b].at) > max_sq * t.rest_sq) tight.push_back(t);
    }
}

void Cloth::State::solve_tight()
{
    if (tight.empty()) return;
    const std::size_t sweeps = std::min(k_max_tight_sweeps, 1 + k_tight_solved / tight.size());
    for (std::size_t k = 0; k < sweeps; ++k)
        for (const Thread& l : tight) solve_thread(l, moving);
}

void Cloth::State::sum_bending()
{
    std::fill(bends.begin(), bends.end(), Bending{});
    for (const Hinge& h : hinges)
        for (std::size_t k = 0; k < 4; ++k) lanes(bends[h.node[k]]) += h.weight[k] * vector_of(lanes(h.bending));
}

void Cloth::State::solve_bending(const Share& share)
{
    // The forces of the last share are there at once: one solution is too little for stiff fabric, but then only has to follow
    // what has changed.
    const auto per_scale = static_cast<float>(share.dt * share.dt), scale = 1 / per_scale,
               loss = static_cast<float>(k_bending_loss / share.dt);
    for (std::size_t i = 0; i < moving.size(); ++i)
        lanes(moving[i]) += (per_scale * moving[i].inverse_mass) * vector_of(lanes(bends[i]));
    for (Hinge& h : hinges) {  // always in this order: to and fro, they would shake the cloth
        const auto [ia, ib, ic, id] = h.node;
        Moving &a = moving[ia], &b = moving[ib], &c = moving[ic], &d = moving[id];
        const Lanes at = lanes(a), from = lanes(before[ia]);
        const Lanes sum = h.weight[1] * (lanes(b) - at) + h.weight[2] * (lanes(c) - at) + h.weight[3] * (lanes(d) - at);
        const Lanes was = h.weight[1] * (lanes(before[ib]) - from) + h.weight[2] * (lanes(before[ic]) - from) +
                          h.weight[3] * (lanes(before[id]) - from);
        const float wa = a.inverse_mass * h.weight[0], wb = b.inverse_mass * h.weight[1], wc = c.inverse_mass * h.weight[2],
                    wd = d.inverse_mass * h.weight[3];
        const float give = wa * h.weight[0] + wb * h.weight[1] + wc * h.weight[2] + wd * h.weight[3];
        const float compliance = h.bending.compliance;
        const Lanes push = vector_of((-1 / ((1 + loss) * give + compliance * scale)) *
                                     (sum + loss * (sum - was) + compliance * lanes(h.bending))),
                    force = scale * push;
        lanes(h.bending) += force;
        lanes(a) += wa * push;
        lanes(b) += wb * push;
        lanes(c) += wc * push;
        lanes(d) += wd * push;
        lanes(bends[ia]) += h.weight[0] * force;
        lanes(bends[ib]) += h.weight[1] * force;
        lanes(bends[ic]) += h.weight[2] * force;
        lanes(bends[id]) += h.weight[3] * force;
    }
}

void Cloth::State::solve_shear(const Share& share)
{
    // A square cell that is sheared by g stretches its one diagonal, of length d, by g d / 2: at twice the modulus of shear it
    // stores the energy of the sheet, whatever the pitch.
    const auto give = static_cast<float>(1 / (2 * fabric.shear * share.dt * share.dt)),
               loss = static_cast<float>(k_shear_loss / share.dt);
    for (const Shear& s : shears) {
        Moving &a = moving[s.a], &b = moving[s.b];
        const Lanes del = vector_of(lanes(b) - lanes(a));
        const float length = std::sqrt(norm_sq(del)), was = std::sqrt(norm_sq(lanes(before[s.b]) - lanes(before[s.a])));
        const float mass = a.inverse_mass + b.inverse_mass;
        if (!(length > 0.f)) continue;
        const float longer = length - s.rest + loss * (length - was);
        const float k = longer / (length * ((1 + loss) * mass + give));
        lanes(a) += (k * a.inverse_mass) * del;
        lanes(b) -= (k * b.inverse_mass) * del;
    }
}

void Cloth::State::push_interiors_out(const Share* share)
{
    const float yet = share != nullptr ? static_cast<float>(1 - share->done) : 0.f;
    const auto mu = static_cast<float>(fabric.friction);
    for (InteriorSpace& s : interiors.all()) {
        Moving* n[3];
        Vec3f x{};
        float give = 0;
        for (int k = 0; k < 3; ++k) {
            n[k] = &moving[s.nodes[static_cast<std::size_t>(k)]];
            x += s.weights[k] * n[k]->at;
            give += s.weights[k] * s.weights[k] * n[k]->inverse_mass;
        }
        const float below = s.offset - yet * dot(s.normal, s.motion) - dot(s.normal, x);
        if (!(below > 0.f) || !(give > 0.f)) continue;
        s.push += below;
        Vec3f moves = below * s.normal;
        if (share != nullptr && options.friction == Friction::Coulomb) {
            Vec3f slip = -static_cast<float>(share->part) * s.motion;
            for (int k = 0; k < 3; ++k) {
                const std::uint32_t i = s.nodes[static_cast<std::size_t>(k)];
                slip += s.weights[k] * (static_cast<float>(share->dt) * speed[i] + (n[k]->at - predicted[i]));
            }
            slip -= dot(slip, s.normal) * s.normal;
            const float length = norm(slip), max_grip = mu * below;
            moves -= (length > max_grip ? max_grip / length : 1.f) * slip;
        }
        for (int k = 0; k < 3; ++k) n[k]->at += (s.weights[k] * n[k]->inverse_mass / give) * moves;
    }
}

void Cloth::State::push_out(const Share& share)
{
    const double ahead = 1 - share.done;
    push_interiors_out(&share);
    const auto mu = static_cast<float>(fabric.friction), yet = static_cast<float>(ahead), part = static_cast<float>(share.part);
    const auto h = static_cast<float>(share.dt);
    for (HalfSpace& s : contacts.all()) {
        Moving& n = moving[s.node];
        if (!(n.inverse_mass > 0)) continue;
        const float height = dot(s.normal, n.at) - s.offset + yet * dot(s.normal, s.motion);
        if (!(height < 0.f)) continue;
        s.push -= height;
        n.at -= height * s.normal;
        // Friction undoes the slip of this share, but no more of it than the cone (or eq. 33) allows.
        float max_grip = -mu * height;
        if (options.friction == Friction::None)
            max_grip = 0;
        else if (options.friction == Friction::Paper)
            max_grip = static_cast<float>(
                           friction_size({options.paper_friction, options.paper_stiffness}, static_cast<double>(s.depth)) *
                           share.dt * share.dt) *
                       n.inverse_mass;
        Vec3f slip = h * speed[s.node] + (n.at - predicted[s.node]) - part * s.motion;
        slip -= dot(slip, s.normal) * s.normal;
        const float length = norm(slip);
        n.at -= (length > max_grip ? max_grip / length : 1.f) * slip;
    }
}

void Cloth::State::push_out_last()
{
    push_interiors_out(nullptr);
    const float mu = options.friction == Friction::Coulomb ? static_cast<float>(fabric.friction) : 0.f;
    for (HalfSpace& s : contacts.all()) {
        Moving& n = moving[s.node];
        if (!(n.inverse_mass > 0)) continue;
        const float height = dot(s.normal, n.at) - s.offset;
        if (!(height < 0.f)) continue;
        s.push -= height;
        n.at -= height * s.normal;
        Vec3f slip = n.at - cast<float>(previous[s.node]) - s.motion;
        slip -= dot(slip, s.normal) * s.normal;
        const float length = norm(slip), max_grip = -mu * height;  // eq. 33 acted in the shares, and does not grow with the push
        n.at -= (length > max_grip ? max_grip / length : 1.f) * slip;
    }
}

void Cloth::State::take_speeds(double dt)
{
    // The solution alone changes the speed: a node's path has rounding in it.
    const auto keep = static_cast<float>(std::exp(-fabric.damping * dt)), per = static_cast<float>(1 / dt);
    for (std::size_t i = 0; i < moving.size(); ++i) speed[i] = keep * (speed[i] + per * (moving[i].at - predicted[i]));
}

void Cloth::State::limit(double dt, StepReport& report)
{
    const double farthest = options.max_speed * dt;
    for (std::size_t i = 0; i < position.size(); ++i) {
        position[i] = cast<double>(moving[i].at);
        const Vec3d path = position[i] - previous[i];
        const double path_sq = norm_sq(path);
        if (!(path_sq > farthest * farthest) || !(moving[i].inverse_mass > 0)) continue;
        const double share = farthest / std::sqrt(path_sq);
        moving[i].at = cast<float>(previous[i] + share * path);
        speed[i] = static_cast<float>(share) * speed[i];
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
    // Corrections after the shares count as if they had come evenly.
    for (std::size_t i = 0; i < n; ++i)
        velocity[i] = cast<double>(speed[i]) + (1 / dt) * (position[i] - cast<double>(predicted[i]));
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
        speed[i] = cast<float>(velocity[i]);
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
