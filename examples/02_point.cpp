// Loads a baked model and queries one point: inside or not, penetration depth, direction out.
#include <sqmap/io/model_file.h>
#include <sqmap/sqmap.h>

#include <cstdio>

int main(int argc, char** argv)
try {
    if (argc != 2) return 64;
    const sqmap::io::MappedModel file(argv[1]);  // mapped and verified
    // In the mesh's frame and units. Real-time safe: no allocation, no lock, no exception.
    const sqmap::query::PointResult point = sqmap::query::query_point(file.view(), {0, 0, 0.9});
    if (point.contact) std::printf("%.3f deep on part %d, out along %.2f\n", point.depth, point.part, point.normal.z);
} catch (const sqmap::io::ModelFileError& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 65;
}
