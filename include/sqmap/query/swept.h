// A moving probe between two ticks: contacts that a query at the end alone misses because they happened on the path.
#pragma once

#include "sqmap/query/probe.h"

#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::query {

/// Between two poses: translation straight, rotation about one axis at a steady rate. share in [0, 1]; ends are exact.
/// @pre both rotations are proper
[[nodiscard]] Pose between(const Pose& from, const Pose& to, double share) noexcept;

/// How finely a path is queried.
struct SweptOptions {
    QueryOptions query{};
    /// Nothing is missed whose chord along a point's path, as the model sees it, is at least this long, where the path meets it
    /// at more than 15 degrees. The poses' units. Points that move less are queried once. Not above 0: every point that moves is
    /// queried max_steps times.
    double step = 0;
    std::uint32_t max_steps = 64;  ///< a point that moves farther than this many steps is queried at longer ones: k_coarse
};

/// The workspace of a swept query, made outside the tick: one for each thread that queries.
class SweptWorkspace {
public:
    /// points: of the probe. Allocates.
    explicit SweptWorkspace(std::size_t points);
    /// With a second probe in it, like the first, for positions on the path: the first one need not be moved there and back.
    explicit SweptWorkspace(const Probe& probe);

private:
    friend struct SweptRun;
    Probe probe_;
    std::vector<Vec3d> at_;
    std::vector<std::uint8_t> fast_;
    std::vector<std::uint32_t> contact_;  ///< of each point: where its contact is, or none
    std::vector<Contact> found_;
};

/// Contacts along a path.
struct SweptResult {
    ProbeResult probe;            ///< as query_probe's, of all contacts
    std::size_t fast = 0;         ///< points that moved farther than a step
    std::size_t caught = 0;       ///< contacts that the end alone had missed or had with a surface behind the point
    std::uint32_t positions = 1;  ///< of the path that were queried
};

/// A probe that moves, and that deforms on its way.
struct SweptQuery {
    Body touched{};                        ///< where the path ends
    Probe* probe = nullptr;                ///< stands at `now` afterwards, so it belongs to one thread
    Pose from{}, to{};                     ///< probe's frame -> that of touched.pose, at both ends
    std::span<const Vec3d> previous, now;  ///< positions of the probe's points at both ends, the probe's frame
};

/// Contacts of the probe's points at the end of their path, as query_probe gives them, and of those that crossed the surface on
/// it: such a contact is with the surface that was crossed first, and its depth is the distance behind that surface's tangent
/// plane. In the frame of the poses. Total, noexcept, no allocation; a point that is not finite has no contacts.
/// @pre previous.size() == now.size() == probe->size(), and the workspace is for as many
/// Cost: a probe query, and for each step of the fastest point one of the points that move farther than a step.
[[nodiscard]] SweptResult query_swept(const SweptQuery& query, const SweptOptions& options, SweptWorkspace& workspace,
                                      std::span<Contact> contacts) noexcept;

}  // namespace sqmap::query
