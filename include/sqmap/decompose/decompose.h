// Decomposition of a mesh into quasi-convex parts by visual salience and curvature (section 3).
#pragma once

#include "sqmap/mesh/mesh.h"
#include "sqmap/mesh/words.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace sqmap::decompose {

/// Why a boundary between two parts exists. Salient and curvature cuts passed a test of section 3, creases are where a person
/// would cut, cuts of kind Error serve the fit.
enum class CutKind : std::uint8_t { Salient, Curvature, Crease, Error };

/// A boundary between two adjacent parts.
struct Boundary {
    std::uint32_t part_a;  ///< part_a < part_b
    std::uint32_t part_b;
    CutKind kind;   ///< the strongest reason for it, in this order
    double length;  ///< mesh units
};

/// Parts of a mesh: one label a triangle; every part is connected through edges. Labels are in order of area, the
/// largest part first.
struct Partition {
    std::vector<std::uint32_t> part_of_triangle;  ///< #triangles, values in [0, part_count)
    std::uint32_t part_count = 0;
    std::vector<Boundary> boundaries;  ///< pairs of adjacent parts, in order of (part_a, part_b)
};

/// How the protrusion sum of eq. 4 is taken.
enum class ProtrusionSum : std::uint8_t {
    Sampled,  ///< over area-weighted farthest-point sources: near-linear cost
    Exact,    ///< over every triangle: quadratic cost
};

/// How the two tests of section 3 lead to cuts.
enum class Cutting : std::uint8_t {
    Passes,   ///< protruding parts, then bends, each along the best crease near the locale
    Printed,  ///< step 3 as printed: both tests at each locale, from each salient feature on, cut along the locale
};

/// Mean curvature of a locale's hyperbolic points in the printed test.
enum class CurvatureMean : std::uint8_t {
    Area,   ///< weighted by area: does not depend on the triangles' sizes
    Count,  ///< as printed: over the dual vertices
};

/// Thresholds of section 3, whose values the paper does not state. Lengths are fractions of sqrt(surface area), areas of
/// the surface area, so that every default is free of scale.
struct DecomposeOptions {
    ProtrusionSum protrusion = ProtrusionSum::Sampled;
    std::uint32_t protrusion_sources = 64;  ///< sources of the sampled sum
    double salient_window = 0.12;           ///< eps of eq. 5, of sqrt(area)
    double salient_prominence = 0.02;       ///< rise of p from the pass to a higher peak, of the mean of p
    double locale_width = 0.012;            ///< geodesic width of a locale, of sqrt(area)
    double boundary_strength = 0.25;        ///< growth of a locale's radius (area / (2 pi width)) per geodesic distance
                                            ///< that counts as a significant rise; a cylinder meeting a plane has 0.5
    double protrusion_ratio = 1.6;          ///< least ratio of geodesic height to radius of a salient part at its cut;
                                            ///< a disc has 1, a hemisphere pi / 2
    double boundary_concavity = 0.3;        ///< least mean concavity of a salient boundary (radius times bending per
                                            ///< length, at most 1), unless the part is twice the protrusion ratio tall
    double curvature_window = 2.0;          ///< window of the Gaussian curvature, of sqrt(triangle area)
    double curvature_floor = 1.25e-4;       ///< least triangle area that the window counts with, of the surface area:
                                            ///< detail below it is noise; 0: as printed
    double hyperbolic_share = 0.35;         ///< k_h: least share of a locale's area that is hyperbolic
    double hyperbolic_curvature = 3.0;      ///< t_h: least |mean curvature of hyperbolic points| times their area since
                                            ///< the last cut: twice the angle by which a tube may turn, 4 pi for a torus
    double minimum_part_area = 0.006;       ///< least part, of the surface area
    double fragment_roundness = 0.5;        ///< a part whose 4 pi area is less than this share of its border's length
                                            ///< squared is a fragment; a disc has 1
    std::uint32_t max_parts = 24;           ///< no more cuts beyond this
    Cutting cutting = Cutting::Passes;
    CurvatureMean curvature_mean = CurvatureMean::Area;  ///< Printed
    double printed_strength = 0.2;   ///< Printed: least rise of Boundary Strength from one locale to the next; where a
                                     ///< cylinder meets a plane it rises from 0 to 1
    double printed_curvature = 250;  ///< Printed: t_h, least |mean curvature of hyperbolic points| times the surface area
    friend constexpr bool operator==(const DecomposeOptions&, const DecomposeOptions&) = default;
};

