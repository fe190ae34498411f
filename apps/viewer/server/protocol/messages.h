// Messages of a browser: JSON text becomes a checked struct, or nothing.
#pragma once

#include "sqmap/haptic/zone.h"
#include "sqmap/math/vec.h"
#include "sqmap/paper/force.h"
#include "sqmap/paper/model.h"
#include "sqmap/query/point.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sqmap::viewer {

/// The axis of an object's mesh that points upwards in the world.
enum class Up : std::uint8_t { X, Y, Z };
[[nodiscard]] const char* name_of(Up up) noexcept;  ///< "x", "y" or "z"
[[nodiscard]] std::optional<Up> up_named(std::string_view name) noexcept;

/// A tool: a ball, the project's own hand, or a mesh of the scene.
enum class ToolKind : std::uint8_t { Ball, Hand, Mesh };

/// The state of the page's sliders.
struct Settings {
    /// Not layer One. Nothing: as the tool needs it, Exact for a ball or a point, Three for a hand or a mesh.
    std::optional<query::Layer> layer{};
    double tolerance = 0.0002;  ///< m, of layer Auto, 0 to 0.01
    bool paper_force = false;   ///< paper::with_paper_force, of paper models
    bool proxy = true;          ///< the tool stays on the surface while the hand goes below it; not with the paper's force
    double stiffness = haptic::ZoneOptions{}.stiffness;  ///< N/m, 0 to 2000
    double damping = 0.3;                                ///< N s/m, 0 to 5
    Friction law = haptic::Material{}.friction;
    double friction = haptic::Material{}.mu_dynamic;                    ///< 0 to 1.5; mu_static is a third more
    double f_c = haptic::Material{}.f_c, k_f = haptic::Material{}.k_f;  ///< eq. 33: N, 0 to 2, and 1/m, 0 to 1000
    double texture = 0;                                                 ///< m, standard deviation of the relief, 0 to 0.001
    double smoothing = 0;        ///< m, radius of the smoothing sphere of a point as tool, 0: the tool is a ball; 0 to 0.01
    double tool_radius = 0.006;  ///< m, of the ball, 0.001 to 0.05
    double zone = 0;         ///< m, of the impact zone of a hand or a mesh about the tool's position; 0: the whole tool; to 0.1
    double force_limit = 2;  ///< N, 0.1 to 3.3
    paper::QueryOptions paper{};         ///< how objects with the paper's maps are read; numbers within paper::k_query_numbers
    std::uint32_t gate = query::k_gate;  ///< k_L of layer Gate, to 1000
    bool offset = false;                 ///< eq. 12, with the paper's force
    bool edges = false;                  ///< edges and faces of a hand or a mesh touch too, where its surface is closed
    ToolKind tool = ToolKind::Ball;
    std::uint32_t tool_object = 0;  ///< of the scene, where the tool is a mesh
    double tool_size = 0.06;        ///< m, largest extent of a hand or a mesh, 0.01 to 0.3
    double tool_turn = 0;           ///< degrees about the upward axis, then
    double tool_tilt = 0;           ///< degrees about the axis to the right, -180 to 180
    bool operator==(const Settings&) const = default;
};

/// As the page sends and gets them.
[[nodiscard]] nlohmann::ordered_json settings_json(const Settings& settings);
/// Reads them from an object that may have other fields too. False where a field is missing or out of its range.
[[nodiscard]] bool read_settings(const nlohmann::json& in, Settings& settings);
/// How many fields a message or a recording has for them: recordings from before there were settings of the paper's maps have
/// fewer.
[[nodiscard]] std::size_t settings_fields(const nlohmann::json& in);

enum class Say : std::uint8_t {
    Touch,  ///< where the hand wants the tool, and whether it is held there
    Take,   ///< the tool from another window
    Rest,   ///< the page shows nothing that is touched: the servo ends unless another page holds the tool
    Stop,
    Resume,
    Settings,
    Device,   ///< by its number in the list that the server sent
    Split,    ///< part of an object, in two
    Merge,    ///< part and other
    MoveCut,  ///< between part and other, into other by `distance`
    Refit,    ///< the part's superquadric anew
    Name,     ///< a part; an empty name takes it away
    Undo,
    Redo,
    Bake,     ///< the edited parts become the object's model
    Rebake,   ///< the same parts with the other projection, as another object
    Remove,   ///< the object
    Restore,  ///< the object that was removed last
    Hide,     ///< the object, from sight and touch, or no more
    Move,     ///< the object's centre
    Turn,     ///< the object, so that another axis of its mesh points upwards
    Rename,   ///< the object
    Cancel,   ///< an upload
    Record,   ///< every tick from here on, instead of what was recorded before; or no more
    Fit,      ///< what is to be worn: garment, fabric, whether the figure walks
    Cloth,    ///< what is done to it
    Undress,  ///< the figure and its cloth are no longer wanted
};

/// An act on the cloth.
enum class Handling : std::uint8_t { Grasp, Drag, Release, Pin, Unpin, Cut, Sew, Slit, Restart };

inline constexpr std::size_t k_max_line = 64;

/// A point on the cloth, wherever it goes: corner 0 + u (corner 1 - corner 0) + v (corner 2 - corner 0) of a triangle.
struct ClothPoint {
    std::uint32_t triangle = 0;
    double u = 0, v = 0;  ///< 0 to 1
    bool operator==(const ClothPoint&) const = default;
};

struct Message {
    Say say = Say::Stop;
    Vec3d target{};     ///< m, world
    bool held = false;  ///< of Record and Hide: on
    Up up = Up::Y;      ///< of Turn
    Settings settings{};
    std::uint32_t device = 0, object = 0, part = 0, other = 0;
    std::uint32_t upload = 0;  ///< the page's number of it
    double distance = 0;       ///< m, of MoveCut, 0 to 0.1
    std::string name{};        ///< of a part or an object, at most k_max_name bytes, no control characters
    std::string garment{}, fabric{};
    bool walks = false;
    Handling handling = Handling::Release;  ///< target: where; part: which seam
    std::vector<ClothPoint> line{};         ///< of Slit: 2 to k_max_line
};

/// The object of a JSON text of the page, or of a file that it sends; nothing for any other text, or where brackets are nested
/// deeper than max_depth.
[[nodiscard]] std::optional<nlohmann::json> shallow_object(std::string_view text, int max_depth);
/// Three numbers from -max to max; nothing for anything else.
[[nodiscard]] std::optional<Vec3d> vector_in(const nlohmann::json& in, double max);

/// Nothing for what is not JSON, not an object, nested deeper than 4, of an unknown kind, with a number missing, out of its range
/// or not finite. Fields that a kind does not have are an error too.
[[nodiscard]] std::optional<Message> read_message(std::string_view text);

}  // namespace sqmap::viewer
