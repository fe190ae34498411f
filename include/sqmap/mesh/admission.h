// Admission, which every mesh passes: polygons as they come in, a validated mesh or a reasoned refusal out, with repairs,
// warnings and facts. Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/math/box.h"
#include "sqmap/mesh/error.h"
#include "sqmap/mesh/mesh.h"
#include "sqmap/mesh/words.h"
#include "sqmap/mesh/wrap.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sqmap::mesh {

/// The answer to a mesh: the first rung of the ladder that gives a solid, or none.
enum class Admission {
    Accept,    ///< taken unchanged
    Repaired,  ///< after repairs that leave no doubt about the surface that was meant
    Closed,    ///< with holes filled, cracks stitched, edges with more than two faces resolved
    Wrapped,   ///< as a new surface around the volume that the input encloses
    Refused,
};

/// As printed: "ACCEPT", "REPAIRED", "CLOSED", "WRAPPED" or "REFUSED". Never null.
[[nodiscard]] const char* name_of(Admission admission) noexcept;

/// The highest rung that may be taken. None: nothing is changed.
enum class Repair { None, Safe, Close, Wrap };

/// The solid that is meant. AsIs: what the surface bounds. Outer: what cannot be reached from outside, see outer_solid.
enum class SolidKind { AsIs, Outer };

/// Polygons as read; the spans belong to the caller.
struct PolygonView {
    std::span<const Vec3d> positions;
    std::span<const std::uint32_t> offsets;  ///< #polygons + 1: polygon i is indices[offsets[i] .. offsets[i+1])
    std::span<const std::int64_t> indices;   ///< zero-based; anything may stand here
};

/// How far admission may change a mesh that bounds no solid.
struct AdmitOptions {
    Repair repair = Repair::Wrap;
    bool accept_surface = false;  ///< an open mesh is taken as a surface without inside (solid is false then)
    double thickness = 0;  ///< > 0: open meshes and flat ones, also closed, become plates this thick, in units of the result
    std::optional<double> unit{};               ///< metres per unit of the file: the result is in metres; absent: as in the file
    double max_filled = 0.25;                   ///< share of the area that fillings may have where a mesh is closed
    bool refine_fillings = true;                ///< fillings get points of their own, and go on from the surface around
    std::uint64_t max_cured_faces = 2'000'000;  ///< larger meshes are not closed or wrapped
    WrapOptions wrap{};                         ///< its tolerance and limits are those of outer solids, too
    SolidKind solid = SolidKind::AsIs;          ///< Outer: the ladder is left out; any triangles that span a volume are taken
    double gap = 0.01;                          ///< of an outer solid: gaps narrower than that are closed, share of R_max
    std::uint64_t max_components = 1000;        ///< connected pieces of the surface: each becomes a part at least
    std::uint64_t max_intersections = 1'000'000;  ///< counting of intersecting pairs stops here
};

/// Its numbers that doors set, beside those of `wrap`.
inline constexpr NumberOption<AdmitOptions> k_admission_numbers[] = {{"thickness", &AdmitOptions::thickness, {0, 1e300}},
                                                                     {"unit", &AdmitOptions::unit, {1e-12, 1e12}},
                                                                     {"max_filled", &AdmitOptions::max_filled, {0, 1}},
                                                                     {"gap", &AdmitOptions::gap, k_gap_range}};

/// A kind of repair.
enum class RepairKind : std::uint8_t {
    Triangulated,
    UnusedVertices,
    WeldedVertices,
    DegenerateFaces,
    DuplicateFaces,
    Reoriented,
    Flipped,
    SplitVertices,
    FilledHoles,
    Thickened,
    Stitched,
    DroppedWalls,
    DroppedFaces,
    CutEdges,
    DroppedSheets,
    Wrapped,
    Enclosed,  ///< triangles that an outer solid is proven to hold
};

/// As printed: "welded_vertices". Never null.
[[nodiscard]] const char* name_of(RepairKind kind) noexcept;

/// Something that was done to the mesh.
struct RepairNote {
    RepairKind kind{};
    std::uint64_t count = 0;  ///< polygons, vertices, edges, faces or holes that it changed
};

