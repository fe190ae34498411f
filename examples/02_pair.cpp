// Two balls in the world, one pushed into the other: contacts of both, each reported once, in world coordinates.
#include <sqmap/io/model_file.h>
#include <sqmap/io/read.h>
#include <sqmap/query/scene.h>

#include <algorithm>
#include <cstdio>

int main(int argc, char** argv)
{
    using namespace sqmap;
    if (argc != 3) return 64;
    // Set up once: the model, and the mesh's own vertices as probe.
    const io::MappedModel file(argv[1]);
    const io::ReadResult mesh = io::read_mesh_file(argv[2]);
    if (mesh.error) return 65;
    const query::Probe probe(mesh.soup.positions);
    query::Scene scene;
    scene.add(&file.view(), &probe);
    const query::BodyId second = scene.add(&file.view(), &probe);
    std::vector<query::ScenePair> pairs(16);
    std::vector<query::PairContact> contacts(4096);

    // Each frame, real-time safe: poses in, contacts out. The balls have radius 1.
    for (const double x : {3.0, 1.9}) {
        scene.set_pose(second, {{}, {x, 0, 0}});
        const query::SceneResult result = scene.query_pairs({}, pairs, contacts);
        float depth = 0;
        for (const query::PairContact& c : std::span(contacts).first(result.contacts)) depth = std::max(depth, c.depth);
        std::printf("at %.1f: %zu near, %s, %.2f deep\n", x, result.pairs, result.contacts > 0 ? "touching" : "free",
                    static_cast<double>(depth));
    }
}
