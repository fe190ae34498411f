#include "sqmap/bake/rebake.h"

namespace sqmap::bake {

mesh::Mesh baked_mesh(const model::ModelView& view)
{
    mesh::Mesh out;
    for (std::size_t v = 0; v + 2 < view.vertices.size(); v += 3)
        out.vertices.push_back(cast<double>(model::vec3(&view.vertices[v])));
    for (std::uint32_t t = 0; t < view.triangle_part.size(); ++t)
        out.triangles.push_back(
            {model::triangle_vertex(view, t, 0), model::triangle_vertex(view, t, 1), model::triangle_vertex(view, t, 2)});
    return out;
}

}  // namespace sqmap::bake
