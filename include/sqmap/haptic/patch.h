// Points that represent the surface of a tool, whatever its mesh: for Averaging::Patch.
#pragma once

#include "sqmap/haptic/zone.h"

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace sqmap::haptic {

/// Points with the area about each, in the square of the points' unit.
struct PatchPoints {
    std::vector<Vec3d> points;
    std::vector<float> weights;
};

/// The corners of a mesh's triangles, each divided in four, again and again, while its longest edge exceeds `spacing` (the
/// vertices' unit): a subdivided mesh thus gives the points of the coarse one, as long as its triangles exceed the spacing. The
/// first that holds or nothing is divided.
/// @pre triangles index vertices @throw std::bad_alloc. Cost: n log n in the points. Any thread.
[[nodiscard]] PatchPoints patch_points(std::span<const Vec3d> vertices, std::span<const std::array<std::uint32_t, 3>> triangles,
                                       double spacing, std::size_t max_points = 100000);

/// Sets of patch_points of 2.5, 2 and 1.5 mm, for Zone::denser; those with no more points than the one before, or with more
/// than max_points, are left out. Made outside the loop: the constructor allocates. @pre vertices in metres (not checked)
/// Thread safety: immutable once made; any number of threads may read it.
class DenserSets {
public:
    DenserSets() = default;
    /// vertices: metres. triangles: indices of them. max_points: of a set.
    DenserSets(std::span<const Vec3d> vertices, std::span<const std::array<std::uint32_t, 3>> triangles,
               std::size_t max_points = 100000);
    /// Valid while this lives and is not moved from.
    [[nodiscard]] std::span<const DenserPoints> points() const noexcept { return points_; }
    [[nodiscard]] std::size_t max_points() const noexcept;  ///< of the densest set; 0: there is none

private:
    struct Set {
        query::Probe probe;
        std::vector<float> weights;
    };
    std::vector<std::unique_ptr<Set>> sets_;
    std::vector<DenserPoints> points_;
};

}  // namespace sqmap::haptic
