// A garment on its avatar, and what is said of it in the end.
#pragma once

#include "common/dress/handling.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <string>
#include <vector>

namespace sqmap::app {

/// The time of a stage in each step.
struct Stage {
    std::vector<double> us;
    [[nodiscard]] nlohmann::json summary();
};

struct Worn {
    GarmentFile file;
    sim::Cloth cloth;
    Stage predict, move, query, response, threads, self, collision;
    std::vector<std::vector<Vec3d>> shapes;
    std::uint32_t status = 0;
    std::size_t caught = 0, max_contacts = 0;
    double deepest_walking = 0;
    sim::Drape drape{};
    double least_energy = INFINITY, start_energy = NAN, max_energy = -INFINITY;
    std::unique_ptr<Handling> handling{};
    double began_inside = 0;  ///< m, the deepest vertex at first

    /// After each step of the cloth.
    void add(const sim::StepReport& step, double time);
};

/// The report of a drape, for people.
[[nodiscard]] std::string text_of(const sim::DrapeReport& drape);

/// Penetration, strain, seams, pulls, time by stage, and in words what went wrong; against the solids as they are at the end.
[[nodiscard]] nlohmann::json report_of(Worn& worn, double height, std::span<const sim::Collider> solids, double time);

}  // namespace sqmap::app
