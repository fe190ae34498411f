// Nodes against triangles and edges against edges, swept over a step, as R. Bridson, R. Fedkiw, J. Anderson, "Robust treatment of
// collisions, contact and friction for cloth animation", SIGGRAPH 2002, found them; which triangle represents an edge or a node
// is as in S. Curtis, R. Tamstorf, D. Manocha, "Fast collision detection for deformable models using representative-triangles",
// I3D 2008; patches whose normals lie within a cone are not searched, as P. Volino, N. Magnenat-Thalmann, Eurographics 1994.
#include "self_contacts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

namespace sqmap::sim {

namespace {

constexpr double k_recovers = 0.05;       ///< share of the missing thickness that a step recovers
constexpr double k_looks = 1.5;           ///< thicknesses: pairs farther apart are ignored
constexpr double k_min_gap = 0.1;         ///< thicknesses: pairs that would cross are put back this far
constexpr double k_touches = 1e-6;        ///< m: pairs as near as this go through
constexpr double k_flat = 1.0;            ///< rad: half a cone of normals within which a patch does not touch itself
constexpr double k_share_of_edge = 0.25;  ///< the distance kept is at most this share of the mesh's mean edge
constexpr double k_any_direction = 10;    ///< rad: a cone that holds every direction
constexpr double k_held_mass = 1e6;       ///< kg: a held node does not yield
constexpr int k_searches = 4;             ///< in a step
constexpr int k_zones = 12;               ///< rounds of joining and moving zones in a search
constexpr double k_parallel = 1e-12;

/// The difference of the nearest points of two features as weights of their four nodes.
struct Nearest {
    std::array<double, 4> weight;
    Vec3d difference;
};

/// C. Ericson, Real-Time Collision Detection, 5.1.5.
std::array<double, 3> nearest_in_triangle(Vec3d p, Vec3d a, Vec3d b, Vec3d c)
{
    const Vec3d ab = b - a, ac = c - a, ap = p - a;
    const double d1 = dot(ab, ap), d2 = dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
    const Vec3d bp = p - b;
    const double d3 = dot(ab, bp), d4 = dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
    const Vec3d cp = p - c;
    const double d5 = dot(ab, cp), d6 = dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
        const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return {0, 1 - w, w};
    }
    const double sum = va + vb + vc;
    return {va / sum, vb / sum, vc / sum};
}

/// The same, 5.1.9: shares of the path along p-q and r-s.
std::array<double, 2> nearest_on_edges(Vec3d p, Vec3d q, Vec3d r, Vec3d s)
{
    const Vec3d d1 = q - p, d2 = s - r, d = p - r;
    const double a = norm_sq(d1), e = norm_sq(d2), f = dot(d2, d), c = dot(d1, d), b = dot(d1, d2);
    if (!(a > 0) || !(e > 0)) return {0, e > 0 ? std::clamp(f / e, 0.0, 1.0) : 0};
    const double denominator = a * e - b * b;
    double u = denominator > k_parallel * a * e ? std::clamp((b * f - c * e) / denominator, 0.0, 1.0) : 0.5;
    double v = (b * u + f) / e;
    if (v < 0) {
        v = 0;
        u = std::clamp(-c / a, 0.0, 1.0);
    } else if (v > 1) {
        v = 1;
        u = std::clamp((b - c) / a, 0.0, 1.0);
    }
    return {u, v};
}

using Four = std::array<Vec3d, 4>;

Nearest nearest(const Four& x, bool edges)
{
    Nearest out;
    if (edges) {
        const auto [u, v] = nearest_on_edges(x[0], x[1], x[2], x[3]);
        out.weight = {1 - u, u, v - 1, -v};
    } else {
        const auto [a, b, c] = nearest_in_triangle(x[0], x[1], x[2], x[3]);
        out.weight = {1, -a, -b, -c};
    }
    out.difference = {};
    for (std::size_t k = 0; k < 4; ++k) out.difference += out.weight[k] * x[k];
    return out;
}

/// Width of the gap between the features along normal; negative if no plane across it separates them.
double gap(const Four& x, bool edges, Vec3d normal)
{
    const double h0 = dot(normal, x[0]), h1 = dot(normal, x[1]), h2 = dot(normal, x[2]), h3 = dot(normal, x[3]);
    return edges ? std::min(h0, h1) - std::max(h2, h3) : h0 - std::max(h1, std::max(h2, h3));
}

/// Nearest points and time, in [0, 1], at which two features meet.
struct Meeting {
    Nearest at;
    double when = 0;
};

/// The first meeting of the features of four points on straight paths; nothing if they do not meet.
std::optional<Meeting> meet(const Four& from, const Four& to, bool edges)
{
    const Vec3d a = from[1] - from[0], b = from[2] - from[0], c = from[3] - from[0];
    const Vec3d da = to[1] - to[0] - a, db = to[2] - to[0] - b, dc = to[3] - to[0] - c;
    const Vec3d ab = cross(a, b), mixed = cross(a, db) + cross(da, b), dd = cross(da, db);
    const double c0 = dot(ab, c), c1 = dot(mixed, c) + dot(ab, dc), c2 = dot(dd, c) + dot(mixed, dc), c3 = dot(dd, dc);
    const auto value = [&](double t) { return ((c3 * t + c2) * t + c1) * t + c0; };
    const auto touching = [&](double t) -> std::optional<Meeting> {
        Four x;
        for (std::size_t k = 0; k < 4; ++k) x[k] = from[k] + t * (to[k] - from[k]);
        const Meeting meeting{nearest(x, edges), t};
        if (norm_sq(meeting.at.difference) <= k_touches * k_touches) return meeting;
        return std::nullopt;
    };
    // Between the turns of the cubic there is one root at most.
    double ends[4] = {0, 1, 1, 1};
    int count = 1;
    const double discriminant = c2 * c2 - 3 * c3 * c1;
    if (discriminant > 0) {
        const double q = -(c2 + std::copysign(std::sqrt(discriminant), c2));
        double r[2] = {c3 != 0 ? q / (3 * c3) : -1, q != 0 ? c1 / q : -1};
        if (r[0] > r[1]) std::swap(r[0], r[1]);
        for (const double t : r)
            if (t > 0 && t < 1) ends[count++] = t;
    }
    ends[count] = 1;
    for (int k = 0; k < count; ++k) {
        double low = ends[k], high = ends[k + 1];
        const double f_low = value(low), f_high = value(high);
        if ((f_low > 0) == (f_high > 0)) {
            // At a turn the cubic may touch zero but for rounding.
            if (k > 0)
                if (const auto meeting = touching(low)) return meeting;
            continue;
        }
        for (int i = 0; i < 40; ++i) {
            const double middle = 0.5 * (low + high);
            ((value(middle) > 0) == (f_low > 0) ? low : high) = middle;
        }
        if (const auto meeting = touching(low)) return meeting;
    }
    return touching(1);
}

Vec3d normal_of(Vec3d a, Vec3d b, Vec3d c)
{
    const Vec3d n = cross(b - a, c - a);
    const double length = norm(n);
    return length > 0 ? n / length : Vec3d{};
}

}  // namespace

