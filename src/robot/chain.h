// The joints between two links, and how far they can move points of one against the other.
#pragma once

#include "sqmap/math/pose.h"
#include "sqmap/robot/description.h"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace sqmap::robot {

/// The range of joint positions that a proof is about.
struct JointRange {
    double lower = 0, upper = 0;
};

/// The path from link a to link b along the tree of joints.
class Chain {
public:
    /// A joint that moves one end of the path against the other.
    struct Moving {
        Pose before{};  ///< from the frame after the joint before it, or a's, to this joint's
        bool slides = false;
        Vec3d axis{};
        double factor = 1, offset = 0;  ///< amount of motion = factor times the variable + offset
        std::size_t variable = 0;
    };
    /// A joint whose position the path's poses depend on: it follows no other.
    struct Variable {
        std::size_t joint = 0;
        JointRange range{};
    };

    Chain(const Description& robot, std::size_t a, std::size_t b);

    [[nodiscard]] std::span<const Moving> moving() const { return moving_; }
    [[nodiscard]] std::span<const Variable> variables() const { return variables_; }
    /// Links between a and b.
    [[nodiscard]] std::span<const std::size_t> between() const { return between_; }
    /// The name of a joint on the path that floats or moves in a plane; empty without one.
    [[nodiscard]] const std::string& unbounded() const { return unbounded_; }
    /// The length of all offsets on the path: rounding of poses is relative to it.
    [[nodiscard]] double length() const { return length_; }

    /// Frames for positions of the variables.
    struct Frames {
        std::vector<Vec3d> at, axis;  ///< of each moving joint, in a's frame
        Pose b_in_a{};
    };
    void pose_at(std::span<const double> values, Frames& frames) const;

private:
    void add(const Description& robot, std::size_t joint, bool upwards);
    std::size_t variable_of(const Description& robot, std::size_t joint, double& factor, double& offset);

    std::vector<Moving> moving_;
    std::vector<Variable> variables_;
    std::vector<std::size_t> between_;
    std::string unbounded_;
    Pose last_{};  ///< from the frame after the last moving joint to b's
    double length_ = 0;
};

}  // namespace sqmap::robot
