// The limit on strain in a pull. Threads that are solved one by one hand a pull on slowly, the lighter the cloth the worse: at 30
// N those of silk would be many times too long, and a forearm would slip between them. In one sweep from the far end of the cloth
// to the hand each node follows the one behind it (Mueller, Kim, Chentanez 2012): the hand, not a thread, gives way.
#include "cloth_state.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sqmap::sim {

namespace {

constexpr float k_longest = 1.3f;  ///< times a thread's length
constexpr std::uint32_t k_unreached = 0xffffffffu;

/// Nodes by how many threads lie between them and the held ones.
std::vector<std::uint32_t> rings(const std::vector<std::vector<std::uint32_t>>& neighbours, std::vector<std::uint32_t> queue)
{
    std::vector<std::uint32_t> ring(neighbours.size(), k_unreached);
    for (const std::uint32_t v : queue) ring[v] = 0;
    for (std::size_t i = 0; i < queue.size(); ++i)
        for (const std::uint32_t v : neighbours[queue[i]]) {
            if (ring[v] != k_unreached) continue;
            ring[v] = ring[queue[i]] + 1;
            queue.push_back(v);
        }
    return ring;
}

}  // namespace

void Cloth::State::find_pulled()
{
    pulled.clear();
    if (held.empty()) return;
    std::vector<Pulled> all;
    const auto add = [&](int l, float length) {
        const btSoftBody::Link& link = body->m_links[l];
        all.push_back({number(link.m_n[0]), number(link.m_n[1]), k_longest * length});
    };
    for (std::size_t l = 0; l < weak.size(); ++l)
        if (weak[l] == 0) add(static_cast<int>(l), static_cast<float>(body->m_links[static_cast<int>(l)].m_rl));
    // A seam that is still being drawn together is no thread yet.
    for (const SeamLinks& seam : seams)
        for (int i = 0; i < seam.count && seam.is_closed(); ++i) add(seam.first + i, static_cast<float>(fabric.thickness));
    std::vector<std::vector<std::uint32_t>> neighbours(position.size());
    for (const Pulled& p : all) {
        neighbours[p.near].push_back(p.far);
        neighbours[p.far].push_back(p.near);
    }
    std::vector<std::uint32_t> grip;
    for (const Held& h : held) grip.push_back(h.node);
    const std::vector<std::uint32_t> ring = rings(neighbours, grip);
    for (Pulled& p : all) {
        if (ring[p.near] > ring[p.far]) std::swap(p.near, p.far);
        if (ring[p.far] != k_unreached && ring[p.near] < ring[p.far]) pulled.push_back(p);
    }
    std::stable_sort(pulled.begin(), pulled.end(), [&](const Pulled& a, const Pulled& b) { return ring[a.near] > ring[b.near]; });
}

void Cloth::State::solve_pulled()
{
    for (const Pulled& p : pulled) {
        Moving& n = moving[p.near];
        const Vec3f from = moving[p.far].at, d = n.at - from;
        const float length_sq = norm_sq(d);
        if (length_sq > p.max * p.max && n.inverse_mass > 0) n.at = from + (p.max / std::sqrt(length_sq)) * d;
    }
}

}  // namespace sqmap::sim
