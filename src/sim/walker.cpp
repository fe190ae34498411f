#include "sim/walker.h"

#include "math/turns.h"
#include "sqmap/math/assert.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace sqmap::sim {

namespace {

enum Part { Pelvis, Chest, Head, UpperArmL, ForearmL, UpperArmR, ForearmR, ThighL, ShinL, FootL, ThighR, ShinR, FootR, k_parts };

double eased(double share)
{
    const double s = std::clamp(share, 0.0, 1.0);
    return s * s * (3 - 2 * s);
}

}  // namespace

std::vector<Bone> capsule_human(double height)
{
    if (!(std::isfinite(height) && height > 0)) throw std::invalid_argument("a figure's height must be positive");
    std::vector<Bone> bones(k_parts);
    const auto mirrored = [](Vec3d v, double side) { return Vec3d{side * v.x, v.y, v.z}; };
    bones[Pelvis] = {"pelvis",
                     -1,
                     {0, 0.97, 0},
                     {{{-0.075, 0.93, 0}, {0.075, 0.93, 0}, 0.11, 0.11}, {{-0.05, 1.06, 0}, {0.05, 1.06, 0}, 0.10, 0.10}}};
    bones[Chest] = {"chest",
                    Pelvis,
                    {0, 1.08, 0},
                    {{{-0.05, 1.08, 0}, {0.05, 1.08, 0}, 0.10, 0.10},
                     {{-0.09, 1.30, 0}, {0.09, 1.30, 0}, 0.115, 0.115},
                     {{-0.15, 1.43, 0}, {0.15, 1.43, 0}, 0.065, 0.065},
                     {{0, 1.40, 0}, {0, 1.52, 0}, 0.075, 0.055}}};
    bones[Head] = {"head",
                   Chest,
                   {0, 1.52, 0},
                   {{{0, 1.50, 0}, {0, 1.58, 0.01}, 0.055, 0.06}, {{0, 1.62, 0.02}, {0, 1.66, 0.0}, 0.085, 0.09}}};
    for (const double side : {1.0, -1.0}) {
        const bool left = side > 0;
        const auto at = [&](double x, double y, double z) { return mirrored({x, y, z}, side); };
        const int upper = left ? UpperArmL : UpperArmR, fore = left ? ForearmL : ForearmR;
        bones[static_cast<std::size_t>(upper)] = {left ? "left upper arm" : "right upper arm",
                                                  Chest,
                                                  at(0.18, 1.43, 0),
                                                  {{at(0.18, 1.43, 0), at(0.45, 1.43, 0), 0.062, 0.042}}};
        bones[static_cast<std::size_t>(fore)] = {
            left ? "left forearm" : "right forearm",
            upper,
            at(0.45, 1.43, 0),
            {{at(0.45, 1.43, 0), at(0.70, 1.43, 0), 0.042, 0.030}, {at(0.70, 1.43, 0), at(0.82, 1.43, 0.01), 0.032, 0.028}}};
        const int thigh = left ? ThighL : ThighR, shin = left ? ShinL : ShinR, foot = left ? FootL : FootR;
        bones[static_cast<std::size_t>(thigh)] = {left ? "left thigh" : "right thigh",
                                                  Pelvis,
                                                  at(0.095, 0.92, 0),
                                                  {{at(0.095, 0.92, 0), at(0.095, 0.50, 0), 0.09, 0.060}}};
        bones[static_cast<std::size_t>(shin)] = {left ? "left shin" : "right shin",
                                                 thigh,
                                                 at(0.095, 0.50, 0),
                                                 {{at(0.095, 0.50, 0), at(0.095, 0.10, -0.01), 0.060, 0.042}}};
        bones[static_cast<std::size_t>(foot)] = {left ? "left foot" : "right foot",
                                                 shin,
                                                 at(0.095, 0.10, -0.01),
                                                 {{at(0.095, 0.10, -0.01), at(0.095, 0.045, -0.03), 0.042, 0.045},
                                                  {at(0.095, 0.045, -0.03), at(0.105, 0.035, 0.16), 0.045, 0.035}}};
    }
    const double scale = height / 1.75;
    for (Bone& bone : bones) {
        bone.joint = scale * bone.joint;
        for (BoneCapsule& c : bone.flesh) c = {scale * c.a, scale * c.b, scale * c.radius_a, scale * c.radius_b};
    }
    return bones;
}

void pose_bones(std::span<const Bone> bones, std::span<const Mat3d> turns, Vec3d shift, std::span<Pose> poses)
{
    for (std::size_t b = 0; b < bones.size(); ++b) {
        const Vec3d joint = bones[b].joint;
        Pose own{turns[b], joint - turns[b] * joint};
        if (bones[b].parent < 0)
            own.translation += shift;
        else
            own = compose(poses[static_cast<std::size_t>(bones[b].parent)], own);
        poses[b] = own;
    }
}

void walk(std::span<const Bone> bones, const Gait& gait, double time, std::span<Pose> poses)
{
    SQMAP_ASSERT(bones.size() == k_parts && poses.size() == bones.size());
    std::vector<Mat3d> turns(bones.size());
    const double down = eased((time - gait.lower_at) / gait.ease), go = eased((time - gait.walk_at) / gait.ease);
    const double phase = 2 * std::numbers::pi * std::max(0.0, time - gait.walk_at) / gait.period;
    const double swing = go * 0.42 * std::sin(phase);
    // Left is +x: a positive turn about x moves a hanging limb back, so the left leg starts forward with the right arm.
    turns[Pelvis] = about_y(-0.08 * go * std::sin(phase));
    turns[Chest] = about_y(0.16 * go * std::sin(phase));
    for (const double side : {1.0, -1.0}) {
        const bool left = side > 0;
        const double leg = side * swing;
        turns[left ? ThighL : ThighR] = about_x(-leg);
        // The knee bends while the leg comes forward.
        turns[left ? ShinL : ShinR] = about_x(go * (0.10 + 0.75 * std::pow(std::max(0.0, side * std::cos(phase)), 2)));
        turns[left ? FootL : FootR] = about_x(0.15 * leg);
        turns[left ? UpperArmL : UpperArmR] = about_x(0.8 * leg) * about_z(-side * down * 1.22);
        turns[left ? ForearmL : ForearmR] = about_y(-side * (0.1 * down + 0.25 * go));
    }
    const double lift = 0.02 * go * std::cos(2 * phase),
                 walked = gait.speed * std::max(0.0, time - gait.walk_at - 0.5 * gait.ease);
    pose_bones(bones, turns, {0, lift, walked}, poses);
}

}  // namespace sqmap::sim
