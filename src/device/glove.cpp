#include "sqmap/device/glove.h"

#include <cmath>

namespace sqmap::device {

namespace {

constexpr double k_two_pi = 6.283185307179586;

/// A finger in shares of the hand's length: base of its metacarpal, lengths of its bones, and its direction in a flat hand.
struct Finger {
    Vec3d base;
    std::array<double, 4> bone;  // metacarpal, proximal, intermediate, distal; the thumb has no intermediate
    double turn;                 // rad, of the metacarpal towards the thumb's side
};
constexpr std::array<Finger, 5> k_fingers{{
    {{0.10, 0.06, -0.02}, {0.251, 0.196, 0, 0.158}, 0.75},
    {{0.06, 0.08, 0}, {0.383, 0.245, 0.143, 0.097}, 0.12},
    {{0.01, 0.08, 0}, {0.376, 0.266, 0.170, 0.108}, 0.0},
    {{-0.04, 0.08, 0}, {0.341, 0.244, 0.165, 0.107}, -0.10},
    {{-0.08, 0.07, 0}, {0.324, 0.204, 0.117, 0.093}, -0.22},
}};

/// About z: y turns towards x.
Mat3d spread_by(double angle)
{
    const double c = std::cos(angle), s = std::sin(angle);
    return {{{c, s, 0}, {-s, c, 0}, {0, 0, 1}}};
}

/// About x: y turns towards -z, into the palm.
Mat3d curl_by(double angle)
{
    const double c = std::cos(angle), s = std::sin(angle);
    return {{{1, 0, 0}, {0, c, s}, {0, -s, c}}};
}

}  // namespace

std::array<Pose, k_hand_joints> hand_joints(const HandPosture& posture, double length) noexcept
{
    std::array<Pose, k_hand_joints> joints;
    joints[0] = posture.wrist;
    std::size_t j = 1;
    for (std::size_t f = 0; f < k_fingers.size(); ++f) {
        const Finger& finger = k_fingers[f];
        Pose at{posture.wrist.rotation * spread_by(finger.turn),
                posture.wrist.translation + length * (posture.wrist.rotation * finger.base)};
        const double follow[] = {0, 1, 0.8, 0.6};
        for (std::size_t b = 0; b < finger.bone.size(); ++b) {
            if (finger.bone[b] == 0) continue;
            if (b == 1) at.rotation = at.rotation * spread_by(posture.spread[f]);
            at.rotation = at.rotation * curl_by(follow[b] * posture.curl[f]);
            joints[j++] = at;
            at.translation += length * finger.bone[b] * (at.rotation * Vec3d{0, 1, 0});
        }
        joints[j++] = at;
    }
    return joints;
}

std::array<Pose, k_glove_zones> glove_zones(const std::array<Pose, k_hand_joints>& joints) noexcept
{
    std::array<Pose, k_glove_zones> zones;
    for (std::size_t f = 0; f < k_tip_joints.size(); ++f) zones[f] = joints[k_tip_joints[f]];
    // Half-way between the wrist and where the middle finger begins.
    zones[5] = {joints[0].rotation, 0.5 * (joints[0].translation + joints[11].translation)};
    return zones;
}

HandPosture posture_at(const GloveMotion& motion, double time) noexcept
{
    HandPosture posture;
    posture.wrist = {motion.wrist.rotation,
                     motion.wrist.translation + std::sin(k_two_pi * time / motion.sway_period) * motion.sway};
    // Starts open and still.
    const double share = 0.5 * (1 - std::cos(k_two_pi * time / motion.curl_period));
    for (double& curl : posture.curl) curl = share * motion.curl;
    return posture;
}

HandTarget glove_script(const void* context, double time, std::size_t zone) noexcept
{
    const GloveMotion& motion = *static_cast<const GloveMotion*>(context);
    constexpr double k_step = 1e-4;
    const auto zones = glove_zones(hand_joints(posture_at(motion, time), motion.length));
    const auto later = glove_zones(hand_joints(posture_at(motion, time + k_step), motion.length));
    HandTarget target{zones[zone], {}};
    target.twist.linear = (later[zone].translation - zones[zone].translation) / k_step;
    const Mat3d d = later[zone].rotation * transpose(zones[zone].rotation);
    target.twist.angular = 0.5 / k_step * Vec3d{d.row[2].y - d.row[1].z, d.row[0].z - d.row[2].x, d.row[1].x - d.row[0].y};
    return target;
}

std::unique_ptr<SimulatedDevice> simulated_glove(const GloveMotion& motion, MotorRecord* motors)
{
    return std::make_unique<SimulatedDevice>(
        SimulatedOptions{.mechanism = {.mass = 0.02, .damping = 0.5, .coulomb_friction = 0.1},
                         .hand = k_hand_profiles[1],
                         .zones = k_glove_zones,
                         .script = glove_script,
                         .script_context = &motion,
                         .motors = motors});
}

}  // namespace sqmap::device
