// The baked model as the runtime sees it: plain structs over one immutable blob that the caller owns.
#pragma once

#include "sqmap/math/assert.h"
#include "sqmap/math/vec.h"
#include "sqmap/model/arrays.h"
#include "sqmap/shape/superquadric.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace sqmap::query {
struct Answers;
}

namespace sqmap::model {

/// Version of the model format. Other versions are refused: bake again.
inline constexpr std::uint32_t k_format_version = 11;

/// One part: its superquadric, certificate, central chart and where its data lies in the model's arrays.
/// Model space throughout. Layout equals the FlatBuffers struct Part of sqmap.fbs.
struct Part {
    // Superquadric: 15 parameters, the rotation as matrix rows too.
    float a[3];
    float eps[2];
    float rotation[9];
    float translation[3];
    float euler[3];  ///< phi, theta, chi of eq. 2 (ZYZ), radians
    float taper[2];
    float bend, bend_angle;
    // Proof that it holds its triangles and the caps that close them (see fit/fit.h).
    float largest_f, tolerance;
    float sphere[4];  ///< bounding sphere of the superquadric: centre, radius
    // Central chart: x' = scale * rotation' * (p - centre) with chart rows = diag(1/a) rotation.
    float chart_rows[9];
    float chart_centre[3];
    float chart_lo[9], chart_hi[9];  ///< where the chart answers: bounds of x', y', z', x'+y', x'-y', x'+z', x'-z', y'+z', y'-z'
    float offset_step, smoothing_step;  ///< what one step of offsets (model units) and of smoothing (in w) means
    float w_min, w_step;                ///< a stored value v means w = 1/rho = w_min + w_step v, rho the largest coordinate
    std::uint32_t base;                 ///< cells along a face's side, even; 0: a part of a model without central maps
    std::uint32_t flags;                ///< see centre_inside and is_fallback
    std::int32_t centre_winding;        ///< winding number of the mesh about the chart's centre
    std::uint32_t triangle_count, vertex_count;            ///< of the surface that belongs to the part
    float area;                                            ///< of that surface
    Slice samples, cells, blocks, splits, specials, pool;  ///< of the model's arrays; offsets and smoothing lie beside samples
};

/// Facts of the whole model. Layout equals the FlatBuffers struct Header.
struct Header {
    double origin[3];  ///< mesh units; model = (mesh - origin) / unit
    double unit;
    double r_max;              ///< largest distance between two vertices, model units
    double quantisation;       ///< largest error that 16-bit storage added to a radius, model units
    float sphere[4];           ///< bounding sphere of the object, model units
    std::uint32_t solid;       ///< 1 a closed solid, 0 a surface
    std::uint32_t projection;  ///< 0; 1 within a paper model
    std::uint32_t triangle_count, vertex_count;
    std::uint32_t self_intersecting;  ///< 1 if some exact triangles cross each other
    std::uint32_t reserved;
};

/// Figures measured on a finished model, lengths in percent of R_max (see bake/evaluate.h for what each means).
struct Measured {
    std::uint32_t points = 0;
    std::uint32_t missed = 0, false_contacts = 0;  ///< layer 3, farther than 0.5 % of R_max from the surface
    double eq35_mean = 0, eq35_p99 = 0, eq35_max = 0;
    double depth_median = 0, depth_p95 = 0, depth_p99 = 0, depth_max = 0;
    double normal_median = 0;                           ///< degrees
    double q2_share = 0;                                ///< percent of the surface that its part's projection does not see first
    double layer1_depth_p99 = 0, layer2_depth_p99 = 0;  ///< as depth_p99, of those layers; 0: not measured
};

/// Bake found points farther than 0.5 % of R_max from the surface on the wrong side of it.
[[nodiscard]] constexpr bool has_wrong_verdicts(const Measured& m) { return m.missed + m.false_contacts > 0; }

/// Largest 99th percentile of the depth error with which layer 3 gives verdicts, percent of R_max.
inline constexpr double k_max_depth_p99 = 0.5;
/// Layers below the exact one are for pictures, not for verdicts: Layer::Auto and the page take the exact layer.
[[nodiscard]] constexpr bool is_doubtful(const Measured& m) { return has_wrong_verdicts(m) || m.depth_p99 > k_max_depth_p99; }

/// How a mesh was made a solid before it was baked.
enum class Rung : std::uint32_t {
    AsItIs = 0,  ///< or repaired without doubt: nothing below counts
    Closed = 1,
    Wrapped = 2,
};

/// How far the surface moved, mesh units: means and percentiles weigh by area.
struct Cure {
    Rung rung = Rung::AsItIs;
    double from_mean = 0, from_p99 = 0, from_max = 0;  ///< from the input's surface to the mesh
    double to_mean = 0, to_p99 = 0, to_max = 0;        ///< from the mesh, without what was made up, to the input
    double made_up_share = 0;                          ///< of the area: where nothing of the input stood
};

/// Everything a query reads, and what a reader wants to know: spans over a blob that the caller owns, which are valid as long as
/// it is. Copyable; any number of threads may read one at a time.
struct ModelView : CentralArrays<ArrayView>,
                   MeshArrays<ArrayView>,
                   LocatorArrays<ArrayView>,
                   CandidateArrays<ArrayView>,
                   BoundArrays<ArrayView> {
    Header header{};
    ArrayView<Part> parts;
    DistanceArrays<ArrayView> distance;
    InputArrays<ArrayView> input;
    Measured measured{};  ///< by bake
    Cure cure{};
    ArrayView<std::uint32_t> made_up_cells;     ///< a bit for each of locator_cells; empty where nothing was made up
    std::string_view made_by, source, options;  ///< provenance
    std::uint64_t mesh_hash = 0;                ///< mesh::content_hash of the mesh that was baked; 0: not known
    /// Functions that answer queries of a model whose maps belong to another library, as sqmap::paper's do. Null: the central
    /// maps answer. Outlives the view.
    const query::Answers* answers = nullptr;
};

/// False where parts have no central maps, as in what a paper model shares with every model.
[[nodiscard]] constexpr bool has_central_maps(const ModelView& view) { return !view.samples.empty(); }
/// False for a view that was not baked as a whole: the tree that signed distances need is missing.
[[nodiscard]] constexpr bool has_distance(const ModelView& view) { return !view.distance.bounds.empty(); }
/// False for a surface.
[[nodiscard]] constexpr bool has_locator(const ModelView& view) { return !view.bricks.empty(); }
/// False where the model was baked without its exact layer.
[[nodiscard]] constexpr bool has_exact(const ModelView& view) { return !view.triangle_part.empty(); }
/// False where the model keeps its vertices as floats alone: exact distances are in float then.
[[nodiscard]] constexpr bool has_input(const ModelView& view)
{
    return !view.input.coordinates32.empty() || !view.input.coordinates64.empty();
}
/// A vertex in mesh units, as the caller gave it. @pre has_input(view) and the vertex exists (not checked)
[[nodiscard]] constexpr Vec3d input_vertex(const ModelView& view, std::size_t vertex)
{
    const std::size_t i = 3 * vertex;
    if (const ArrayView<double>& c = view.input.coordinates64; !c.empty()) return {c[i], c[i + 1], c[i + 2]};
    const ArrayView<float>& c = view.input.coordinates32;
    return cast<double>(Vec3f{c[i], c[i + 1], c[i + 2]});
}
/// Vertex k (0 to 2) of a triangle. @pre has_exact(view) and the triangle exists
[[nodiscard]] constexpr std::uint32_t triangle_vertex(const ModelView& view, std::uint32_t triangle, std::uint32_t k)
{
    SQMAP_ASSERT(triangle < view.triangle_part.size() && k < 3);
    const std::size_t i = 3 * static_cast<std::size_t>(triangle) + k;
    return view.triangles16.empty() ? view.triangles32[i] : view.triangles16[i];
}
/// Three values of a struct above.
[[nodiscard]] constexpr Vec3f vec3(const float* v) { return {v[0], v[1], v[2]}; }
/// The part's own central map, as views of a model's arrays. @pre they hold the part's slices, as parse checks
template <template <class> class Array>
[[nodiscard]] constexpr CentralArrays<ArrayView> arrays_of(const CentralArrays<Array>& all, const Part& part)
{
    CentralArrays<ArrayView> own;
    const auto cut = [](const Slice& slice, std::size_t values, auto& span, const auto& array) {
        SQMAP_ASSERT(values * slice.first <= array.size() && values * slice.count <= array.size() - values * slice.first);
        span = std::span(array).subspan(values * slice.first, values * slice.count);
    };
    CentralArrays<ArrayView>::each_slice(cut, part, own, all);
    return own;
}
/// The part's superquadric, model space.
[[nodiscard]] shape::Superquadricf superquadric_of(const Part& part) noexcept;
/// The sides of the convex polytope that bounds a part beside its superquadric, model space; none in a model without polytopes.
/// @pre part < view.parts.size()
[[nodiscard]] constexpr std::span<const HalfSpacef> polytope_of(const ModelView& view, std::size_t part)
{
    SQMAP_ASSERT(part < view.parts.size());
    if (view.polytope_ends.empty()) return {};
    const std::uint32_t first = part == 0 ? 0 : view.polytope_ends[part - 1];
    return view.polytope_sides.subspan(first, view.polytope_ends[part] - first);
}
/// True where the chart's centre lies in the solid.
[[nodiscard]] bool centre_inside(const Part& part) noexcept;
/// True where a closed-form ellipsoid bounds the part: no superquadric was found that does.
[[nodiscard]] bool is_fallback(const Part& part) noexcept;
/// True of a triangle where nothing of the input stood: a cure filled a hole or a gap. @pre has_exact(view) and the triangle
/// exists
[[nodiscard]] bool is_made_up(const ModelView& view, std::size_t triangle) noexcept;
/// Part that a triangle's surface belongs to. @pre has_exact(view) and the triangle exists
[[nodiscard]] std::uint32_t part_of_triangle(const ModelView& view, std::size_t triangle) noexcept;
/// Surface point, model space, of the i-th sample of a part's central map; nothing where its ray meets no surface.
/// @pre i < part.samples.count
[[nodiscard]] std::optional<Vec3f> sample_point(const ModelView& view, const Part& part, std::uint32_t i) noexcept;

/// The view without the caller's coordinates: for a view whose frame is no longer theirs. Exact distances of it are in float.
void forget_coordinates(ModelView& view) noexcept;
/// The same model with model space for its mesh frame: origin zero, unit one. Shares the model's bytes, but for the caller's
/// coordinates.
[[nodiscard]] ModelView normalized(const ModelView& view) noexcept;
/// Mesh units -> model space, where the model's arrays are. In double up to the last step: coordinates may be far from zero.
[[nodiscard]] constexpr Vec3f to_model_space(const Header& header, Vec3d p)
{
    return cast<float>((p - Vec3d{header.origin[0], header.origin[1], header.origin[2]}) / header.unit);
}
/// Model space -> mesh units. Lengths: times header.unit; directions stay as they are.
[[nodiscard]] constexpr Vec3d to_mesh_units(const Header& header, Vec3f p)
{
    return header.unit * cast<double>(p) + Vec3d{header.origin[0], header.origin[1], header.origin[2]};
}

/// A vertex in mesh units: as the caller gave it where the model keeps that, else rounded to float.
/// @pre it exists (not checked)
[[nodiscard]] constexpr Vec3d mesh_vertex(const ModelView& view, std::size_t vertex)
{
    return has_input(view) ? input_vertex(view, vertex) : to_mesh_units(view.header, vec3(&view.vertices[3 * vertex]));
}

}  // namespace sqmap::model
