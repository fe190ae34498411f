#include "steps.h"

#include <tuple>
#include <utility>

namespace sqmap::mesh {
namespace {

using Step = std::pair<std::uint32_t, std::uint32_t>;  // from, to

std::vector<Step> boundary_steps(const Surface& surface)
{
    std::vector<Step> steps;
    for_each_edge(edge_uses(surface.faces), [&](std::span<const EdgeUse> sides) {
        if (sides.size() != 1) return;
        const Triangle& v = surface.faces[sides[0].half / 3].v;
        const std::uint32_t k = sides[0].half % 3;
        steps.emplace_back(v[(k + 1) % 3], v[k]);
    });
    std::sort(steps.begin(), steps.end());
    return steps;
}

}  // namespace

std::vector<std::vector<std::uint32_t>> boundary_loops(const Surface& surface)
{
    const std::vector<Step> steps = boundary_steps(surface);
    std::vector<bool> taken(steps.size(), false);
    std::vector<std::uint32_t> index_in_path(surface.points.size(), k_none);
    std::vector<std::vector<std::uint32_t>> loops;
    for (std::size_t start = 0; start < steps.size(); ++start) {
        if (taken[start]) continue;
        std::vector<std::uint32_t> path{steps[start].first};
        index_in_path[path[0]] = 0;
        while (!path.empty()) {
            auto step = std::lower_bound(steps.begin(), steps.end(), Step{path.back(), 0});
            while (step != steps.end() && step->first == path.back() && taken[static_cast<std::size_t>(step - steps.begin())])
                ++step;
            if (step == steps.end() || step->first != path.back()) break;  // a dead end, or all loops of the path are cut off
            taken[static_cast<std::size_t>(step - steps.begin())] = true;
            const std::uint32_t v = step->second;
            if (index_in_path[v] == k_none) {
                index_in_path[v] = static_cast<std::uint32_t>(path.size());
                path.push_back(v);
                continue;
            }
            loops.emplace_back(path.begin() + index_in_path[v], path.end());
            for (std::size_t i = index_in_path[v] + 1; i < path.size(); ++i) index_in_path[path[i]] = k_none;
            path.resize(index_in_path[v] + 1);
        }
        for (const std::uint32_t v : path) index_in_path[v] = k_none;
    }
    // By position, so that the file's order of vertices has no say in how ties between triangulations are settled.
    const auto key = [&](std::uint32_t v) {
        const Vec3d p = surface.points[v];
        return std::tuple(p.x, p.y, p.z);
    };
    for (auto& loop : loops)
        std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end(), [&](auto a, auto b) { return key(a) < key(b); }),
                    loop.end());
    std::stable_sort(loops.begin(), loops.end(), [&](const auto& a, const auto& b) { return key(a[0]) < key(b[0]); });
    return loops;
}

}  // namespace sqmap::mesh
