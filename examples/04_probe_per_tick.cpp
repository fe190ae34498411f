// A tool's vertices against a baked model, once a tick: which are inside, penetration depth, direction out.
#include <sqmap/io/model_file.h>
#include <sqmap/io/read.h>
#include <sqmap/sqmap.h>

#include <cstdio>
#include <vector>

int main(int argc, char** argv)
try {
    using namespace sqmap;
    if (argc != 3) return 64;
    // Set up once: the model, the tool's vertices, and space for as many contacts.
    const io::MappedModel file(argv[1]);
    const io::ReadResult tool = io::read_mesh_file(argv[2]);
    if (tool.error) return 65;
    const query::Probe probe(tool.soup.positions);
    std::vector<query::Contact> contacts(probe.size());  // a query::ProbeWorkspace instead makes queries of slow hands sooner

    // Each tick, real-time safe: poses in, contacts out, in the frame of the poses. Here the world's, the model at its origin.
    for (const double height : {2.1, 1.95}) {
        const query::Body touched{.model = &file.view()}, collider{.probe = &probe, .pose = {{}, {0, 0, height}}};
        const query::ProbeResult result = query::query_probe(touched, collider, {}, contacts);
        float depth = 0;
        Vec3d at{};
        for (const query::Contact& c : result.written(contacts))
            if (c.depth > depth) {
                depth = c.depth;
                at = result.position(c);
            }
        std::printf("at %.2f: %s, %.2f deep at height %.1f\n", height, result.contacts > 0 ? "touching" : "free",
                    static_cast<double>(depth), at.z);
    }
} catch (const sqmap::io::ModelFileError& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 65;
}
