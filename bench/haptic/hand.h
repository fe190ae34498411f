// The hand on its shared paths: what a tick costs, and what a denser hand feels.
#pragma once

#include "../setting.h"
#include "sqmap/model/model.h"

#include <cstdint>
#include <filesystem>
#include <vector>

namespace sqmap::bench {

struct HandPath {
    Files files;
    std::filesystem::path path;
    double spacing = 0;                       ///< m, of the points that stand for the hand's surface; 0: its vertices
    int touching = 0;                         ///< most points that touch of a denser set (haptic::Zone::denser); 0: no such sets
    int divide = 0;                           ///< times that every triangle of the hand is split in four before anything else
    std::vector<std::filesystem::path> by{};  ///< objects that stand by in the scene
    bool paper = false;                       ///< the objects are paper models, and force is the paper's
    bool edges = false;                       ///< edges and faces touch too
    bool exact = false;                       ///< the exact layer instead of layer 3
};

/// CPU time of a whole tick, us: query, force, torque and friction of one zone, safety filter.
struct TickCost {
    double p50 = 0, p99 = 0, p999 = 0;     ///< over all samples
    double query_p50 = 0, query_p999 = 0;  ///< of the query that it makes, alone
    double scene_p50 = 0, scene_p999 = 0;  ///< of a step with all that stands by
    double contacts = 0;                   ///< a tick, in the mean
    std::uint32_t ticks = 0;
    struct Tick {
        double query_us = 0, us = 0;  ///< medians over the passes
        std::uint32_t contacts = 0;
    };
    std::vector<Tick> series;  ///< a pose of the path each
};
[[nodiscard]] TickCost tick_cost(const HandPath& path, int passes);

/// How the force and torque of a probe with every triangle split in four differ from the probe's own, percent.
struct DensityChange {
    double force_median = 0, force_p95 = 0, force_max = 0;  ///< of the force
    double within_5 = 0;                                    ///< share of the ticks whose force changes by less than 5 %
    double share_median = 0, share_p95 = 0, share_max = 0;  ///< of stiffness times depth: opposite contacts do not cancel in it
    double torque_median = 0, torque_p95 = 0;
    std::uint32_t touching = 0;
    double contacts = 0, dense_contacts = 0;
};
/// weighted: each vertex by its share of the area.
[[nodiscard]] DensityChange density_change(const HandPath& path, bool weighted);

}  // namespace sqmap::bench
