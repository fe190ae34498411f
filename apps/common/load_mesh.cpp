#include "common/load_mesh.h"

#include <utility>

namespace sqmap::app {

LoadedMesh load_mesh(const std::filesystem::path& path, const LoadOptions& options)
{
    LoadedMesh out;
    io::ReadResult read = io::read_mesh_file(path, options.limits);
    if (read.format) out.format = io::format_name(*read.format);
    if (read.error) {
        out.diagnosis = {read.error->code, read.error->element, read.error->message, read.error->cure};
        return out;
    }
    const io::PolygonSoup& soup = read.soup;
    mesh::GateResult gate =
        mesh::admit({soup.positions, soup.polygon_offsets, soup.indices}, {.repair = options.repair,
                                                                           .accept_surface = options.accept_surface,
                                                                           .thickness = options.thickness,
                                                                           .unit = options.unit,
                                                                           .max_components = options.max_components});
    out.verdict = gate.verdict;
    out.diagnosis = {mesh::name_of(gate.diagnosis.code), gate.diagnosis.element, gate.diagnosis.message, gate.diagnosis.cure};
    out.repairs = std::move(gate.repairs);
    out.warnings = std::move(gate.warnings);
    out.facts = gate.facts;
    out.mesh = std::move(gate.mesh);
    out.solid = gate.solid;
    out.crossed = std::move(gate.crossed);
    return out;
}

const char* verdict_name(mesh::Verdict verdict)
{
    switch (verdict) {
        case mesh::Verdict::Accept:
            return "ACCEPT";
        case mesh::Verdict::Repaired:
            return "REPAIRED";
        case mesh::Verdict::Refused:
            break;
    }
    return "REFUSED";
}

std::string report(const LoadedMesh& loaded)
{
    std::string out = verdict_name(loaded.verdict);
    if (loaded.refused())
        out += " " + loaded.diagnosis.code + " at " + loaded.diagnosis.element + ": " + loaded.diagnosis.message +
               "\n  cure: " + loaded.diagnosis.cure;
    out += "\n";
    for (const mesh::RepairNote& r : loaded.repairs)
        out += std::string("  repaired: ") + mesh::name_of(r.kind) + " (" + std::to_string(r.count) + ")\n";
    for (const mesh::Warning& w : loaded.warnings) out += std::string("  ") + mesh::name_of(w.kind) + ": " + w.message + "\n";
    return out;
}

}  // namespace sqmap::app
