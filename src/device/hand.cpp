#include "device/hand.h"

#include "sqmap/math/assert.h"
#include "sqmap/math/rotation.h"

#include <algorithm>
#include <cmath>
#include <numeric>

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

namespace {

constexpr const char* k_joint_names[k_hand_joints] = {
    "wrist",
    "thumb-metacarpal",
    "thumb-phalanx-proximal",
    "thumb-phalanx-distal",
    "thumb-tip",
    "index-finger-metacarpal",
    "index-finger-phalanx-proximal",
    "index-finger-phalanx-intermediate",
    "index-finger-phalanx-distal",
    "index-finger-tip",
    "middle-finger-metacarpal",
    "middle-finger-phalanx-proximal",
    "middle-finger-phalanx-intermediate",
    "middle-finger-phalanx-distal",
    "middle-finger-tip",
    "ring-finger-metacarpal",
    "ring-finger-phalanx-proximal",
    "ring-finger-phalanx-intermediate",
    "ring-finger-phalanx-distal",
    "ring-finger-tip",
    "pinky-finger-metacarpal",
    "pinky-finger-phalanx-proximal",
    "pinky-finger-phalanx-intermediate",
    "pinky-finger-phalanx-distal",
    "pinky-finger-tip",
};

constexpr std::size_t k_palm = 5, k_index_knuckle = 6, k_middle_knuckle = 11, k_little_knuckle = 21, k_middle_tip = 14;

/// The bones of a finger that turn, from the knuckle on, and the share of the curl that each takes, as in hand_joints.
struct Bones {
    std::size_t knuckle;
    int count;
    double follow[3];
};
constexpr std::array<Bones, 5> k_bones{{
    {2, 2, {1, 0.6, 0}},
    {6, 3, {1, 0.8, 0.6}},
    {11, 3, {1, 0.8, 0.6}},
    {16, 3, {1, 0.8, 0.6}},
    {21, 3, {1, 0.8, 0.6}},
}};

/// The zone that a joint's skin belongs to: metacarpals are the palm.
std::size_t zone_of(std::size_t joint)
{
    for (std::size_t f = 0; f < k_bones.size(); ++f)
        if (joint >= k_bones[f].knuckle && joint <= k_tip_joints[f]) return f;
    return k_palm;
}

/// y from the wrist to the middle finger's knuckle, x to the thumb's side, z out of the back: a right hand has left-handed axes.
struct Axes {
    Vec3d x, y, z;
};
Axes axes_of(const std::array<Vec3d, k_hand_joints>& positions)
{
    Axes a;
    a.y = normalized(positions[k_middle_knuckle] - positions[0]);
    const Vec3d across = positions[k_index_knuckle] - positions[k_little_knuckle];
    a.x = normalized(across - dot(across, a.y) * a.y);
    // Only the thumb and the bend of the fingers show which side is the back: both lie towards the palm.
    Vec3d palm = positions[k_tip_joints[0]] - positions[0];
    for (const Bones& bones : k_bones)
        palm += positions[bones.knuckle + static_cast<std::size_t>(bones.count)] - positions[bones.knuckle];
    a.z = cross(a.x, a.y);
    if (dot(palm, a.z) > 0) a.z = -1. * a.z;
    return a;
}

}  // namespace

const char* hand_joint_name(std::size_t joint) noexcept { return joint < k_hand_joints ? k_joint_names[joint] : ""; }

