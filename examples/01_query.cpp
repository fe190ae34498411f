// Loads a baked model and queries one point: inside or not, penetration depth, direction to the surface.
#include <sqmap/io/model_file.h>
#include <sqmap/query/query.h>

#include <cstdio>

int main(int argc, char** argv)
{
    if (argc != 2) return 64;
    const sqmap::io::MappedModel file(argv[1]);  // mapped and verified, or throws ModelFileError
    const sqmap::model::ModelView& model = file.view();
    const sqmap::Vec3f p = sqmap::model::to_model_space(model.header, {0, 0, 0.9});
    // Real-time safe: no allocation, no lock, no exception.
    const sqmap::query::Contact c = sqmap::query::query_point(model, p, sqmap::query::Layer::Three);
    const double depth = static_cast<double>(c.depth) * model.header.unit;  // back to the mesh's units
    if (c.contact) std::printf("%.3f deep on part %d, out along %.2f\n", depth, c.part, static_cast<double>(c.normal.z));
}
