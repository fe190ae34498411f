// Devices without hardware: paths that were recorded or scripted, played a pose a tick.
#pragma once

#include "sqmap/device/device.h"
#include "sqmap/query/probe.h"

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace sqmap::device {

/// Plays poses: each read() gives the next one, whatever the clock says, so that runs repeat. A sample's time is the time of its
/// read(), as for any device. After the last pose the device is gone. Ignores wrenches. Thread safety: as every Device.
class PathDevice final : public Device {
public:
    /// poses: #ticks by #zones, a tick's zones side by side. rate: Hz at which they were taken, for capabilities().
    /// @throw DeviceError without poses, with zones outside 1 to k_max_zones or not a divisor, or a rate not above zero.
    PathDevice(std::string name, std::vector<Pose> poses, double rate, std::size_t zones = 1);

    [[nodiscard]] const Capabilities& capabilities() const noexcept override { return capabilities_; }
    bool read(Sample& sample) noexcept override;
    bool write(std::span<const Wrench> wrenches) noexcept override;
    void zero() noexcept override {}
    /// Number of poses per zone.
    [[nodiscard]] std::size_t ticks() const noexcept { return poses_.size() / capabilities_.zones; }

private:
    std::vector<Pose> poses_;
    Capabilities capabilities_;
    std::size_t next_ = 0;
};

/// Reads a CSV with the header r00,r01,r02,r10,...,r22,tx,ty,tz and a pose a row: x in the world = rotation x + translation.
/// @throw DeviceError that names the line: no such file, another header, not twelve finite numbers, rows that are not a
/// rotation within 1e-4, no row at all. Any thread.
[[nodiscard]] std::vector<Pose> read_path(const std::filesystem::path& path);

/// Motion of a scripted hand.
enum class Script {
    Press,   ///< in along the normal, a hold, out again
    Tap,     ///< in and out as a sine, its greatest speed as chosen
    Slide,   ///< along the surface, in the plane of its normal and travel, round the object again and again
    Circle,  ///< round the point that a press would touch
};

/// Lengths in mesh units, times in seconds.
struct ScriptOptions {
    double seconds = 10;   ///< in all
    double wait = 0;       ///< s of them at rest where the tool starts: the safety filter's ramp takes half a second
    double rate = 1000;    ///< Hz, poses a second
    double speed = 0.1;    ///< a second
    double depth = 0.002;  ///< of the deepest point of the tool
    double gap = 0.005;    ///< from where the tool starts
    double radius = 0.02;  ///< of the circle
    /// From the model's origin towards the point to touch, any length; zero: the first of z, x, y, -z, -x, -y that meets the
    /// surface.
    Vec3d direction{};
    Vec3d travel{1, 0, 0};  ///< direction in which a slide or circle starts, projected onto the surface
};

/// Time, s, from the start until the tool reaches its full depth; for a press or a tap, until it has left again. A script with
/// less time ends early. Any thread.
[[nodiscard]] double script_needs(Script script, const ScriptOptions& options) noexcept;

/// Poses of a tool over a model, in the mesh's frame and units; the tool keeps its orientation. Slides and circles are smoothed
/// over 50 ticks, so the depth holds on average. A circle follows the surface along one direction and hovers over drops. Neither
/// ever jumps. Deterministic. Cost: some 40 queries per tick of a slide or circle. Any thread.
/// @throw DeviceError where no surface lies in the direction, or for options out of range.
[[nodiscard]] std::vector<Pose> scripted_path(const model::ModelView& model, const query::Probe& tool, Script script,
                                              const ScriptOptions& options);

}  // namespace sqmap::device
