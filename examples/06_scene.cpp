// Many solids in one world: which are near each other, and their contacts.
#include <sqmap/io/model_file.h>
#include <sqmap/io/read.h>
#include <sqmap/sqmap.h>

#include <cstdio>
#include <vector>

int main(int argc, char** argv)
try {
    using namespace sqmap;
    if (argc != 3) return 64;
    const io::MappedModel file(argv[1]);
    const io::ReadResult mesh = io::read_mesh_file(argv[2]);
    if (mesh.error) {
        std::fprintf(stderr, "%s: %s; %s\n", argv[2], mesh.error->message.c_str(), mesh.error->cure.c_str());
        return 65;
    }
    const query::Probe probe(mesh.soup.positions);
    // A row of ten, 3 apart: none touches another.
    query::Scene scene;
    std::vector<query::BodyId> bodies;
    for (int i = 0; i < 10; ++i) bodies.push_back(scene.add(&file.view(), &probe, {{}, {3.0 * i, 0, 0}}));
    std::vector<query::ScenePair> pairs(16);
    std::vector<query::PairContact> contacts(4096);

    // Each tick, real-time safe. The first one moves along the row.
    for (const double x : {0.0, 1.1, 4.1}) {
        scene.set_pose(bodies.front(), {{}, {x, 0, 0}});
        const query::SceneResult result = scene.query_pairs({}, pairs, contacts);
        std::printf("at %.1f: %zu near, %s\n", x, result.pairs, result.contacts > 0 ? "touching" : "free");
    }
} catch (const sqmap::io::ModelFileError& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 65;
}
