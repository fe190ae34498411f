// The steps of admission: refusals, the triangles of a soup, cleaning, flatness, plates, warnings.
#pragma once

#include "shells.h"
#include "sqmap/math/box.h"
#include "sqmap/mesh/admission.h"
#include "sqmap/mesh/error.h"
#include "sqmap/mesh/wrap.h"
#include "surface.h"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace sqmap::mesh {

/// Thrown within mesh::admit and caught there.
struct Refused {
    Diagnosis diagnosis;
};

[[noreturn]] inline void refuse(Refusal code, std::string element, std::string message, Words cure)
{
    throw Refused{{code, std::move(element), std::move(message), std::move(cure)}};
}

inline std::string number(std::uint64_t n) { return std::to_string(n); }
/// "face 12", counted from 1.
inline std::string element(const char* kind, std::uint64_t zero_based) { return kind + (" " + number(zero_based + 1)); }

struct Soup {
    Surface surface;
    Box box;  ///< of the vertices in use
    std::uint64_t unused_vertices = 0, cut_polygons = 0;
    std::uint64_t degenerate_polygons = 0;  ///< that repeat a corner
};

/// Judges the numbers and cuts polygons into triangles.
/// @throw Refused for the numbers' codes: Index, NonFinite, Empty, Range, Limit
[[nodiscard]] Soup soup_of(const PolygonView& polygons);

/// Counts of cleaning.
struct Cleaned {
    std::uint64_t degenerate_faces = 0, duplicate_faces = 0, welded_vertices = 0;
};

/// Drops faces that say nothing about a surface and makes one vertex of equal ones: faces with a repeated corner, duplicates,
/// faces without area that no neighbour needs; where the mesh is not closed as it is indexed, positions that are equal, then
/// those closer than a file's rounding if the mesh closes by that. box: of the points.
Cleaned clean(Surface& surface, const Box& box);

/// Faces without area that have a neighbour at each side.
struct TightSlivers {
    std::uint64_t removed = 0, left = 0;
};

/// Joins the corner of such a face that lies on the opposite edge to the corner beyond, so that nothing opens and nothing
/// moves. diagonal: of the box of the points.
TightSlivers remove_tight_slivers(Surface& surface, double diagonal);

/// Volume over area to the power of 3/2, halved: thinner is a sheet.
inline constexpr double k_flat_thickness = 1e-5;

struct Flatness {
    double area = 0;              ///< of all faces, units of the points squared
    bool is_plane = false;        ///< all faces lie in one plane, as far as a fit can tell
    bool encloses_volume = true;  ///< if closed: some shell is thicker than a sheet
    std::string message;          ///< describes the flatness
    [[nodiscard]] bool is_flat(bool closed) const { return is_plane || (closed && !encloses_volume); }
};

/// points: of the surface, near the origin and about unit size; component: of every face; scale: of a printed length.
[[nodiscard]] Flatness flatness_of(const Surface& surface, std::span<const Vec3d> points,
                                   std::span<const std::uint32_t> component, double scale);

/// A length as a user reads it.
[[nodiscard]] std::string length_text(double length);

/// Keeps one side of each closed sheet: the largest stretch of its faces without a fold, the walls between its sides left
/// out. False, and nothing done, where that is not about half of every component.
/// @pre mate, component: of a closed surface whose components are thin (see Pairing, components)
bool keep_one_side(Surface& surface, const std::vector<std::uint32_t>& mate, const std::vector<std::uint32_t>& component);

/// Replaces a surface by a plate: both sides offset by half the thickness along the vertex normals, the rim closed.
/// @pre faces agree in orientation, every vertex has one fan, every edge at most two faces.
void thicken(Surface& surface, double thickness);

/// Counts a repair with those of its kind.
void note(std::vector<RepairNote>& repairs, RepairKind kind, std::uint64_t count);

/// Judges a clean surface, in the order of the codes: pieces, edges with too many faces, orientation, flatness, holes; sets the
/// result's mesh, facts and warnings and adds its repairs. box: of the points as they came. @throw Refused
void judge_surface(Surface& surface, const Box& box, const AdmitOptions& options, AdmitResult& out);

/// W_DROPPED where polygons that closing left out stand out of the solid. diagonal: of the input's box, units of the meshes.
[[nodiscard]] std::optional<Warning> dropped_warning(const Mesh& dropped, const Mesh& solid, double diagonal);

/// W_TOLERANCE for a wrapped mesh that is farther from the input, or larger, than the options allow.
[[nodiscard]] std::optional<Warning> tolerance_warning(const Mesh& wrapped, const Deviation& moved, const WrapOptions& options);

}  // namespace sqmap::mesh
