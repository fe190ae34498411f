// A cell of joint positions is free where the links, in the pose of its middle, are farther apart than the joints can move them
// within it. Distances of rigid bodies change by no more than one of them moves in the frame of the other. Joints are moved one
// at a time; each moves either side of itself, so the side that is nearer to its axis counts. Lipschitz bounds of this kind:
// F. Schwarzer, M. Saha, J.-C. Latombe, "Adaptive dynamic collision checking for single and multiple articulated robots",
// IEEE T-RO 21(3), 2005; here for each pair of branches of both trees, since what is near an axis moves little.
#include "robot/pair_sweep.h"

#include "math/random.h"
#include "math/trigonometry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace sqmap::robot {
namespace {

/// The share of the smallest clearance seen that is proven: the nearer to 1, the smaller are cells.
constexpr double k_proven_share = 0.5;

double distance_from_axis(Vec3d p, Vec3d at, Vec3d axis) { return norm(cross(p - at, axis)); }

}  // namespace

PairSweep::PairSweep(const Chain& chain, const LinkShape& a, const LinkShape& b)
    : chain_(chain),
      a_(a),
      b_(b),
      seen_(std::numeric_limits<double>::infinity()),
      bound_(std::numeric_limits<double>::infinity()),
      amount_(chain.moving().size()),
      chord_(chain.moving().size()),
      moved_(chain.moving().size()),
      reach_(chain.moving().size())
{
    const Branch &root_a = a.branches()[0], &root_b = b.branches()[0];
    rounding_ = 1e-10 * (chain.length() + norm(root_a.centre) + root_a.radius + norm(root_b.centre) + root_b.radius);
    std::vector<double> lower, upper;
    for (const Chain::Variable& v : chain.variables()) {
        lower.push_back(v.range.lower);
        upper.push_back(v.range.upper);
    }
    push(lower, upper, 0);
}

void PairSweep::push(std::span<const double> lower, std::span<const double> upper, std::uint16_t level)
{
    corners_.insert(corners_.end(), lower.begin(), lower.end());
    corners_.insert(corners_.end(), upper.begin(), upper.end());
    levels_.push_back(level);
}

double PairSweep::left() const
{
    double share = given_up_;
    for (const std::uint16_t level : levels_) share += std::ldexp(1., -level);
    return share;
}

double PairSweep::clearance(std::span<const double> values, double within)
{
    chain_.pose_at(values, frames_);
    const double found = Placement(a_, b_, frames_.b_in_a).distance(within, nearest_);
    return found <= rounding_ ? 0 : found;
}

void PairSweep::look(std::span<const double> values)
{
    const double found = clearance(values, seen_);
    if (!(found < seen_)) return;
    const bool is_much = found < 0.9 * seen_;
    seen_ = found;
    pose_.assign(values.begin(), values.end());
    if (is_much && seen_ > 0) go_downhill(pose_, seen_);
}

void PairSweep::go_downhill(std::vector<double> values, double clearance_now)
{
    constexpr double k_first_step = 0.1, k_last_step = 2e-3;
    const auto variables = chain_.variables();
    for (double step = k_first_step; step > k_last_step && clearance_now > 0;) {
        bool is_better = false;
        for (std::size_t v = 0; v < values.size() && clearance_now > 0; ++v) {
            const JointRange& range = variables[v].range;
            for (const double sign : {-1., 1.}) {
                const double was = values[v];
                values[v] = std::clamp(was + sign * step * (range.upper - range.lower), range.lower, range.upper);
                const double found = values[v] == was ? clearance_now : clearance(values, clearance_now);
                if (found < clearance_now) {
                    clearance_now = found;
                    is_better = true;
                } else {
                    values[v] = was;
                }
            }
        }
        if (!is_better) step *= 0.5;
    }
    if (clearance_now >= seen_) return;
    seen_ = clearance_now;
    pose_ = values;
}

void PairSweep::sample()
{
    constexpr int k_samples = 128;
    constexpr std::size_t k_starts = 2;
    struct Start {
        double clearance;
        std::vector<double> values;
    };
    const auto variables = chain_.variables();
    SplitMix64 random(31);
    std::vector<Start> starts;
    for (int i = 0; i < k_samples; ++i) {
        std::vector<double> values;
        for (const Chain::Variable& v : variables)
            values.push_back(i == 0 ? 0.5 * (v.range.lower + v.range.upper) : random.between(v.range.lower, v.range.upper));
        const bool is_full = starts.size() == k_starts;
        const double within = is_full ? starts.back().clearance : std::numeric_limits<double>::infinity();
        const double found = clearance(values, within);
        if (is_full && found >= within) continue;
        if (found < seen_) {
            seen_ = found;
            pose_ = values;
        }
        if (seen_ <= 0) return;
        if (is_full) starts.pop_back();
        const auto at = std::find_if(starts.begin(), starts.end(), [&](const Start& s) { return found < s.clearance; });
        starts.insert(at, {found, std::move(values)});
        if (variables.empty()) break;
    }
    for (const Start& start : starts)
        if (seen_ > 0) go_downhill(start.values, start.clearance);
}

void PairSweep::search(std::uint64_t cells)
{
    for (std::uint64_t i = 0; i < cells && !finished(); ++i) judge_next();
}

