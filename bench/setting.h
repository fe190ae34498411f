// The setting of a bench: the object, the probe, and the folder that keeps long work between runs.
#pragma once

#include "sqmap/mesh/mesh.h"
#include "sqmap/mesh/solid.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

namespace sqmap::bench {

inline constexpr double k_object_diagonal = 1.0;
inline constexpr double k_probe_diagonal = 0.4;

/// The mesh centred on its bounding box and scaled to the given box diagonal.
[[nodiscard]] mesh::Mesh centred(mesh::Mesh mesh, double diagonal);

/// The two meshes as a path means them. The class cannot be copied or moved, since the oracle refers to the object.
class Setting {
public:
    /// crossed: of the object, as mesh::Solid takes it. @pre the object is closed.
    Setting(mesh::Mesh object_mesh, mesh::Mesh probe_mesh, std::vector<std::uint8_t> crossed = {});
    Setting(const Setting&) = delete;
    Setting& operator=(const Setting&) = delete;

    const mesh::Mesh object;      ///< diagonal 1
    const mesh::Mesh probe;       ///< diagonal 0.4
    const mesh::Solid solid;      ///< exact oracle of the object
    const double r_max;           ///< largest distance between two vertices of the object
    std::filesystem::path cache;  ///< folder for fields that take long to make; empty: none is kept
    double target_error = 0.5;    ///< of sqmap's own model, see bake::BakeOptions
    unsigned threads = 0;         ///< for building; 0: one a core
};

/// Reads and places both meshes. An object must be closed; a probe may be anything with vertices.
/// @throw BenchError with element and cure where a file is not read or refused.
struct Files {
    std::filesystem::path object, probe;
};
[[nodiscard]] std::unique_ptr<Setting> load_setting(const Files& files);

}  // namespace sqmap::bench
