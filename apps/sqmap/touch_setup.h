// What a touch is made of, the same for touching and for replaying: the solids, the tool, the forces' options.
#pragma once

#include "sqmap/device/trace.h"
#include "sqmap/haptic/step.h"
#include "sqmap/io/model_file.h"

#include <CLI/CLI.hpp>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace sqmap::app {

/// A model, a tool or a trace's setup that cannot be used; what() says why.
class BadTouch : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

struct TouchObject {
    std::string file;
    Vec3d place{};               ///< of the model's origin in the world, m
    double metres_per_unit = 0;  ///< of the mesh
    std::uint64_t hash = 0;      ///< of the model's content; 0: any
};

struct TouchOptions {
    std::vector<TouchObject> objects;
    std::string tool = "sphere";                            ///< sphere[:RADIUS, m], point[:SMOOTHING RADIUS, m] or a mesh file
    double tool_size = 0.1;                                 ///< m, R_max of a tool that is a mesh
    double tool_spacing = 0;                                ///< m, of the points of a tool that is a mesh; 0: its vertices
    std::uint64_t tool_hash = 0;                            ///< of its points; 0: any
    haptic::ZoneOptions zone{.layer = query::Layer::Auto};  ///< Auto: Exact for a sphere or a point, Three for a mesh
    double zone_radius = 0;                                 ///< m, of the impact sphere; 0: the whole tool
    haptic::Material material{};
};

/// Everything that step() reads, owned.
class TouchSetup {
public:
    /// beside: where files are looked for that are not found as named (a trace's folder).
    /// @throw BadTouch for files that cannot be read, or other content than their hash says; @throw io::ModelFileError
    explicit TouchSetup(const TouchOptions& options, std::size_t zones, const std::filesystem::path& beside = {});

    /// As given, with hashes and scales filled in: goes into a trace.
    [[nodiscard]] const TouchOptions& options() const { return options_; }
    /// The first object in metres, and where its frame is.
    [[nodiscard]] const model::ModelView& first_model() const { return views_.front(); }
    [[nodiscard]] const haptic::Pose& first_pose() const { return solids_.front().pose; }
    /// What a script brings into contact: the tool's points; of a point the point alone, not the samples of its smoothing.
    [[nodiscard]] const query::Probe& tool() const { return point_ ? *point_ : *probe_; }

    /// One tick: fills computed, depth, contacts and status of a row from its poses, twists, dt and input.
    void step(device::TraceRow& row) noexcept;
    /// Forgets what was felt: the start of another recording.
    void reset() noexcept { state_->reset(); }

private:
    void load_tool(const std::filesystem::path& beside);

    TouchOptions options_;
    std::vector<io::MappedModel> models_;
    std::vector<model::ModelView> views_;  // in metres
    std::vector<haptic::Solid> solids_;
    std::unique_ptr<query::Probe> probe_, point_;
    std::vector<float> weights_;
    std::unique_ptr<haptic::State> state_;
    std::size_t zones_;
};

/// The softest spring, N/m, that these forces show to the hand: what SafetyOptions::softest wants to know.
[[nodiscard]] double softest_spring(const TouchOptions& options);

/// The setup as a trace's field "setup" has it, and back.
[[nodiscard]] std::string setup_text(const TouchOptions& options);
/// @throw BadTouch where the text is no setup.
[[nodiscard]] TouchOptions setup_from(const std::string& text);

/// Adds the options of the forces to a subcommand.
void add_force_options(CLI::App& command, TouchOptions& options);

}  // namespace sqmap::app