void PairSweep::judge_next()
{
    const std::size_t n = chain_.variables().size();
    const auto first = corners_.end() - static_cast<std::ptrdiff_t>(2 * n);
    const std::vector<double> lower(first, first + static_cast<std::ptrdiff_t>(n)),
        upper(first + static_cast<std::ptrdiff_t>(n), corners_.end());
    const std::uint16_t level = levels_.back();
    corners_.resize(corners_.size() - 2 * n);
    levels_.pop_back();
    ++cells_;
    std::vector<double> middle(n);
    for (std::size_t v = 0; v < n; ++v) middle[v] = 0.5 * (lower[v] + upper[v]);
    const auto moving = chain_.moving();
    for (std::size_t j = 0; j < moving.size(); ++j) {
        constexpr double k_half_turn = 3.141592653589793;
        const std::size_t v = moving[j].variable;
        // The middle is rounded: the farther end counts.
        amount_[j] = std::abs(moving[j].factor) * std::max(upper[v] - middle[v], middle[v] - lower[v]);
        chord_[j] = 2 * sine_cosine(0.5 * std::min(amount_[j], k_half_turn)).sine;
    }
    chain_.pose_at(middle, frames_);
    const Placement at(a_, b_, frames_.b_in_a);
    // The range of the joints is connected: if surfaces meet nowhere, a point within a solid in one pose is within it in all.
    if (!is_containment_known_ && at.contained()) {
        seen_ = 0;
        pose_ = middle;
        return;
    }
    is_containment_known_ = true;
    if (prove(at)) return;
    const std::vector<double> moved = moved_;
    look(middle);
    if (seen_ <= 0) return;
    moved_ = moved;
    divide(lower, upper, level);
}

void PairSweep::divide(std::span<const double> lower, std::span<const double> upper, std::uint16_t level)
{
    const auto moving = chain_.moving();
    std::vector<double> by_variable(lower.size());
    double all = 0;
    for (std::size_t j = 0; j < moving.size(); ++j) {
        by_variable[moving[j].variable] += moved_[j];
        all += moved_[j];
    }
    constexpr std::uint16_t k_deepest = 1000;
    if (!(all > rounding_) || level >= k_deepest) {
        given_up_ += std::ldexp(1., -level);
        return;
    }
    const auto widest = static_cast<std::size_t>(std::max_element(by_variable.begin(), by_variable.end()) - by_variable.begin());
    std::vector<double> middle_up(upper.begin(), upper.end()), middle_low(lower.begin(), lower.end());
    middle_up[widest] = middle_low[widest] = 0.5 * (lower[widest] + upper[widest]);
    push(lower, middle_up, static_cast<std::uint16_t>(level + 1));
    push(middle_low, upper, static_cast<std::uint16_t>(level + 1));
}

double PairSweep::motion(Vec3d centre_a, double radius_a, Vec3d centre_b, double radius_b)
{
    const auto moving = chain_.moving();
    // Joints between a branch and an axis move the branch before the axis turns it: the ball about it grows.
    for (std::size_t j = 0; j < moving.size(); ++j) {
        reach_[j] = distance_from_axis(centre_a, frames_.at[j], frames_.axis[j]) + radius_a;
        radius_a += moving[j].slides ? amount_[j] : chord_[j] * reach_[j];
    }
    double sum = 0;
    for (std::size_t j = moving.size(); j-- > 0;) {
        const double reach = distance_from_axis(centre_b, frames_.at[j], frames_.axis[j]) + radius_b;
        radius_b += moving[j].slides ? amount_[j] : chord_[j] * reach;
        moved_[j] = moving[j].slides ? amount_[j] : chord_[j] * std::min(reach, reach_[j]);
        sum += moved_[j];
    }
    return sum;
}

bool PairSweep::prove(const Placement& at)
{
    const auto a = a_.branches(), b = b_.branches();
    const double wanted = k_proven_share * seen_ + rounding_;
    double proven = std::numeric_limits<double>::infinity();
    stack_.assign(1, {0, 0, at.lower_bound(a[0], b[0])});
    while (!stack_.empty()) {
        const Entry e = stack_.back();
        stack_.pop_back();
        const Branch &s = a[e.a], &t = b[e.b];
        const bool is_leaf = s.count > 0 && t.count > 0;
        if (e.bound > wanted || is_leaf) {
            const double moves = motion(s.centre, s.radius, at.centre_in_a(t), t.radius);
            double apart = e.bound;
            if (is_leaf && apart - moves < wanted) {
                apart = std::numeric_limits<double>::infinity();
                for (std::uint32_t i = s.first; i < s.first + s.count; ++i)
                    for (std::uint32_t j = t.first; j < t.first + t.count; ++j) apart = std::min(apart, at.gap(i, j).lower);
                if (apart - moves < wanted) return false;
            }
            if (apart - moves >= wanted) {
                proven = std::min(proven, apart - moves);
                continue;
            }
        }
        const bool splits_a = t.count > 0 || (s.count == 0 && s.radius >= t.radius);
        Entry next[2];
        for (std::uint32_t k = 0; k < 2; ++k) {
            next[k] = splits_a ? Entry{s.first + k, e.b, 0} : Entry{e.a, t.first + k, 0};
            next[k].bound = at.lower_bound(a[next[k].a], b[next[k].b]);
        }
        // The nearer one is next: where a cell is not free, this is soon known.
        if (next[0].bound < next[1].bound) std::swap(next[0], next[1]);
        stack_.insert(stack_.end(), next, next + 2);
    }
    bound_ = std::min(bound_, proven - rounding_);
    return true;
}

}  // namespace sqmap::robot
