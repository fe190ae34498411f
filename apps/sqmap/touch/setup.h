// What a touch is made of, the same for touching and for replaying: the solids, the tool, the forces' options.
#pragma once

#include "sqmap/device/hand_skin.h"
#include "sqmap/device/trace.h"
#include "sqmap/haptic/patch.h"
#include "sqmap/haptic/step.h"
#include "sqmap/io/model_file.h"
#include "sqmap/mesh/mesh.h"
#include "touch/surface_texture.h"

#include <CLI/CLI.hpp>

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
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

/// How the objects move: all alike.
struct BodyOptions {
    double mass = 0;         ///< kg; 0: what touches does not move them
    double spring = 200;     ///< N/m that holds each at its place, critically damped, in turning with the same frequency; 0: free
    Vec3d sway{};            ///< m, to either side of the place
    double sway_period = 2;  ///< s
};

/// What the user says of the coupling; what is not said is taken from the device.
struct CouplingWishes {
    std::optional<double> stiffness, damping, rotational, rotational_damping, inertia;
};

struct TouchOptions {
    std::vector<TouchObject> objects;
    std::string tool = "sphere";  ///< sphere[:RADIUS, m], point[:SMOOTHING RADIUS, m] or a mesh file
    double tool_size = 0.1;       ///< m, R_max of a tool that is a mesh
    double tool_spacing = 0;      ///< m, of the points of a tool that is a mesh; 0: its vertices
    double tool_touching = 0;     ///< most points of haptic::DenserSets that touch, without tool_spacing; 0: no such sets
    std::uint64_t tool_hash = 0;  ///< of its points; 0: any
    haptic::ZoneOptions zone{.layer = query::Layer::Auto};  ///< Auto: Exact for a sphere or a point, Three for a mesh
    double zone_radius = 0;                                 ///< m, of the impact sphere; 0: the whole tool
    haptic::Material material{};
    haptic::Kernel kernel = haptic::Kernel::Ball;  ///< of a sphere's or point's smoothing
    double tolerance = -1;                         ///< m, of it; below zero: the tool's own
    double hand_length = 0.19;                     ///< m, of a skinned hand on a glove
    TextureOptions texture{};
    std::uint64_t texture_hash = 0;  ///< of its table; 0: any
    BodyOptions body{};
    CouplingWishes coupling{};      ///< not in a trace: the numbers in zone are
    bool stiffness_wished = false;  ///< nor is this: zone.stiffness is the user's word, not to be lowered for a device
};

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
    /// What a script brings into contact: the tool's points; of a point the point alone, not the samples of its smoothing; of a
    /// hand on a glove the flat hand, its middle at the origin.
    [[nodiscard]] const query::Probe& tool() const { return point_ ? *point_ : *probe_; }
    /// The same of all zones at once, where they stand at these poses; of a hand on a glove the flat hand, whatever they are.
    [[nodiscard]] query::Probe tool_at(std::span<const sqmap::Pose> zones) const;
    /// A glove poses a skinned hand every tick.
    [[nodiscard]] bool has_hand() const { return hand_ != nullptr; }
    /// What the user should know of these options; a line each.
    [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

    /// One tick: fills computed, depth, contacts and status of a row from its poses, twists, dt and input.
    void step(device::TraceRow& row) noexcept;
    /// m, how deep the device was in the last step: the row's depth, but where a proxy stays outside for it, how far behind that.
    [[nodiscard]] double device_depth() const { return device_depth_; }
    /// N, one a zone, of the last step: what the safety filter wants to know.
    [[nodiscard]] std::span<const double> pushes() const { return std::span(zone_pushes_).first(zones_); }

private:
    /// An object that moves: its centre and what of it has moved.
    struct Body {
        Vec3d centre{};        ///< mesh frame, m
        Vec3d off{}, speed{};  ///< of the centre, from the place
        Mat3d turn{};
        Vec3d spin{};
        double inertia = 0;  ///< kg m^2
    };

    void load_tool(const std::filesystem::path& beside);
    void load_mesh_tool(const std::filesystem::path& beside, mesh::Mesh& tool);
    void load_hand(device::HandMesh mesh);
    [[nodiscard]] std::vector<haptic::Zone> zones_of_tool() const;
    [[nodiscard]] haptic::ZoneOptions options_of(std::size_t zone) const;
    void place(std::size_t object) noexcept;
    void move_objects(double dt) noexcept;

    TouchOptions options_;
    std::vector<io::MappedModel> models_;
    std::vector<model::ModelView> views_;  // in metres
    std::vector<haptic::TouchedBody> solids_;
    std::unique_ptr<query::Probe> probe_, point_;
    std::unique_ptr<device::HandSkin> hand_;
    std::vector<Vec3d> points_;  // of the probe
    std::vector<float> weights_;
    haptic::DenserSets denser_;
    double reach_ = 0;  // m, of the points of a mesh from their zone's pose
    SurfaceTexture texture_;
    std::vector<Body> bodies_;
    std::vector<haptic::Wrench> pushes_;  // on the objects
    double time_ = 0;                     // s
    double device_depth_ = 0;             // m
    std::array<double, device::k_max_zones> zone_pushes_{};
    std::vector<std::string> notes_;
    std::unique_ptr<haptic::State> state_;
    std::size_t zones_;
};

/// A file as named, or of that name in the folder beside.
[[nodiscard]] std::filesystem::path found(const std::string& file, const std::filesystem::path& beside);

/// @throw BadTouch for numbers that do not go together or are out of range. what: what has them, "" for options.
void check(const TouchOptions& options, const std::string& what);

/// The softest spring, N/m, that these forces show to the hand: what SafetyOptions::softest wants to know.
[[nodiscard]] double softest_spring(const TouchOptions& options);

/// The setup as a trace's field "setup" has it, and back.
[[nodiscard]] std::string setup_text(const TouchOptions& options);
/// @throw BadTouch where the text is no setup.
[[nodiscard]] TouchOptions setup_from(const std::string& text);

/// Tells, on standard error, of options that were given and count with others only.
void warn_of_idle(const CLI::App& command, const TouchOptions& options);

/// Adds the options of the forces to a subcommand.
void add_force_options(CLI::App& command, TouchOptions& options);

}  // namespace sqmap::app
