// Files of other programs with shapes that enclose the parts of a thing.
// Any number of threads, on files of their own.
#pragma once

#include "sqmap/collider/shape.h"
#include "sqmap/decompose/decompose.h"
#include "sqmap/model/model.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sqmap::collider {

/// Files that are written.
enum class Format : std::uint8_t {
    Urdf,     ///< a link with a collision element a shape; box, cylinder and sphere, others as meshes in files beside it
    Mjcf,     ///< MuJoCo: a free body with a geom a shape
    Sdf,      ///< SDFormat 1.9: a model with a link
    Srdf,     ///< MoveIt's link_sphere_approximation: spheres alone
    Spheres,  ///< cuRobo's YAML: spheres alone
    Json,     ///< every parameter, and the equation that holds within
    Obj,      ///< the shapes as triangles, an object each
    Glb,      ///< the same as binary glTF, a node each
};

/// "urdf", "mjcf", "sdf", "srdf", "spheres", "json", "obj" or "glb". Never null.
[[nodiscard]] const char* name_of(Format format) noexcept;
/// The format of a name, whatever its case; nothing for another word.
[[nodiscard]] std::optional<Format> format_named(std::string_view name) noexcept;
/// The format that a file's ending says: ".urdf", ".mjcf", ".sdf", ".srdf", ".json", ".obj" or ".glb". Nothing for another.
[[nodiscard]] std::optional<Format> format_by_ending(const std::filesystem::path& path);

/// True of a format in which files_of() writes spheres and nothing else.
[[nodiscard]] constexpr bool holds_spheres_alone(Format format) noexcept
{
    return format == Format::Srdf || format == Format::Spheres;
}

/// A shape for each part, or balls for the whole.
struct ShapeChoice {
    Kind kind = Kind::Hull;
    std::size_t spheres = 0;  ///< above 0: at most so many balls that hold the whole together, and kind does not count
};
/// "hull", "box", ..., or "spheres:64". Nothing for other text, and for a number of spheres out of 1 to 4096.
[[nodiscard]] std::optional<ShapeChoice> choice_named(std::string_view text) noexcept;

/// Shapes with their figures.
struct Colliders {
    std::string name;
    /// One shape with its name and figures.
    struct Item {
        std::string name;
        Shape shape;
        Figures figures;            ///< beside the part's own solid
        std::vector<Vec3d> points;  ///< which the shape holds
        bool certified = true;      ///< false of a superquadric of EditedParts that is not proven to hold its part
    };
    std::vector<Item> items;
    Figures whole;  ///< of all shapes beside the whole solid
    /// True of balls that hold the whole together: none holds a part by itself.
    [[nodiscard]] bool is_cover() const { return !items.empty() && items.front().points.empty(); }
};

/// Shapes that hold the parts of a model, which name names. threads: 0 one a core; the result does not depend on it.
/// model: with its exact layer. @throw mesh::InvalidInput without it, and for spheres of a model that is no solid
/// Cost: as enclosing and figures_of for each part; of spheres some seconds.
[[nodiscard]] Colliders colliders_of(const model::ModelView& model, const std::string& name, const ShapeChoice& choice,
                                     unsigned threads = 0);

/// Parts that replace a model's own: a partition of its triangles that is not baked into it.
struct EditedParts {
    const decompose::Partition& partition;                ///< of the model's triangles
    std::span<const shape::Superquadricd> superquadrics;  ///< #parts, model space
    std::span<const double>
        largest_f;  ///< #parts: a proven bound of F over the part's solid; at most 1 where the superquadric holds it
    std::span<const std::string> names;  ///< #parts
};
/// The same for parts that were edited. @throw as above, and mesh::InvalidInput where a span has another length than the
/// partition
[[nodiscard]] Colliders colliders_of(const model::ModelView& model, const EditedParts& parts, const std::string& name,
                                     const ShapeChoice& choice, unsigned threads = 0);

/// A file to be written.
struct ExportFile {
    std::filesystem::path path;
    std::string bytes;
};
/// The files of a format: the one that path names comes last, meshes that it refers to before it. The shapes in them are those
/// that a reader finds, to the last bit: as_hull stands for a shape that the format lacks.
/// @throw mesh::InvalidInput for another shape than spheres where the format has nothing else
[[nodiscard]] std::vector<ExportFile> files_of(const Colliders& colliders, Format format, const std::filesystem::path& path);
/// Writes them; each appears whole or not at all, the one that refers to the others last. @throw io::ModelFileError
void write(const std::vector<ExportFile>& files);

/// Figures of each shape and of the whole, one object as JSON text.
[[nodiscard]] std::string report_json(const Colliders& colliders);

/// Options of export_model.
struct ExportOptions {
    Format format = Format::Json;
    ShapeChoice shape{};
    unsigned threads = 0;
};
/// Encloses the model's parts in shapes and writes them to a file; returns the shapes with their figures.
/// @throw as colliders_of, files_of and write
[[nodiscard]] Colliders export_model(const model::ModelView& model, const std::filesystem::path& path,
                                     const ExportOptions& options = {});

}  // namespace sqmap::collider
