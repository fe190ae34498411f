// From a mesh file to the signed distance of a point. The model is kept in a file, too, for the other examples.
#include <sqmap/bake_mesh.h>
#include <sqmap/sqmap.h>

#include <cstdio>
#include <exception>

int main(int argc, char** argv)
try {
    if (argc != 3) return 64;
    const sqmap::BakedModel model = sqmap::bake_mesh(argv[1]);
    std::printf("%.2f\n", sqmap::query::distance(model.view(), {0, 0, 1.05}).distance);  // in the mesh's frame and units
    model.save(argv[2]);
} catch (const std::exception& e) {  // E_OPEN at edge 7-9: ...
    std::fprintf(stderr, "%s\n", e.what());
    return 65;
}
