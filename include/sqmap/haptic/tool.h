// A tool: from its description to the zones that step() reads, with the points and probes that they refer to.
#pragma once

#include "sqmap/haptic/patch.h"
#include "sqmap/haptic/step.h"
#include "sqmap/haptic/zone.h"
#include "sqmap/math/assert.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace sqmap::haptic {

/// The body that touches.
enum class ToolShape : std::uint8_t {
    Surface,  ///< the description's points
    Point,    ///< a point, whose force is smoothed over a sphere about it (force.smoothing). On the smoothed map of a paper model
              ///< the point alone, which that map smooths
    Ball,     ///< a ball about the zone's tip. A paper model's smoothed map takes a Surface in its place
};

/// The description of a tool. SI units.
struct ToolDescription {
    ZoneOptions force{};  ///< mode, layer and force of all zones; the shape sets averaging, a Ball also smoothing
    ToolShape shape = ToolShape::Surface;
    double ball_radius = 0.005;         ///< Ball: m
    std::optional<double> tolerance{};  ///< Point, Ball: Smoothing::tolerance, m; absent: 0.2 mm of a point, 0.3 mm of a ball
    std::vector<Vec3d> points{};        ///< Surface: m, the zone's frame
    std::vector<float> weights{};       ///< Surface: m^2 about each point; empty: all alike
    DenserSets denser{};                ///< Surface: the same surface with more points
    /// Surface, as a whole: triangles between its points that close it, so that edges and faces touch too (Zone::surface). Empty:
    /// points alone. @pre query::find_fault(points, triangles) finds nothing
    std::vector<query::ProbeTriangle> triangles{};
    std::uint32_t max_touching = 1200;  ///< points of a denser set in contact
    double radius = 0;                  ///< m, of the impact sphere about a zone's pose; 0: the whole tool is felt
    std::size_t zones = 1;              ///< each carries the whole tool at a pose of its own, where `first` is empty
    /// Index of each zone's first point, then #points: the zones are fingers of one hand. The points are in the world then
    /// and follow by Tool::probe().move.
    std::vector<std::uint32_t> first{};
};

/// The surface of a mesh as a tool: the description's points and weights by patch_points, and denser sets where wanted.
/// @throw std::bad_alloc
void take_surface(ToolDescription& tool, std::span<const Vec3d> vertices, std::span<const std::array<std::uint32_t, 3>> triangles,
                  double spacing, bool has_denser);

/// A tool that is made, outside the loop. Movable: what the zones refer to stays where it is.
/// Thread safety: as a probe; the zones may be read by any number of threads.
class Tool {
public:
    Tool() = default;
    /// @throw std::bad_alloc
    explicit Tool(ToolDescription description);

    /// Valid while this lives.
    [[nodiscard]] std::span<const Zone> zones() const noexcept { return zones_; }
    /// The tool's points in its own frame, m. Valid while this lives.
    [[nodiscard]] std::span<const Vec3d> points() const noexcept { return description_.points; }
    /// The probe of the same points, which a deforming tool moves. @pre the tool was made of a description
    [[nodiscard]] query::Probe& probe() noexcept
    {
        SQMAP_ASSERT(probe_ != nullptr);
        return *probe_;
    }
    /// The probe of the same points. @pre the tool was made of a description
    [[nodiscard]] const query::Probe& probe() const noexcept
    {
        SQMAP_ASSERT(probe_ != nullptr);
        return *probe_;
    }
    /// The forces of these zones on so many touched bodies; refers to the tool. @throw std::bad_alloc
    [[nodiscard]] State state(std::size_t max_touched = 1) const;

private:
    ToolDescription description_;
    std::unique_ptr<query::Probe> probe_;
    std::unique_ptr<query::Probe> surface_;  ///< with triangles; null: points alone
    std::vector<Zone> zones_;
};

}  // namespace sqmap::haptic
