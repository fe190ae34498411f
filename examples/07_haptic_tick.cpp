// A haptic tick without a device: the force that a tip feels, and what the safety filter lets through to a hand.
#include <sqmap/io/model_file.h>
#include <sqmap/sqmap.h>

#include <algorithm>
#include <cstdio>

int main(int argc, char** argv)
try {
    using namespace sqmap;
    if (argc != 2) return 64;
    const io::MappedModel file(argv[1]);
    // Forces are in N and m: a ball of radius 1 becomes one of 5 cm.
    const model::ModelView ball = haptic::in_metres(file.view(), 0.05);
    const haptic::TouchedBody touched{.model = &ball};

    // The tool is a point: samples about it smooth the force.
    const haptic::Tool tip({.shape = haptic::ToolShape::Point});
    haptic::State state = tip.state();
    haptic::SafetyFilter filter({.max_force = 3, .continuous_force = 1},
                                {.force_limit = 1});  // N: what the device can, and what the user wants

    // 1 kHz: a second above the surface, then down into it by 3 mm.
    haptic::Wrench commanded, sent;
    for (int tick = 0; tick < 4000; ++tick) {
        const double time = 0.001 * tick, along = std::min(std::max(time - 1, 0.0) / 2, 1.0);
        const Pose pose{{}, {0, 0, 0.060 - 0.013 * along}};
        haptic::step(state, {.touched = {&touched, 1}, .poses = {&pose, 1}}, {&commanded, 1});
        haptic::SafetyInput in;
        in.time = in.sample_time = time;
        in.sequence = static_cast<std::uint64_t>(tick) + 1;
        in.poses = {&pose, 1};
        in.commanded = {&commanded, 1};
        filter.tick(in, {&sent, 1});
    }
    std::printf("%.1f N commanded, %.1f N sent\n", commanded.force.z, sent.force.z);
} catch (const sqmap::io::ModelFileError& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 65;
}