HandSkin::HandSkin(const HandMesh& mesh, double length) : length_(length)
{
    const auto of_the_hand = [](const auto& joints) {
        return std::all_of(joints.begin(), joints.end(), [](std::size_t j) { return j < k_hand_joints; });
    };
    const auto finite = [](float weight) { return std::isfinite(weight); };
    SQMAP_ASSERT(std::all_of(mesh.weights.begin(), mesh.weights.end(), finite));
    SQMAP_ASSERT(mesh.weights.size() == mesh.points.size() && mesh.joints.size() == mesh.points.size() &&
                 mesh.shares.size() == mesh.points.size() && std::all_of(mesh.joints.begin(), mesh.joints.end(), of_the_hand));
    // Puts the mesh into the axes of the hand of hand_joints.
    std::array<Vec3d, k_hand_joints> bones;
    const auto joints = hand_joints({}, length);
    for (std::size_t j = 0; j < k_hand_joints; ++j) bones[j] = joints[j].translation;
    const Axes from = axes_of(mesh.positions), to = axes_of(bones);
    const Vec3d wrist = mesh.positions[0];
    const double scale = norm(bones[k_middle_tip]) / norm(mesh.positions[k_middle_tip] - wrist);
    const auto in_hand = [&](const Vec3d& p) {
        const Vec3d d = scale * (p - wrist);
        return dot(d, from.x) * to.x + dot(d, from.y) * to.y + dot(d, from.z) * to.z;
    };
    for (std::size_t j = 0; j < k_hand_joints; ++j) positions_[j] = in_hand(mesh.positions[j]);
    for (std::size_t f = 0; f < k_bones.size(); ++f) {
        const Vec3d bone = positions_[k_bones[f].knuckle + 1] - positions_[k_bones[f].knuckle];
        axis_[f] = normalized(cross(Vec3d{0, 0, 1}, bone));
    }

    std::vector<std::size_t> zones(mesh.points.size()), order(mesh.points.size());
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
        const auto largest = std::max_element(mesh.shares[i].begin(), mesh.shares[i].end()) - mesh.shares[i].begin();
        zones[i] = zone_of(mesh.joints[i][static_cast<std::size_t>(largest)]);
    }
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return zones[a] < zones[b]; });
    const auto flat = glove_zones(hand_joints({}, length));
    for (const std::size_t i : order) {
        rest_.push_back(in_hand(mesh.points[i]));
        weights_.push_back(mesh.weights[i]);
        joints_.push_back(mesh.joints[i]);
        shares_.push_back(mesh.shares[i]);
        for (std::size_t k = zones[i] + 1; k < first_.size(); ++k) ++first_[k];
        for (const std::size_t k : {zones[i], k_palm}) reach_[k] = std::max(reach_[k], norm(rest_.back() - flat[k].translation));
    }
    posed_ = rest_;
}

void HandSkin::pose(std::span<const Pose, k_glove_zones> zones) noexcept
{
    const auto flat = glove_zones(hand_joints({}, length_));
    HandPosture posture;
    posture.wrist.rotation = zones[k_palm].rotation;
    posture.wrist.translation = zones[k_palm].translation - zones[k_palm].rotation * flat[k_palm].translation;
    for (std::size_t f = 0; f < k_bones.size(); ++f) {
        // All bones of a finger turn about one axis: its tip has turned by the sum.
        const Mat3d turn = transpose(posture.wrist.rotation) * zones[f].rotation * transpose(flat[f].rotation);
        const Vec3d closing = -1. * Vec3d{flat[f].rotation.row[0].x, flat[f].rotation.row[1].x, flat[f].rotation.row[2].x};
        double angle = dot(rotation_vector(turn), closing);
        if (angle < -0.25 * k_two_pi) angle += k_two_pi;  // closed by more than half a turn
        posture.curl[f] = angle / (k_bones[f].follow[0] + k_bones[f].follow[1] + k_bones[f].follow[2]);
    }
    const auto expected = glove_zones(hand_joints(posture, length_));

    // One map per joint, from bound positions to the world.
    std::array<Pose, k_hand_joints> maps;
    maps.fill(posture.wrist);
    for (std::size_t f = 0; f < k_bones.size(); ++f) {
        const Bones& bones = k_bones[f];
        const Vec3d off = zones[f].translation - expected[f].translation;
        Pose map = posture.wrist;
        for (int b = 0; b < bones.count; ++b) {
            const std::size_t joint = bones.knuckle + static_cast<std::size_t>(b);
            const Vec3d centre = apply(map, positions_[joint]);
            map.rotation = map.rotation * rotation_by(bones.follow[b] * posture.curl[f] * axis_[f]);
            map.translation = centre - map.rotation * positions_[joint];
            maps[joint] = {map.rotation, map.translation + (b + 1.) / bones.count * off};
        }
        maps[k_tip_joints[f]] = maps[k_tip_joints[f] - 1];
    }
    for (std::size_t i = 0; i < rest_.size(); ++i) {
        Vec3d p{};
        for (std::size_t k = 0; k < 4; ++k)
            if (shares_[i][k] > 0) p += shares_[i][k] * apply(maps[joints_[i][k]], rest_[i]);
        posed_[i] = p;
    }
}

}  // namespace sqmap::device
