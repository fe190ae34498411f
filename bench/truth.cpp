#include "truth.h"

#include "distance_grid.h"

#include <algorithm>
#include <thread>

namespace sqmap::bench {

std::vector<std::vector<TrueContact>> true_contacts(const Setting& setting, std::span<const Pose> path)
{
    struct Seen {
        Vec3d at{};
        double distance = 0;  ///< signed; a vertex not yet seen is anywhere
    };
    const auto& vertices = setting.probe.vertices;
    std::vector<std::vector<TrueContact>> frames(path.size());
    const auto run = [&](std::size_t begin, std::size_t end) {
        std::vector<Seen> seen(vertices.size());
        for (std::size_t f = begin; f < end; ++f)
            for (std::uint32_t i = 0; i < vertices.size(); ++i) {
                const Vec3d p = path[f](vertices[i]);
                Seen& last = seen[i];
                const double moved = norm(p - last.at) * (1 + 1e-9);
                // The ball of its distance about where it was lies on one side of the surface.
                if (moved < last.distance) continue;
                last = {p, signed_distance(setting.solid, p)};
                if (last.distance < 0) frames[f].push_back({i, -last.distance});
            }
    };
    const std::size_t thread_count = std::min<std::size_t>(
        path.size(), setting.threads != 0 ? setting.threads : std::max(1u, std::thread::hardware_concurrency()));
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < thread_count; ++t)
        threads.emplace_back(run, path.size() * t / thread_count, path.size() * (t + 1) / thread_count);
    for (std::thread& thread : threads) thread.join();
    return frames;
}

}  // namespace sqmap::bench
