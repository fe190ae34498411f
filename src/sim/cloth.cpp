#include "sqmap/sim/cloth.h"

#include "cloth_state.h"
#include "contacts.h"
#include "sim/crossings.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace sqmap::sim {

namespace {

constexpr int k_last_pushes = 3;  ///< a node between several surfaces needs more than one
constexpr int k_self_pushes = 8;  ///< at most: stop() puts back pairs that still cross

/// True where the time is positive, the poses are finite, and no collider has a skin that expect() was not told of.
bool can_step(double dt, std::span<const Collider> colliders, bool expects_skins)
{
    return std::isfinite(dt) && dt > 0 && std::all_of(colliders.begin(), colliders.end(), [&](const Collider& collider) {
               return is_finite(collider.pose) && is_finite(collider.previous) && (collider.skin == nullptr || expects_skins);
           });
}

}  // namespace

Cloth::~Cloth() = default;
Cloth::Cloth(Cloth&&) noexcept = default;
Cloth& Cloth::operator=(Cloth&&) noexcept = default;

void Cloth::expect(const query::SkinLattice& lattice)
{
    state_->contacts.expect(lattice, state_->position);
    state_->interiors.expect(lattice, state_->position);
    state_->settling.expect(lattice);
}

std::size_t Cloth::settle(std::span<const Collider> colliders) noexcept
{
    State& s = *state_;
    // A pull draws the edges of a seam millimetres apart, and skin would be seen between them.
    s.settling.begin_seams();
    for (const State::SeamLinks& seam : s.seams)
        for (int i = 0; i < seam.count && seam.is_closed(); ++i) {
            const btSoftBody::Link& l = s.body->m_links[seam.first + i];
            s.settling.join(s.number(l.m_n[0]), s.number(l.m_n[1]));
        }
    const std::size_t moved = s.settling.run({s.position, s.moving, s.contacts.normals(), s.interiors.all()}, colliders);
    for (std::size_t i = 0; i < s.position.size(); ++i) s.node(i).m_x = to_bullet(s.position[i]);
    return moved;
}

StepReport Cloth::step(double dt, std::span<const Collider> colliders) noexcept
{
    State& s = *state_;
    StepReport report;
    if (!can_step(dt, colliders, s.contacts.expects_skins())) {
        report.status = k_cloth_bad_step;
        return report;
    }
    const bool colliders_stand = all_stand(colliders);
    const double start = cpu_seconds();
    // The tailor's hands carry a garment until it is sewn.
    const bool sewing =
        std::any_of(s.seams.begin(), s.seams.end(), [](const State::SeamLinks& l) { return l.carried && l.age < k_sewing_time; });
    const Vec3d gravity = sewing ? Vec3d{} : s.options.gravity;
    const int shares = std::max(1, s.options.iterations);
    State::Share share{dt / shares, 0, 1.0 / shares};
    s.move_pins(colliders);
    s.set_seams(dt);
    s.previous.swap(s.position);
    s.take_nodes();
    s.take_links();
    s.find_tight();
    s.sum_bending();
    s.contacts.ride(colliders);
    s.interiors.ride(colliders);
    double mark = cpu_seconds();
    report.seconds.predict = mark - start;
    if (s.self) {
        s.self->begin(s.previous);
        const double now = cpu_seconds();
        report.seconds.self += now - mark;
        mark = now;
    }
    // Threads pull against the half-spaces of the last step; nodes that they pulled into a collider, or through one, are found
    // afterwards and pushed out last.
    s.tension = {};
    for (int i = 0; i < shares; ++i) {
        share.done = static_cast<double>(i + 1) / shares;
        s.advance(share, gravity);
        s.solve_bending(share);
        s.solve_shear(share);
        s.solve_threads();
        s.solve_tight();
        s.solve_held(share);
        s.solve_pulled();
        double threads = cpu_seconds();
        report.seconds.threads += threads - mark;
        if (s.self) {
            mark = threads;
            s.self->solve(s.previous, s.moving, s.fabric.friction);
            threads = cpu_seconds();
            report.seconds.self += threads - mark;
        }
        s.push_out(share);
        s.take_speeds(share.dt);
        mark = cpu_seconds();
        report.seconds.response += mark - threads;
    }
    for (std::size_t i = 0; i < s.moving.size(); ++i) s.predicted[i] = s.moving[i].at;
    s.limit(dt, report);
    report.seconds.predict += cpu_seconds() - mark;
    report.status |= s.contacts.find({s.previous, s.position}, colliders, report);
    mark = cpu_seconds();
    s.interiors.find({s.position, s.contacts.normals(), s.contacts.rests()}, colliders);
    report.seconds.query += cpu_seconds() - mark;
    mark = cpu_seconds();
    for (int i = 0; i < k_last_pushes; ++i) s.push_out_last();
    report.seconds.response += cpu_seconds() - mark;
    mark = cpu_seconds();
    if (s.self) {
        s.self->find(s.previous, s.moving, s.names);
        for (int i = 0; i < k_self_pushes && s.self->push_apart(s.previous, s.moving) > 0; ++i) s.push_out_last();
        report.seconds.self += cpu_seconds() - mark;
        mark = cpu_seconds();
    }
    s.finish(dt, colliders_stand, report);
    report.seconds.predict += cpu_seconds() - mark;
    return report;
}

std::size_t Cloth::size() const noexcept { return state_->position.size(); }
std::span<const std::array<std::uint32_t, 3>> Cloth::triangles() const noexcept { return state_->triangles; }
std::span<const Vec3d> Cloth::positions() const noexcept { return state_->position; }
std::span<const Vec3d> Cloth::query_points() const noexcept { return state_->contacts.query_points(); }
std::span<const Vec3d> Cloth::velocities() const noexcept { return state_->velocity; }

std::vector<double> Cloth::strain() const
{
    const State& s = *state_;
    std::map<std::array<std::uint32_t, 2>, double> stretch;
    for (int l = 0; l < s.body->m_links.size(); ++l) {
        const btSoftBody::Link& link = s.body->m_links[l];
        if (!(link.m_rl > 0) || s.diagonal[static_cast<std::size_t>(l)] != 0) continue;
        const std::uint32_t a = s.number(link.m_n[0]), b = s.number(link.m_n[1]);
        stretch[{std::min(a, b), std::max(a, b)}] = norm(s.position[a] - s.position[b]) / static_cast<double>(link.m_rl) - 1;
    }
    std::vector<double> sum(size()), count(size());
    for (const auto& t : s.triangles) {
        double largest = -1;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto found = stretch.find({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
            if (found != stretch.end()) largest = std::max(largest, found->second);
        }
        for (const std::uint32_t v : t) {
            sum[v] += largest;
            count[v] += 1;
        }
    }
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = count[i] > 0 ? sum[i] / count[i] : 0;
    return sum;
}

std::size_t Cloth::crossings() const { return sim::crossings(state_->position, state_->triangles, state_->names); }

void Drape::add(const StepReport& step, double time) noexcept
{
    report_.fastest = step.fastest;
    report_.fastest_node = step.fastest_node;
    if (!(step.fastest <= threshold_))
        quiet_since_ = -1;
    else if (quiet_since_ < 0)
        quiet_since_ = time;
    report_.at_rest = quiet_since_ >= 0 && time - quiet_since_ >= k_quiet;
    report_.since = report_.at_rest ? quiet_since_ : 0;
}

}  // namespace sqmap::sim
