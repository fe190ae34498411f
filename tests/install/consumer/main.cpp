#include <sqmap/mesh/shapes.h>

#include <cstdio>

int main()
{
    const sqmap::mesh::Mesh ball = sqmap::mesh::sphere(1.0, 4);
    std::printf("volume %.4f\n", sqmap::mesh::volume(ball));
    return sqmap::mesh::volume(ball) > 4.1 && sqmap::mesh::volume(ball) < 4.19 ? 0 : 1;
}
