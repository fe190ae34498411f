// Poses of a gripper against an object: poses answered a second with minimum and derivative, beside every point by itself.
#include "clock.h"
#include "error.h"
#include "math/random.h"
#include "measure.h"
#include "setting.h"
#include "sqmap/bake_mesh.h"
#include "sqmap/bulk/clearances.h"
#include "sqmap/math/rotation.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sqmap::bench {
namespace {

constexpr std::size_t k_checked = 500;  ///< poses whose points are answered one by one too

/// Points on a palm and two fingers, 0.25 wide in an object's units, whose box has the diagonal 1.
std::vector<Vec3d> gripper()
{
    struct Box {
        Vec3d lo, hi;
        std::size_t count;
    };
    const Box boxes[] = {{{-0.125, -0.03, 0}, {0.125, 0.03, 0.05}, 200},
                         {{-0.125, -0.02, 0.05}, {-0.1, 0.02, 0.2}, 150},
                         {{0.1, -0.02, 0.05}, {0.125, 0.02, 0.2}, 150}};
    SplitMix64 random(1);
    std::vector<Vec3d> points;
    for (const Box& box : boxes)
        for (std::size_t i = 0; i < box.count; ++i) {
            Vec3d p;
            for (int k = 0; k < 3; ++k) p[k] = random.between(box.lo[k], box.hi[k]);
            const int side = static_cast<int>(random.bits() % 3);
            p[side] = (random.bits() & 1) != 0 ? box.lo[side] : box.hi[side];
            points.push_back(p);
        }
    return points;
}

std::vector<Pose> random_poses(std::size_t count, double reach)
{
    SplitMix64 random(2);
    std::vector<Pose> poses;
    const auto in = [&](double r) { return Vec3d{random.between(-r, r), random.between(-r, r), random.between(-r, r)}; };
    for (std::size_t i = 0; i < count; ++i) poses.push_back({rotation_by(in(std::numbers::pi)), in(reach)});
    return poses;
}

struct Kind {
    const char* name;
    double band;
    std::optional<double> stop_below;
};

void report(const model::ModelView& model, const bulk::ToolPoints& tool, std::span<const Vec3d> points,
            std::span<const Pose> poses)
{
    std::vector<bulk::PoseClearance> answers(poses.size());
    for (const Kind& kind :
         {Kind{"exact anywhere", query::k_everywhere, {}}, {"exact within 0.02", 0.02, {}}, {"until one touches", 0.02, 0.0}}) {
        const bulk::ClearanceQuery query{{&model}, &tool, poses, kind.band, kind.stop_below, 1};
        double seconds = INFINITY;
        for (int round = 0; round < 3; ++round) {
            const double start = thread_seconds();
            bulk::clearances(query, answers);
            seconds = std::min(seconds, thread_seconds() - start);
        }
        const auto touching = std::count_if(answers.begin(), answers.end(), [](const auto& a) { return a.distance <= 0; });
        const auto count = static_cast<double>(poses.size());
        std::printf("  %-18s %6.2f us a pose, %7.1f million points a second, %4.1f %% touch\n", kind.name, 1e6 * seconds / count,
                    1e-6 * count * static_cast<double>(points.size()) / seconds, 100 * static_cast<double>(touching) / count);
    }
    bulk::clearances({{&model}, &tool, poses}, answers);
    std::vector<query::SignedDistance> each(points.size());
    std::size_t differ = 0;
    const std::size_t checked = std::min(k_checked, poses.size());
    const double start = thread_seconds();
    for (std::size_t i = 0; i < checked; ++i) {
        std::vector<Vec3d> posed;
        for (const Vec3d& p : points) posed.push_back(apply(poses[i], p));
        query::exact_distances(model, posed, each);
        const auto least = std::min_element(each.begin(), each.end(), [](auto& a, auto& b) { return a.distance < b.distance; });
        differ += least->distance != answers[i].distance || least - each.begin() != answers[i].index;
    }
    const double seconds = thread_seconds() - start;
    std::printf("  %-18s %6.2f us a pose, %7.1f million points a second; %zu of %zu poses differ\n", "every point",
                1e6 * seconds / static_cast<double>(checked), 1e-6 * static_cast<double>(checked * points.size()) / seconds,
                differ, checked);
}

}  // namespace
}  // namespace sqmap::bench

int sqmap::bench::measure_poses(int argc, char** argv)
{
    std::size_t count = 0;
    const std::string_view number = argc > 2 ? argv[1] : "";
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), count);
    if (error != std::errc() || count < 1) return k_wrong_usage;
    const std::vector<Vec3d> points = gripper();
    const bulk::ToolPoints tool(points);
    for (int i = 2; i < argc; ++i) {
        AdmittedMesh admitted = admit_mesh(argv[i]);
        if (admitted.refused())
            throw BenchError(std::string(argv[i]) + ": " + admitted.diagnosis.message +
                             "\n  cure: " + admitted.diagnosis.cure.text());
        const BakedModel baked = bake_mesh(centred(std::move(admitted.mesh), k_object_diagonal));
        const model::ModelView model = baked.view();
        for (const double reach : {0.5, 1.5}) {
            std::printf("%s, poses within %g of its middle\n", argv[i], reach);
            report(model, tool, points, random_poses(count, reach));
            std::fflush(stdout);
        }
    }
    return 0;
}
