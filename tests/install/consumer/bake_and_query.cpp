// Uses every installed library: makes a ball, bakes it, writes the model, maps it back and queries it.
#include <sqmap/bake/bake.h>
#include <sqmap/bake/normal_map.h>
#include <sqmap/io/model_file.h>
#include <sqmap/mesh/shapes.h>
#include <sqmap/query/query.h>

#include <cmath>
#include <cstdio>

int main()
{
    const sqmap::mesh::Mesh ball = sqmap::mesh::sphere(1.0, 3);
    const sqmap::bake::BakeResult baked = sqmap::bake::bake(ball, true, {});
    sqmap::io::write_model(baked.model, "ball.sqmap");
    const sqmap::io::MappedModel file("ball.sqmap");
    const sqmap::model::ModelView& model = file.view();
    const sqmap::Vec3f inside = sqmap::model::to_model_space(model.header, {0, 0, 0.8});
    const sqmap::query::Contact contact = sqmap::query::query_point(model, inside, sqmap::query::Layer::Three);
    const double depth = static_cast<double>(contact.depth) * model.header.unit;
    // Rays of the normal map: they need the ray tracing library that the package must have found.
    const sqmap::bake::MapRays rays(ball);
    const bool hit = rays.first_hit({0, 0, 3}, {0, 0, -1}, 0, 10).has_value();
    std::printf("contact %d, depth %.4f, ray hit %d\n", contact.contact, depth, hit);
    return contact.contact && std::abs(depth - 0.2) < 0.01 && hit ? 0 : 1;
}
