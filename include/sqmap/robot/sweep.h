// Decides which links of a robot can collide within the limits of its joints: proven by branch and bound, not sampled.
// Any number of threads, on files of their own.
#pragma once

#include "sqmap/bake_mesh.h"
#include "sqmap/robot/description.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sqmap::robot {

/// Options of a sweep.
struct SweepOptions {
    std::vector<std::pair<std::string, std::string>> pairs{};  ///< of links; empty: all pairs of links that have shapes
    Packages packages{};
    MeshOptions mesh{};
    double seconds = 600;  ///< after which pairs are left open; what is decided before does not depend on it
    unsigned threads = 0;  ///< 0: one a core; verdicts do not depend on it
};

/// The outcome for a pair of links.
enum class PairVerdict : std::uint8_t {
    Colliding,  ///< they touch or cut one another in the pose that is given
    Free,       ///< proven to touch nowhere within the limits
    Open,       ///< neither is known, for the reason that is given
    Adjacent,   ///< neighbours, whose shapes commonly overlap at their joint: not swept
};
/// "colliding", "free", "open" or "adjacent". Never null.
[[nodiscard]] const char* name_of(PairVerdict verdict) noexcept;

/// A pair of links, swept.
struct SweptPair {
    /// The position of a joint between the links.
    struct Position {
        std::string joint;
        double value = 0;  ///< radians or metres
    };
    std::string a, b;
    PairVerdict verdict = PairVerdict::Open;
    double bound = 0;              ///< Free: the links are farther apart than this in every pose, metres, proven
    double seen = 0;               ///< smallest clearance of a pose that was looked at, metres; 0 where they collide
    std::vector<Position> pose{};  ///< in which `seen` was seen; joints that move the pair and follow no other
    double left = 0;               ///< Open: share of the joints' range that no proof covers
    std::uint64_t cells = 0;       ///< of that range which were judged
    bool fixed = false;            ///< no joint moves one against the other
    mesh::Words reason{};          ///< of Open
};

/// A link's shapes, as swept.
struct SweptLink {
    std::string name;
    std::size_t triangles = 0;
    std::string verdict{};  ///< of admission of its meshes: "ACCEPT", "WRAPPED, E_OPEN"
    mesh::Words problem{};  ///< not empty: a shape is missing from it, and why; its pairs are open unless they collide
};

/// A robot, swept.
struct Sweep {
    std::vector<SweptLink> links;  ///< that have shapes, in the file's order
    std::vector<SweptPair> pairs;  ///< in that order
};

/// Judges pairs of links. Shapes are the robot's collision elements: boxes, cylinders and spheres as they are, meshes as their
/// files have them, filled where they bound a solid; where a cure closed or wrapped one, both its surface and the file's. Links
/// are adjacent if at most one moving joint and no link with shapes is between them. Joints that follow another one move with
/// it, within the limits of both. The range of the joints between two links is divided into cells; a cell is free where the
/// triangles, in the pose of its middle, are farther apart than the joints can move them against one another in the cell: by
/// their distances from the joints' axes, for each pair of branches of the links' trees of triangles. Cells are divided until
/// all are free by half the smallest clearance seen, or a pose collides. Distances are in double; a ten-thousandth of a millionth
/// of the robot's size allows for rounding.
/// @throw DescriptionError as read_description, and for a pair that names no link; mesh::InvalidInput for seconds not above 0
/// Cost: reading each mesh; then milliseconds for most pairs, up to `seconds` in all.
[[nodiscard]] Sweep sweep(std::string_view text, const std::filesystem::path& robot_file, const SweepOptions& options = {});

/// MoveIt's SRDF: disable_collisions for adjacent pairs and those proven free, with their reasons, and nothing else.
[[nodiscard]] std::string srdf_text(const std::string& robot, const Sweep& swept);

}  // namespace sqmap::robot
