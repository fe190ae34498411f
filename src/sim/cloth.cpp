#include "sqmap/sim/cloth.h"

#include "contacts.h"
#include "cpu_time.h"
#include "interiors.h"
#include "self_contacts.h"
#include "sqmap/sim/crossings.h"

#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyInternals.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <stdexcept>

namespace sqmap::sim {

namespace {

constexpr int k_last_pushes = 3;                  ///< a node between several surfaces needs more than one
constexpr std::uint32_t k_looks_at_threads = 16;  ///< steps
constexpr int k_self_pushes = 8;                  ///< at most: what goes through itself on the way is put back
constexpr double k_hard_push = 2;                 ///< times thickness: a node that is pushed farther stops where it is
// A node that threads and two surfaces throw to and fro is held on a leash, how far it may go in a step: it counts as restless
// while it turns back more often than about every fifth step, faster than k_stirs.
constexpr double k_calm = 0.2;     ///< m / s: of the cloth as a whole, by its kinetic energy
constexpr double k_stirs = 0.015;  ///< m / s
constexpr float k_calms = 0.9f, k_restless = 1.5f, k_shorter = 0.25f, k_longer = 1.02f;
constexpr double k_sewing_time = 0.5;  ///< s: in which a seam is drawn together

btVector3 to_bullet(Vec3d v) { return {static_cast<btScalar>(v.x), static_cast<btScalar>(v.y), static_cast<btScalar>(v.z)}; }
void check(const Garment& garment)
{
    const std::size_t n = garment.start.size();
    if (garment.flat.size() != n)
        throw std::invalid_argument("a garment's flat pattern has another number of vertices than its start");
    if (garment.triangles.empty()) throw std::invalid_argument("a garment without triangles");
    for (const auto& t : garment.triangles)
        for (const std::uint32_t v : t)
            if (v >= n) throw std::invalid_argument("a garment's triangle names a vertex that is not there");
    for (const Seam& seam : garment.seams)
        for (const auto& pair : seam.pairs)
            if (pair[0] >= n || pair[1] >= n)
                throw std::invalid_argument("seam '" + seam.name + "' names a vertex that is not there");
    for (std::size_t i = 0; i < n; ++i)
        if (!is_finite(garment.start[i]) || !is_finite(garment.flat[i]))
            throw std::invalid_argument("a garment's vertex is not finite");
}

}  // namespace

struct Cloth::State {
    struct SeamLinks {
        int first = 0, count = 0;  ///< of the body's links
        bool sewn = true;
        std::vector<btScalar> gap;  ///< rest lengths at the time of sewing
        double age = 0;             ///< negative while it waits for those that are sewn before it
        bool carried = true;        ///< the first sewing
    };
    struct Pin {
        std::uint32_t node, collider;
        Vec3d place;  ///< in the collider's frame
        btScalar mass;
    };
    struct Restless {
        Vec3f way{};                    ///< when it last stirred
        float turns = 0, leash = 1e9f;  ///< lately; m
    };
    /// A node on a spring to its place in a tool's grip.
    struct Held {
        std::uint32_t node;
        Vec3d place;  ///< from the tool
        Vec3d pull;   ///< kg m: what the spring did in this step, times dt^2
    };
    /// A link between two nodes: with Moving what Bullet's own have, in an eighth of the bytes. They are gone through a dozen
    /// times a step, and what they push out of the caches the contacts wait for.
    struct Thread {
        std::uint32_t a, b;
        float stiff, rest_sq;  ///< Bullet's c0: inverse masses over stiffness, not positive where it is cut; c1
    };

    State(const Garment& garment, const Fabric& f, const ClothOptions& o)
        : fabric(f),
          options(o),
          triangles(garment.triangles),
          contacts(garment.start, f.thickness, o.sweep_step, o.layer),
          interiors(garment.triangles, f.thickness, o.layer)
    {
        info.m_gravity = to_bullet(o.gravity);
        const std::size_t n = garment.start.size();
        std::vector<btVector3> x(n);
        for (std::size_t i = 0; i < n; ++i) x[i] = to_bullet(garment.start[i]);
        body = std::make_unique<btSoftBody>(&info, static_cast<int>(n), x.data(), nullptr);
        body->getCollisionShape()->setMargin(static_cast<btScalar>(f.thickness));
        body->m_cfg.kDF = static_cast<btScalar>(std::min(1.0, f.friction));
        body->m_cfg.kSHR = 1;
        add_threads(garment);
        add_mass(garment);
        add_seams(garment);
        body->m_bUpdateRtCst = false;  // Bullet would take the start for the rest shape
        body->updateLinkConstants();
        if (o.self_collision) self = std::make_unique<SelfContacts>(garment.start, triangles, f.thickness);
        moving.resize(n);
        restless.resize(n);
        threads.resize(static_cast<std::size_t>(body->m_links.size()));
        weak.resize(threads.size(), 1);
        for (int l = 0; l < (seams.empty() ? body->m_links.size() : seams.front().first); ++l)
            weak[static_cast<std::size_t>(l)] = body->m_links[l].m_bbending ? 1 : 0;
        position.assign(garment.start.begin(), garment.start.end());
        velocity.resize(n);
        previous = good = position;
        names = sewn_names();
    }

