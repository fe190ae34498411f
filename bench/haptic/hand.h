// The hand on its shared paths: what a tick costs, and what a denser hand feels.
#pragma once

#include "../setting.h"

#include <cstdint>
#include <filesystem>

namespace sqmap::bench {

struct HandPath {
    Files files;
    std::filesystem::path path;
};

/// CPU time of a whole step, us: query, force, torque and friction of one zone.
struct TickCost {
    double p50 = 0, p99 = 0, p999 = 0;  ///< over all samples
    double contacts = 0;                ///< a tick, in the mean
    std::uint32_t ticks = 0;
};
[[nodiscard]] TickCost tick_cost(const HandPath& path, int passes);

/// How the force and torque of a probe with every triangle split in four differ from the probe's own, percent.
struct DensityChange {
    double force_median = 0, force_p95 = 0, force_max = 0, torque_median = 0, torque_p95 = 0;
    std::uint32_t touching = 0;
    double contacts = 0, dense_contacts = 0;
};
/// weighted: each vertex by its share of the area.
[[nodiscard]] DensityChange density_change(const HandPath& path, bool weighted);

}  // namespace sqmap::bench
