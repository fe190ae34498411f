// Dinic's algorithm.
#include "maximum_flow.h"

#include <algorithm>
#include <limits>

namespace sqmap::decompose {

std::vector<std::uint8_t> MaximumFlow::source_side(std::uint32_t source, std::uint32_t sink, double tolerance)
{
    sort_arcs();
    std::vector<int> level;
    std::vector<std::uint32_t> queue, next, path;
    while (true) {
        level.assign(nodes_, -1);
        level[source] = 0;
        queue.assign(1, source);
        for (std::size_t i = 0; i < queue.size() && level[sink] < 0; ++i)  // what is as far as the sink leads nowhere
            for (const Arc& arc : arcs_from(queue[i]))
                if (arc.capacity > tolerance && level[arc.to] < 0) {
                    level[arc.to] = level[queue[i]] + 1;
                    queue.push_back(arc.to);
                }
        if (level[sink] < 0) break;
        next.assign(first_.begin(), first_.end() - 1);
        path.clear();
        std::uint32_t at = source;
        while (true) {
            if (at == sink) {
                double push = std::numeric_limits<double>::infinity();
                for (const auto a : path) push = std::min(push, arcs_[a].capacity);
                std::size_t keep = path.size();
                for (std::size_t i = path.size(); i-- > 0;) {
                    arcs_[path[i]].capacity -= push;
                    arcs_[arcs_[path[i]].back].capacity += push;
                    if (arcs_[path[i]].capacity <= tolerance) keep = i;
                }
                path.resize(keep);
                at = path.empty() ? source : arcs_[path.back()].to;
                continue;
            }
            bool moved = false;
            for (; next[at] < first_[at + 1]; ++next[at]) {
                const Arc& arc = arcs_[next[at]];
                if (arc.capacity > tolerance && level[arc.to] == level[at] + 1) {
                    path.push_back(next[at]);
                    at = arc.to;
                    moved = true;
                    break;
                }
            }
            if (moved) continue;
            if (path.empty()) break;
            level[at] = -1;
            path.pop_back();
            at = path.empty() ? source : arcs_[path.back()].to;
        }
    }
    std::vector<std::uint8_t> side(nodes_, 0);
    for (std::size_t i = 0; i < nodes_; ++i) side[i] = level[i] >= 0;
    return side;
}

void MaximumFlow::sort_arcs()
{
    first_.assign(nodes_ + 1, 0);
    for (std::size_t a = 0; a < added_.size(); ++a) ++first_[added_[a ^ 1].to + 1];
    for (std::size_t v = 0; v < nodes_; ++v) first_[v + 1] += first_[v];
    arcs_.resize(added_.size());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t a = 0; a < added_.size(); a += 2) {
        const std::uint32_t there = next[added_[a + 1].to]++, back = next[added_[a].to]++;
        arcs_[there] = {added_[a].to, back, added_[a].capacity};
        arcs_[back] = {added_[a + 1].to, there, added_[a + 1].capacity};
    }
}

}  // namespace sqmap::decompose
