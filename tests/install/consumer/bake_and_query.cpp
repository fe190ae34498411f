// Bakes a ball through the front door, as a central and as a paper model, writes and maps the file, and queries both.
#include <sqmap/bake_mesh.h>
#include <sqmap/io/model_file.h>
#include <sqmap/mesh/shapes.h>
#include <sqmap/sqmap.h>

#include <cmath>
#include <cstdio>

int main()
{
    const sqmap::mesh::Mesh ball = sqmap::mesh::sphere(1.0, 3);
    const sqmap::BakedModel baked = sqmap::bake_mesh(ball);
    baked.save("ball.sqmap");
    const sqmap::io::MappedModel file("ball.sqmap");
    const sqmap::query::PointResult contact = sqmap::query::query_point(file.view(), {0, 0, 0.8});
    const sqmap::BakedModel paper = sqmap::bake_mesh(ball, {.paper_maps = sqmap::paper::MapOptions{}});
    const sqmap::query::PointResult by_maps = sqmap::query::query_point(paper.view(), {0, 0, 0.8});
    std::printf("depth %.4f, by the paper's maps %.4f\n", contact.depth, by_maps.depth);
    return std::abs(contact.depth - 0.2) < 0.01 && std::abs(by_maps.depth - 0.2) < 0.01 ? 0 : 1;
}
