// One object of the scene: a model with its triangles, and where it stands in the world.
#pragma once

#include "sqmap/bake_mesh.h"
#include "sqmap/decompose/decompose.h"
#include "sqmap/haptic/wrench.h"
#include "sqmap/mesh/mesh.h"
#include "sqmap/model/model.h"
#include "sqmap/paper/model_file.h"
#include "sqmap/shape/superquadric.h"
#include "viewer/server/protocol/messages.h"
#include "viewer/server/scene/names.h"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sqmap::viewer {

/// Parts as they are shown: the model's own, or edited ones that are not baked yet.
struct Parts {
    decompose::Partition partition;                   ///< without boundaries where it comes from a model
    std::vector<shape::Superquadricd> superquadrics;  ///< #parts, model space
    std::vector<double> largest_f;                    ///< #parts, proven; above 1: not certified
    std::vector<sqmap::Sphere3<double>> spheres;      ///< #parts, about the superquadrics, model space
    std::vector<std::string> names;                   ///< #parts: shape and position, for people who do not see colours
};

/// Immutable once it is shared, so that threads may read it. Model space: as the model has it. World: metres, y up.
struct Object {
    std::string name;                                    ///< of the file, without folder and extension
    std::shared_ptr<const std::vector<std::byte>> file;  ///< the bytes of the .sqmap file, which copies share
    std::shared_ptr<const paper::AnyModel> model;        ///< of the file, shared alike
    model::ModelView view{};                             ///< of the model
    model::ModelView metres{};                           ///< the same, measured in metres
    double metres_per_unit = 1;
    Vec3d centre{};    ///< of its box, mesh units
    Vec3d half{};      ///< of its box as it stands, m
    Vec3d position{};  ///< of the centre in the world, m
    Up up = Up::Y;
    mesh::Mesh mesh;         ///< model space; empty where the model was baked without its triangles
    mesh::DualGraph dual{};  ///< of mesh
    Parts parts;
    std::filesystem::path names_file;  ///< where its names are kept: beside a model that the program opened; empty: nowhere
    Words words;                       ///< that its parts were named with
    std::optional<mesh::Admission> admission;     ///< of the mesh it was baked from here; absent of a model
    std::vector<Note> notes;                      ///< about that mesh and about the model
    std::optional<bake::BakeOptions> baked_with;  ///< when it was baked here, without progress and partition; absent of a model

    /// Scales the object and moves it. metres_per_unit: metres a unit of the mesh; position: of the centre in the world, m
    /// up: the mesh's axis that points upwards from then on
    void put_at(double metres_per_unit, Vec3d position, Up up = Up::Y);

    [[nodiscard]] Mat3d turn() const;        ///< axes of the mesh -> axes of the world
    [[nodiscard]] sqmap::Pose pose() const;  ///< mesh frame in metres -> world
    [[nodiscard]] Vec3f world(Vec3d model_point) const;
    [[nodiscard]] Vec3d mesh_units(Vec3d world_point) const;
    [[nodiscard]] Vec3f model_space(Vec3d world_point) const
    {
        return model::to_model_space(view.header, mesh_units(world_point));
    }
    [[nodiscard]] Frame frame() const;  ///< model space -> mesh units
    [[nodiscard]] double metres_per_model_unit() const { return view.header.unit * metres_per_unit; }
};
using ObjectPtr = std::shared_ptr<const Object>;

/// The triangles of one part and the vertices that they use, model space.
[[nodiscard]] mesh::Mesh part_mesh(const Object& object, const Parts& parts, std::uint32_t part);
/// #triangles, 1 where the cure of the mesh made the triangle up; empty where there was no cure.
[[nodiscard]] std::vector<std::uint8_t> made_up_triangles(const Object& object);
/// True where both have the same triangles, up to rounding to float.
[[nodiscard]] bool are_of_one_mesh(const Object& a, const Object& b);
/// Tells whether a triangle may be entered, so far along the surface from its seed, model units.
using MayEnter = std::function<bool(std::uint32_t triangle, double along)>;
inline constexpr std::uint32_t k_no_seed = 0xffffffff;
/// #triangles: the number of the seed that is nearest along the surface; k_no_seed where none is reached. seeds: triangles.
[[nodiscard]] std::vector<std::uint32_t> nearest_seeds(const mesh::Mesh& mesh, const mesh::DualGraph& dual,
                                                       const std::vector<std::uint32_t>& seeds, const MayEnter& may_enter);
/// Moves the object to the right of the others, in rows of three, one behind the other.
void put_beside(Object& object, std::span<const ObjectPtr> others);

}  // namespace sqmap::viewer
