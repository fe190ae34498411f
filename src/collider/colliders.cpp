#include "collider/pieces.h"
#include "collider/spheres.h"
#include "mesh/convex_hull.h"
#include "parallel/for_each.h"
#include "sqmap/collider/export.h"
#include "sqmap/mesh/error.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>

namespace sqmap::collider {
namespace {

constexpr std::array k_formats{"urdf", "mjcf", "sdf", "srdf", "spheres", "json", "obj", "glb"};
constexpr std::size_t k_max_spheres = 4096;

std::string lower(std::string_view text)
{
    std::string out(text);
    std::transform(out.begin(), out.end(), out.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return out;
}

/// Corners of the convex hull alone, which is all that a convex shape has to hold.
std::vector<Vec3d> extreme(const std::vector<Vec3d>& points)
{
    mesh::Mesh hull = mesh::convex_hull(points);
    return hull.triangles.empty() ? points : std::move(hull.vertices);
}

Shape shape_of(const Piece& piece, Kind kind, std::span<const Vec3d> points)
{
    if (kind != Kind::Superquadric) return enclosing(kind, points);
    if (!piece.superquadric) throw mesh::InvalidInput(piece.name + ": it has no superquadric; take another shape");
    return {.kind = kind, .xyz = piece.superquadric->translation, .superquadric = *piece.superquadric};
}

}  // namespace

const char* name_of(Format format) noexcept { return k_formats[static_cast<std::size_t>(format)]; }

std::optional<Format> format_named(std::string_view name) noexcept
{
    const auto found = std::find(k_formats.begin(), k_formats.end(), lower(name));
    if (found == k_formats.end()) return std::nullopt;
    return static_cast<Format>(found - k_formats.begin());
}

std::optional<Format> format_by_ending(const std::filesystem::path& path)
{
    const std::string ending = path.extension().string();
    if (ending.empty()) return std::nullopt;
    const std::optional<Format> format = format_named(ending.substr(1));
    return format == Format::Spheres ? std::nullopt : format;  // cuRobo's file is YAML, whose ending says nothing
}

std::optional<ShapeChoice> choice_named(std::string_view text) noexcept
{
    const std::string name = lower(text);
    for (int i = 0; i <= static_cast<int>(Kind::Superquadric); ++i)
        if (name == name_of(static_cast<Kind>(i))) return ShapeChoice{.kind = static_cast<Kind>(i)};
    constexpr std::string_view k_spheres = "spheres:";
    if (!name.starts_with(k_spheres)) return std::nullopt;
    ShapeChoice choice{.kind = Kind::Sphere};
    const char* const first = name.data() + k_spheres.size();
    const char* const last = name.data() + name.size();
    const auto [end, error] = std::from_chars(first, last, choice.spheres);
    if (error != std::errc{} || end != last || choice.spheres == 0 || choice.spheres > k_max_spheres) return std::nullopt;
    return choice;
}

Colliders colliders_of(const Pieces& pieces, const ShapeChoice& choice, unsigned threads)
{
    Colliders out{.name = pieces.name, .items = {}, .whole = {}};
    const Piece whole = pieces.whole();
    const std::vector<Vec3d> all = extreme(whole.points);
    std::vector<Shape> shapes;
    if (choice.spheres > 0) {
        if (!pieces.is_solid)
            throw mesh::InvalidInput("spheres hold a solid, and this mesh bounds none; take hull, box or sphere, or close it");
        shapes = covering_spheres(pieces.surface, pieces.crossed, choice.spheres, pieces.held);
        for (std::size_t i = 0; i < shapes.size(); ++i)
            out.items.push_back({"sphere_" + std::to_string(i),
                                 shapes[i],
                                 {.volume = volume(shapes[i]), .support_excess = -1, .coverage = -1},
                                 {}});
    } else {
        out.items.resize(pieces.pieces.size());
        parallel::for_each(pieces.pieces.size(), threads, [&](std::size_t i) {
            const Piece& piece = pieces.pieces[i];
            Colliders::Item& item = out.items[i];
            item.name = piece.name;
            item.points = extreme(piece.points);
            item.shape = shape_of(piece, choice.kind, item.points);
            item.certified = piece.certified || choice.kind != Kind::Superquadric;
            item.figures = figures_of({&item.shape, 1}, {.points = item.points, .volume = piece.volume});
        });
        for (const Colliders::Item& item : out.items) shapes.push_back(item.shape);
    }
    out.whole = figures_of(
        shapes,
        {.points = all, .volume = whole.volume, .solid = pieces.is_solid ? &pieces.surface : nullptr, .crossed = pieces.crossed});
    return out;
}

Colliders colliders_of(const model::ModelView& model, const std::string& name, const ShapeChoice& choice, unsigned threads)
{
    return colliders_of(pieces_of(model, name), choice, threads);
}

Colliders colliders_of(const model::ModelView& model, const EditedParts& parts, const std::string& name,
                       const ShapeChoice& choice, unsigned threads)
{
    return colliders_of(pieces_of(model, parts, name), choice, threads);
}

Colliders export_model(const model::ModelView& model, const std::filesystem::path& path, const ExportOptions& options)
{
    Colliders out = colliders_of(model, path.stem().string(), options.shape, options.threads);
    write(files_of(out, options.format, path));
    return out;
}

}  // namespace sqmap::collider
