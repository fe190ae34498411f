// Prints what libsdformat finds in an SDF file: a line a collision, name, kind, pose (x y z roll pitch yaw), sizes or mesh.
// usage: sdf_reader FILE
#include <sdf/sdf.hh>

#include <cstdio>

int main(int argc, char** argv)
{
    if (argc != 2) return 64;
    sdf::Root root;
    const sdf::Errors errors = root.Load(argv[1]);
    for (const sdf::Error& e : errors) std::fprintf(stderr, "%s\n", e.Message().c_str());
    if (!errors.empty() || root.Model() == nullptr) return 2;
    for (std::uint64_t l = 0; l < root.Model()->LinkCount(); ++l) {
        const sdf::Link& link = *root.Model()->LinkByIndex(l);
        for (std::uint64_t c = 0; c < link.CollisionCount(); ++c) {
            const sdf::Collision& collision = *link.CollisionByIndex(c);
            const sdf::Geometry& shape = *collision.Geom();
            const auto& at = collision.RawPose();
            std::printf("%s %.17g %.17g %.17g %.17g %.17g %.17g", collision.Name().c_str(), at.Pos().X(), at.Pos().Y(),
                        at.Pos().Z(), at.Rot().Roll(), at.Rot().Pitch(), at.Rot().Yaw());
            if (const sdf::Box* box = shape.BoxShape())
                std::printf(" box %.17g %.17g %.17g\n", box->Size().X(), box->Size().Y(), box->Size().Z());
            else if (const sdf::Sphere* sphere = shape.SphereShape())
                std::printf(" sphere %.17g\n", sphere->Radius());
            else if (const sdf::Cylinder* cylinder = shape.CylinderShape())
                std::printf(" cylinder %.17g %.17g\n", cylinder->Radius(), cylinder->Length());
            else if (const sdf::Capsule* capsule = shape.CapsuleShape())
                std::printf(" capsule %.17g %.17g\n", capsule->Radius(), capsule->Length());
            else if (const sdf::Ellipsoid* ellipsoid = shape.EllipsoidShape())
                std::printf(" ellipsoid %.17g %.17g %.17g\n", ellipsoid->Radii().X(), ellipsoid->Radii().Y(),
                            ellipsoid->Radii().Z());
            else if (const sdf::Mesh* mesh = shape.MeshShape())
                std::printf(" mesh %s\n", mesh->Uri().c_str());
            else
                return 3;
        }
    }
    return 0;
}
