// How the joints of a skin stand and move.
#include "gltf_file.h"
#include "sqmap/math/assert.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sqmap::io {
namespace {

using Quaternion = std::array<double, 4>;

Quaternion normalized(Quaternion q)
{
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (double& v : q) v /= length;
    return q;
}

/// About one axis, the short way (Shoemake 1985).
Quaternion between(const Quaternion& a, Quaternion b, double share)
{
    double cosine = 0;
    for (std::size_t i = 0; i < 4; ++i) cosine += a[i] * b[i];
    if (cosine < 0) {
        cosine = -cosine;
        for (double& v : b) v = -v;
    }
    double of_a = 1 - share, of_b = share;
    if (cosine < 0.9999) {
        const double angle = std::acos(cosine);
        of_a = std::sin((1 - share) * angle) / std::sin(angle);
        of_b = std::sin(share * angle) / std::sin(angle);
    }
    Quaternion q;
    for (std::size_t i = 0; i < 4; ++i) q[i] = of_a * a[i] + of_b * b[i];
    return normalized(q);
}

Quaternion value_at(const JointTrack& track, double time)
{
    const bool turns = track.path == JointTrack::Path::Rotation, cubic = track.between == JointTrack::Between::Cubic;
    const auto value = [&](std::size_t k) {
        const Quaternion& v = track.values[cubic ? 3 * k + 1 : k];
        return turns ? normalized(v) : v;
    };
    const auto next = std::upper_bound(track.times.begin(), track.times.end(), time);
    if (next == track.times.begin()) return value(0);
    const auto k = static_cast<std::size_t>(next - track.times.begin()) - 1;
    if (next == track.times.end() || track.between == JointTrack::Between::Step) return value(k);
    const double span = track.times[k + 1] - track.times[k], t = (time - track.times[k]) / span;
    if (turns && !cubic) return between(value(k), value(k + 1), t);
    Quaternion out;
    for (std::size_t i = 0; i < 4; ++i) {
        const double a = track.values[cubic ? 3 * k + 1 : k][i], b = track.values[cubic ? 3 * k + 4 : k + 1][i];
        if (!cubic) {
            out[i] = a + t * (b - a);
            continue;
        }
        const double t2 = t * t, t3 = t2 * t, leaves = track.values[3 * k + 2][i], comes = track.values[3 * k + 3][i];
        out[i] = (2 * t3 - 3 * t2 + 1) * a + span * (t3 - 2 * t2 + t) * leaves + (3 * t2 - 2 * t3) * b + span * (t3 - t2) * comes;
    }
    return turns ? normalized(out) : out;
}

}  // namespace

std::vector<JointPose> rest_poses(const SkinnedSoup& skin)
{
    std::vector<JointPose> poses;
    for (const SkinJoint& joint : skin.skeleton) poses.push_back(joint.rest);
    return poses;
}

std::vector<JointPose> poses_at(const SkinnedSoup& skin, const SkinAnimation& animation, double time)
{
    std::vector<JointPose> poses = rest_poses(skin);
    for (const JointTrack& track : animation.tracks) {
        const Quaternion v = value_at(track, time);
        JointPose& pose = poses[track.joint];
        if (track.path == JointTrack::Path::Rotation)
            pose.rotation = v;
        else
            (track.path == JointTrack::Path::Scale ? pose.scale : pose.translation) = Vec3d{v[0], v[1], v[2]};
    }
    return poses;
}

std::vector<JointPose> blended(std::span<const JointPose> a, std::span<const JointPose> b, double share)
{
    SQMAP_ASSERT(a.size() == b.size());
    std::vector<JointPose> out;
    for (std::size_t j = 0; j < a.size(); ++j)
        out.push_back({a[j].translation + share * (b[j].translation - a[j].translation),
                       between(normalized(a[j].rotation), normalized(b[j].rotation), share),
                       a[j].scale + share * (b[j].scale - a[j].scale)});
    return out;
}

std::vector<Affine> joint_maps(const SkinnedSoup& skin, std::span<const JointPose> poses)
{
    SQMAP_ASSERT(poses.size() == skin.skeleton.size());
    const std::size_t n = skin.skeleton.size();
    std::vector<Affine> world(n), maps;
    std::vector<std::uint8_t> done(n, 0);
    std::vector<std::size_t> chain;
    for (std::size_t j = 0; j < n; ++j) {
        for (std::size_t at = j; done[at] == 0;) {
            chain.push_back(at);
            if (skin.skeleton[at].parent < 0) break;
            at = static_cast<std::size_t>(skin.skeleton[at].parent);
        }
        for (; !chain.empty(); chain.pop_back()) {
            const SkinJoint& joint = skin.skeleton[chain.back()];
            const Affine own = affine_of(poses[chain.back()]);
            const Affine local = joint.has_matrix ? joint.local : joint.above * own;
            world[chain.back()] = joint.parent < 0 ? local : world[static_cast<std::size_t>(joint.parent)] * local;
            done[chain.back()] = 1;
        }
        maps.push_back(world[j] * skin.skeleton[j].inverse_bind);
    }
    return maps;
}

}  // namespace sqmap::io
