#include "settling.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <numeric>
#include <utility>

namespace sqmap::sim {

namespace {

constexpr std::size_t k_at_once = 512;  ///< points of a query
// In thicknesses: how far above the surface a point is left, and the most that it is moved at once.
constexpr double k_leaves = 0.1, k_farthest = 4, k_shallow = 2;
// Points near moved nodes are queried again until none is inside, those that were inside more often. Between two surfaces that
// nearly meet a node is pushed to and fro a while.
constexpr int k_rounds = 12, k_passes = 4;

}  // namespace

Settling::Settling(std::span<const std::array<std::uint32_t, 3>> triangles, std::size_t nodes, double thickness)
    : triangles_(triangles.begin(), triangles.end()),
      owned_(triangles.size()),
      samples_(nodes + 7 * triangles.size()),
      moved_(nodes),
      next_(nodes),
      pinned_(nodes),
      touches_(nodes),
      thickness_(thickness)
{
    begin_seams();
    std::map<std::array<std::uint32_t, 2>, std::size_t> owner;
    for (std::size_t t = 0; t < triangles_.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = triangles_[t][k], b = triangles_[t][(k + 1) % 3];
            if (owner.try_emplace({std::min(a, b), std::max(a, b)}, t).second)
                owned_[t] = static_cast<std::uint8_t>(owned_[t] | (1u << k));
        }
}

void Settling::expect(const query::SkinLattice& lattice)
{
    // Samples are taken in the order of the pattern, so that neighbours are queried together.
    points_.resize(k_at_once);
    for (std::size_t i = 0; i < k_at_once; ++i) points_[i] = {static_cast<double>(i), 0, 0};
    active_.resize(k_at_once);
    found_.resize(k_at_once);
    workspace_ = std::make_unique<query::SkinWorkspace>(lattice, points_);
}

void Settling::begin_seams() noexcept { std::iota(next_.begin(), next_.end(), 0u); }

void Settling::join(std::uint32_t a, std::uint32_t b) noexcept
{
    for (std::uint32_t v = next_[a]; v != a; v = next_[v])
        if (v == b) return;
    if (a != b) std::swap(next_[a], next_[b]);  // two rings become one
}

void Settling::close_seams(const SettlingNodes& nodes) noexcept
{
    for (std::uint32_t v = 0; v < next_.size(); ++v) pinned_[v] = nodes.mass[v].inverse_mass > 0 ? 0 : 1;
    for (std::uint32_t v = 0; v < next_.size(); ++v) {
        Vec3d sum = nodes.at[v], fixed = nodes.at[v];
        double count = 1;
        bool first = true, pinned = pinned_[v] != 0;
        for (std::uint32_t u = next_[v]; u != v; u = next_[u]) {
            first = first && v < u;
            sum += nodes.at[u];
            count += 1;
            if (pinned_[u] != 0 && !pinned) fixed = nodes.at[u], pinned = true;
        }
        if (count == 1 || !first) continue;
        nodes.at[v] = pinned ? fixed : (1 / count) * sum;
        pinned_[v] = pinned ? 1 : 0;
        for (std::uint32_t u = next_[v]; u != v; u = next_[u]) nodes.at[u] = nodes.at[v], pinned_[u] = pinned_[v];
    }
}

void Settling::add_triangle(std::size_t triangle) noexcept
{
    const auto& t = triangles_[triangle];
    samples_[count_++] = {t, {1.f / 3, 1.f / 3, 1.f / 3}};
    for (std::size_t k = 0; k < 3; ++k)
        for (const float share : {1.f / 3, 2.f / 3})
            if ((owned_[triangle] >> k & 1) != 0)
                samples_[count_++] = {{t[k], t[(k + 1) % 3], t[(k + 2) % 3]}, {1 - share, share, 0}};
}

std::size_t Settling::pass(const SettlingNodes& nodes, const Collider& collider) noexcept
{
    std::size_t kept = 0;
    for (std::size_t first = 0; first < count_; first += k_at_once) {
        const std::size_t n = std::min(k_at_once, count_ - first);
        std::fill(active_.begin(), active_.end(), std::uint8_t{0});
        for (std::size_t i = 0; i < n; ++i) {
            const Sample& s = samples_[first + i];
            points_[i] = {};
            for (std::size_t k = 0; k < 3; ++k) points_[i] += static_cast<double>(s.weight[k]) * nodes.at[s.node[k]];
            active_[i] = 1;
        }
        const query::ProbeResult result = query::query_skin({collider.model, &collider.skin->to(), points_, active_},
                                                            {.layer = query::Layer::Exact}, *workspace_, found_);
        for (const query::SkinContact& c : std::span(found_).first(std::min(result.contacts, found_.size()))) {
            if ((c.status & query::k_no_surface) != 0 || !(c.depth > 0)) continue;
            const Sample s = samples_[first + c.index];
            // Far in, a triangle that nothing touches may have gone through from the other side.
            const auto free = [&](std::uint32_t v) { return touches_[v] == 0 && moved_[v] == 0; };
            if (c.depth > k_shallow * thickness_ && s.node[0] != s.node[1] && free(s.node[0]) && free(s.node[1]) &&
                free(s.node[2]))
                continue;
            double give = 0;
            for (std::size_t k = 0; k < 3; ++k)
                if (pinned_[s.node[k]] == 0) give += static_cast<double>(s.weight[k] * s.weight[k]);
            if (!(give > 0)) continue;
            const double push = std::min(c.depth + k_leaves * thickness_, k_farthest * thickness_) / give;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t v = s.node[k];
                if (!(s.weight[k] > 0) || pinned_[v] != 0) continue;
                nodes.at[v] += (push * static_cast<double>(s.weight[k])) * c.normal;
                moved_[v] = 1;
                for (std::uint32_t u = next_[v]; u != v; u = next_[u]) nodes.at[u] = nodes.at[v], moved_[u] = 1;
            }
            samples_[kept++] = s;
        }
    }
    count_ = kept;
    return kept;
}

std::size_t Settling::run(const SettlingNodes& nodes, std::span<const Collider> colliders) noexcept
{
    std::size_t moved = 0;
    close_seams(nodes);
    if (workspace_ == nullptr) return moved;
    std::fill(moved_.begin(), moved_.end(), std::uint8_t{0});
    for (const InteriorSpace& s : nodes.held)
        for (const std::uint32_t v : s.nodes) moved_[v] = 1;
    for (std::size_t v = 0; v < touches_.size(); ++v) touches_[v] = moved_[v] != 0 || norm_sq(nodes.normals[v]) > 0 ? 1 : 0;
    std::size_t last = 1;
    for (int round = 0; round < k_rounds && last > 0; ++round) {
        last = 0;
        for (const Collider& collider : colliders) {
            if (collider.model == nullptr || collider.skin == nullptr) continue;
            count_ = 0;
            // The first round queries all: a finger may be within a triangle whose nodes, and those beside them, touch nothing.
            const auto concerned = [&](std::uint32_t v) { return round == 0 || moved_[v] != 0; };
            for (std::uint32_t v = 0; v < nodes.at.size(); ++v)
                if (concerned(v)) samples_[count_++] = {{v, v, v}, {1, 0, 0}};
            for (std::size_t t = 0; t < triangles_.size(); ++t) {
                const auto& n = triangles_[t];
                if (concerned(n[0]) || concerned(n[1]) || concerned(n[2])) add_triangle(t);
            }
            for (int i = 0; i < k_passes && count_ > 0; ++i) last += pass(nodes, collider);
        }
        moved += last;
    }
    return moved;
}

}  // namespace sqmap::sim
