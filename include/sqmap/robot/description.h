// A robot as URDF describes it: links and the joints between them, judged.
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/math/pose.h"

#include <cstddef>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace sqmap::robot {

/// A robot file that is not taken; what() names the file, the line and the cure. Thread safety: a value.
class DescriptionError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// A mesh that stands for a link in contacts.
struct CollisionMesh {
    std::string filename;  ///< as the robot file has it
    Vec3d scale{1, 1, 1};
    Pose pose{};         ///< of the scaled mesh in the link's frame, metres
    std::size_t line{};  ///< of the collision element, from 1
};
/// A collision shape that is no mesh. rewrite() leaves it as it is.
struct CollisionSolid {
    /// Other: an element that URDF does not know.
    enum class Kind : std::uint8_t { Box, Cylinder, Sphere, Other };
    Kind kind = Kind::Other;
    std::string element;  ///< its name, "box"
    Vec3d size{};         ///< box: full lengths; cylinder: radius, radius, length; sphere: radius three times; metres
    Pose pose{};          ///< of the shape in the link's frame, metres
    std::size_t line{};   ///< of the collision element, from 1
};
/// A rigid body.
struct Link {
    std::string name;
    std::size_t line{};
    std::vector<CollisionMesh> meshes{};
    std::vector<CollisionSolid> solids{};
};

/// How a joint moves.
enum class JointKind : std::uint8_t { Fixed, Revolute, Continuous, Prismatic, Other };
/// A joint between two links.
struct Joint {
    std::string name;
    JointKind kind = JointKind::Fixed;
    std::size_t parent = 0, child = 0;  ///< indices of links
    Pose origin{};                      ///< of the child's frame in the parent's, at position 0
    Vec3d axis{1, 0, 0};                ///< unit, in the child's frame
    double lower = 0, upper = 0;        ///< radians or metres
    std::size_t line{};
    /// Position = multiplier times that of another joint + offset; no joint: its own.
    struct Mimic {
        std::size_t joint = static_cast<std::size_t>(-1);
        double multiplier = 1, offset = 0;
    } mimic{};
    /// True if the position follows another joint's.
    [[nodiscard]] bool mimics() const { return mimic.joint != static_cast<std::size_t>(-1); }
};

/// A robot as its URDF describes it.
struct Description {
    std::string name;
    std::vector<Link> links;
    std::vector<Joint> joints;  ///< a tree: every link but the root is the child of one
    std::size_t root = 0;       ///< index of a link
};

/// Reads a URDF file's text. file: names it in errors.
/// @throw DescriptionError with the line, for XML that does not parse, a file that is no robot or still xacro, names that repeat
/// or are missing, links that no joint leads to, joints in a circle, scales of zero, numbers that are none, a joint that mimics
/// itself or none. Linear.
[[nodiscard]] Description read_description(std::string_view text, const std::string& file);

/// Folders of ROS packages by name.
using Packages = std::map<std::string, std::filesystem::path>;
/// The file that a mesh's name means. package://NAME/REST: in the folder of that name in packages, else in a folder of that name
/// among those that hold the robot file. file://: as it stands. Others: beside the robot file. It need not exist.
[[nodiscard]] std::filesystem::path mesh_path(const std::string& filename, const std::filesystem::path& robot_file,
                                              const Packages& packages);

}  // namespace sqmap::robot
