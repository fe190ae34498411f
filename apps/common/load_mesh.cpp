#include "common/load_mesh.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <map>
#include <utility>

namespace sqmap::app {

namespace {

LoadedMesh judged(const io::ReadResult& read, const LoadOptions& options)
{
    LoadedMesh out;
    if (read.format) out.format = io::format_name(*read.format);
    if (read.error) {
        out.diagnosis = {read.error->code, read.error->element, read.error->message, read.error->cure};
        return out;
    }
    const io::PolygonSoup& soup = read.soup;
    mesh::AdmitResult gate =
        mesh::admit({soup.positions, soup.polygon_offsets, soup.indices}, {.repair = options.repair,
                                                                           .accept_surface = options.accept_surface,
                                                                           .thickness = options.thickness,
                                                                           .unit = options.unit,
                                                                           .max_filled = options.max_filled,
                                                                           .max_cured_faces = options.max_cured_faces,
                                                                           .wrap = options.wrap,
                                                                           .max_components = options.max_components});
    out.verdict = gate.admission;
    out.diagnosis = {mesh::name_of(gate.diagnosis.code), gate.diagnosis.element, gate.diagnosis.message, gate.diagnosis.cure};
    out.repairs = std::move(gate.repairs);
    out.warnings = std::move(gate.warnings);
    out.facts = gate.facts;
    out.mesh = std::move(gate.mesh);
    out.solid = gate.solid;
    out.crossed = std::move(gate.crossed);
    out.made_up = std::move(gate.made_up);
    out.deviation = gate.deviation;
    return out;
}

}  // namespace

LoadedMesh load_mesh(const std::filesystem::path& path, const LoadOptions& options)
{
    return judged(io::read_mesh_file(path, options.limits), options);
}

LoadedMesh load_mesh(std::span<const std::byte> bytes, const std::string& name, const LoadOptions& options)
{
    const std::map<std::string, io::MeshFormat> formats{{".off", io::MeshFormat::Off},   {".obj", io::MeshFormat::Obj},
                                                        {".stl", io::MeshFormat::Stl},   {".ply", io::MeshFormat::Ply},
                                                        {".gltf", io::MeshFormat::Gltf}, {".glb", io::MeshFormat::Glb}};
    std::string extension = std::filesystem::path(name).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (const auto format = formats.find(extension); format != formats.end())
        return judged(io::read_mesh_bytes(bytes, format->second, options.limits), options);
    LoadedMesh out;
    out.diagnosis = {"E_FORMAT", "name", "the name does not end in .off, .obj, .stl, .ply, .gltf or .glb",
                     "save the mesh in one of these formats"};
    return out;
}

const char* verdict_name(mesh::Admission verdict)
{
    switch (verdict) {
        case mesh::Admission::Accept:
            return "ACCEPT";
        case mesh::Admission::Repaired:
            return "REPAIRED";
        case mesh::Admission::Closed:
            return "CLOSED";
        case mesh::Admission::Wrapped:
            return "WRAPPED";
        case mesh::Admission::Refused:
            break;
    }
    return "REFUSED";
}

std::vector<std::string> notes_of(const LoadedMesh& loaded)
{
    std::vector<std::string> out;
    for (const mesh::RepairNote& r : loaded.repairs)
        out.push_back(std::string("repaired: ") + mesh::name_of(r.kind) + " (" + std::to_string(r.count) + ")");
    if (loaded.deviation) {
        const mesh::Deviation& d = *loaded.deviation;
        const double r_max = mesh::largest_vertex_distance(loaded.mesh);
        const auto text = [&](const mesh::Distances& one) {
            char line[128];
            std::snprintf(line, sizeof line, "mean %.3g, p99 %.3g (%.2g %% of R_max), max %.3g", one.mean, one.p99,
                          100 * one.p99 / r_max, one.max);
            return std::string(line);
        };
        out.push_back("moved: from the file " + text(d.input_to_result) + "; to the file " + text(d.result_to_input));
        if (d.bounding_to_result) out.push_back("moved: from the file where it bounds the solid " + text(*d.bounding_to_result));
        char line[96];
        std::snprintf(line, sizeof line, "made up: %.3g %% of the area", 100 * d.made_up_share);
        out.emplace_back(line);
    }
    for (const mesh::Warning& w : loaded.warnings) out.push_back(std::string(mesh::name_of(w.kind)) + ": " + w.message);
    return out;
}

std::string report(const LoadedMesh& loaded)
{
    std::string out = verdict_name(loaded.verdict);
    if (loaded.refused())
        out += " " + loaded.diagnosis.code + " at " + loaded.diagnosis.element + ": " + loaded.diagnosis.message +
               "\n  cure: " + loaded.diagnosis.cure;
    out += "\n";
    for (const std::string& note : notes_of(loaded)) out += "  " + note + "\n";
    return out;
}

}  // namespace sqmap::app