struct SelfContacts::PairVisitor : btDbvt::ICollide {
    SelfContacts* self = nullptr;
    std::uint32_t number(const Tree* leaf) const
    {
        return static_cast<std::uint32_t>(static_cast<const Triangle*>(leaf->data) - self->triangles_.data());
    }
    void Process(const btDbvntNode* a, const btDbvntNode* b) override { self->consider(number(a), number(b)); }
};

SelfContacts::SelfContacts(std::span<const Vec3d> start, std::span<const Triangle> triangles, double thickness)
    : triangles_(triangles),
      owned_(triangles.size()),
      now_(start.begin(), start.end()),
      swept_(start.size()),
      zone_(start.size()),
      zone_path_(start.size()),
      zone_mass_(start.size())
{
    // Builds the tree from above once; later only its boxes and cones change.
    btDbvt tree;
    std::vector<std::uint8_t> taken(start.size());
    constexpr std::uint32_t k_none = 0xffffffffu;
    std::map<std::array<std::uint32_t, 2>, std::array<std::uint32_t, 2>> edges;  // triangle, corner
    std::vector<Triangle> beside(triangles.size(), {k_none, k_none, k_none});
    double length = 0;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        const Triangle& t = triangles[i];
        const btVector3 corners[] = {to_bullet(start[t[0]]), to_bullet(start[t[1]]), to_bullet(start[t[2]])};
        tree.insert(btDbvtVolume::FromPoints(corners, 3), const_cast<Triangle*>(&t));
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3];
            if (taken[a] == 0) owned_[i] = static_cast<std::uint8_t>(owned_[i] | 1u << k);
            taken[a] = 1;
            const auto number = static_cast<std::uint32_t>(i), corner = static_cast<std::uint32_t>(k);
            const auto [edge, first] = edges.insert({{std::min(a, b), std::max(a, b)}, {number, corner}});
            if (!first) {
                beside[i][k] = edge->second[0];
                beside[edge->second[0]][edge->second[1]] = number;
                continue;
            }
            owned_[i] = static_cast<std::uint8_t>(owned_[i] | 8u << k);
            length += norm(start[a] - start[b]);
        }
    }
    thickness_ = std::min(thickness, k_share_of_edge * length / static_cast<double>(edges.size()));
    tree.optimizeTopDown(2);
    const auto copy = [](const auto& self, const btDbvtNode* from) -> Tree* {
        auto* node = new Tree(from);
        if (from->isinternal())
            for (int k = 0; k < 2; ++k) node->childs[k] = self(self, from->childs[k]);
        return node;
    };
    root_.reset(copy(copy, tree.m_root));
    join(*root_, beside);
}

