// The paper's own query and force, step by step, on a model of its projection: F, foot, distance map, smoothed map, spring.
#include <sqmap/paper/force.h>
#include <sqmap/paper/model_file.h>
#include <sqmap/paper/projection.h>
#include <sqmap/sqmap.h>

#include <cstdio>

int main(int argc, char** argv)
try {
    using namespace sqmap;
    if (argc != 2) return 64;
    const paper::MappedModel file(argv[1]);  // sqmap bake ball.obj -o ball.sqmap --projection normal
    if (!paper::is_paper(file.view())) {
        std::fprintf(stderr, "%s has the central projection: bake it with --projection normal\n", argv[1]);
        return 65;
    }
    // Section 2: a part's superquadric, F < 1 inside. These functions take model space.
    const paper::MapView map = paper::map_of(file.view(), 0);
    const auto scale = static_cast<float>(1 / file.view().header.unit);
    const Vec3f p{0, 0, 0.9f * scale};
    std::printf("F %.2f\n", static_cast<double>(shape::implicit(map.superquadric, p)));

    // Section 4.2: the point's foot on the superquadric, and how far below it the map has the surface.
    for (const query::Layer layer : {query::Layer::Two, query::Layer::Three}) {
        const paper::PartAnswer answer = paper::project(map, p, {.layer = layer});
        std::printf("layer %d: %.3f below the foot, the surface %.3f: %.2f deep\n", layer == query::Layer::Two ? 2 : 3,
                    static_cast<double>(answer.foot_distance / scale), static_cast<double>(answer.map_distance / scale),
                    static_cast<double>(answer.depth / scale));
    }

    // Section 6: the spring of eqs. 21 and 32 along the normal of eq. 26, on the smoothed map. In N and m: a ball of 5 cm.
    const model::ModelView ball = haptic::in_metres(file.view(), 0.05);
    const haptic::TouchedBody touched{.model = &ball, .material = {.friction = Friction::None}};
    const haptic::Tool tip(
        {.force = paper::with_paper_force({.layer = query::Layer::Three, .stiffness = 300}), .shape = haptic::ToolShape::Point});
    haptic::State state = tip.state();
    const Pose pose{{}, {0, 0, 0.048}};
    haptic::Wrench force;
    (void)haptic::step(state, {.touched = {&touched, 1}, .poses = {&pose, 1}}, {&force, 1});
    std::printf("2 mm deep at 300 N/m: %.1f N\n", force.force.z);
} catch (const sqmap::io::ModelFileError& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 65;
}
