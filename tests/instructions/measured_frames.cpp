// Runs the same frames as ever on one layer, for a tool that counts instructions in measured_frames().
// usage: measured_frames MODEL PROBE_MESH LAYER(1-4) -> contacts and the instruction set that answered
#include "sqmap/io/model_file.h"
#include "sqmap/io/read.h"
#include "sqmap/query/probe.h"

#include <hwy/targets.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

using namespace sqmap;

namespace {

/// From all around, as far in as the bounding spheres overlap by a third, a half and so on: some touch, some are near, some deep.
std::vector<Pose> poses(const model::ModelView& model)
{
    std::vector<Pose> out;
    constexpr int k_poses = 60;
    for (int i = 0; i < k_poses; ++i) {
        // A spiral over the sphere (Saff and Kuijlaars 1997).
        const double z = 1 - (2 * i + 1.0) / k_poses, r = std::sqrt(1 - z * z), a = 3.6 * i / std::sqrt(1.0 * k_poses);
        const Vec3d d{r * std::cos(a), r * std::sin(a), z};
        Pose pose;
        pose.rotation.row[0] = {std::cos(a), -std::sin(a), 0};
        pose.rotation.row[1] = {std::sin(a), std::cos(a), 0};
        pose.rotation.row[2] = {0, 0, 1};
        pose.translation = to_mesh_units(model.header, cast<float>((0.3 + 0.1 * (i % 6)) * double{model.header.r_max} * d));
        out.push_back(pose);
    }
    return out;
}

}  // namespace

extern "C" std::size_t measured_frames(const model::ModelView& model, const query::Probe& probe, const std::vector<Pose>& path,
                                       query::Layer layer, std::span<query::Contact> out);
extern "C" __attribute__((noinline)) std::size_t measured_frames(const model::ModelView& model, const query::Probe& probe,
                                                                 const std::vector<Pose>& path, query::Layer layer,
                                                                 std::span<query::Contact> out)
{
    std::size_t contacts = 0;
    for (const Pose& pose : path)
        contacts += query::query_probe({.model = &model}, {.probe = &probe, .pose = pose}, {.layer = layer}, out).contacts;
    return contacts;
}

int main(int argc, char** argv)
{
    if (argc != 4) return 2;
    const io::MappedModel model(argv[1]);
    std::vector<Vec3d> points = io::read_mesh_file(argv[2]).soup.positions;
    Vec3d lo = points.front(), hi = lo;
    for (const Vec3d& p : points)
        for (int k = 0; k < 3; ++k) {
            lo[k] = std::min(lo[k], p[k]);
            hi[k] = std::max(hi[k], p[k]);
        }
    const model::Header& header = model.view().header;
    const double scale = 0.8 * double{header.r_max} * header.unit / norm(hi - lo);
    for (Vec3d& p : points) p = scale * (p - 0.5 * (lo + hi));
    const query::Probe probe(points);
    std::vector<query::Contact> out(points.size());
    const auto layer = static_cast<query::Layer>(std::atoi(argv[3]) - 1);
    const std::size_t contacts = measured_frames(model.view(), probe, poses(model.view()), layer, out);
    const auto targets = static_cast<std::uint64_t>(hwy::SupportedTargets());
    std::printf("%zu %s\n", contacts, hwy::TargetName(static_cast<std::int64_t>(targets & (~targets + 1))));
    return 0;
}
