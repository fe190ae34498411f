// Janabi-Sharifi, Hayward, Chen, "Discrete-time adaptive windowing for velocity estimation", IEEE Trans. Control Systems
// Technology 8(6), 2000 (end-fit, first-order): a velocity over the longest past that it explains to within the encoder's step.
// At rest and in slow motion, where one step in one tick would be a jerk, that is long; in fast motion one tick.
#pragma once

#include "rigid.h"
#include "sqmap/haptic/safety.h"

namespace sqmap::haptic {

/// The last poses of a device that reports no velocity. One thread.
class Track {
public:
    /// dt: s since the one before
    void add(const Pose& pose, double dt)
    {
        for (int i = k_max; i > 0; --i) past_[i] = past_[i - 1];
        for (int i = 1; i <= k_max; ++i) past_[i].age += dt;
        past_[0] = {pose, 0};
        count_ = std::min(count_ + 1, k_max + 1);
    }

    /// True if a pose is farther from the last one than any motion leads: by more than k_teleport or k_teleport_turn, and by more
    /// than the top speeds allow in dt, s.
    [[nodiscard]] bool jumps(const Pose& pose, double dt) const
    {
        if (count_ == 0) return false;
        const Pose& before = past_[0].pose;
        return norm(pose.translation - before.translation) > std::max(k_teleport, k_top_speed * dt) ||
               norm(rotation_vector(pose.rotation * transpose(before.rotation))) > std::max(k_teleport_turn, k_top_turn * dt);
    }

    /// m since the last tick
    [[nodiscard]] Vec3d shift() const { return count_ > 1 ? past_[0].pose.translation - past_[1].pose.translation : Vec3d{}; }
    [[nodiscard]] double step() const { return norm(shift()); }

    /// rad since the last tick
    [[nodiscard]] double turn() const
    {
        return count_ > 1 ? norm(rotation_vector(past_[0].pose.rotation * transpose(past_[1].pose.rotation))) : 0;
    }

    /// resolution: m, of the encoder; 0: the difference of the last two poses. A turn counts at k_arm.
    [[nodiscard]] Twist twist(double resolution) const
    {
        Vec3d shift[k_max + 1], turn[k_max + 1];
        Twist twist;
        bool moves = true, turns = true;
        for (int n = 1; n < count_ && (moves || turns); ++n) {
            const Past& then = past_[n];
            shift[n] = past_[0].pose.translation - then.pose.translation;
            turn[n] = rotation_vector(past_[0].pose.rotation * transpose(then.pose.rotation));
            moves = moves && (n == 1 || fits(shift, n, resolution));
            turns = turns && (n == 1 || fits(turn, n, resolution / k_arm));
            if (moves) twist.linear = shift[n] / then.age;
            if (turns) twist.angular = turn[n] / then.age;
            if (!(resolution > 0)) break;
        }
        return twist;
    }

private:
    static constexpr int k_max = 16;       // ticks
    static constexpr double k_arm = 0.02;  // m

    struct Past {
        Pose pose{};
        double age = 0;
    };

    /// True if all poses since n ticks ago lie within a step of the straight line from then to now, along every axis.
    [[nodiscard]] bool fits(const Vec3d (&shift)[k_max + 1], int n, double step) const
    {
        for (int i = 1; i < n; ++i) {
            const Vec3d off = shift[i] - (past_[i].age / past_[n].age) * shift[n];
            // 0.1 % more, since the differences are whole steps themselves.
            for (int k = 0; k < 3; ++k)
                if (!(std::fabs(off[k]) <= 1.001 * step)) return false;
        }
        return true;
    }

    Past past_[k_max + 1];
    int count_ = 0;
};

}  // namespace sqmap::haptic