/// Its thresholds, which every bake checks; printed_cuts() gives some of them other values.
inline constexpr OptionRange k_any_threshold{1e-3, 1e6}, k_share{0, 1};
inline constexpr NumberOption<DecomposeOptions> k_thresholds[] = {
    {"protrusion_sources", &DecomposeOptions::protrusion_sources, {1, 1e5}},
    {"salient_window", &DecomposeOptions::salient_window, k_any_threshold},
    {"salient_prominence", &DecomposeOptions::salient_prominence, k_any_threshold},
    {"locale_width", &DecomposeOptions::locale_width, k_any_threshold},
    {"boundary_strength", &DecomposeOptions::boundary_strength, k_any_threshold},
    {"protrusion_ratio", &DecomposeOptions::protrusion_ratio, k_any_threshold},
    {"boundary_concavity", &DecomposeOptions::boundary_concavity, k_share},
    {"curvature_window", &DecomposeOptions::curvature_window, k_any_threshold},
    {"curvature_floor", &DecomposeOptions::curvature_floor, k_share},
    {"hyperbolic_share", &DecomposeOptions::hyperbolic_share, k_share},
    {"hyperbolic_curvature", &DecomposeOptions::hyperbolic_curvature, k_any_threshold},
    {"minimum_part", &DecomposeOptions::minimum_part_area, k_share},
    {"fragment_roundness", &DecomposeOptions::fragment_roundness, k_share},
    {"printed_strength", &DecomposeOptions::printed_strength, k_any_threshold},
    {"printed_curvature", &DecomposeOptions::printed_curvature, k_any_threshold}};

/// The first threshold that is not its default and that cuts of this kind do not read. Any thread.
[[nodiscard]] std::optional<IdleOption> idle_threshold(const DecomposeOptions& options);

/// Findings of decompose(), for pictures and reports.
struct Decomposition {
    Partition partition;
    std::vector<double> protrusion;               ///< p of eq. 4 over the mean of p, #triangles
    std::vector<double> curvature;                ///< Gaussian curvature of eq. 6, 1 / mesh units squared, #triangles
    std::vector<std::uint32_t> salient_vertices;  ///< salient features, the most protruding first
};

/// Cuts a mesh into quasi-convex parts: steps 1 to 3 of section 3.
/// Any units and frame; the mesh may have several components and borders.
/// Cost: O(n log n) with ProtrusionSum::Sampled. Thread-safe.
/// Source: paper section 3; departures are listed in docs/algorithms/decompose.md.
[[nodiscard]] Decomposition decompose_with_diagnostics(const mesh::Mesh& mesh, const DecomposeOptions& options = {});
/// The same, the partition alone.
[[nodiscard]] Partition decompose(const mesh::Mesh& mesh, const DecomposeOptions& options = {});

/// The best cut of one part in two (or more, where the cut leaves several pieces), labelled CutKind::Error.
struct Split {
    Partition partition;
    bool found = false;  ///< false: no cut leaves both sides at least minimum_part_area
    double gain = 0;     ///< share of the volume of its ellipsoid of inertia that the cut saves, below 1; may be negative
};

struct CutSurface;

/// Changes partitions of one mesh, which must outlive it. Kept between changes, since the data of the mesh that they need
/// is the same for all. Const members are thread-safe.
class Cutter {
public:
    /// Cost: O(n log n) in the mesh.
    explicit Cutter(const mesh::Mesh& mesh);
    ~Cutter();

    /// Cuts a part where the pieces' bounding ellipsoids of inertia shrink most and the crease is deepest, for the length
    /// of the cut. Cost: O(n log n) in the part, times the number of candidate cuts (about 50), and O(n) in the mesh.
    /// The pieces keep the labels of the part and of part_count onwards: other parts keep their labels.
    [[nodiscard]] Split split(const Partition& partition, std::uint32_t part, const DecomposeOptions& options = {}) const;

    /// The partition with part_b joined to part_a; the last label moves into the gap.
    [[nodiscard]] Partition merge(const Partition& partition, std::uint32_t part_a, std::uint32_t part_b) const;

    /// Relabelled by area, the largest part first.
    [[nodiscard]] Partition ordered_by_area(const Partition& partition) const;

private:
    std::unique_ptr<const CutSurface> surface_;
};

/// Step 3 as printed, with the thresholds that give sensible parts: chosen on 24 creatures of the Princeton segmentation
/// benchmark, the same for every mesh; docs/algorithms/decompose.md has the table.
[[nodiscard]] DecomposeOptions printed_cuts();

}  // namespace sqmap::decompose
