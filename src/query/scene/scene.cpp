// Sweep and prune: D. Baraff, Dynamic simulation of non-penetrating rigid bodies, 1992; J. Cohen et al., I-COLLIDE, I3D 1995;
// on one axis, over spheres.
#include "sqmap/query/scene.h"

#include "pair_query.h"
#include "query/probe/triangle_tree.h"

#include <algorithm>
#include <cmath>

namespace sqmap::query {

namespace {

bool touch(const Sphere& a, const Sphere& b, double slack)
{
    const double reach = a.radius + b.radius + slack;
    return norm_sq(a.centre - b.centre) <= reach * reach;
}

bool can_touch(const Body& a, const Body& b)
{
    return (a.model != nullptr && b.probe != nullptr) || (b.model != nullptr && a.probe != nullptr) ||
           (has_triangles(a) && has_triangles(b));
}

/// A little more than the body's, since positions are rounded.
Sphere safe_sphere(const Body& body)
{
    Sphere s = sphere_of(body);
    s.radius *= 1.0001;
    return s;
}

}  // namespace

/// Pairs as they are found.
struct Scene::PairList {
    std::span<ScenePair> out;
    SceneResult& result;

    void add(BodyId a, BodyId b)
    {
        if (const std::size_t at = result.pairs++; at < out.size())
            out[at] = {std::min(a, b), std::max(a, b)};
        else
            result.pairs_full = true;
    }
    void sort()
    {
        const std::span<ScenePair> found = out.first(std::min(result.pairs, out.size()));
        std::sort(found.begin(), found.end(),
                  [](const ScenePair& p, const ScenePair& q) { return p.a != q.a ? p.a < q.a : p.b < q.b; });
    }
};

bool Scene::set_pose(BodyId id, const Pose& pose) noexcept
{
    if (id >= bodies_.size()) return false;
    bodies_[id].pose = pose;
    Sphere s = safe_sphere(bodies_[id]);
    // Also where the sphere overflows.
    const bool finite = is_finite(pose) && is_finite(s.centre) && std::isfinite(s.radius);
    if (!finite) s = {{}, -1};
    spheres_[id] = s;
    stale_ = true;
    return finite;
}

/// The axis on which fewest of n pairs overlap, drawn the same way each time; the present one unless another is much better.
void Scene::choose_axis() noexcept
{
    const std::size_t n = order_.size();
    std::size_t overlaps[3] = {};
    std::uint32_t draw = 1;
    for (const Entry& e : order_) {
        draw = draw * 1664525u + 1013904223u;
        const BodyId other = order_[(std::uint64_t{draw} * n) >> 32].id;
        const Sphere &a = spheres_[e.id], &b = spheres_[other];
        const double reach = a.radius + b.radius;
        for (int k = 0; k < 3; ++k) overlaps[k] += std::abs(a.centre[k] - b.centre[k]) <= reach ? 1u : 0u;
    }
    const int best = static_cast<int>(std::min_element(overlaps, overlaps + 3) - overlaps);
    if (2 * overlaps[best] < overlaps[axis_]) axis_ = best;
}

/// By insertion, as bodies move little from frame to frame; where they do not, from scratch.
void Scene::sort() noexcept
{
    const auto before = [](const Entry& a, const Entry& b) { return a.lo != b.lo ? a.lo < b.lo : a.id < b.id; };
    std::size_t moves = 8 * order_.size();
    for (std::size_t i = 1; i < order_.size(); ++i) {
        const Entry e = order_[i];
        std::size_t k = i;
        for (; k > 0 && before(e, order_[k - 1]); --k) {
            order_[k] = order_[k - 1];
            --moves;
            if (moves == 0) break;
        }
        if (moves == 0) {
            order_[k - 1] = e;
            std::sort(order_.begin(), order_.end(), before);
            return;
        }
        order_[k] = e;
    }
}

/// Spheres in float, larger by what that loses.
void Scene::narrow() noexcept
{
    const Vec3d origin = posed_ > 0 ? sorted_[0].centre : Vec3d{};
    for (std::size_t i = 0; i < posed_; ++i) {
        const Vec3d c = sorted_[i].centre - origin;
        x_[i] = static_cast<float>(c.x);
        y_[i] = static_cast<float>(c.y);
        z_[i] = static_cast<float>(c.z);
        radius_[i] = static_cast<float>(1.00001 * sorted_[i].radius + 1e-6 * (std::abs(c.x) + std::abs(c.y) + std::abs(c.z)));
    }
    // Far away; what overflows is not ruled out but left to the test in double.
    for (std::size_t i = posed_; i < x_.size(); ++i) {
        x_[i] = y_[i] = z_[i] = 1e18f;
        radius_[i] = 0.f;
    }
}

bool Scene::any_near(std::size_t s, std::size_t first, float slack) const noexcept
{
    const float x = x_[s], y = y_[s], z = z_[s], radius = radius_[s] + slack;
    int any = 0;
    for (std::size_t j = first; j < first + k_block; ++j) {
        const float dx = x_[j] - x, dy = y_[j] - y, dz = z_[j] - z, reach = radius_[j] + radius;
        any |= static_cast<int>(!(dx * dx + dy * dy + dz * dz > reach * reach));
    }
    return any != 0;
}

void Scene::update() noexcept
{
    if (!stale_) return;
    choose_axis();
    for (Entry& e : order_) {
        const Sphere& s = spheres_[e.id];
        e.lo = s.radius < 0 ? INFINITY : s.centre[axis_] - s.radius;
    }
    sort();
    posed_ = 0;
    largest_radius_ = 0;
    for (const Entry& e : order_) {
        if (!(e.lo < INFINITY)) break;
        largest_radius_ = std::max(largest_radius_, spheres_[e.id].radius);
        sorted_[posed_++] = spheres_[e.id];
    }
    narrow();
    stale_ = false;
}

double Scene::largest_reach(const QueryOptions& options) const noexcept
{
    double reach = 0;
    if (options.offset || options.margin > 0)
        for (const Entry& e : order_) reach = std::max(reach, reach_of(bodies_[e.id], options));
    return reach;
}

SceneResult Scene::pairs(std::span<ScenePair> pairs) noexcept { return find(0, pairs); }

SceneResult Scene::find(double slack, std::span<ScenePair> pairs) noexcept
{
    update();
    SceneResult result;
    if (posed_ < order_.size()) result.status |= k_not_finite;
    PairList list{pairs, result};
    const float slack_above = static_cast<float>(1.00001 * slack);
    for (std::size_t i = 0; i < posed_; ++i) {
        const Sphere& s = sorted_[i];
        const double hi = s.centre[axis_] + s.radius + slack;
        for (std::size_t first = i + 1; first < posed_ && order_[first].lo <= hi; first += k_block) {
            if (!any_near(i, first, slack_above)) continue;
            for (std::size_t j = first; j < std::min(first + k_block, posed_); ++j)
                if (touch(s, sorted_[j], slack) && can_touch(bodies_[order_[i].id], bodies_[order_[j].id]))
                    list.add(order_[i].id, order_[j].id);
        }
    }
    list.sort();
    return result;
}

SceneResult Scene::query(SceneResult result, const Body* collider, const PairOptions& options, const Output& to) noexcept
{
    for (ScenePair& p : to.pairs.first(std::min(result.pairs, to.pairs.size()))) {
        PairQuery pair{options, workspace_, to.contacts.subspan(result.contacts)};
        pair.run(bodies_[p.a], collider != nullptr ? *collider : bodies_[p.b]);
        const PairQuery::Result& r = pair.result;
        p.first = static_cast<std::uint32_t>(result.contacts);
        p.count = static_cast<std::uint32_t>(r.contacts);
        p.status = r.status;
        result.contacts += r.contacts;
        result.status |= r.status;
        if (options.query.first_only && r.found > 0) break;
    }
    return result;
}

SceneResult Scene::query_pairs(const PairOptions& options, std::span<ScenePair> near, std::span<PairContact> contacts) noexcept
{
    return query(find(largest_reach(options.query), near), nullptr, options, {near, contacts});
}

SceneResult Scene::query_probe(const Body& collider, const QueryOptions& options, std::span<ScenePair> near,
                               std::span<PairContact> contacts) noexcept
{
    update();
    SceneResult result;
    if (posed_ < order_.size()) result.status |= k_not_finite;
    const Body body{nullptr, collider.probe, collider.pose};
    if (body.probe == nullptr) return result;
    Sphere s = safe_sphere(body);
    s.radius += largest_reach(options);
    if (!is_finite(body.pose) || !is_finite(s.centre)) {
        result.status |= k_not_finite;
        return result;
    }
    PairList list{near, result};
    // Spheres that begin before the probe ends; none that begins earlier than the widest one before it can reach it.
    const double lo = s.centre[axis_] - s.radius - 2 * largest_radius_, hi = s.centre[axis_] + s.radius;
    const auto end = order_.begin() + static_cast<std::ptrdiff_t>(posed_);
    for (auto at = std::lower_bound(order_.begin(), end, lo, [](const Entry&e, double v) { return e.lo < v; });
         at != end && at->lo <= hi; ++at)
        if (touch(s, sorted_[static_cast<std::size_t>(at - order_.begin())], 0) && bodies_[at->id].model != nullptr)
            list.add(at->id, k_no_body);
    list.sort();
    return query(result, &body, {.query = options}, {near, contacts});
}

}  // namespace sqmap::query
