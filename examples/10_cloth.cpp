// A blanket that falls on a ball and comes to rest.
#include <sqmap/io/model_file.h>
#include <sqmap/sim/cloth.h>

#include <cstdio>

int main(int argc, char** argv)
try {
    using namespace sqmap;
    if (argc != 2) return 64;
    const io::MappedModel file(argv[1]);  // a ball of radius 1: a metre
    const sim::Garment blanket = sim::sheet({.centre = {0, 1.2, 0}, .width = 2, .depth = 2, .vertices = 400});
    sim::Cloth cloth(blanket, sim::fabric("cotton"));
    const sim::Collider ball{.model = &file.view()};

    sim::StepReport report;
    for (int step = 0; step < 120; ++step) report = cloth.step(1.0 / 60, {&ball, 1});
    const sim::Penetration inside = sim::penetration(cloth.positions(), cloth.triangles(), {&ball, 1});
    std::printf("%zu of %zu nodes lie on the ball, the deepest %.1f mm inside\n", report.contacts, cloth.size(),
                1000 * inside.nodes);
} catch (const sqmap::io::ModelFileError& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 65;
}
