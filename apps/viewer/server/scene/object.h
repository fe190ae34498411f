// One object of the scene: a model with its triangles, its position in the world, and what the page shows of it.
#pragma once

#include "common/load_mesh.h"
#include "sqmap/bake/bake.h"
#include "sqmap/decompose/decompose.h"
#include "sqmap/haptic/wrench.h"
#include "sqmap/model/model.h"
#include "sqmap/shape/superquadric.h"
#include "viewer/server/scene/names.h"

#include <nlohmann/json.hpp>

#include <cstddef>
#include <filesystem>
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

/// Immutable, so that threads share it. Model space: as the model has it. World: metres, y up.
struct Object {
    std::string name;             ///< of the file, without folder and extension
    std::vector<std::byte> blob;  ///< the .sqmap file
    model::ModelView view{};      ///< of blob
    model::ModelView metres{};    ///< the same, measured in metres
    double metres_per_unit = 1;
    Vec3d centre{};          ///< of its box, mesh units
    Vec3d half{};            ///< of its box, m
    Vec3d position{};        ///< of the centre in the world, m
    mesh::Mesh mesh;         ///< model space; empty where the model was baked without its triangles
    mesh::DualGraph dual{};  ///< of mesh
    Parts parts;
    std::filesystem::path names_file;  ///< where its names are kept: beside a model that the program opened; empty: nowhere
    Words words;                       ///< that its parts were named with
    std::string verdict;               ///< of the mesh it was baked from, with repairs and warnings; empty for a model
    std::vector<std::string> notes;

    Object() = default;
    Object(const Object&) = delete;
    Object& operator=(const Object&) = delete;

    [[nodiscard]] sqmap::Pose pose() const;  ///< mesh frame in metres -> world
    [[nodiscard]] Vec3f world(Vec3d model_point) const;
    [[nodiscard]] Vec3d mesh_units(Vec3d world_point) const;
    [[nodiscard]] Vec3f model_space(Vec3d world_point) const
    {
        return model::to_model_space(view.header, mesh_units(world_point));
    }
    [[nodiscard]] Frame frame() const;  ///< model space -> mesh units
};
using ObjectPtr = std::shared_ptr<const Object>;

/// size: m, that R_max becomes. words: what its parts are called.
/// @throw std::runtime_error where the bytes are no model
[[nodiscard]] std::shared_ptr<Object> object_from_model(std::vector<std::byte> bytes, const std::string& name, double size,
                                                        const Words& words = {});
/// The file that keeps the names of a model's parts: cow.sqmap has cow.names.json beside it.
[[nodiscard]] std::filesystem::path names_file_of(const std::filesystem::path& model);
/// What that file says; nothing said where there is none or it is not one.
[[nodiscard]] Words words_beside(const std::filesystem::path& model);
/// @throw mesh::Error
[[nodiscard]] std::shared_ptr<Object> object_from_mesh(const app::LoadedMesh& loaded, const std::string& name, double size,
                                                       const bake::BakeOptions& options);
/// The same object with other parts, baked with the options' projection; what the cure of its mesh made up stays so.
/// @throw mesh::Error
[[nodiscard]] std::shared_ptr<Object> rebaked(const Object& object, const Parts& parts, const bake::BakeOptions& options,
                                              const Words& words);

/// #triangles, 1 where the cure of the mesh made the triangle up; empty where there was no cure.
[[nodiscard]] std::vector<std::uint8_t> made_up_triangles(const Object& object);
/// Both have the same triangles, up to rounding to float.
[[nodiscard]] bool are_of_one_mesh(const Object& a, const Object& b);

/// The same object elsewhere: metres_per_unit and position as given.
[[nodiscard]] std::shared_ptr<Object> moved(const Object& object, double metres_per_unit, Vec3d position);
/// Moves to the right of what is there already; rows of three, one behind the other.
void put_beside(Object& object, std::span<const ObjectPtr> others);