SelfContacts::~SelfContacts() = default;

std::vector<std::uint32_t> SelfContacts::join(const Tree& node, std::span<const Triangle> beside)
{
    const std::size_t number = joined_.size();
    joined_.push_back(1);
    if (node.isleaf()) return {static_cast<std::uint32_t>(static_cast<const Triangle*>(node.data) - triangles_.data())};
    std::vector<std::uint32_t> all = join(*node.childs[0], beside), reached{all.front()};
    const std::vector<std::uint32_t> others = join(*node.childs[1], beside);
    all.insert(all.end(), others.begin(), others.end());
    std::sort(all.begin(), all.end());
    std::vector<std::uint8_t> seen(all.size());
    const auto reach = [&](std::uint32_t t) {
        const auto found = std::lower_bound(all.begin(), all.end(), t);
        if (found == all.end() || *found != t || seen[static_cast<std::size_t>(found - all.begin())] != 0) return false;
        return (seen[static_cast<std::size_t>(found - all.begin())] = 1) != 0;
    };
    reach(reached.front());
    for (std::size_t i = 0; i < reached.size(); ++i)
        for (const std::uint32_t t : beside[reached[i]])
            if (reach(t)) reached.push_back(t);
    joined_[number] = reached.size() == all.size() ? 1 : 0;
    return all;
}

auto SelfContacts::around(const Box& a, const Box& b) noexcept -> Box
{
    const auto min = [](float x, float y) { return x < y ? x : y; };
    const auto max = [](float x, float y) { return x > y ? x : y; };
    return {{min(a.low.x, b.low.x), min(a.low.y, b.low.y), min(a.low.z, b.low.z)},
            {max(a.high.x, b.high.x), max(a.high.y, b.high.y), max(a.high.z, b.high.z)}};
}