/// A kind of doubt about a mesh that was taken.
enum class WarningKind : std::uint8_t {
    SelfIntersections,  ///< faces intersect: the solid is where the winding number is positive
    Cavities,           ///< shells lie inside others
    Flipped,            ///< faces were inside out and have been turned
    Unit,               ///< so large that the unit may be another than metres
    Degenerate,         ///< faces without area are left
    Surface,            ///< open, and taken as a surface without inside
    Thickness,          ///< a thickness was given and not used
    DroppedSurface,     ///< closing dropped polygons that stand out of the solid
    Tolerance,          ///< a wrapped mesh is farther from the input than the options allow, or has more triangles
};

/// As printed: "W_SELFX". Never null.
[[nodiscard]] const char* name_of(WarningKind kind) noexcept;

/// Something a user should know about.
struct Warning {
    WarningKind kind{};
    std::uint64_t count = 0;  ///< pairs, shells, faces, edges or triangles it is about
    bool at_least = false;    ///< SelfIntersections: counting stopped at max_intersections
    /// DroppedSurface: area and greatest distance of what stands out, units of the result. Tolerance: the share of R_max that
    /// was reached and the one that was wanted.
    double first = 0, second = 0;
    std::uint64_t triangles = 0, wanted = 0;  ///< Tolerance: of the wrapped mesh, and at most
};

/// "2 shells are cavities inside others". @throw std::bad_alloc
[[nodiscard]] std::string words(const Warning& warning, const SettingNames& names = k_cpp_settings);
/// "welded_vertices (12)". @throw std::bad_alloc
[[nodiscard]] std::string words(const RepairNote& repair);

/// Facts of the mesh, as far as admission looked at it before a refusal.
struct MeshFacts {
    std::uint64_t vertex_count = 0, triangle_count = 0;
    std::uint64_t component_count = 0;
    std::uint64_t boundary_edge_count = 0;
    std::uint64_t nonmanifold_edge_count = 0;
    std::uint64_t self_intersecting_pairs = 0;
    bool intersections_complete = true;  ///< false: counting stopped at max_intersections
    bool is_closed = false;
    std::int64_t genus = 0;       ///< sum over the components; closed meshes only
    Box box;                      ///< of the vertices in use, units of the result
    double area = 0, volume = 0;  ///< volume: signed, closed meshes only
};

/// The number of what is none of the input.
inline constexpr std::uint32_t k_no_polygon = 0xffffffffu;

/// A mesh that was taken and its repairs, or the reason of a refusal.
struct AdmitResult {
    Admission admission = Admission::Refused;
    Diagnosis diagnosis;  ///< of a refusal
    std::vector<RepairNote> repairs;
    std::vector<Warning> warnings;
    MeshFacts facts;
    Mesh mesh;                          ///< canonical; empty after a refusal
    bool solid = false;                 ///< the mesh bounds a volume: where its winding number is positive
    std::vector<std::uint8_t> crossed;  ///< #triangles, 1 where another one cuts it (for mesh/solid.h); empty if none is cut
    std::vector<std::uint8_t> made_up;  ///< #triangles, 1 where nothing of the input stood; empty below Closed
    std::vector<std::uint32_t> source_triangle;  ///< #triangles: number of the polygon that it is of, k_no_polygon: made here
    std::vector<std::uint32_t> source_vertex;    ///< #vertices: number of the position, k_no_polygon: made here
    std::optional<Deviation> deviation;          ///< from the input, units of the result; from Closed up
};

/// Judges, repairs and normalises polygons into a Mesh. When several codes apply, the first of this order is given:
/// Index, NonFinite, Empty, Range, Limit (components, corners of a polygon), then repairs, then NonManifold, Orient, Flat, Open.
/// Repair::None refuses with the one of the last that names what would have been repaired, Repair where none does. Polygons are
/// split into triangles; equal positions are made one vertex unless the mesh is closed as it is indexed; faces are oriented alike
/// by propagation, shells outward by volume; vertices where shells touch are split. Shells that intersect are accepted: the solid
/// is where the winding number is positive. Cost: n log n in the number of corners, plus the intersecting pairs.
/// @throw InvalidInput for options out of k_admission_numbers' ranges; std::bad_alloc
[[nodiscard]] AdmitResult admit(const PolygonView& polygons, const AdmitOptions& options = {});

}  // namespace sqmap::mesh
