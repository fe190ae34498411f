// The paper's own map: distance along the superquadric's normal, looked up at the foot point (section 4.2).
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/paper/model.h"
#include "sqmap/shape/surface.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace sqmap::paper {

/// How a paper map is read.
struct ProjectionOptions {
    /// Two reads the nearest base sample; Three the finest level and the vertices of step 3. Gate is the gate of section
    /// 4.2 step 4; Exact has no data here and is answered by Three.
    query::Layer layer = query::Layer::Three;
    std::uint32_t gate = query::k_gate;  ///< k_L of the gate
    Projector projector = Projector::Newton;
    bool offset = false;      ///< subtract delta of eq. 12: for probes made of triangles, not for points
    bool corrections = true;  ///< step 3 data in layer 3
    /// Layer 3 contacts with a surface: how often the surface point is looked up again at the point's projection on its tangent
    /// plane, so that depth and normal are those of the nearest surface, not of the one along the line to the foot.
    int nearest_steps = 2;
    bool gaps = true;  ///< openings behind the first surface in layer 3 (beyond the paper)
};

/// Bits of PartAnswer::flags.
enum ProjectionFlags : std::uint8_t {
    k_projection_cap = 1,         ///< contact without a surface to push to
    k_projection_miss = 2,        ///< free because the ray meets nothing
    k_projection_wide = 4,        ///< the pyramid's window did not hold the foot: the whole surface was searched
    k_projection_unproven = 8,    ///< the foot search did not converge: the verdict is a guess and no witness
    k_projection_behind = 32,     ///< decided by an opening behind the first surface: its border carries no normal
    k_projection_by_cap = 64,     ///< free beside samples that start inside the solid: no witness against another part's claim
    k_projection_silhouette = 16  ///< the cell holds a jump of the surface: values of one sheet only were used
};

/// A part's verdict on a point.
enum class Verdict : std::uint8_t {
    Outside,  ///< of this superquadric: says nothing about the solid
    Free,     ///< inside the superquadric, in front of the surface: proves that the point is free
    Contact,  ///< inside the superquadric and not in front of the surface
};

/// A part's answer about one point.
struct PartAnswer {
    Verdict verdict = Verdict::Outside;
    std::uint8_t flags = 0;
    float foot_distance = 0;       ///< |p - P_M|, S_SQ^M of eq. 21
    float map_distance = 0;        ///< D_SQ(P_M); 0 for a cap, infinity for a miss
    float depth_along = 0;         ///< foot_distance - map_distance: depth along the superquadric's normal, negative in front
    float depth = 0;               ///< to the tangent plane at the surface point; of the printed search depth_along
    shape::SurfaceAnglesf angles;  ///< of the foot
    Vec3f foot;                    ///< P_M
    Vec3f foot_normal;             ///< outward normal of the superquadric
    Vec3f surface;                 ///< the surface point (see nearest_steps); the foot for caps and misses
    Vec3f normal;                  ///< unit outward surface normal; that of the superquadric for caps, misses and layer 1
};

/// Layer 1, then the asked-for layer for points inside the superquadric. Layer One answers Contact for all of those. This is the
/// template of probe queries with one lane, and has their bits.
/// Total: a point that is not finite is Outside. @pre is_consistent(map)
[[nodiscard]] PartAnswer project(const MapView& map, Vec3f p, const ProjectionOptions& options = {}) noexcept;

/// True where an answer proves its point free, whatever other parts claim (errata 15).
[[nodiscard]] constexpr bool is_witness(const PartAnswer& answer) noexcept
{
    return answer.verdict == Verdict::Free && (answer.flags & (k_projection_unproven | k_projection_by_cap)) == 0;
}

/// The answer of all parts together about one point.
struct CombinedAnswer {
    bool contact = false;
    bool has_surface = false;  ///< false where only caps claim the point: no depth, no normal
    std::int32_t part = -1;    ///< index into answers of the part that depth and normal come from
};

/// The witness rule for overlapping parts (errata 15): a point is in contact if a part claims it and no part that holds it
/// proves it free; a proof is a Free verdict whose foot converged and whose cell no other part's surface runs through. Depth and
/// normal come from the claim with the least depth among true surface samples.
[[nodiscard]] CombinedAnswer combine(std::span<const PartAnswer> answers) noexcept;

/// The foot point alone.
[[nodiscard]] shape::Foot<float> find_foot(const MapView& map, Vec3f p, Projector projector,
                                           std::uint8_t* flags = nullptr) noexcept;

/// The points in which the search departs from the paper's.
struct PyramidOptions {
    bool both_directions = true;   ///< false: the one direction of eq. 16
    bool compare_distance = true;  ///< false: I_S of eq. 19 alone decides
    bool wide_fallback = true;     ///< false: whatever the window holds
    bool seeded = true;            ///< false: the window lies about p's own ray, never about the table's start
};

/// A sample of the base grid, and how it was found.
struct GridFoot {
    std::uint32_t row = 0, column = 0;  ///< of the base grid
    float collinearity = 0;             ///< I_S of eq. 19
    int evaluations = 0;                ///< of I_S or distance
    bool wide = false;
};

/// The pyramid search on the base grid (eqs. 17 to 19, Fig. 7) around the sample on p's own ray; with all options false
/// it is the paper's. p in the model frame, inside the superquadric.
[[nodiscard]] GridFoot pyramid_search(const MapView& map, Vec3f p, const PyramidOptions& options = {}) noexcept;

/// A map's content at one pair of angles. The bake measures itself with the same samples.
struct MapSample {
    float distance = 0;  ///< infinity for a miss, 0 for a cap
    Vec3f normal;        ///< unit, outward, model frame; zero for caps and misses
    std::uint8_t flags = 0;
};
/// At given angles, model frame. Of the options the layer, its gate, offset and corrections count. Total.
[[nodiscard]] MapSample sample_map(const MapView& map, shape::SurfaceAnglesf angles, const ProjectionOptions& options) noexcept;

/// The smoothed map (section 6) at given angles: layer 3 plus what smoothing adds, with the smoothed surface's normal; layer
/// 3 as it is where the smoothed map has a hole. Layer Two: the same of the nearest base sample.
[[nodiscard]] MapSample sample_smoothed(const MapView& map, shape::SurfaceAnglesf angles,
                                        query::Layer layer = query::Layer::Three) noexcept;

/// A position of the superquadric that a search has looked at.
struct FootSearchStep {
    shape::SurfaceAnglesf angles;
    float distance = 0;        ///< to the point, model units
    float collinearity = 0;    ///< I_S of eq. 19
    std::uint32_t stride = 0;  ///< samples of the finest grid between neighbours of this level; 0: a step of Newton's method
    bool better = false;       ///< the best so far
};

/// Every step of the search that project() makes for a point, in order; the last one that was better is where it ends, to the
/// bit. options: the projector counts; layer Three. Returns how many there were, of which as many as the span holds are written:
/// 0 where the superquadric does not hold the point. Total. @pre is_consistent(map)
std::size_t record_foot_search(const MapView& map, Vec3f p, Projector projector, std::span<FootSearchStep> steps) noexcept;

}  // namespace sqmap::paper
