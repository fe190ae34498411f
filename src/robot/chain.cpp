#include "robot/chain.h"

#include "sqmap/math/rotation.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sqmap::robot {
namespace {

constexpr auto k_no_joint = static_cast<std::size_t>(-1);

Pose motion_of(const Chain::Moving& joint, double amount)
{
    if (joint.slides) return {{}, amount * joint.axis};
    return {rotation_by(amount * joint.axis), {}};
}

/// Joints from a link to the root.
std::vector<std::size_t> joints_above(const Description& robot, std::span<const std::size_t> joint_to, std::size_t link)
{
    std::vector<std::size_t> out;
    for (; joint_to[link] != k_no_joint; link = robot.joints[out.back()].parent) out.push_back(joint_to[link]);
    return out;
}

}  // namespace

Chain::Chain(const Description& robot, std::size_t a, std::size_t b)
{
    std::vector<std::size_t> joint_to(robot.links.size(), k_no_joint);
    for (std::size_t i = 0; i < robot.joints.size(); ++i) joint_to[robot.joints[i].child] = i;
    std::vector<std::size_t> up = joints_above(robot, joint_to, a), down = joints_above(robot, joint_to, b);
    while (!up.empty() && !down.empty() && up.back() == down.back()) {
        up.pop_back();
        down.pop_back();
    }
    for (const std::size_t joint : up) {
        add(robot, joint, true);
        between_.push_back(robot.joints[joint].parent);
    }
    if (!up.empty() && down.empty()) between_.pop_back();
    for (auto joint = down.rbegin(); joint != down.rend(); ++joint) {
        if (joint != down.rbegin()) between_.push_back(robot.joints[*joint].parent);
        add(robot, *joint, false);
    }
}

void Chain::add(const Description& robot, std::size_t index, bool upwards)
{
    const Joint& joint = robot.joints[index];
    length_ += norm(joint.origin.translation);
    if (joint.kind == JointKind::Other) unbounded_ = joint.name;
    // The last pose leads to where the path is now; a joint closes it and begins another.
    if (!upwards) last_ = compose(last_, joint.origin);
    if (joint.kind != JointKind::Fixed && joint.kind != JointKind::Other) {
        Moving moving{.before = last_, .slides = joint.kind == JointKind::Prismatic, .axis = joint.axis};
        moving.variable = variable_of(robot, index, moving.factor, moving.offset);
        if (upwards) {
            moving.factor = -moving.factor;
            moving.offset = -moving.offset;
        }
        if (moving.slides) {
            const JointRange& range = variables_[moving.variable].range;
            length_ += std::max(std::abs(moving.factor * range.lower + moving.offset),
                                std::abs(moving.factor * range.upper + moving.offset));
        }
        moving_.push_back(moving);
        last_ = {};
    }
    if (upwards) last_ = compose(last_, inverse(joint.origin));
}

std::size_t Chain::variable_of(const Description& robot, std::size_t joint, double& factor, double& offset)
{
    // Each joint that is followed may itself follow another.
    std::vector<std::size_t> followers;
    factor = 1;
    offset = 0;
    while (robot.joints[joint].mimics()) {
        followers.push_back(joint);
        const Joint::Mimic& mimic = robot.joints[joint].mimic;
        offset += factor * mimic.offset;
        factor *= mimic.multiplier;
        joint = mimic.joint;
    }
    if (robot.joints[joint].kind == JointKind::Other) unbounded_ = robot.joints[joint].name;
    const auto found = std::find_if(variables_.begin(), variables_.end(), [&](const Variable& v) { return v.joint == joint; });
    const auto index = static_cast<std::size_t>(found - variables_.begin());
    if (found == variables_.end()) variables_.push_back({joint, {robot.joints[joint].lower, robot.joints[joint].upper}});
    // A follower stops where its own limits end.
    JointRange& range = variables_[index].range;
    double own_factor = 1, own_offset = 0;
    for (auto follower = followers.rbegin(); follower != followers.rend(); ++follower) {
        const Joint& f = robot.joints[*follower];
        own_offset = f.mimic.multiplier * own_offset + f.mimic.offset;
        own_factor *= f.mimic.multiplier;
        if (own_factor == 0 || f.kind == JointKind::Continuous) continue;
        double from = (f.lower - own_offset) / own_factor, to = (f.upper - own_offset) / own_factor;
        if (from > to) std::swap(from, to);
        from = std::max(from, range.lower);
        to = std::min(to, range.upper);
        if (from <= to) range = {from, to};
    }
    return index;
}

void Chain::pose_at(std::span<const double> values, Frames& frames) const
{
    frames.at.resize(moving_.size());
    frames.axis.resize(moving_.size());
    Pose pose{};
    for (std::size_t i = 0; i < moving_.size(); ++i) {
        const Moving& m = moving_[i];
        pose = compose(pose, m.before);
        frames.at[i] = pose.translation;
        frames.axis[i] = pose.rotation * m.axis;
        pose = compose(pose, motion_of(m, m.factor * values[m.variable] + m.offset));
    }
    frames.b_in_a = compose(pose, last_);
}

}  // namespace sqmap::robot
