// Uses every installed library: makes a ball, bakes it, writes the model, maps it back and queries it.
#include <sqmap/bake/bake.h>
#include <sqmap/io/model_file.h>
#include <sqmap/mesh/shapes.h>
#include <sqmap/paper/bake.h>
#include <sqmap/sqmap.h>

#include <cmath>
#include <cstdio>

int main()
{
    const sqmap::mesh::Mesh ball = sqmap::mesh::sphere(1.0, 3);
    const sqmap::bake::BakeResult baked = sqmap::bake::bake(ball, true, {});
    sqmap::io::write_model(baked.model, "ball.sqmap");
    const sqmap::io::MappedModel file("ball.sqmap");
    const sqmap::model::ModelView& model = file.view();
    const sqmap::query::PointResult contact = sqmap::query::query_point(model, {0, 0, 0.8});
    // Rays of the paper map.
    const sqmap::paper::MapRays rays(ball);
    const bool hit = rays.first_hit({0, 0, 3}, {0, 0, -1}, 0, 10).has_value();
    std::printf("contact %d, depth %.4f, ray hit %d\n", contact.contact, contact.depth, hit);
    return contact.contact && std::abs(contact.depth - 0.2) < 0.01 && hit ? 0 : 1;
}