void SelfContacts::refit(Tree& node, std::size_t& number)
{
    const bool joined = joined_[number++] != 0;
    Vec3d normal;
    double half, wider = 0;  // half angles of the cone; the node keeps it as the normal's fourth component
    const auto vec = [](const btVector3& v) {
        return Vec3d{static_cast<double>(v.x()), static_cast<double>(v.y()), static_cast<double>(v.z())};
    };
    if (node.isinternal()) {
        Tree &a = *node.childs[0], &b = *node.childs[1];
        refit(a, number);
        refit(b, number);
        Merge(a.volume, b.volume, node.volume);
        normal = vec(a.normal) + vec(b.normal);
        wider = static_cast<double>(std::max(a.normal.w(), b.normal.w()));
    } else {
        const Triangle& t = *static_cast<const Triangle*>(node.data);
        const Box box = around(around(swept_[t[0]], swept_[t[1]]), swept_[t[2]]);
        node.volume = btDbvtVolume::FromMM({box.low.x, box.low.y, box.low.z}, {box.high.x, box.high.y, box.high.z});
        normal = normal_of(previous_[t[0]], previous_[t[1]], previous_[t[2]]) + normal_of(now_[t[0]], now_[t[1]], now_[t[2]]);
    }
    const double length = norm(normal);
    half = length > 1e-3 ? wider + std::acos(std::min(1.0, 0.5 * length)) : k_any_direction;
    if (length > 1e-3) normal = normal / length;
    node.normal = to_bullet(normal);
    node.normal.setW(static_cast<btScalar>(half));
    // Bullet descends if this exceeds pi. Triangles that are not one piece may lie on each other whatever their normals.
    node.angle = static_cast<btScalar>((joined ? half : k_any_direction) * (SIMD_PI / k_flat));
}

bool SelfContacts::share(std::span<const std::uint32_t> a, std::span<const std::uint32_t> b) const noexcept
{
    for (const std::uint32_t i : a)
        for (const std::uint32_t j : b)
            if (same_[i] == same_[j]) return true;
    return false;
}

void SelfContacts::watch(const Pair& pair)
{
    const auto& v = pair.node;
    const Box &p = swept_[v[0]], &q = swept_[v[1]], &r = swept_[v[2]], &s = swept_[v[3]];
    const Box a = pair.edges ? around(p, q) : p, b = pair.edges ? around(r, s) : around(around(q, r), s);
    if (a.low.x > b.high.x || b.low.x > a.high.x || a.low.y > b.high.y || b.low.y > a.high.y || a.low.z > b.high.z ||
        b.low.z > a.high.z)
        return;
    Four was, is;
    for (std::size_t k = 0; k < 4; ++k) {
        was[k] = previous_[v[k]];
        is[k] = now_[v[k]];
    }
    const Nearest n = nearest(was, pair.edges);
    const double distance = norm(n.difference);
    if (!(distance > 1e-9)) return;
    const Vec3d normal = n.difference / distance;
    if (gap(is, pair.edges, normal) > k_looks * thickness_) return;
    watched_.push_back({pair, cast<float>(normal), static_cast<float>(distance)});
}

void SelfContacts::consider(std::uint32_t a, std::uint32_t b)
{
    for (int turn = 0; turn < 2; ++turn, std::swap(a, b))
        for (std::size_t k = 0; k < 3; ++k) {
            const Triangle &s = triangles_[a], &t = triangles_[b];
            if ((owned_[a] >> k & 1u) != 0 && !share({&s[k], 1}, t)) watch({{s[k], t[0], t[1], t[2]}, false});
        }
    if ((owned_[a] >> 3) == 0 || (owned_[b] >> 3) == 0) return;
    const Triangle &s = triangles_[a], &t = triangles_[b];
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            if ((owned_[a] >> (3 + i) & 1u) == 0 || (owned_[b] >> (3 + j) & 1u) == 0) continue;
            const std::array<std::uint32_t, 4> ends{s[i], s[(i + 1) % 3], t[j], t[(j + 1) % 3]};
            if (!share(std::span(ends).first<2>(), std::span(ends).last<2>())) watch({ends, true});
        }
}

