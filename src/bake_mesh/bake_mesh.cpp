#include "sqmap/bake_mesh.h"

#include "io/replace_file.h"
#include "sqmap/model/model.h"
#include "sqmap/paper/model_file.h"

#include <utility>

namespace sqmap {
namespace {

template <class... F>
struct DoorCases : F... {
    using F::operator()...;
};
template <class... F>
DoorCases(F...) -> DoorCases<F...>;

mesh::Refusal refusal_of(const io::ReadError& error)
{
    for (const mesh::Refusal refusal : {mesh::Refusal::File, mesh::Refusal::Truncated, mesh::Refusal::Limit})
        if (error.code == mesh::name_of(refusal)) return refusal;
    return mesh::Refusal::Format;
}

mesh::Words cure_of(const io::ReadError& error)
{
    mesh::Words out(error.cure);
    if (error.limit == io::Raisable::MaxBytes) out.with(", or raise the limit with ", mesh::Setting::MaxBytes);
    if (error.limit == io::Raisable::MaxFaces) out.with(", or raise the limit with ", mesh::Setting::MaxFaces);
    return out;
}

AdmittedMesh admitted_as(const mesh::PolygonView& polygons, const MeshOptions& options, std::string source)
{
    return {mesh::admit(polygons, options.admit), "", std::move(source)};
}

AdmittedMesh admitted(io::ReadResult read, const MeshOptions& options, const std::filesystem::path& name)
{
    AdmittedMesh out;
    if (read.error)
        out.diagnosis = {refusal_of(*read.error), read.error->element, read.error->message, cure_of(*read.error)};
    else {
        if (options.as_read != nullptr) (*options.as_read)(read.soup);
        out = admitted_as({read.soup.positions, read.soup.polygon_offsets, read.soup.indices}, options, "");
    }
    if (read.format) out.format = io::format_name(*read.format);
    out.source = name.filename().string();
    return out;
}

AdmittedMesh admitted(const mesh::PolygonView& polygons, const MeshOptions& options)
{
    if (!polygons.offsets.empty() || polygons.indices.empty()) return admitted_as(polygons, options, "arrays");
    std::vector<std::uint32_t> offsets(polygons.indices.size() / 3 + 1);
    for (std::size_t i = 0; i < offsets.size(); ++i) offsets[i] = static_cast<std::uint32_t>(3 * i);
    return admitted_as({polygons.positions, offsets, polygons.indices}, options, "arrays");
}

AdmittedMesh admitted(const mesh::Mesh& mesh, const MeshOptions& options)
{
    std::vector<std::int64_t> corners;
    for (const mesh::Triangle& t : mesh.triangles) corners.insert(corners.end(), t.begin(), t.end());
    return admitted(mesh::PolygonView{mesh.vertices, {}, corners}, options);
}

/// The record of the cure for the model. It refers to the mesh.
bake::Cured cured(const AdmittedMesh& mesh)
{
    if (mesh.admission != mesh::Admission::Closed && mesh.admission != mesh::Admission::Wrapped) return {};
    return {mesh.admission == mesh::Admission::Closed ? model::Rung::Closed : model::Rung::Wrapped, mesh.made_up,
            mesh.deviation.value_or(mesh::Deviation{})};
}

}  // namespace

std::vector<Note> AdmittedMesh::notes() const
{
    std::vector<Note> out(repairs.begin(), repairs.end());
    if (deviation) {
        const double r_max = mesh::largest_vertex_distance(mesh);
        out.emplace_back(MovedNote{deviation->input_to_result, deviation->result_to_input, r_max});
        if (deviation->bounding_to_result) out.emplace_back(MovedBoundaryNote{*deviation->bounding_to_result, r_max});
        out.emplace_back(MadeUpNote{deviation->made_up_share});
    }
    out.insert(out.end(), warnings.begin(), warnings.end());
    return out;
}

AdmittedMesh admit_mesh(const MeshInput& input, const MeshOptions& options)
{
    return std::visit(
        DoorCases{
            [&](const std::filesystem::path& path) { return admitted(io::read_mesh_file(path, options.limits), options, path); },
            [&](const MeshBytes& file) {
                return admitted(io::read_mesh_bytes(file.bytes, file.name, options.limits), options, file.name);
            },
            [&](const auto& arrays) { return admitted(arrays, options); }},
        input);
}

AdmittedMesh admitted_mesh_of(const model::ModelView& model)
{
    AdmittedMesh out;
    const model::Cure& cure = model.cure;
    out.admission = cure.rung == model::Rung::Closed    ? mesh::Admission::Closed
                    : cure.rung == model::Rung::Wrapped ? mesh::Admission::Wrapped
                                                        : mesh::Admission::Accept;
    out.solid = model.header.solid != 0;
    out.source = model.source;
    for (std::size_t v = 0; v < model.vertices.size() / 3; ++v) out.mesh.vertices.push_back(model::mesh_vertex(model, v));
    out.source_triangle.assign(model.input.source_triangle.begin(), model.input.source_triangle.end());
    out.source_vertex.assign(model.input.source_vertex.begin(), model.input.source_vertex.end());
    const bool is_cured = cure.rung != model::Rung::AsItIs;
    for (std::uint32_t t = 0; t < model.triangle_part.size(); ++t) {
        out.mesh.triangles.push_back(
            {model::triangle_vertex(model, t, 0), model::triangle_vertex(model, t, 1), model::triangle_vertex(model, t, 2)});
        if (is_cured) out.made_up.push_back(model::is_made_up(model, t) ? 1 : 0);
    }
    if (!is_cured) return out;
    out.deviation.emplace();
    out.deviation->input_to_result = {cure.from_mean, cure.from_p99, cure.from_max};
    out.deviation->result_to_input = {cure.to_mean, cure.to_p99, cure.to_max};
    out.deviation->made_up_share = cure.made_up_share;
    return out;
}

BakedModel bake_mesh(const MeshInput& input, const BakeMeshOptions& options)
{
    return bake_mesh(admit_mesh(input, options.mesh), options);
}

BakedModel bake_mesh(AdmittedMesh mesh, const BakeMeshOptions& options)
{
    if (mesh.refused()) throw mesh::RefusedMesh(mesh.diagnosis);
    bake::BakeOptions bake = options.bake;
    bake.cured = cured(mesh);
    bake.source = {mesh.source_triangle, mesh.source_vertex};
    paper::BakeResult result = paper::bake(mesh.mesh, mesh.solid, bake, options.paper_maps);
    BakedModel out;
    out.model = std::move(result.model);
    out.mesh = std::move(mesh);
    out.report = std::move(result.report);
    model::ModelData& model = out.model.common;
    model.made_by = options.provenance.made_by;
    model.source = options.provenance.source.value_or(out.mesh.source);
    model.options = options.provenance.options;
    if (options.paper_maps) out.reading.emplace(out.model.view());
    out.notes = out.mesh.notes();
    if (model.measured.depth_p99 > bake.target_error)
        out.notes.emplace_back(OffTargetNote{bake.target_error, model.measured.depth_p99});
    if (const std::optional<Note> doubt = doubt_of(out.view())) out.notes.push_back(*doubt);
    return out;
}

std::optional<Note> doubt_of(const model::ModelView& model)
{
    const model::Measured& m = model.measured;
    if (!model::is_doubtful(m)) return std::nullopt;
    return DoubtNote{m.missed + m.false_contacts, m.points, m.depth_p99, model::has_exact(model)};
}

BakedModel& BakedModel::operator=(BakedModel&& other) noexcept
{
    model = std::move(other.model);
    mesh = std::move(other.mesh);
    report = std::move(other.report);
    notes = std::move(other.notes);
    // Short strings move with their object, so a reading of the other's model would look at freed memory.
    reading.reset();
    if (other.reading) reading.emplace(model.view(), other.reading->options());
    other.reading.reset();
    return *this;
}

std::vector<std::byte> BakedModel::bytes() const { return paper::serialize(model, records_of(notes)); }

void BakedModel::save(const std::filesystem::path& path) const { io::replace_file(path, bytes()); }

}  // namespace sqmap
