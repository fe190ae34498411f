#include "truth.h"

#include "distance_grid.h"
#include "parallel/for_each.h"

namespace sqmap::bench {

std::vector<std::vector<TrueContact>> true_contacts(const Setting& setting, std::span<const Pose> path)
{
    struct Seen {
        Vec3d at{};
        double distance = 0;  ///< signed; a vertex not yet seen is anywhere
    };
    const auto& vertices = setting.probe.vertices;
    std::vector<std::vector<TrueContact>> frames(path.size());
    constexpr std::size_t k_slice = 64;  // frames whose vertices are followed from one to the next
    parallel::for_slices(path.size(), k_slice, setting.threads, [&](parallel::Slice slice) {
        std::vector<Seen> seen(vertices.size());
        for (std::size_t f = slice.first; f < slice.first + slice.count; ++f)
            for (std::uint32_t i = 0; i < vertices.size(); ++i) {
                const Vec3d p = apply(path[f], vertices[i]);
                Seen& last = seen[i];
                const double moved = norm(p - last.at) * (1 + 1e-9);
                // The ball of its distance about where it was lies on one side of the surface.
                if (moved < last.distance) continue;
                last = {p, signed_distance(setting.solid, p)};
                if (last.distance < 0) frames[f].push_back({i, -last.distance});
            }
    });
    return frames;
}

}  // namespace sqmap::bench
