// Two solids in the world, one pushed into the other: the vertices of each in the other, then all that touches, edges too.
#include <sqmap/io/model_file.h>
#include <sqmap/sqmap.h>

#include <cstdio>
#include <vector>

int main(int argc, char** argv)
try {
    using namespace sqmap;
    if (argc != 2) return 64;
    // Set up once: the model, and the mesh in it as probe. Complete contacts need its triangles.
    const io::MappedModel file(argv[1]);
    const model::ModelView& view = file.view();
    std::vector<Vec3d> points;
    for (std::size_t v = 0; v < view.vertices.size() / 3; ++v) points.push_back(model::mesh_vertex(view, v));
    std::vector<query::ProbeTriangle> triangles;
    for (std::uint32_t t = 0; t < view.triangle_part.size(); ++t)
        triangles.push_back(
            {model::triangle_vertex(view, t, 0), model::triangle_vertex(view, t, 1), model::triangle_vertex(view, t, 2)});
    const query::Probe probe(points, triangles);
    query::PairWorkspace workspace(probe.size());
    query::ContactWorkspace complete(probe.size());

    const query::Body left{&view, &probe, {}};
    query::Body right{&view, &probe, {{}, {1.9, 0, 0}}};
    const query::PairResult pair = query::query_pair(left, right, {}, workspace);
    const query::PairContact* deepest = nullptr;
    for (const query::PairContact& c : pair.contacts)
        if (deepest == nullptr || c.depth > deepest->depth) deepest = &c;
    if (deepest != nullptr)
        std::printf("%.2f deep, the right one leaves along %.1f\n", static_cast<double>(deepest->depth),
                    static_cast<double>(deepest->normal.x));

    // No contact is missed, whichever features touch; here the four that span most of where the balls do.
    const query::ContactResult all = query::query_contacts(left, right, {.per_region = 4}, complete);
    std::printf("%zu region, %zu contacts\n", all.regions, all.contacts.size());
    right.pose.translation.x = 2.5;
    std::printf("%.2f apart\n", query::clearance(left, right).distance);
    const query::BodyTouch touch = query::first_touch(left, right, {{}, {1.5, 0, 0}});
    std::printf("touch after %.2f of the way to 1.5\n", touch.time);
} catch (const sqmap::io::ModelFileError& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 65;
}
