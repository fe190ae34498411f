// How near each of many poses brings a tool to a model, with gradients, in one call.
#pragma once

#include "sqmap/math/pose.h"
#include "sqmap/query/body.h"
#include "sqmap/query/distance.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace sqmap::bulk {

/// Points of a tool, in groups of near ones that are culled together. Any number of threads may read it.
class ToolPoints {
public:
    /// A group: points first to first + count, in a ball; the tool's frame.
    struct Group {
        Vec3d centre;
        double radius;
        std::size_t first, count;
    };

    ToolPoints() = default;
    /// points: any order, the tool's frame. @pre they are finite. @throw std::bad_alloc. Cost: n log n
    explicit ToolPoints(std::span<const Vec3d> points);

    /// Number of points.
    [[nodiscard]] std::size_t size() const noexcept { return points_.size(); }
    /// The points, group by group.
    [[nodiscard]] std::span<const Vec3d> points() const noexcept { return points_; }
    /// Number of each of points() in the order that they were given in.
    [[nodiscard]] std::span<const std::uint32_t> numbers() const noexcept { return numbers_; }
    /// About the square root of size().
    [[nodiscard]] std::span<const Group> groups() const noexcept { return groups_; }
    /// A ball with all points. @pre there are points
    [[nodiscard]] const Group& all() const noexcept { return all_; }

private:
    void divide(std::size_t first, std::size_t count, std::size_t max_count, std::span<const Vec3d> given);

    std::vector<Vec3d> points_;
    std::vector<std::uint32_t> numbers_;
    std::vector<Group> groups_;
    Group all_{};
};

/// The question: a tool at many poses beside one model.
struct ClearanceQuery {
    query::Body touched{};             ///< its model is queried, its probe does not count
    const ToolPoints* tool = nullptr;  ///< outlives the call
    std::span<const Pose> poses{};     ///< tool frame -> the frame of touched.pose. @pre rotations are proper (not checked)
    /// Units of the poses: farther than this a lower bound suffices.
    double band = query::k_everywhere;
    /// Absent: the minimum is sought. Else a pose is done when one point is found to be this near.
    std::optional<double> stop_below{};
    unsigned threads = 1;  ///< 0: one per core. The answers do not depend on it
};

/// How near a pose brings the tool; the frame and units of the poses.
struct PoseClearance {
    double distance = 0;         ///< least signed distance of the tool's points, negative inside; of a bound at most that
    Vec3d by_translation{};      ///< its derivative with respect to the pose's translation; unit; zero of a bound
    Vec3d by_rotation{};         ///< and to turns about the pose's translation, axis times radians, axes of the frame
    Vec3d point{};               ///< the point at that distance; of a bound the middle of the tool
    Vec3d witness{};             ///< the surface point nearest to it; of a bound as `point`
    std::int64_t index = -1;     ///< its number among the tool's points, the lowest of several; -1 of a bound
    std::int32_t part = -1;      ///< that owns the surface there; -1 of a bound
    std::int32_t triangle = -1;  ///< of the model, that holds the witness; -1 of a bound
    query::DistanceKind known = query::DistanceKind::LowerBound;  ///< LowerBound: no point is nearer
    std::uint8_t status = query::k_ok;                            ///< bits of query::Status
    bool complete = true;  ///< false where stop_below ended the search: another point may be nearer
};

/// How near each pose brings the tool: answers[i] is that of poses[i], the same bits for any number of threads. Balls about
/// groups of near points leave out what cannot be nearest; the points that remain are answered in float, and the nearest of
/// these, with all that float cannot tell from it, in double by query::exact_distance. Models without the exact layer answer by
/// layer 3 (Approximate), as far as its error tells points apart. A pose that is not finite: distance NaN, k_not_finite; the
/// others stay right. The derivatives are those of the nearest point: where two points or two surface points are equally near the
/// minimum has a crease, and they are those of one side. A tool without points, or without a model to touch: infinite,
/// LowerBound.
/// @pre answers.size() >= poses.size(), else the rest is left out
/// @throw std::bad_alloc
/// Cost: 45 to 100 us a pose for 500 points, 1 to 21 us with a band of a fiftieth of the object. Thread-safe.
void clearances(const ClearanceQuery& query, std::span<PoseClearance> answers);

}  // namespace sqmap::bulk
