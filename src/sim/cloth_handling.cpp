// Holding, pulling, cutting and sewing a cloth.
#include "cloth_state.h"

#include <algorithm>
#include <stdexcept>

namespace sqmap::sim {

void Cloth::State::set_seams(double dt)
{
    for (SeamLinks& seam : seams) {
        if (seam.age <= k_sewing_time) links_changed = true;
        seam.age += dt;
        const double share = std::clamp(1 - seam.age / k_sewing_time, 0.0, 1.0);
        for (int i = 0; i < seam.count; ++i) {
            btSoftBody::Link& l = body->m_links[seam.first + i];
            const btScalar rest = static_cast<btScalar>(share) * seam.gap[static_cast<std::size_t>(i)];
            l.m_c1 = rest * rest;
        }
    }
}

void Cloth::State::move_pins(std::span<const Collider> colliders)
{
    for (Pin& pin : pins) {
        pin.from = position[pin.node];
        pin.to = pin.collider < colliders.size() ? apply(colliders[pin.collider].pose, pin.local) : pin.local;
    }
}

void Cloth::State::solve_held(const Share& s)
{
    const double dt = s.dt, share = s.part;
    const double give = 1 / (grip_stiffness / static_cast<double>(held.size()) * dt * dt);
    for (Held& h : held) {
        Moving& n = moving[h.node];
        const double w = static_cast<double>(n.inverse_mass);
        const Vec3d off = cast<double>(n.at) - (tool + h.offset);
        const Vec3d push = (-1 / (w + give)) * off;
        tension -= (share / (dt * dt)) * push;
        n.at += cast<float>(w * push);
    }
}

void Cloth::pin(std::span<const std::uint32_t> nodes, std::uint32_t collider, const Pose& pose)
{
    State& s = *state_;
    for (const std::uint32_t n : nodes) {
        if (n >= size()) throw std::invalid_argument("a pin names a node that is not there");
        const Vec3d local = collider == k_world ? s.position[n] : apply(inverse(pose), s.position[n]);
        s.pins.push_back({n, collider, local, s.position[n], s.position[n], s.body->getMass(static_cast<int>(n))});
        s.body->setMass(static_cast<int>(n), 0);
    }
    s.links_changed = true;
}

void Cloth::unpin(std::span<const std::uint32_t> nodes)
{
    State& s = *state_;
    for (const std::uint32_t n : nodes) {
        const auto found = std::find_if(s.pins.begin(), s.pins.end(), [n](const State::Pin& p) { return p.node == n; });
        if (found == s.pins.end()) continue;
        s.body->setMass(static_cast<int>(n), found->mass);
        s.pins.erase(found);
    }
    s.links_changed = true;
}

std::size_t Cloth::seams() const noexcept { return state_->seams.size(); }
void Cloth::cut(std::size_t seam)
{
    state_->seams.at(seam).sewn = false;
    state_->links_changed = true;
    state_->names = state_->sewn_names();
    state_->find_pulled();
}

void Cloth::sew(std::size_t seam)
{
    State& s = *state_;
    State::SeamLinks& links = s.seams.at(seam);
    for (int i = 0; i < links.count; ++i) {
        const btSoftBody::Link& l = s.body->m_links[links.first + i];
        links.gap[static_cast<std::size_t>(i)] = (l.m_n[0]->m_x - l.m_n[1]->m_x).length();
    }
    links.age = 0;
    links.carried = false;
    links.sewn = true;
    s.links_changed = true;
    s.names = s.sewn_names();
    s.find_pulled();
}

double Cloth::gap(std::size_t seam) const
{
    const State& s = *state_;
    const State::SeamLinks& links = s.seams.at(seam);
    double widest = 0;
    for (int i = 0; i < links.count; ++i) {
        const btSoftBody::Link& l = s.body->m_links[links.first + i];
        widest = std::max(widest, static_cast<double>((l.m_n[0]->m_x - l.m_n[1]->m_x).length()));
    }
    return widest;
}

void Cloth::grasp(std::uint32_t node, double radius, Vec3d tool, double stiffness)
{
    State& s = *state_;
    if (node >= size()) throw std::invalid_argument("a grasp of a node that is not there");
    if (!(stiffness > 0) || !std::isfinite(stiffness)) throw std::invalid_argument("a grip's stiffness must be above zero");
    release();
    for (std::uint32_t i = 0; i < size(); ++i)
        if ((i == node || norm(s.position[i] - s.position[node]) <= radius) && s.node(i).m_im > 0)
            s.held.push_back({i, s.position[i] - tool});
    s.tool = tool;
    s.grip_stiffness = stiffness;
    s.find_pulled();
}

void Cloth::drag(Vec3d tool) noexcept
{
    if (is_finite(tool)) state_->tool = tool;
}

void Cloth::release()
{
    state_->held.clear();
    state_->pulled.clear();
    state_->tension = {};
}

Vec3d Cloth::tension() const noexcept { return state_->tension; }

}  // namespace sqmap::sim
