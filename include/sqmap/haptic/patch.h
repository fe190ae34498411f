// Points that stand for the surface of a tool, whatever its mesh: what Averaging::Patch sums over.
#pragma once

#include "sqmap/haptic/step.h"

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace sqmap::haptic {

/// One weight a point: the area about it, in the square of the points' unit.
struct PatchPoints {
    std::vector<Vec3d> points;
    std::vector<float> weights;
};

/// The corners of a mesh's triangles, each divided in four, again and again, while its longest edge exceeds `spacing`: finer
/// meshes of one surface then come to the same points where their triangles are larger than that. spacing 0: the vertices as
/// they are; first in any case, in their order. At most `most` points: the spacing is widened by a fifth until that holds or
/// nothing is divided. Allocates. @pre triangles index vertices
[[nodiscard]] PatchPoints patch_points(std::span<const Vec3d> vertices, std::span<const std::array<std::uint32_t, 3>> triangles,
                                       double spacing, std::size_t most = 100000);

/// Sets of patch_points of 2.5, 2 and 1.5 mm, for Zone::denser; those with no more points than the one before, or with more
/// than `most`, are left out. Allocates. @pre vertices in metres
class DenserSets {
public:
    DenserSets() = default;
    DenserSets(std::span<const Vec3d> vertices, std::span<const std::array<std::uint32_t, 3>> triangles,
               std::size_t most = 100000);
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
