// From a mesh file to a validated mesh: reading and judging in one step, for every subcommand that takes a mesh.
#pragma once

#include "sqmap/io/read.h"
#include "sqmap/mesh/admit.h"

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sqmap::app {

struct LoadOptions {
    mesh::Repair repair = mesh::Repair::Wrap;
    double max_filled = mesh::AdmitOptions{}.max_filled;
    mesh::WrapOptions wrap{};
    bool accept_surface = false;
    double thickness = 0;
    std::optional<double> unit{};  ///< metres per unit of the file
    io::ReadLimits limits{};
    std::uint64_t max_components = mesh::AdmitOptions{}.max_components;
    std::uint64_t max_cured_faces = mesh::AdmitOptions{}.max_cured_faces;
};

/// Why a file is not taken, by the reader or by the gate, as both print it.
struct Diagnosis {
    std::string code, element, message, cure;
};

struct LoadedMesh {
    mesh::Admission verdict = mesh::Admission::Refused;
    Diagnosis diagnosis;  ///< of a refusal
    std::vector<mesh::RepairNote> repairs;
    std::vector<mesh::Warning> warnings;
    mesh::MeshFacts facts;
    mesh::Mesh mesh;                    ///< canonical, in the file's units (metres where a unit is given); empty after a refusal
    bool solid = false;                 ///< false: an open surface, taken because accept_surface asked for it
    std::vector<std::uint8_t> crossed;  ///< #triangles, 1 where another one cuts it: for mesh::Solid; empty if none is cut
    std::vector<std::uint8_t> made_up;  ///< #triangles, 1 where nothing of the file stood; empty below Closed
    std::optional<mesh::Deviation> deviation;  ///< from the file's surface, from Closed up
    std::string format;                        ///< "OBJ"; empty where it was not recognised

    [[nodiscard]] bool refused() const { return verdict == mesh::Admission::Refused; }
};

/// Reads and judges a mesh file. Does not throw on any content of the file: look at verdict.
[[nodiscard]] LoadedMesh load_mesh(const std::filesystem::path& path, const LoadOptions& options = {});

/// The same of a file's bytes; name: the file's, whose extension tells the format.
[[nodiscard]] LoadedMesh load_mesh(std::span<const std::byte> bytes, const std::string& name, const LoadOptions& options = {});

/// "ACCEPT", "REPAIRED", "CLOSED", "WRAPPED" or "REFUSED".
[[nodiscard]] const char* verdict_name(mesh::Admission verdict);

/// Repairs, how far the surface moved, and warnings, a line each.
[[nodiscard]] std::vector<std::string> notes_of(const LoadedMesh& loaded);

/// One line each for verdict, repairs and warnings, as `sqmap check` prints them.
[[nodiscard]] std::string report(const LoadedMesh& loaded);

}  // namespace sqmap::app
