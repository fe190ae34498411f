// What a browser may say: JSON text to a checked struct, or nothing.
#pragma once

#include "sqmap/math/vec.h"
#include "sqmap/query/query.h"

#include <cstdint>
#include <optional>
#include <string_view>

namespace sqmap::viewer {

/// What the page's sliders set.
struct Settings {
    query::Layer layer = query::Layer::Three;
    double stiffness = 400;      ///< N/m, 0 to 2000; the simulated device is proven stable to 467
    double damping = 0.3;        ///< N s/m, 0 to 5
    double friction = 0.3;       ///< mu_dynamic, 0 to 1.5; mu_static is a third more
    double texture = 0;          ///< m, standard deviation of the relief, 0 to 0.001
    double smoothing = 0;        ///< m, radius of the smoothing sphere of a point as tool, 0: the tool is a ball; 0 to 0.01
    double tool_radius = 0.006;  ///< m, of the ball, 0.001 to 0.05
    double zone = 0;             ///< m, of the impact zone about the tool's lowest place; 0: the whole tool; to 0.1
    double force_limit = 2;      ///< N, 0.1 to 3.3
    bool operator==(const Settings&) const = default;
};

enum class Say : std::uint8_t {
    Touch,  ///< where the hand wants the tool, and whether it is held there
    Stop,
    Resume,
    Settings,
    Device,  ///< by its place in the list that the server sent
    Split,   ///< part of an object, in two
    Merge,   ///< part and other
    Refit,   ///< superquadrics of the edited parts anew, bent and tapered ones tried
    Undo,
    Redo,
    Bake,    ///< the edited parts become the object's model
    Remove,  ///< the object
};

struct Message {
    Say say = Say::Stop;
    Vec3d target{};  ///< m, world
    bool held = false;
    Settings settings{};
    std::uint32_t device = 0, object = 0, part = 0, other = 0;
};

/// Nothing for what is not JSON, not an object, nested deeper than 4, of an unknown kind, with a number missing, out of its range
/// or not finite. Fields that a kind does not have are an error too.
[[nodiscard]] std::optional<Message> read_message(std::string_view text);

}  // namespace sqmap::viewer
