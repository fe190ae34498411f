// Branch and bound over the joints between two links.
#pragma once

#include "robot/bodies.h"
#include "robot/chain.h"

#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::robot {

/// The search for one pair. Everything outlives it.
class PairSweep {
public:
    PairSweep(const Chain& chain, const LinkShape& a, const LinkShape& b);

    /// Looks at random poses, and goes downhill from the nearest: a first clearance to be proven, or a collision.
    void sample();
    /// Judges up to that many cells.
    void search(std::uint64_t cells);

    /// All cells are judged, or a collision was seen.
    [[nodiscard]] bool finished() const { return seen_ <= 0 || levels_.empty(); }
    [[nodiscard]] double seen() const { return seen_; }
    [[nodiscard]] std::span<const double> pose() const { return pose_; }
    /// Clearance that is proven where nothing is left.
    [[nodiscard]] double bound() const { return bound_; }
    /// Share of the joints' range that is not proven free.
    [[nodiscard]] double left() const;
    [[nodiscard]] std::uint64_t cells() const { return cells_; }

private:
    /// How far the joints move a branch of b against one of a within the cell, at most; by joint in moved_.
    double motion(Vec3d centre_a, double radius_a, Vec3d centre_b, double radius_b);
    /// True where the cell is free; bound_ then counts it. Otherwise moved_ says what moves the branches that fail.
    bool prove(const Placement& at);
    [[nodiscard]] double clearance(std::span<const double> values, double within);
    void look(std::span<const double> values);
    void go_downhill(std::vector<double> values, double clearance);
    void judge_next();
    void divide(std::span<const double> lower, std::span<const double> upper, std::uint16_t level);
    void push(std::span<const double> lower, std::span<const double> upper, std::uint16_t level);

    struct Entry {
        std::uint32_t a, b;
        double bound;
    };

    const Chain& chain_;
    const LinkShape& a_;
    const LinkShape& b_;
    double rounding_ = 0;  ///< that poses and distances are allowed
    double seen_, bound_;
    double given_up_ = 0;
    std::uint64_t cells_ = 0;
    bool is_containment_known_ = false;
    std::vector<double> pose_;
    std::vector<double> corners_;        ///< of the cells that wait: lower, then upper positions of the variables
    std::vector<std::uint16_t> levels_;  ///< of the same: how often the range was divided
    Chain::Frames frames_;
    Placement::TrianglePair nearest_{};  ///< of the pose that was looked at last
    std::vector<double> amount_;         ///< by joint: half of its range in the cell
    std::vector<double> chord_;          ///< by joint: twice the sine of half of that, what a point at distance 1 moves
    std::vector<double> moved_;          ///< by joint
    std::vector<double> reach_;          ///< by joint, of a's branch
    std::vector<Entry> stack_;
};

}  // namespace sqmap::robot