void SelfContacts::begin(std::span<const Vec3d> now)
{
    near_.clear();
    for (const Watched& w : watched_) {
        const Nearest n = nearest({now[w.node[0]], now[w.node[1]], now[w.node[2]], now[w.node[3]]}, w.edges);
        const double distance = norm(n.difference);
        if (!(distance < k_looks * thickness_) || !(distance > 1e-9)) continue;
        Near contact{};
        static_cast<Pair&>(contact) = w;
        for (std::size_t k = 0; k < 4; ++k) contact.weight[k] = static_cast<float>(n.weight[k]);
        contact.normal = cast<float>(n.difference / distance);
        contact.offset = static_cast<float>(distance < thickness_ ? distance + k_recovers * (thickness_ - distance) : thickness_);
        near_.push_back(contact);
    }
}

void SelfContacts::solve(std::span<const Vec3d> previous, std::span<Moving> moving, double friction) noexcept
{
    const auto mu = static_cast<float>(friction);
    for (Near& c : near_) {
        Vec3f apart{}, was{};
        float yields = 0;
        for (std::size_t k = 0; k < 4; ++k) {
            const Moving& m = moving[c.node[k]];
            apart += c.weight[k] * m.at;
            yields += c.weight[k] * c.weight[k] * m.inverse_mass;
        }
        const float missing = c.offset - dot(c.normal, apart);
        if (!(missing > 0.f) && !(c.push > 0.f)) continue;
        if (!(yields > 0.f)) continue;
        Vec3f shift{};
        if (missing > 0.f) {
            shift = missing * c.normal;
            c.push += missing;
        }
        for (std::size_t k = 0; k < 4; ++k) was += c.weight[k] * cast<float>(previous[c.node[k]]);
        Vec3f slip = apart - was;
        slip -= dot(slip, c.normal) * c.normal;
        Vec3f grip = c.grip - slip;
        const float length = norm(grip), max_grip = mu * c.push;
        if (length > max_grip) grip = (max_grip / length) * grip;
        shift += grip - c.grip;
        c.grip = grip;
        for (std::size_t k = 0; k < 4; ++k) {
            Moving& m = moving[c.node[k]];
            m.at += (c.weight[k] * m.inverse_mass / yields) * shift;
        }
    }
}

void SelfContacts::find(std::span<const Vec3d> previous, std::span<const Moving> moving, std::span<const std::uint32_t> same)
{
    same_ = same;
    bool finite = true;
    for (std::size_t i = 0; i < now_.size(); ++i) {
        now_[i] = cast<double>(moving[i].at);
        finite = finite && std::isfinite(norm_sq(now_[i]));
    }
    watched_.clear();
    if (finite) search(previous);
}

void SelfContacts::search(std::span<const Vec3d> previous)
{
    previous_ = previous;
    watched_.clear();
    // Rounded outwards, since the boxes are float.
    const auto far = static_cast<float>(0.5 * k_looks * thickness_ * (1 + 1e-3));
    for (std::size_t i = 0; i < now_.size(); ++i) {
        const Vec3f was = cast<float>(previous[i]), is = cast<float>(now_[i]);
        for (int c = 0; c < 3; ++c) {
            swept_[i].low[c] = std::min(was[c], is[c]) - far;
            swept_[i].high[c] = std::max(was[c], is[c]) + far;
        }
    }
    std::size_t number = 0;
    refit(*root_, number);
    PairVisitor collider;
    collider.self = this;
    btDbvt().selfCollideT(root_.get(), collider);
}

