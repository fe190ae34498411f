// A skinned shape: baked once as it was bound, queried in every pose of its bones. Here a finger of two bones that bends.
#include <sqmap/bake/skin_lattice.h>
#include <sqmap/bake_mesh.h>
#include <sqmap/mesh/shapes.h>
#include <sqmap/sqmap.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <vector>

int main()
{
    using namespace sqmap;
    // Set up once: the bound mesh, which bone moves which vertex, the model and the lattice.
    const mesh::Mesh finger = mesh::ellipsoid({1, 0.2, 0.2}, 3);
    mesh::Influences influences;
    for (const Vec3d& v : finger.vertices) {
        const double tip = std::clamp(0.5 + 2 * v.x, 0.0, 1.0);  // blended about the joint at the origin
        influences.joints.push_back({0, 1, 0, 0});
        influences.weights.push_back({1 - tip, tip, 0, 0});
    }
    const BakedModel baked = bake_mesh(finger);
    const model::ModelView bound = baked.view();
    const query::SkinLattice lattice = bake::skin_lattice(finger, influences);
    query::PosedSkin skin(lattice);
    const std::array<Vec3d, 2> points{{{0.8, 0, 0}, {0, 0.8, 0}}};
    query::SkinWorkspace workspace(lattice, points);
    std::array<query::SkinContact, 2> contacts;

    // Each tick, real-time safe: the bones' maps in, contacts in the posed frame out.
    const std::array<const char*, 2> names{"straight", "bent"};
    const Affine quarter{{{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}}, {}};
    for (std::size_t i = 0; i < 2; ++i) {
        const std::array<Affine, 2> bones{Affine{}, i == 0 ? Affine{} : quarter};
        if (!skin.pose(bones)) return 65;
        const query::ProbeResult result = query::query_skin({&bound, &skin, points, {}}, {}, workspace, contacts);
        if (result.contacts > 0) std::printf("%s: point %u is %.2f deep\n", names[i], contacts[0].index, contacts[0].depth);
    }
}
