#include "touch/hand_file.h"

#include "sqmap/haptic/patch.h"
#include "sqmap/io/read_skin.h"

#include <algorithm>
#include <string>

namespace sqmap::app {
namespace {

/// The joint's position in the bound mesh: the point that its inverse bind takes to the joint's origin.
std::optional<Vec3d> bound_position(const Affine& inverse_bind)
{
    const Vec3d *r = inverse_bind.linear.row, t = inverse_bind.shift;
    const double determinant = dot(r[0], cross(r[1], r[2]));
    if (determinant == 0) return {};
    return (-1 / determinant) * (t.x * cross(r[1], r[2]) + t.y * cross(r[2], r[0]) + t.z * cross(r[0], r[1]));
}

}  // namespace

std::optional<device::HandMesh> read_hand(const std::filesystem::path& path)
{
    std::string end = path.extension().string();
    std::transform(end.begin(), end.end(), end.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (end != ".glb" && end != ".gltf") return {};
    const io::SkinResult read = io::read_skinned_file(path);
    if (read.error) return {};
    const io::SkinnedSoup& skin = read.skin;

    constexpr std::uint16_t k_none = 0xffff;
    std::vector<std::uint16_t> number(skin.skeleton.size(), k_none);
    device::HandMesh hand;
    for (std::size_t j = 0; j < device::k_hand_joints; ++j) {
        const auto at = std::find_if(skin.skeleton.begin(), skin.skeleton.end(),
                                     [&](const io::SkinJoint& joint) { return joint.name == device::hand_joint_name(j); });
        if (at == skin.skeleton.end()) return {};
        const std::optional<Vec3d> position = bound_position(at->inverse_bind);
        if (!position) return {};
        number[static_cast<std::size_t>(at - skin.skeleton.begin())] = static_cast<std::uint16_t>(j);
        hand.positions[j] = *position;
    }
    hand.points = skin.soup.positions;
    hand.shares = skin.weights;
    for (std::array<std::uint16_t, 4> joints : skin.joints) {
        for (std::uint16_t& joint : joints) joint = number[joint] == k_none ? std::uint16_t{0} : number[joint];
        hand.joints.push_back(joints);
    }
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (std::size_t i = 0; i + 1 < skin.soup.polygon_offsets.size(); ++i)
        for (std::uint32_t k = skin.soup.polygon_offsets[i] + 2; k < skin.soup.polygon_offsets[i + 1]; ++k)
            triangles.push_back({static_cast<std::uint32_t>(skin.soup.indices[skin.soup.polygon_offsets[i]]),
                                 static_cast<std::uint32_t>(skin.soup.indices[k - 1]),
                                 static_cast<std::uint32_t>(skin.soup.indices[k])});
    hand.weights = haptic::patch_points(hand.points, triangles, 0).weights;
    return hand;
}

}  // namespace sqmap::app
