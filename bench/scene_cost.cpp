// Cost of a scene's broad phase and of a pile in a frame: run under callgrind, whose counts do not depend on the machine's load.
#include "math/random.h"
#include "math/turns.h"
#include "measure.h"
#include "sqmap/bake_mesh.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/query/scene.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <vector>

namespace {

using namespace sqmap;

int run(std::string_view kind, std::size_t bodies, int frames)
{
    const mesh::Mesh shape = mesh::polygonized(mesh::hand_capsules(), 0.06);
    const BakedModel baked = bake_mesh(shape);
    const model::ModelView view = baked.view();
    const query::Probe probe(shape.vertices);
    query::Scene scene;
    SplitMix64 random(3);
    // A grid, shaken: as many to the volume whatever their number. The hand is about 1 long and half as wide: in the pile it
    // touches its neighbours.
    const auto side = static_cast<std::size_t>(std::ceil(std::cbrt(static_cast<double>(bodies))));
    const double apart = kind == "pile" ? 0.8 : 4.0;
    const double extent = apart * static_cast<double>(side);
    std::vector<Vec3d> positions, velocities;
    for (std::size_t i = 0; i < bodies; ++i) {
        const Vec3d cell{static_cast<double>(i % side), static_cast<double>(i / side % side),
                         static_cast<double>(i / side / side)};
        positions.push_back(apart * (cell + 0.3 * Vec3d{random.uniform(), random.uniform(), random.uniform()}));
        velocities.push_back(0.005 * Vec3d{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)});
        (void)scene.add(&view, &probe, {{}, positions.back()});
    }
    std::vector<query::ScenePair> pairs(20000);
    std::vector<query::PairContact> contacts(400000);
    std::size_t near = 0, found = 0;
    for (int frame = 0; frame < frames; ++frame) {
        if (kind == "probe") {  // what moves is the probe
            const query::SceneResult r = scene.query_probe(
                {.probe = &probe, .pose = {about_z(0.01 * frame), {extent * random.uniform(), extent * random.uniform(), -2}}},
                {}, pairs, contacts);
            near += r.pairs;
            found += r.contacts;
            continue;
        }
        for (std::size_t i = 0; i < bodies; ++i) {
            positions[i] += velocities[i];
            (void)scene.set_pose(static_cast<query::BodyId>(i), {about_z(0.01 * frame + static_cast<double>(i)), positions[i]});
        }
        const query::SceneResult r = scene.query_pairs({}, pairs, contacts);
        near += r.pairs;
        found += r.contacts;
    }
    if (frames > 0)
        std::printf("%zu bodies: %.1f pairs, %.1f contacts a frame\n", bodies, static_cast<double>(near) / frames,
                    static_cast<double>(found) / frames);
    return 0;
}

}  // namespace

int sqmap::bench::measure_scene_cost(int argc, char** argv)
{
    const std::string_view kind = argc == 4 ? argv[1] : "";
    int bodies = 0, frames = -1;
    const auto number = [](std::string_view text, int& value) {
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        return error == std::errc() && end == text.data() + text.size();
    };
    if ((kind != "far" && kind != "pile" && kind != "probe") || !number(argv[2], bodies) || !number(argv[3], frames) ||
        bodies < 1 || bodies > 5000 || frames < 0)
        return k_wrong_usage;
    return run(kind, static_cast<std::size_t>(bodies), frames);
}
