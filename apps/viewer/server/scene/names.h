// Names of parts that mean something: surface points of an object that have a name, kept beside its model.
#pragma once

#include "sqmap/decompose/decompose.h"
#include "sqmap/mesh/mesh.h"
#include "sqmap/shape/superquadric.h"

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <vector>

namespace sqmap::viewer {

inline constexpr std::size_t k_max_landmarks = 256;

/// A point on the surface and what people call it.
struct Landmark {
    std::string name;
    Vec3d at{};  ///< mesh units
};

/// An object in words. They name points, not parts, so that names outlive another decomposition.
struct Words {
    std::vector<Landmark> landmarks;
    bool whole = false;  ///< the landmarks speak of all of it: a part between them is named after the nearest along the surface
    Vec3d forward{0, 0, 1}, up{0, 1, 0};  ///< where the object looks, for "upper", "front", "left"
};

/// Nothing where the text is not what names_json writes.
[[nodiscard]] std::optional<Words> read_names(const std::string& json);
[[nodiscard]] nlohmann::ordered_json names_json(const Words& words);

/// The frame of model space: position = origin + unit * model space, mesh units.
struct Frame {
    Vec3d origin{};
    double unit = 1;
};

/// A name for every part, no two alike. A part that holds landmarks is named after them, the others after the nearest landmark
/// where the words are whole, or else by shape and position: "long part, upper left front", as seen with x to the right, y up, z
/// towards the eye. mesh, superquadrics: model space.
[[nodiscard]] std::vector<std::string> part_names(const mesh::Mesh& mesh, const mesh::DualGraph& dual,
                                                  const decompose::Partition& partition,
                                                  const std::vector<shape::Superquadricd>& superquadrics, const Words& words,
                                                  const Frame& frame);

/// The words with a part called `name`: landmarks on it give way to one in its middle; an empty name only takes them away.
[[nodiscard]] Words renamed(const Words& words, const mesh::Mesh& mesh, const decompose::Partition& partition, std::uint32_t part,
                            const std::string& name, const Frame& frame);

}  // namespace sqmap::viewer
