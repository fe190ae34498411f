// Least signed distance of a tool's points at each of many poses: branch and bound over balls about groups of points. The poses
// of a chunk go through it together, so that every round queries one batch of points.
#include "sqmap/bulk/clearances.h"

#include "parallel/for_each.h"

#include <algorithm>
#include <cmath>

namespace sqmap::bulk {

namespace {

using query::DistanceKind;
using query::SignedDistance;

constexpr double k_infinite = std::numeric_limits<double>::infinity();
constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t k_batch = 4096;  ///< points that share work in query::distances
/// More than float distances err, of R_max and the distance together.
constexpr double k_float_error = 5e-7;

/// A point, or the middle of a group, at one pose of the chunk.
struct Queued {
    std::uint32_t pose, number;
};

/// A point of the tool that may be the nearest, and the least that its distance may be.
struct Nearby {
    std::uint32_t point;
    double min_distance;
};

/// State of one pose of the chunk.
struct Progress {
    bool is_answered = false;          ///< nothing is left to compute, the answer is written
    bool is_stopped = false;           ///< nothing is left to compute, the nearest point so far is the answer
    double max_distance = k_infinite;  ///< some point is this near
    std::uint32_t first = 0;           ///< group whose points are answered first
    std::vector<Nearby> nearby;

    bool is_open() const { return !is_answered && !is_stopped; }
};

/// Answers one chunk of poses.
class Chunk {
public:
    Chunk(const ClearanceQuery& query, parallel::Slice slice, std::span<PoseClearance> answers)
        : query_(query),
          tool_(*query.tool),
          poses_(query.poses.subspan(slice.first, slice.count)),
          answers_(answers.subspan(slice.first, slice.count)),
          progress_(slice.count),
          bounds_(slice.count * tool_.groups().size(), -k_infinite),
          is_loose_(bounds_.size()),
          r_max_(query.touched.model->header.r_max * query.touched.model->header.unit)
    {
    }

    void run()
    {
        leave_out_far_poses();
        bound_groups(query::k_baked_band, [](std::size_t) { return true; });
        answer_first_groups();
        // Bounds beyond the baked band may be half of the truth: those that count are made exact.
        bound_groups(query_.band, [&](std::size_t group) { return is_loose_[group] != 0; });
        answer_other_groups();
        for (std::uint32_t i = 0; i < poses_.size(); ++i)
            if (!progress_[i].is_answered) finish(i);
    }

private:
    std::size_t row(std::uint32_t pose) const { return pose * tool_.groups().size(); }
    double error_of(double distance) const { return k_float_error * (r_max_ + std::abs(distance)); }
    static bool is_loose(const SignedDistance& found) { return found.known == DistanceKind::LowerBound; }
    /// The least that a float distance stands for: a bound has the sign of the truth, which is at most twice as far.
    double lower_of(const SignedDistance& found) const
    {
        return (is_loose(found) && found.distance < 0 ? 2 : 1) * found.distance - error_of(found.distance);
    }
    double upper_of(const SignedDistance& found) const
    {
        return (is_loose(found) && found.distance > 0 ? 2 : 1) * found.distance + error_of(found.distance);
    }

    /// Queries distances of the queued positions, k_batch at a time: take(queued, answer).
    template <class Position, class Take>
    void compute(double band, Position&& position, Take&& take)
    {
        found_.resize(std::min(k_batch, queued_.size()));
        for (std::size_t first = 0; first < queued_.size(); first += k_batch) {
            const std::span some = std::span(queued_).subspan(first, std::min(k_batch, queued_.size() - first));
            positions_.clear();
            for (const Queued& a : some) positions_.push_back(apply(poses_[a.pose], position(a.number)));
            query::distances(query_.touched, positions_, found_, band);
            for (std::size_t i = 0; i < some.size(); ++i) take(some[i], found_[i]);
        }
        queued_.clear();
    }

    /// Poses whose whole tool is beyond the band have a lower bound for an answer.
    void leave_out_far_poses()
    {
        for (std::uint32_t i = 0; i < poses_.size(); ++i) {
            answers_[i] = {};
            if (is_finite(poses_[i])) {
                queued_.push_back({i, 0});
                continue;
            }
            progress_[i].is_answered = true;
            answers_[i].distance = k_nan;
            answers_[i].status = query::k_not_finite;
        }
        const ToolPoints::Group& all = tool_.all();
        compute(
            query::k_baked_band, [&](std::uint32_t) { return all.centre; },
            [&](const Queued& a, const SignedDistance& found) {
                answers_[a.pose].point = answers_[a.pose].witness = apply(poses_[a.pose], all.centre);
                const double bound = lower_of(found) - all.radius;
                if (bound > query_.band) answer_bound(a.pose, bound);
            });
    }

    void answer_bound(std::uint32_t pose, double bound)
    {
        progress_[pose].is_answered = true;
        answers_[pose].distance = bound;
    }

    /// Bounds the distances of groups from below, where wanted(row of the pose and group) and where the group still counts.
    template <class Wanted>
    void bound_groups(double band, Wanted&& wanted)
    {
        const std::span groups = tool_.groups();
        for (std::uint32_t i = 0; i < poses_.size(); ++i)
            for (std::uint32_t g = 0; g < groups.size() && progress_[i].is_open(); ++g)
                if (wanted(row(i) + g) && counts(i, g)) queued_.push_back({i, g});
        compute(
            band, [&](std::uint32_t group) { return groups[group].centre; },
            [&](const Queued& a, const SignedDistance& found) {
                const std::size_t at = row(a.pose) + a.number;
                bounds_[at] = lower_of(found) - groups[a.number].radius * (1 + 1e-12);
                is_loose_[at] = is_loose(found) ? 1 : 0;
            });
    }

