// A hand of tubes about the bones of device::hand_joints, skinned to one joint each: a HandMesh with known answers.
#pragma once

#include "device/hand.h"

#include <array>
#include <cmath>
#include <vector>

namespace sqmap::test {

/// map: of the flat hand's points, whatever frame, unit and side the mesh is to have. bone: joint that moves each point.
template <class Map>
device::HandMesh tube_hand(double length, Map&& map)
{
    const auto joints = device::hand_joints({}, length);
    device::HandMesh mesh;
    const auto add = [&](const Vec3d& p, std::size_t joint) {
        mesh.points.push_back(map(p));
        mesh.weights.push_back(1);
        mesh.joints.push_back({static_cast<std::uint16_t>(joint), 0, 0, 0});
        mesh.shares.push_back({1, 0, 0, 0});
    };
    for (std::size_t j = 0; j < joints.size(); ++j) mesh.positions[j] = map(joints[j].translation);
    for (std::size_t j = 1; j + 1 < joints.size(); ++j) {
        if (j == 4 || j == 9 || j == 14 || j == 19) continue;  // a tip: the next joint is another finger's
        for (int ring = 0; ring <= 6; ++ring)
            for (int k = 0; k < 10; ++k) {
                const double a = 0.62831853 * k, radius = 0.045 * length, t = ring / 6.;
                const Vec3d on = (1 - t) * joints[j].translation + t * joints[j + 1].translation;
                add(on + joints[j].rotation * Vec3d{radius * std::cos(a), 0, radius * std::sin(a)}, j);
            }
    }
    return mesh;
}

}  // namespace sqmap::test
