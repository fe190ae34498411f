// The setup of a touch, the same for touching and for replaying: the solids, the tool, the state of the forces.
#pragma once

#include "device/hand.h"
#include "sqmap/device/trace.h"
#include "sqmap/haptic/step.h"
#include "sqmap/haptic/stiffness.h"
#include "sqmap/haptic/tool.h"
#include "sqmap/mesh/mesh.h"
#include "sqmap/paper/model_file.h"
#include "touch/objects.h"
#include "touch/options.h"

#include <array>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace sqmap::app {

/// Everything that step() reads, owned.
class TouchSetup {
public:
    /// beside: where files are looked for that are not found as named (a trace's folder).
    /// @throw BadTouch for files that cannot be read, or other content than their hash says; @throw io::ModelFileError
    explicit TouchSetup(const TouchOptions& options, std::size_t zones, const std::filesystem::path& beside = {});

    /// Fits what depends on the device: stiffness, coupling, the share of the torque, the encoder. Null: a path, which nothing
    /// swings.
    void suit(const haptic::DeviceLimits* device);

    /// As given, with hashes and scales filled in: goes into a trace.
    [[nodiscard]] const TouchOptions& options() const { return options_; }
    /// The first object in metres, and where its frame is.
    [[nodiscard]] const model::ModelView& first_model() const { return views_.front(); }
    [[nodiscard]] const sqmap::Pose& first_pose() const { return solids_.front().pose; }
    /// The probe that a script brings into contact: the tool's points; a point alone without the samples of its smoothing; of a
    /// hand on a glove the flat hand, its middle at the origin.
    [[nodiscard]] const query::Probe& tool() const { return point_ ? *point_ : tool_.probe(); }
    /// The same of all zones at once, where they stand at these poses; of a hand on a glove the flat hand, whatever they are.
    [[nodiscard]] query::Probe tool_at(std::span<const sqmap::Pose> zones) const;
    /// Notes for the user about these options, a line each.
    [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

    /// One tick: fills computed, depth, contacts and status of a row from its poses, twists, dt and input.
    void step(device::TraceRow& row) noexcept;
    /// m, how deep the device was in the last step: the row's depth, but where a proxy stays outside for it, how far behind that.
    [[nodiscard]] double device_depth() const { return device_depth_; }
    /// N, one a zone, of the last step: what the safety filter wants to know.
    [[nodiscard]] std::span<const double> pushes() const { return std::span(zone_pushes_).first(zones_); }

private:
    void load_tool(const std::filesystem::path& beside);
    void warn_of_idle_reading();
    void load_mesh_tool(const std::filesystem::path& beside, haptic::ToolDescription& tool);
    void add_edges(const mesh::Mesh& mesh, haptic::ToolDescription& tool);
    void load_hand(device::HandMesh mesh, haptic::ToolDescription& tool);
    [[nodiscard]] haptic::ZoneOptions options_of(std::size_t zone) const;

    TouchOptions options_;
    std::vector<paper::MappedModel> models_;
    std::vector<model::ModelView> views_;  // in metres
    std::vector<haptic::TouchedBody> solids_;
    std::vector<query::Probe> surfaces_;  // of the objects, where edges touch
    haptic::Tool tool_;
    std::unique_ptr<query::Probe> point_;
    std::unique_ptr<device::HandSkin> hand_;
    double reach_ = 0;  // m, of the points of a mesh from their zone's pose
    SurfaceTexture texture_;
    MovingObjects objects_;
    std::vector<haptic::Wrench> pushes_;  // on the objects
    double device_depth_ = 0;             // m
    std::array<double, device::k_max_zones> zone_pushes_{};
    std::vector<std::string> notes_;
    std::unique_ptr<haptic::State> state_;
    std::size_t zones_;
};

}  // namespace sqmap::app
