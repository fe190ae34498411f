// The options of a touch, as the command line and traces give them: the objects, the tool, the forces.
#pragma once

#include "sqmap/haptic/step.h"
#include "sqmap/paper/model.h"
#include "touch/surface_texture.h"

#include <cstdint>
#include <filesystem>
#include <optional>
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
    Vec3d position{};            ///< of the model's origin in the world, m
    double metres_per_unit = 0;  ///< of the mesh
    std::uint64_t hash = 0;      ///< of the model's content; 0: any
    std::string projection{};    ///< of the model, for the trace's reader
};

/// How the objects move: all alike.
struct BodyOptions {
    double mass = 0;      ///< kg; 0: what touches does not move them
    double spring = 200;  ///< N/m that holds each at its position, critically damped, in turning with the same frequency; 0: free
    Vec3d sway{};         ///< m, to either side of the position
    double sway_period = 2;  ///< s
};

/// The user's wishes for the coupling; the device gives the values that are not set.
struct CouplingWishes {
    std::optional<double> stiffness, damping, rotational, rotational_damping, inertia;
};

struct TouchOptions {
    std::vector<TouchObject> objects;
    std::string tool = "sphere";  ///< sphere[:RADIUS, m], point[:SMOOTHING RADIUS, m] or a mesh file
    double tool_size = 0.1;       ///< m, R_max of a tool that is a mesh
    double tool_spacing = 0;      ///< m, of the points of a tool that is a mesh; 0: its vertices
    double tool_touching = 0;     ///< most points of haptic::DenserSets that touch, without tool_spacing; 0: no such sets
    bool edges = false;           ///< edges and faces of a tool that is a mesh touch too
    bool touching_wished = true;  ///< tool_touching is the user's; else fewer suffice where the models answer slowly
    std::uint64_t tool_hash = 0;  ///< of its points; 0: any
    haptic::ZoneOptions zone{.layer = query::Layer::Auto};  ///< Auto: Exact for a sphere or a point, Three for a mesh
    bool paper_force = false;                               ///< paper::with_paper_force, on paper models
    paper::QueryOptions paper{};                            ///< how paper models are read
    bool no_gaps = false, no_pruning = false;               ///< of the command line; paper has them else
    double zone_radius = 0;                                 ///< m, of the impact sphere; 0: the whole tool
    haptic::Material material{};
    haptic::Kernel kernel = haptic::Kernel::Ball;  ///< of a sphere's or point's smoothing
    double tolerance = -1;                         ///< m, of it; below zero: the tool's own
    double hand_length = 0.19;                     ///< m, of a skinned hand on a glove
    TextureOptions texture{};
    std::uint64_t texture_hash = 0;  ///< of its table; 0: any
    BodyOptions body{};
    CouplingWishes coupling{};      ///< a trace does not hold these: it holds the numbers in zone
    bool stiffness_wished = false;  ///< the user gave zone.stiffness, so no device lowers it; a trace does not hold this
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

}  // namespace sqmap::app