std::size_t SelfContacts::push_apart(std::span<const Vec3d> previous, std::span<Moving> moving) noexcept
{
    std::size_t met = 0;
    const double min_gap = k_min_gap * thickness_;
    for (const Watched& w : watched_) {
        Four is;
        for (std::size_t k = 0; k < 4; ++k) is[k] = cast<double>(moving[w.node[k]].at);
        const double keep = std::min(min_gap, 0.5 * static_cast<double>(w.distance));
        Vec3d normal = cast<double>(w.normal);
        if (gap(is, w.edges, normal) >= keep) continue;
        Four was;
        for (std::size_t k = 0; k < 4; ++k) was[k] = previous[w.node[k]];
        const std::optional<Meeting> meeting = meet(was, is, w.edges);
        if (!meeting) continue;
        const Nearest& at = meeting->at;
        // The pair's normal at the meeting, on the side that they come from.
        Four there;
        for (std::size_t k = 0; k < 4; ++k) there[k] = was[k] + meeting->when * (is[k] - was[k]);
        const Vec3d across =
            w.edges ? cross(there[1] - there[0], there[3] - there[2]) : cross(there[2] - there[1], there[3] - there[1]);
        const double length = norm(across);
        Vec3d before{}, after{};
        double yields = 0;
        for (std::size_t k = 0; k < 4; ++k) {
            before += at.weight[k] * was[k];
            after += at.weight[k] * is[k];
            yields += at.weight[k] * at.weight[k] * static_cast<double>(moving[w.node[k]].inverse_mass);
        }
        if (length > 0 && std::abs(dot(before, across)) > 1e-3 * length * norm(before))
            normal = (dot(before, across) > 0 ? 1 / length : -1 / length) * across;
        ++met;
        const double missing = keep - dot(normal, after);
        if (!(missing > 0) || !(yields > 0)) continue;
        for (std::size_t k = 0; k < 4; ++k) {
            Moving& m = moving[w.node[k]];
            m.at += cast<float>((missing * at.weight[k] * static_cast<double>(m.inverse_mass) / yields) * normal);
        }
    }
    return met;
}

std::size_t SelfContacts::stop(std::span<const Vec3d> previous, std::span<Vec3d> now, std::span<const Moving> mass)
{
    std::iota(zone_.begin(), zone_.end(), 0u);
    // The search covers nodes that have moved at most `seen` since. If one has moved farther, search again: it may touch others.
    const double seen = 0.5 * k_looks * thickness_;
    const auto search_again = [&] {
        bool far = false;
        for (std::size_t i = 0; i < now.size(); ++i) far = far || norm_sq(now[i] - now_[i]) > seen * seen;
        if (!far) return false;
        std::copy(now.begin(), now.end(), now_.begin());
        search(previous);
        return true;
    };
    std::size_t met = 0;
    search_again();
    for (int searches = 0; searches < k_searches; ++searches) {
        met = 0;
        for (int round = 0; round < k_zones && (met = join_zones(previous, now)) > 0; ++round) move_zones(previous, now, mass);
        if (!search_again()) break;
    }
    return met;
}

std::uint32_t SelfContacts::zone_of(std::uint32_t v) noexcept
{
    while (zone_[v] != v) v = zone_[v] = zone_[zone_[v]];
    return v;
}

std::size_t SelfContacts::join_zones(std::span<const Vec3d> previous, std::span<const Vec3d> now) noexcept
{
    std::size_t met = 0;
    for (const Watched& w : watched_) {
        Four was, is;
        for (std::size_t k = 0; k < 4; ++k) {
            was[k] = previous[w.node[k]];
            is[k] = now[w.node[k]];
        }
        if (gap(is, w.edges, cast<double>(w.normal)) > k_touches) continue;
        if (!meet(was, is, w.edges)) continue;
        ++met;
        for (std::size_t k = 1; k < 4; ++k) zone_[zone_of(w.node[k])] = zone_of(w.node[0]);
    }
    return met;
}

void SelfContacts::move_zones(std::span<const Vec3d> previous, std::span<Vec3d> now, std::span<const Moving> mass) noexcept
{
    std::fill(zone_path_.begin(), zone_path_.end(), Vec3d{});
    std::fill(zone_mass_.begin(), zone_mass_.end(), 0.0);
    for (std::uint32_t i = 0; i < now.size(); ++i) {
        const double m = mass[i].inverse_mass > 0 ? 1 / static_cast<double>(mass[i].inverse_mass) : k_held_mass;
        zone_path_[zone_of(i)] += m * (now[i] - previous[i]);
        zone_mass_[zone_of(i)] += m;
    }
    for (std::uint32_t i = 0; i < now.size(); ++i) {
        const std::uint32_t zone = zone_of(i);
        if (mass[i].inverse_mass > 0) now[i] = previous[i] + zone_path_[zone] / zone_mass_[zone];
    }
}

}  // namespace sqmap::sim
