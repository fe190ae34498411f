// Two solids in the world, one pushed into the other: the contacts of both, each reported once.
#include <sqmap/io/model_file.h>
#include <sqmap/io/read.h>
#include <sqmap/sqmap.h>

#include <cstdio>

int main(int argc, char** argv)
try {
    using namespace sqmap;
    if (argc != 3) return 64;
    // Set up once: the model, and the mesh's own vertices as probe.
    const io::MappedModel file(argv[1]);
    const io::ReadResult mesh = io::read_mesh_file(argv[2]);
    if (mesh.error) {
        std::fprintf(stderr, "%s: %s; %s\n", argv[2], mesh.error->message.c_str(), mesh.error->cure.c_str());
        return 65;
    }
    const query::Probe probe(mesh.soup.positions);
    query::PairWorkspace workspace(probe.size());

    const query::Body left{&file.view(), &probe, {}}, right{&file.view(), &probe, {{}, {1.9, 0, 0}}};
    const query::PairResult pair = query::query_pair(left, right, {}, workspace);
    const query::PairContact* deepest = nullptr;
    for (const query::PairContact& c : pair.contacts)
        if (deepest == nullptr || c.depth > deepest->depth) deepest = &c;
    if (deepest != nullptr)
        std::printf("%.2f deep, the right one leaves along %.1f\n", static_cast<double>(deepest->depth),
                    static_cast<double>(deepest->normal.x));
} catch (const sqmap::io::ModelFileError& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 65;
}