    void add_threads(const Garment& garment)
    {
        const auto material = [&](double stiffness) {
            btSoftBody::Material* m = body->appendMaterial();
            m->m_kLST = static_cast<btScalar>(std::clamp(stiffness, 0.0, 1.0));
            return m;
        };
        btSoftBody::Material *along = material(fabric.stretch), *across = material(fabric.shear), *bend = material(fabric.bend);
        struct Edge {
            std::uint32_t opposite[2] = {};
            int count = 0;
        };
        std::map<std::array<std::uint32_t, 2>, Edge> edges;
        for (const auto& t : garment.triangles) {
            body->appendFace(static_cast<int>(t[0]), static_cast<int>(t[1]), static_cast<int>(t[2]));
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = t[k], b = t[(k + 1) % 3];
                Edge& edge = edges[{std::min(a, b), std::max(a, b)}];
                if (edge.count < 2) edge.opposite[edge.count] = t[(k + 2) % 3];
                ++edge.count;
            }
        }
        const auto link = [&](std::uint32_t a, std::uint32_t b, btSoftBody::Material* m) {
            body->appendLink(static_cast<int>(a), static_cast<int>(b), m, false);
            btSoftBody::Link& l = body->m_links[body->m_links.size() - 1];
            l.m_rl = static_cast<btScalar>(norm(garment.flat[a] - garment.flat[b]));
            l.m_c1 = l.m_rl * l.m_rl;
            l.m_bbending = m == bend ? -1 : 0;
        };
        for (const auto& [ends, edge] : edges) {
            // The longest edge of both its triangles is a diagonal of the weave.
            const double length = norm(garment.flat[ends[0]] - garment.flat[ends[1]]);
            bool longest = edge.count == 2;
            for (int k = 0; k < std::min(edge.count, 2); ++k)
                for (const std::uint32_t end : ends)
                    longest = longest && length > norm(garment.flat[edge.opposite[k]] - garment.flat[end]);
            link(ends[0], ends[1], longest ? across : along);
            if (edge.count == 2) link(edge.opposite[0], edge.opposite[1], bend);
        }
        body->randomizeConstraints();  // a sweep in the order of the weave would pull to one side
    }

    void add_mass(const Garment& garment)
    {
        std::vector<double> mass(garment.start.size());
        for (const auto& t : garment.triangles) {
            const double area =
                0.5 * norm(cross(garment.flat[t[1]] - garment.flat[t[0]], garment.flat[t[2]] - garment.flat[t[0]]));
            for (const std::uint32_t v : t) mass[v] += fabric.density * area / 3;
        }
        for (std::size_t i = 0; i < mass.size(); ++i)
            body->setMass(static_cast<int>(i), static_cast<btScalar>(std::max(mass[i], 1e-9)));
    }

    void add_seams(const Garment& garment)
    {
        btSoftBody::Material* thread = body->appendMaterial();
        thread->m_kLST = 1;
        // One after the other: panels whose edges are all drawn together at once bulge, and their edges come so near each other
        // that an arm between them may keep them apart.
        double before = 0;
        for (const Seam& seam : garment.seams) {
            SeamLinks links;
            const bool closed = std::all_of(seam.pairs.begin(), seam.pairs.end(), [&](const auto& pair) {
                return norm(garment.start[pair[0]] - garment.start[pair[1]]) <= fabric.thickness;
            });
            links.age = closed ? k_sewing_time : -before;
            if (seam.sewn && !closed) before += k_sewing_time;
            links.first = body->m_links.size();
            links.sewn = links.carried = seam.sewn;
            for (const auto& pair : seam.pairs)
                body->appendLink(static_cast<int>(pair[0]), static_cast<int>(pair[1]), thread, false);
            links.count = body->m_links.size() - links.first;
            for (int i = 0; i < links.count; ++i) links.gap.push_back(body->m_links[links.first + i].m_rl);
            seams.push_back(std::move(links));
        }
    }