/// Superquadrics and names of a partition. keep: whose superquadrics are taken over where a part has the same triangles.
[[nodiscard]] Parts fitted(const Object& object, decompose::Partition partition, const Parts* keep, const Words& words);
/// part's superquadric fitted anew; the others stay.
[[nodiscard]] Parts refitted(const Object& object, const Parts& parts, std::uint32_t part);
/// The cut between two parts moved into `other` by a distance along the surface, m, one row of triangles at least. Nothing where
/// they do not touch or too little of `other` would be left. What the cut separates from the rest of `other` goes with it.
[[nodiscard]] std::optional<decompose::Partition> moved_cut(const Object& object, const decompose::Partition& partition,
                                                            std::uint32_t part, std::uint32_t other, double distance);
/// Of each part: those that it shares an edge with, ascending.
[[nodiscard]] std::vector<std::vector<std::uint32_t>> neighbours_of(const Object& object, const decompose::Partition& partition);

/// Facts that stay in sight: parts, bytes, certificates, measured error.
[[nodiscard]] nlohmann::ordered_json facts_json(const Object& object, const Parts& parts, bool edited);
/// Parameters of every superquadric, in mesh units and model space.
[[nodiscard]] nlohmann::ordered_json superquadrics_json(const Object& object, const Parts& parts);

// Bytes for the page: little-endian 32-bit values.

/// "SQM1", #vertices, #triangles, #parts; positions (3 floats a vertex, world); corners (3 a triangle); part of each triangle.
[[nodiscard]] std::string mesh_bytes(const Object& object, const Parts& parts);
/// "SQS1", #parts; then a part: #vertices, #triangles, positions, corners.
[[nodiscard]] std::string superquadric_bytes(const Object& object, const Parts& parts, int segments);
enum class Field : std::uint8_t { ErrorOfTwo, Error, Protrusion, Curvature, MadeUp };
/// "SQF1", #triangles; a float a triangle. Error: of layer 3's depth just below the surface, percent of R_max; below 0: missed
/// (-1), not known (-2). ErrorOfTwo: the same of layer 2. Protrusion: over its mean. Curvature: Gaussian, times R_max squared.
/// MadeUp: 1 or 0.
[[nodiscard]] std::string field_bytes(const Object& object, Field field);
/// The same of layer 3's depths by two models of one mesh, 1 % of R_max below the surface: percent of R_max by which they differ;
/// -1 where only one finds contact, -2 where neither does. @pre are_of_one_mesh
[[nodiscard]] std::string difference_bytes(const Object& object, const Object& other);
/// "SQF1", #triangles; a float a triangle: 1 where other surface hides it from its part's projection (Q2 of section 5), 0 where
/// it is seen, -2 not known. Of the model's own parts.
[[nodiscard]] std::string hidden_bytes(const Object& object);
/// "SQP1", #samples; positions (3 floats a sample, world), part of each: the base samples of all maps.
[[nodiscard]] std::string sample_bytes(const Object& object);
/// "SQF1", #vertices; a float a vertex: how far the stored offset (eq. 12) moves the surface out, m.
[[nodiscard]] std::string offset_bytes(const Object& object);
/// "SQU1", width, height; then a pixel: distance of the surface below the superquadric, m, and the surface point, world. Instead
/// of a distance -1: none on this ray, -2: the ray starts inside the solid, -3: no pixel of the map. Of a central model the six
/// faces of the chart's cube as a cross, each `side` pixels wide; of a normal one the grid, at most 8 side wide.
/// @pre part < #parts of the model
[[nodiscard]] std::string map_bytes(const Object& object, std::uint32_t part, int side);
/// Binary glTF: a mesh a part and a mesh a superquadric, in metres. A superquadric has its parameters as extras, texture
/// coordinates, and in its material's extras a displacement texture: grey times `scale` (below 0: inwards) metres along the
/// normal lead to the part's surface where alpha is not zero.
[[nodiscard]] std::string glb_bytes(const Object& object, const Parts& parts);

}  // namespace sqmap::viewer
