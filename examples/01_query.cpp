// Loads a baked model and asks it about points: inside or not, how deep, which way is out.
#include <sqmap/io/model_file.h>
#include <sqmap/query/query.h>

#include <cstdio>

int main(int argc, char** argv)
{
    if (argc != 2) return 64;
    const sqmap::io::MappedModel file(argv[1]);  // mapped and verified; throws ModelFileError where it does not verify
    const sqmap::model::ModelView& model = file.view();

    for (const sqmap::Vec3d p : {sqmap::Vec3d{0, 0, 0.9}, sqmap::Vec3d{0, 0, 1.1}}) {
        // Real-time safe from here: no allocation, no lock, no exception.
        const sqmap::Vec3f q = sqmap::model::to_model_space(model.header, p);
        const sqmap::query::Contact c = sqmap::query::query_point(model, q, sqmap::query::Layer::Three);
        if (c.contact)
            std::printf("%g: inside, %.3f deep, way out (%.2f, %.2f, %.2f)\n", p.z, static_cast<double>(c.depth) * model.header.unit,
                        static_cast<double>(c.normal.x), static_cast<double>(c.normal.y), static_cast<double>(c.normal.z));
        else
            std::printf("%g: free\n", p.z);
    }
}
