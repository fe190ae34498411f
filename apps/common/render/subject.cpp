#include "common/render/subject.h"

#include "sqmap/bake/rebake.h"
#include "sqmap/decompose/decompose.h"
#include "sqmap/fit/fit.h"
#include "sqmap/mesh/bvh.h"
#include "sqmap/paper/model_file.h"
#include "sqmap/query/point.h"

#include <limits>
#include <span>
#include <utility>

namespace sqmap::app {
namespace {

/// The superquadric that holds the point deepest.
std::uint32_t innermost(const std::vector<shape::Superquadricd>& superquadrics, Vec3d p)
{
    std::uint32_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t i = 0; i < superquadrics.size(); ++i)
        if (const double f = shape::implicit(superquadrics[i], p); f < least) {
            least = f;
            best = i;
        }
    return best;
}

/// Parts of a mesh that stands in for the model's own triangles.
std::vector<std::uint32_t> nearest_parts(const Subject& subject, const Subject& own)
{
    const model::ModelView& view = subject.model->view();
    std::optional<mesh::Bvh> bvh;
    if (!own.mesh.triangles.empty()) bvh.emplace(own.mesh);
    std::vector<std::uint32_t> parts;
    for (std::uint32_t t = 0; t < subject.mesh.triangles.size(); ++t) {
        const Vec3d centroid = mesh::triangle_centroid(subject.mesh, t);
        if (bvh) {
            parts.push_back(own.part_of_triangle[bvh->closest_point(centroid).triangle]);
            continue;
        }
        // Just below the surface the map knows whose surface is nearest.
        const auto& [a, b, c] = subject.mesh.triangles[t];
        const auto& v = subject.mesh.vertices;
        const Vec3d below = centroid - 0.002 * subject.r_max * normalized(cross(v[b] - v[a], v[c] - v[a]));
        const query::PointResult contact = query::query_point(model::normalized(view), below);
        parts.push_back(contact.contact && contact.part >= 0 ? static_cast<std::uint32_t>(contact.part)
                                                             : innermost(subject.superquadrics, centroid));
    }
    return parts;
}

}  // namespace

Subject bare_subject(const mesh::Mesh& mesh)
{
    Subject subject;
    subject.mesh = mesh::normalized(mesh, mesh::normalization_of(mesh));
    subject.r_max = mesh::largest_vertex_distance(subject.mesh);
    return subject;
}

SectionThree section_three_of(const Subject& subject, const decompose::DecomposeOptions& options)
{
    SectionThree out{.found = decompose::decompose_with_diagnostics(subject.mesh, options), .locales = {}};
    out.locales = decompose::locale_bands(subject.mesh, out.found, options);
    return out;
}

Subject subject_of_mesh(const mesh::Mesh& mesh, const decompose::DecomposeOptions& options)
{
    Subject subject = bare_subject(mesh);
    const decompose::Partition partition = decompose::decompose(subject.mesh, options);
    subject.part_of_triangle = partition.part_of_triangle;
    std::vector<std::vector<std::uint32_t>> triangles(partition.part_count);
    for (std::uint32_t t = 0; t < subject.part_of_triangle.size(); ++t) triangles[subject.part_of_triangle[t]].push_back(t);
    for (const auto& part : triangles) subject.superquadrics.push_back(fit::fit_bounding(subject.mesh, part, {}).superquadric);
    return subject;
}

Subject subject_of_model(paper::MappedModel mapped, const mesh::Mesh* mesh)
{
    Subject subject;
    subject.model.emplace(std::move(mapped));
    const model::ModelView& view = subject.model->view();
    for (const model::Part& part : view.parts) subject.superquadrics.push_back(shape::cast<double>(model::superquadric_of(part)));

    Subject own;
    own.mesh = bake::baked_mesh(view);
    for (std::uint32_t t = 0; t < view.triangle_part.size(); ++t)
        own.part_of_triangle.push_back(model::part_of_triangle(view, t));
    const bool is_own = mesh == nullptr || mesh::content_hash(*mesh) == view.mesh_hash;
    std::span<const std::uint16_t> labels;
    if (is_own && paper::is_paper(view)) labels = paper::Reading::of(view).model().maps.labels;
    for (const std::uint16_t code : labels) subject.regions.push_back(paper::decode_label(code).region);
    if (mesh == nullptr) {
        if (own.mesh.triangles.empty())
            throw SubjectError("the model was baked without its exact layer: give the mesh as a second argument");
        subject.mesh = std::move(own.mesh);
        subject.part_of_triangle = std::move(own.part_of_triangle);
        subject.r_max = view.header.r_max;
        return subject;
    }
    const model::Header& h = view.header;
    subject.mesh = mesh::normalized(*mesh, {{h.origin[0], h.origin[1], h.origin[2]}, h.unit});
    subject.r_max = view.header.r_max;
    for (const std::uint16_t code : labels) subject.part_of_triangle.push_back(paper::decode_label(code).part);
    if (labels.empty()) subject.part_of_triangle = nearest_parts(subject, own);
    return subject;
}

}  // namespace sqmap::app