    /// True where a point of the group may be the nearest and has not been answered.
    bool counts(std::uint32_t pose, std::uint32_t group) const
    {
        const Progress& p = progress_[pose];
        return (p.nearby.empty() || group != p.first) && bounds_[row(pose) + group] <= p.max_distance;
    }

    void add_points(std::uint32_t pose, std::uint32_t group)
    {
        const ToolPoints::Group& g = tool_.groups()[group];
        for (std::size_t k = 0; k < g.count; ++k) queued_.push_back({pose, static_cast<std::uint32_t>(g.first + k)});
    }

    void answer_first_groups()
    {
        const std::size_t groups = tool_.groups().size();
        for (std::uint32_t i = 0; i < poses_.size(); ++i) {
            if (!progress_[i].is_open()) continue;
            const std::span bounds = std::span(bounds_).subspan(row(i), groups);
            progress_[i].first = static_cast<std::uint32_t>(std::min_element(bounds.begin(), bounds.end()) - bounds.begin());
            add_points(i, progress_[i].first);
        }
        answer_points();
        for (std::uint32_t i = 0; i < poses_.size() && query_.stop_below; ++i) {
            if (!progress_[i].is_open() || !(progress_[i].max_distance <= *query_.stop_below)) continue;
            progress_[i].is_stopped = true;
            for (std::uint32_t g = 0; g < groups; ++g)
                if (counts(i, g)) answers_[i].complete = false;
        }
    }

    void answer_other_groups()
    {
        for (std::uint32_t i = 0; i < poses_.size(); ++i)
            for (std::uint32_t g = 0; g < tool_.groups().size() && progress_[i].is_open(); ++g)
                if (counts(i, g)) add_points(i, g);
        answer_points();
    }

    void answer_points()
    {
        compute(
            query_.band, [&](std::uint32_t point) { return tool_.points()[point]; },
            [&](const Queued& a, const SignedDistance& found) {
                Progress& p = progress_[a.pose];
                const double min_distance = lower_of(found);
                if (min_distance > p.max_distance) return;
                p.max_distance = std::min(p.max_distance, upper_of(found));
                p.nearby.push_back({a.number, min_distance});
            });
    }

    /// Answers in double what float cannot tell from the nearest point.
    void finish(std::uint32_t i)
    {
        const Progress& p = progress_[i];
        double bound = k_infinite;
        for (const Nearby& n : p.nearby) bound = std::min(bound, n.min_distance);
        if (bound > query_.band) return answer_bound(i, bound);
        positions_.clear();
        queued_.clear();
        for (const Nearby& n : p.nearby)
            if (n.min_distance <= p.max_distance) {
                queued_.push_back({i, n.point});
                positions_.push_back(apply(poses_[i], tool_.points()[n.point]));
            }
        found_.resize(positions_.size());
        query::exact_distances(query_.touched, positions_, found_);
        std::size_t best = 0;
        const auto number = [&](std::size_t k) { return tool_.numbers()[queued_[k].number]; };
        for (std::size_t k = 1; k < found_.size(); ++k)
            if (found_[k].distance < found_[best].distance ||
                (found_[k].distance == found_[best].distance && number(k) < number(best)))
                best = k;
        write(answers_[i], i, positions_[best], number(best), found_[best]);
        queued_.clear();
    }

    void write(PoseClearance& answer, std::uint32_t pose, Vec3d point, std::uint32_t number, const SignedDistance& found) const
    {
        answer.distance = found.distance;
        answer.known = found.known;
        answer.status = found.status;
        if (is_loose(found)) return;
        answer.by_translation = found.gradient;
        answer.by_rotation = cross(point - poses_[pose].translation, found.gradient);
        answer.point = point;
        answer.witness = found.witness;
        answer.index = number;
        answer.part = found.part;
        answer.triangle = found.triangle;
    }

    const ClearanceQuery& query_;
    const ToolPoints& tool_;
    const std::span<const Pose> poses_;
    const std::span<PoseClearance> answers_;
    std::vector<Progress> progress_;
    std::vector<double> bounds_;          ///< poses x groups: no point of the group is nearer
    std::vector<std::uint8_t> is_loose_;  ///< poses x groups: the middle's distance was a bound
    std::vector<Queued> queued_;
    std::vector<Vec3d> positions_;
    std::vector<SignedDistance> found_;
    const double r_max_;
};

/// The answer where there is nothing to touch or to be touched by.
PoseClearance of_nothing(const Pose& pose)
{
    PoseClearance answer;
    answer.distance = is_finite(pose) ? k_infinite : k_nan;
    answer.status = is_finite(pose) ? query::k_ok : query::k_not_finite;
    answer.point = answer.witness = pose.translation;
    return answer;
}

}  // namespace

void clearances(const ClearanceQuery& query, std::span<PoseClearance> answers)
{
    const std::size_t count = std::min(query.poses.size(), answers.size());
    if (query.touched.model == nullptr || query.tool == nullptr || query.tool->size() == 0) {
        std::transform(query.poses.begin(), query.poses.begin() + static_cast<std::ptrdiff_t>(count), answers.begin(),
                       of_nothing);
        return;
    }
    // As many poses as have the middles of their groups answered in one batch.
    const std::size_t together = std::max<std::size_t>(1, k_batch / query.tool->groups().size());
    const auto run = [&](parallel::Slice slice) { Chunk(query, slice, answers).run(); };
    if (query.threads == 1)
        for (std::size_t first = 0; first < count; first += together) run({first, std::min(together, count - first)});
    else
        parallel::for_slices(count, together, query.threads, run);
}

}  // namespace sqmap::bulk
