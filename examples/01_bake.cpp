// Bakes a mesh file into a model, or says why the file is no solid.
#include <sqmap/bake/bake.h>
#include <sqmap/io/model_file.h>
#include <sqmap/io/read.h>
#include <sqmap/mesh/admit.h>

#include <cstdio>

int main(int argc, char** argv)
{
    if (argc != 3) return 64;
    const sqmap::io::ReadResult file = sqmap::io::read_mesh_file(argv[1]);
    if (file.error) {
        std::fprintf(stderr, "%s: %s; %s\n", argv[1], file.error->message.c_str(), file.error->cure.c_str());
        return 65;
    }
    const sqmap::mesh::AdmitResult gate = sqmap::mesh::admit({file.soup.positions, file.soup.polygon_offsets, file.soup.indices});
    if (gate.admission == sqmap::mesh::Admission::Refused) {
        std::fprintf(stderr, "%s: %s\n", argv[1], gate.diagnosis.message.c_str());
        return 65;
    }
    sqmap::bake::BakeOptions options;
    options.cured = sqmap::bake::cured(gate.admission, gate.made_up, gate.deviation);  // which surface the file did not have
    const sqmap::bake::BakeResult baked = sqmap::bake::bake(gate.mesh, gate.solid, options);
    sqmap::io::write_model(baked.model, argv[2]);
    std::printf("%zu parts, depth within %.2f %% of R_max\n", baked.model.parts.size(), baked.model.measured.depth_p99);
}