    /// A number for each node, the same for those that are sewn together.
    std::vector<std::uint32_t> sewn_names() const
    {
        std::vector<std::uint32_t> name(position.size());
        std::iota(name.begin(), name.end(), 0u);
        const auto root = [&](std::uint32_t v) {
            while (name[v] != v) v = name[v] = name[name[v]];
            return v;
        };
        for (const SeamLinks& seam : seams)
            for (int i = 0; i < seam.count && seam.sewn; ++i) {
                const btSoftBody::Link& l = body->m_links[seam.first + i];
                const std::uint32_t a = root(number(l.m_n[0])), b = root(number(l.m_n[1]));
                name[std::max(a, b)] = std::min(a, b);
            }
        for (std::uint32_t v = 0; v < name.size(); ++v) name[v] = root(v);
        return name;
    }

    btSoftBody::Node& node(std::size_t i) { return body->m_nodes[static_cast<int>(i)]; }
    std::uint32_t number(const btSoftBody::Node* n) const { return static_cast<std::uint32_t>(n - &body->m_nodes[0]); }

    void set_seams(double dt)
    {
        for (SeamLinks& seam : seams) {
            seam.age += dt;
            const double share = std::clamp(1 - seam.age / k_sewing_time, 0.0, 1.0);
            for (int i = 0; i < seam.count; ++i) {
                btSoftBody::Link& l = body->m_links[seam.first + i];
                const btScalar rest = static_cast<btScalar>(share) * seam.gap[static_cast<std::size_t>(i)];
                l.m_c0 = seam.sewn ? l.m_n[0]->m_im + l.m_n[1]->m_im : 0;
                l.m_c1 = rest * rest;
            }
        }
    }

    void place_pins(std::span<const Collider> colliders)
    {
        for (const Pin& pin : pins) {
            const Vec3d at = pin.collider < colliders.size() ? apply(colliders[pin.collider].pose, pin.place) : pin.place;
            node(pin.node).m_x = to_bullet(at);
        }
    }

    /// From Bullet's nodes and links, after it has predicted; links alone where one has changed.
    void take_nodes()
    {
        for (std::size_t i = 0; i < moving.size(); ++i) {
            const btSoftBody::Node& n = node(i);
            moving[i] = {{n.m_x.x(), n.m_x.y(), n.m_x.z()}, n.m_im};
        }
    }
    void take_links()
    {
        for (std::size_t l = 0; l < threads.size(); ++l) {
            const btSoftBody::Link& link = body->m_links[static_cast<int>(l)];
            threads[l] = {number(link.m_n[0]), number(link.m_n[1]), link.m_c0, link.m_c1};
        }
    }

    /// A sweep of Bullet's PSolve_Links.
    void solve_threads()
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

    /// The springs of the grip, by extended position-based dynamics (Macklin et al. 2016): as stiff as they are said to be,
    /// whatever the step and the sweeps.
    void solve_held(double dt)
    {
        const double give = 1 / (grip_stiffness / static_cast<double>(held.size()) * dt * dt);
        for (Held& h : held) {
            Moving& n = moving[h.node];
            const double w = static_cast<double>(n.inverse_mass);
            const Vec3d off = cast<double>(n.at) - (tool + h.place);
            const Vec3d more = (-1 / (w + give)) * (off + give * h.pull);
            h.pull += more;
            n.at += cast<float>(w * more);
        }
    }

    /// Raises the nodes of triangles in which a collider is, each as it weighs at the place.
    void push_interiors_out()
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

