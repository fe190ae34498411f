// Many poses of a tool in one call, behind the C interface.
#include "objects.h"
#include "sqmap/bulk/clearances.h"
#include "structs.h"

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace sqmap::capi {
namespace {

bulk::ToolPoints tool_of(const sqmap_points& tool)
{
    const std::span<const Vec3d> points = rows(tool, "tool.xyz");
    if (points.empty()) throw Failure{SQMAP_E_ARGUMENT, "tool", "has no points", "give at least one"};
    check_finite(points, "tool.xyz");
    return bulk::ToolPoints(points);
}

template <class T, class Get>
void fill_column(T* target, std::span<const bulk::PoseClearance> answers, Get&& get)
{
    if (target == nullptr) return;
    for (std::size_t i = 0; i < answers.size(); ++i) target[i] = static_cast<T>(get(answers[i]));
}

/// Three numbers of each answer, from `column` on, in rows of `width`.
template <class Get>
void fill_vectors(double* target, std::size_t width, std::size_t column, std::span<const bulk::PoseClearance> answers, Get&& get)
{
    if (target == nullptr) return;
    for (std::size_t i = 0; i < answers.size(); ++i) {
        const Vec3d v = get(answers[i]);
        double* const row = target + width * i + column;
        row[0] = v.x;
        row[1] = v.y;
        row[2] = v.z;
    }
}

void write_clearances(const sqmap_pose_clearances& out, std::span<const bulk::PoseClearance> answers)
{
    using Answer = const bulk::PoseClearance&;
    fill_column(out.distance, answers, [](Answer a) { return a.distance; });
    fill_vectors(out.gradient, 6, 0, answers, [](Answer a) { return a.by_translation; });
    fill_vectors(out.gradient, 6, 3, answers, [](Answer a) { return a.by_rotation; });
    fill_vectors(out.point, 3, 0, answers, [](Answer a) { return a.point; });
    fill_vectors(out.closest, 3, 0, answers, [](Answer a) { return a.witness; });
    fill_column(out.index, answers, [](Answer a) { return a.index; });
    fill_column(out.part, answers, [](Answer a) { return a.part; });
    fill_column(out.known, answers, [](Answer a) { return static_cast<std::uint8_t>(a.known); });
    fill_column(out.complete, answers, [](Answer a) { return a.complete ? 1 : 0; });
    fill_column(out.status, answers, [](Answer a) { return a.status; });
}

}  // namespace
}  // namespace sqmap::capi

using namespace sqmap;

sqmap_code sqmap_query_poses(sqmap_model model, const sqmap_points* tool, const sqmap_poses* poses,
                             sqmap_pose_clearances* clearances)
{
    return capi::guarded([&] {
        const capi::Model& m = *capi::model_of(model);
        const sqmap_points points = capi::taken(&capi::needed(tool, "tool"), "tool");
        const sqmap_poses given = capi::taken(&capi::needed(poses, "poses"), "poses");
        const sqmap_pose_clearances out = capi::taken(&capi::needed(clearances, "clearances"), "clearances");
        constexpr double k_infinite = std::numeric_limits<double>::infinity();
        const bulk::ToolPoints grouped = capi::tool_of(points);
        const std::vector<Pose> frames = capi::poses_of(given.pose, given.count, "poses.pose");
        bulk::ClearanceQuery query{.touched = {&m.view(), nullptr, capi::pose_of(points.pose, "tool.pose")},
                                   .tool = &grouped,
                                   .poses = frames,
                                   .threads = capi::threads_of(given.threads, "poses.threads")};
        if (given.band != 0) query.band = capi::checked(given.band, 0, k_infinite, "poses.band");
        constexpr double k_largest = std::numeric_limits<double>::max();
        const double stop_below = capi::checked(given.stop_below, -k_largest, k_largest, "poses.stop_below");
        if (given.stops != 0) query.stop_below = stop_below;
        std::vector<bulk::PoseClearance> answers(frames.size());
        bulk::clearances(query, answers);
        capi::write_clearances(out, answers);
    });
}
