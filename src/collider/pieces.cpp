#include "collider/pieces.h"

#include "bake/parts/part.h"
#include "bake/parts/refinement.h"
#include "sqmap/bake/rebake.h"
#include "sqmap/mesh/bvh.h"
#include "sqmap/mesh/error.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/shapes.h"

#include <algorithm>
#include <cmath>

namespace sqmap::collider {
namespace {

/// A superquadric of model space in mesh units.
shape::Superquadricd in_mesh_units(shape::Superquadricd sq, Vec3d origin, double unit)
{
    sq.a = unit * sq.a;
    sq.translation = unit * sq.translation + origin;
    sq.bend /= unit;
    return sq;
}

/// Triangles that share no vertices, as a mesh.
mesh::Mesh soup_mesh(std::span<const std::array<Vec3d, 3>> triangles)
{
    mesh::Mesh out;
    for (const std::array<Vec3d, 3>& t : triangles) {
        const auto first = static_cast<std::uint32_t>(out.vertices.size());
        out.vertices.insert(out.vertices.end(), t.begin(), t.end());
        out.triangles.push_back({first, first + 1, first + 2});
    }
    return out;
}

std::vector<std::uint32_t> all_of(std::size_t count)
{
    std::vector<std::uint32_t> out(count);
    for (std::uint32_t i = 0; i < count; ++i) out[i] = i;
    return out;
}

/// The triangles in the model space of a normalization.
std::vector<std::array<Vec3d, 3>> scaled(std::span<const std::array<Vec3d, 3>> triangles, const mesh::Normalization& n)
{
    std::vector<std::array<Vec3d, 3>> out(triangles.begin(), triangles.end());
    for (std::array<Vec3d, 3>& t : out)
        for (Vec3d& v : t) v = (v - n.origin) / n.unit;
    return out;
}

Pieces uncut(const CutInput& input, const CutOptions& options)
{
    Pieces out{.name = input.name, .surface = {}};
    Piece& piece = out.pieces.emplace_back(Piece{.name = input.name, .points = {}});
    for (const std::array<Vec3d, 3>& t : input.triangles) piece.points.insert(piece.points.end(), t.begin(), t.end());
    if (input.solid != nullptr) {
        out.surface = *input.solid;
        out.is_solid = true;
        out.crossed.assign(input.crossed.begin(), input.crossed.end());
        piece.points.insert(piece.points.end(), input.solid->vertices.begin(), input.solid->vertices.end());
        piece.volume = mesh::volume(*input.solid);
    }
    out.held.assign(input.triangles.begin(), input.triangles.end());
    if (options.superquadrics) {
        mesh::Mesh mesh = input.solid != nullptr ? *input.solid : soup_mesh(input.triangles);
        const mesh::Normalization n = mesh::normalization_of(mesh);
        mesh = mesh::normalized(mesh, n);
        const fit::FitReport fit = fit::fit_bounding(mesh, all_of(mesh.triangles.size()), scaled(input.triangles, n));
        piece.superquadric = in_mesh_units(fit.superquadric, n.origin, n.unit);
    }
    return out;
}

/// For each part the input's triangles whose middle is nearest to it.
std::vector<std::vector<std::array<Vec3d, 3>>> nearest_parts(const CutInput& input, const decompose::Partition& partition)
{
    const mesh::Bvh bvh(*input.solid);
    std::vector<std::vector<std::array<Vec3d, 3>>> out(partition.part_count);
    for (const std::array<Vec3d, 3>& t : input.triangles) {
        const Vec3d middle = (t[0] + t[1] + t[2]) / 3.;
        out[partition.part_of_triangle[bvh.closest_point(middle).triangle]].push_back(t);
    }
    return out;
}

}  // namespace

Piece Pieces::whole() const
{
    Piece out{.name = name, .points = {}};
    for (const Piece& p : pieces) {
        out.points.insert(out.points.end(), p.points.begin(), p.points.end());
        out.volume += p.volume;
    }
    if (is_solid) out.volume = mesh::volume(surface);
    return out;
}

Pieces pieces_of(const model::ModelView& model, const std::string& name)
{
    decompose::Partition partition;
    partition.part_count = static_cast<std::uint32_t>(model.parts.size());
    if (model::has_exact(model))
        for (std::uint32_t t = 0; t < model.header.triangle_count; ++t)
            partition.part_of_triangle.push_back(model::part_of_triangle(model, t));
    std::vector<shape::Superquadricd> superquadrics;
    std::vector<std::string> names;
    for (std::size_t p = 0; p < model.parts.size(); ++p) {
        superquadrics.push_back(shape::cast<double>(model::superquadric_of(model.parts[p])));
        names.push_back("part_" + std::to_string(p));
    }
    const std::vector<double> certified(model.parts.size(), 1);
    return pieces_of(model, {partition, superquadrics, certified, names}, name);
}

Pieces pieces_of(const model::ModelView& model, const EditedParts& parts, const std::string& name)
{
    if (!model::has_exact(model))
        throw mesh::InvalidInput(mesh::Words("the model was baked without its triangles, which say what a part is; bake it with ",
                                             mesh::Setting::Exact)
                                     .text());
    const std::size_t count = parts.partition.part_count;
    if (parts.superquadrics.size() != count || parts.largest_f.size() != count || parts.names.size() != count)
        throw mesh::InvalidInput("edited parts need a superquadric, a bound and a name each");
    const mesh::Mesh baked = bake::baked_mesh(model);
    std::vector<bake::Patch> patches = bake::patches_of(baked, parts.partition);
    Pieces out{.name = name, .surface = baked, .is_solid = model.header.solid != 0};
    // Shapes hold the caller's own vertices, which the model's are rounded from.
    for (std::size_t v = 0; v < out.surface.vertices.size(); ++v) out.surface.vertices[v] = model::mesh_vertex(model, v);
    const auto mesh_units = [&](Vec3d p) {
        return model.header.unit * p + Vec3d{model.header.origin[0], model.header.origin[1], model.header.origin[2]};
    };
    for (std::size_t i = 0; i < patches.size(); ++i) {
        Piece piece{.name = parts.names[i], .points = {}};
        if (out.is_solid) piece.volume = bake::enclosed_volume(baked, patches[i]) * std::pow(model.header.unit, 3);
        for (bake::CapTriangle& cap : patches[i].caps)
            for (Vec3d& p : cap) p = mesh_units(p);
        piece.points = bake::corners_of(out.surface, patches[i]);
        piece.superquadric = in_mesh_units(parts.superquadrics[i], mesh_units({}), model.header.unit);
        piece.certified = parts.largest_f[i] <= 1;
        out.pieces.push_back(std::move(piece));
    }
    if (model.header.self_intersecting != 0) out.crossed = mesh::find_self_intersections(out.surface).crossed;
    return out;
}

Pieces pieces_of(const CutInput& input, const CutOptions& options)
{
    if (options.max_parts <= 1 || input.solid == nullptr) return uncut(input, options);
    Pieces out{.name = input.name, .surface = *input.solid, .is_solid = true};
    out.crossed.assign(input.crossed.begin(), input.crossed.end());
    out.held.assign(input.triangles.begin(), input.triangles.end());
    const mesh::Normalization n = mesh::normalization_of(*input.solid);
    const mesh::Mesh mesh = mesh::normalized(*input.solid, n);
    bake::BakeOptions bake{.max_parts = options.max_parts, .threads = options.threads};
    bake.decompose.max_parts = options.max_parts;
    const mesh::Solid solid(mesh, input.crossed);
    const bake::CanonicalMesh canonical = bake::canonical_mesh(mesh);
    const bake::FittedPartition fitted =
        bake::refine_partition({solid, canonical}, decompose::decompose(mesh, bake.decompose), bake);
    const auto held = nearest_parts(input, fitted.partition);
    for (std::size_t i = 0; i < fitted.parts.size(); ++i) {
        const bake::Patch& patch = fitted.parts[i].fitted.patch;
        Piece piece{.name = input.name + "_part_" + std::to_string(i), .points = bake::corners_of(mesh, patch)};
        for (Vec3d& p : piece.points) p = n.unit * p + n.origin;
        for (const std::array<Vec3d, 3>& t : held[i]) piece.points.insert(piece.points.end(), t.begin(), t.end());
        piece.volume = bake::enclosed_volume(mesh, patch) * n.unit * n.unit * n.unit;
        if (options.superquadrics) {
            std::vector<std::array<Vec3d, 3>> caps = scaled(held[i], n);
            caps.insert(caps.end(), patch.caps.begin(), patch.caps.end());
            piece.superquadric = in_mesh_units(fit::fit_bounding(mesh, patch.triangles, caps).superquadric, n.origin, n.unit);
        }
        out.pieces.push_back(std::move(piece));
    }
    return out;
}

}  // namespace sqmap::collider