    /// last: after the step's new half-spaces were found.
    void push_out(double dt, bool last)
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
            if (last && options.friction == Friction::Paper) {  // has acted already: it does not grow with the push
                n.at = x;
                continue;
            }
            Vec3f slip = x - cast<float>(previous[s.node]) - s.motion;
            slip -= dot(slip, s.normal) * s.normal;
            // Friction's sum so far, less the slip, but no longer than the cone (or what eq. 33 says) allows.
            float most = mu * s.push;
            if (options.friction == Friction::None)
                most = 0;
            else if (options.friction == Friction::Paper)
                most = static_cast<float>(
                           friction_size({options.paper_friction, options.paper_stiffness}, static_cast<double>(s.depth)) * dt *
                           dt) *
                       n.inverse_mass;
            Vec3f grip = s.grip - slip;
            const float length = norm(grip);
            if (length > most) grip = (most / length) * grip;
            x += grip - s.grip;
            s.grip = grip;
            n.at = x;
        }
    }

    /// No node goes farther in the step than max_speed allows: the sweep has to follow it.
    void limit(double dt, StepReport& report)
    {
        const double most = options.max_speed * dt;
        for (std::size_t i = 0; i < position.size(); ++i) {
            position[i] = cast<double>(moving[i].at);
            const Vec3d way = position[i] - previous[i];
            const double way_sq = norm_sq(way);
            if (!(way_sq > most * most) || !(moving[i].inverse_mass > 0)) continue;
            moving[i].at = cast<float>(previous[i] + (most / std::sqrt(way_sq)) * way);
            position[i] = cast<double>(moving[i].at);
            report.status |= k_cloth_slowed;
        }
    }

    /// Nodes that go to and fro without end are stilled, where no collider moves and the cloth as a whole hardly does.
    void still_restless(double dt, bool colliders_stand)
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
            const Vec3f way = cast<float>(position[i] - previous[i]);
            const float length = norm(way);
            r.turns *= k_calms;
            r.leash *= k_longer;
            if (length > stirs) {
                if (dot(way, r.way) < 0) r.turns += 1;
                r.way = way;
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

    void finish(double dt, bool colliders_stand, StepReport& report)
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
            report.seconds.predict -= took;  // which counts the whole of this
        }
        for (std::size_t i = 0; i < n; ++i) velocity[i] = (keep / dt) * (position[i] - previous[i]);
        if (!all_finite) {
            report.status |= k_cloth_not_finite;
            position = previous = good;
            std::fill(velocity.begin(), velocity.end(), Vec3d{});
        } else {
            good = position;
            // Pushing out is no bounce: what leaves a surface faster than it was hit does so at the surface's own speed.
            for (const HalfSpace& s : contacts.all()) {
                if (s.push <= 0.f) continue;
                const Vec3d normal = cast<double>(s.normal);
                const double leaves = dot(velocity[s.node] - cast<double>(s.motion) / dt, normal);
                if (leaves > 0) velocity[s.node] -= leaves * normal;
                // Where threads and a surface pull a node to and fro, it does not gain by it.
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

    /// Whether a quarter of the threads, diagonals of the weave too, are longer than k_max_stretch allows; looked at now and
    /// then.
    bool stretched()
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

    Fabric fabric;
    ClothOptions options;
    btSoftBodyWorldInfo info;
    std::unique_ptr<btSoftBody> body;
    std::vector<Moving> moving;
    std::vector<Restless> restless;
    double last_kinetic = 0;
    std::vector<std::uint8_t> weak;  ///< links that resist bending alone, and seams
    std::uint32_t steps = 0;
    bool was_stretched = false;
    std::vector<Thread> threads;  ///< Bullet's links, in their order
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<Vec3d> position, previous, good, velocity;
    std::vector<SeamLinks> seams;
    std::vector<Pin> pins;
    std::vector<Held> held;
    double grip_stiffness = 0;  ///< N / m, of all the springs
    Vec3d tool{}, tension{};
    std::unique_ptr<SelfContacts> self;  ///< where asked for
    std::vector<std::uint32_t> names;    ///< of nodes, as they are sewn
    Contacts contacts;
    Interiors interiors;
};

Cloth::Cloth(const Garment& garment, const Fabric& fabric, const ClothOptions& options)
{
    check(garment);
    state_ = std::make_unique<State>(garment, fabric, options);
}
Cloth::~Cloth() = default;
Cloth::Cloth(Cloth&&) noexcept = default;
Cloth& Cloth::operator=(Cloth&&) noexcept = default;

void Cloth::expect(const query::SkinLattice& lattice) { state_->contacts.expect(lattice, state_->position); }

StepReport Cloth::step(double dt, std::span<const Collider> colliders) noexcept
{
    State& s = *state_;
    StepReport report;
    bool good = std::isfinite(dt) && dt > 0;
    for (const Collider& collider : colliders)
        good = good && is_finite(collider.pose) && is_finite(collider.previous) &&
               (collider.skin == nullptr || s.contacts.expects_skins());
    if (!good) {
        report.status = k_cloth_bad_step;
        return report;
    }
    bool colliders_stand = true;
    for (const Collider& collider : colliders) colliders_stand = colliders_stand && stands(collider);
    const double start = cpu_seconds();
    btSoftBody& body = *s.body;
    // The tailor's hands carry a garment until it is sewn.
    const bool sewing =
        std::any_of(s.seams.begin(), s.seams.end(), [](const State::SeamLinks& l) { return l.carried && l.age < k_sewing_time; });
    s.info.m_gravity = sewing ? btVector3(0, 0, 0) : to_bullet(s.options.gravity);
    body.predictMotion(static_cast<btScalar>(dt));
    s.place_pins(colliders);
    s.set_seams(dt);
    s.take_nodes();
    s.take_links();
    s.previous.swap(s.position);  // Bullet predicts from there, in float
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
    // Threads pull against the half-spaces that the last step found; what they pulled into a collider, or through one, is found
    // afterwards and has the last word.
    for (State::Held& h : s.held) h.pull = {};
    for (int i = 0; i < s.options.iterations; ++i) {
        s.solve_threads();
        s.solve_held(dt);
        double threads = cpu_seconds();
        report.seconds.threads += threads - mark;
        if (s.self) {
            mark = threads;
            s.self->solve(s.previous, s.moving, s.fabric.friction);
            threads = cpu_seconds();
            report.seconds.self += threads - mark;
        }
        s.push_out(dt, false);
        mark = cpu_seconds();
        report.seconds.response += mark - threads;
    }
    s.limit(dt, report);
    report.seconds.predict += cpu_seconds() - mark;
    report.status |= s.contacts.find(s.previous, s.position, colliders, report);
    mark = cpu_seconds();
    s.interiors.find(s.position, s.contacts.touched(), colliders, s.contacts.rests());
    report.seconds.query += cpu_seconds() - mark;
    mark = cpu_seconds();
    for (int i = 0; i < k_last_pushes; ++i) s.push_out(dt, true);
    report.seconds.response += cpu_seconds() - mark;
    mark = cpu_seconds();
    if (s.self) {
        s.self->find(s.previous, s.moving, s.names);
        for (int i = 0; i < k_self_pushes && s.self->push_apart(s.previous, s.moving) > 0; ++i) s.push_out(dt, true);
        report.seconds.self += cpu_seconds() - mark;
        mark = cpu_seconds();
    }
    s.tension = {};
    for (const State::Held& h : s.held) s.tension -= h.pull / (dt * dt);
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
        if (link.m_bbending || !(link.m_rl > 0)) continue;
        const std::uint32_t a = s.number(link.m_n[0]), b = s.number(link.m_n[1]);
        stretch[{std::min(a, b), std::max(a, b)}] = norm(s.position[a] - s.position[b]) / static_cast<double>(link.m_rl) - 1;
    }
    std::vector<double> sum(size()), count(size());
    for (const auto& t : s.triangles) {
        double most = -1;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto found = stretch.find({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
            if (found != stretch.end()) most = std::max(most, found->second);
        }
        for (const std::uint32_t v : t) {
            sum[v] += most;
            count[v] += 1;
        }
    }
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = count[i] > 0 ? sum[i] / count[i] : 0;
    return sum;
}

std::size_t Cloth::crossings() const { return sim::crossings(state_->position, state_->triangles, state_->names); }

void Cloth::pin(std::span<const std::uint32_t> nodes, std::uint32_t collider, const Pose& pose)
{
    State& s = *state_;
    for (const std::uint32_t n : nodes) {
        if (n >= size()) throw std::invalid_argument("a pin names a node that is not there");
        const Vec3d place = collider == k_world ? s.position[n] : apply(inverse(pose), s.position[n]);
        s.pins.push_back({n, collider, place, s.body->getMass(static_cast<int>(n))});
        s.body->setMass(static_cast<int>(n), 0);
    }
    s.body->m_bUpdateRtCst = false;
    s.body->updateLinkConstants();
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
    s.body->m_bUpdateRtCst = false;
    s.body->updateLinkConstants();
}

std::size_t Cloth::seams() const noexcept { return state_->seams.size(); }
void Cloth::cut(std::size_t seam)
{
    state_->seams.at(seam).sewn = false;
    state_->names = state_->sewn_names();
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
    s.names = s.sewn_names();
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
            s.held.push_back({i, s.position[i] - tool, {}});
    s.tool = tool;
    s.grip_stiffness = stiffness;
}

void Cloth::drag(Vec3d tool) noexcept
{
    if (is_finite(tool)) state_->tool = tool;
}

void Cloth::release()
{
    state_->held.clear();
    state_->tension = {};
}

Vec3d Cloth::tension() const noexcept { return state_->tension; }

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
