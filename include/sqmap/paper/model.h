// A paper model: superquadrics, the paper's own map of each part along the normals of its superquadric (section 4.1, steps 2 and
// 3) and, where it was baked so, triangles with the exact layer.
// Everything else of sqmap queries it through a Reading.
#pragma once

#include "sqmap/math/assert.h"
#include "sqmap/mesh/words.h"
#include "sqmap/model/model_data.h"
#include "sqmap/model/parse.h"
#include "sqmap/query/body.h"
#include "sqmap/shape/superellipse.h"
#include "sqmap/shape/superquadric.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace sqmap::paper {

/// The ray of a sample, on its way in, meets one of these.
enum class MapRay {
    Surface,  ///< the surface, at the stored distance
    Cap,      ///< none: it starts inside the solid, which is solid from depth 0
    Miss,     ///< none: all of it is free
};
/// Says what a value of MapView::distance stands for. Any thread.
[[nodiscard]] MapRay ray_of(std::uint16_t stored) noexcept;

/// A mesh vertex seen by step 3, as a correction of the interpolated map: a pyramid over its cell, 1 at the vertex and 0
/// on the border, times correction. Sorted by row (correction_rows) and column.
struct VertexCorrection {
    std::uint16_t column;     ///< of the cell
    std::uint8_t eta, omega;  ///< position in the cell, in 1/256
    std::int16_t correction;  ///< times distance_scale
    friend constexpr bool operator==(const VertexCorrection&, const VertexCorrection&) = default;
};

/// Beyond the paper: an opening behind the first surface on a sample's ray, from where the ray leaves the solid to where it
/// enters again (as a miss is stored: never). Sorted by row (gap_rows), column and distance. Only openings that some point with
/// its foot at this sample can lie in are kept. They lift the limit of Q2 regions (section 5).
struct MapGap {
    std::uint16_t column;
    std::uint16_t leave, enter;  ///< times distance_scale
    friend constexpr bool operator==(const MapGap&, const MapGap&) = default;
};

/// Which of 32 samples of the base grid, row-major, are hits (their rays meet the surface), the first lowest, and how many hits
/// come before them. Normals and the smoothed map are stored for hits alone: see hit_index.
struct HitRank {
    std::uint32_t bits, before;
    friend constexpr bool operator==(const HitRank&, const HitRank&) = default;
};
/// Arrays of hits have so many entries more, all zero: queries read a few bytes behind the last.
inline constexpr std::size_t k_hit_padding = 2;

/// The smoothed map at a hit of the base grid, stored in 20 bits: what smoothing adds to the distance, and the normal of the
/// smoothed surface. Where there is no one surface to smooth: see is_smoothed.
struct SmoothedSample {
    std::int32_t change;   ///< root of the length in change_scale, signed, 6 bits
    std::uint32_t normal;  ///< model::octahedral_normal, 7 + 7 bits
    /// Times change_scale.
    [[nodiscard]] constexpr std::int32_t steps() const { return change < 0 ? -change * change : change * change; }
    friend constexpr bool operator==(const SmoothedSample&, const SmoothedSample&) = default;
};
/// Any thread.
[[nodiscard]] bool is_smoothed(const SmoothedSample& sample) noexcept;

/// A coarse table of starts for the foot search: equal-spaced angles in 1/256 of their ranges.
struct FootSeed {
    std::uint8_t eta, omega;
    friend constexpr bool operator==(const FootSeed&, const FootSeed&) = default;
};
/// MapView::surface_seeds has so many seeds along each axis.
inline constexpr std::uint32_t k_surface_seeds = 12;

/// The finest level has at most so many rows and columns.
inline constexpr std::uint32_t k_max_map_rows = 4097, k_max_map_columns = 8192;

/// The grids of one part's map and the scales of its values. Angles are equal-spaced: eta_i = pi (i / (eta_count - 1) - 1/2),
/// omega_j = 2 pi j / omega_count - pi (eqs. 9 and 10). The base grid of layer 2 is every 2^subdivisions-th row and column.
struct MapGrid {
    std::uint32_t eta_count = 0, omega_count = 0;  ///< multiples of 2^subdivisions: eta_count - 1 and omega_count
    std::uint32_t subdivisions = 0;                ///< A_S of section 4.2.3
    std::uint32_t vertex_count = 0;                ///< N_m: mesh vertices of the part, for the gate of layer 3
    float distance_scale = 0;                      ///< length of one step of distance and correction
    float offset_scale = 0;                        ///< length of an offset whose root is 1
    float change_scale = 1;                        ///< length of a change by smoothing whose root is 1
    float quantization_error = 0;                  ///< largest measured error of a stored distance
    std::uint32_t seed_count = 0;                  ///< seeds along each axis
    std::uint32_t seeds_mirrored = 0;              ///< not 0: seeds cover the octant x, y, z >= 0 only
    std::uint32_t occluded_vertices = 0;           ///< of vertex_count: the mesh hides them from their feet (step 3)
    float q2_share = 0;                            ///< of the part's area: Region::Q2
};

/// The arrays of one map, or of all maps of a model, part after part. Grids are row-major, #eta_count by #omega_count, omega
/// fastest. each(visit, of...) calls visit(name, array of every of...) for the arrays, in the file's order.
template <template <class> class Array>
struct MapArrays {
    Array<std::uint16_t> distance;  ///< finest grid
    Array<HitRank> hits;            ///< base grid, 32 samples each
    Array<std::uint16_t> normal;    ///< hits, padded: surface normals by eq. 26, octahedral, 8 + 8 bits
    /// Finest grid, two bits a node, four nodes a byte: 1 = the surface jumps towards the next row, 2 = next column.
    Array<std::uint8_t> cuts;
    Array<std::uint32_t> offset;           ///< delta of eq. 12 at the base samples that have one, see offset_steps, padded
    Array<std::uint32_t> correction_rows;  ///< #eta_count: cells of row i have corrections [rows[i], rows[i+1])
    Array<std::uint32_t> gap_rows;         ///< #eta_count + 1: samples of row i have gaps [rows[i], rows[i+1])
    Array<VertexCorrection> corrections;
    Array<MapGap> gaps;
    Array<FootSeed> seeds;         ///< #seed_count^3, z fastest, over the undeformed bounding box
    Array<std::uint8_t> smoothed;  ///< hits, padded, for force: see smoothed_at; or none
    /// Over the same box, #k_surface_seeds^3 or none: the sample that shows the surface nearest to the middle of a cell. Below
    /// caps the search for a surface starts from it.
    Array<FootSeed> surface_seeds;
    template <class Visit, class... Of>
    static constexpr void each(Visit&& visit, Of&... of)
    {
        visit("distance", of.distance...);
        visit("hits", of.hits...);
        visit("normal", of.normal...);
        visit("cuts", of.cuts...);
        visit("offset", of.offset...);
        visit("correction_rows", of.correction_rows...);
        visit("gap_rows", of.gap_rows...);
        visit("corrections", of.corrections...);
        visit("gaps", of.gaps...);
        visit("seeds", of.seeds...);
        visit("smoothed", of.smoothed...);
        visit("surface_seeds", of.surface_seeds...);
    }
};

/// The array type of `MapArrays` that gives each array's slice in place of its elements.
template <class>
using SliceOf = model::Slice;

/// The slices that one part's map has of the arrays of all maps. Layout equals the FlatBuffers struct MapRecord.
struct MapRecord {
    MapGrid grid;
    MapArrays<SliceOf> slices;
};

/// The regions of section 5. A triangle is of the region that its middle is in.
enum class Region : std::uint8_t {
    Convex,  ///< at each of the triangle's edges the surface bends away, or by less than a degree
    Q1,      ///< concave, and its foot sees it
    Q2,      ///< the mesh crosses the line to its foot: no map along these normals shows it
};
/// A triangle's entry in ModelMaps::labels.
struct TriangleLabel {
    std::uint32_t part = 0;
    Region region = Region::Convex;
};
inline constexpr std::uint32_t k_label_part_bits = 14;  ///< of a label, from the lowest
/// The code of a label. @pre the part fits into k_label_part_bits, as that of every model does
[[nodiscard]] constexpr std::uint16_t encode_label(const TriangleLabel& label)
{
    SQMAP_ASSERT(label.part < 1u << k_label_part_bits);
    return static_cast<std::uint16_t>(label.part | static_cast<std::uint32_t>(label.region) << k_label_part_bits);
}
/// The label of a code. Its part and region are those of a model only where parse has checked it.
[[nodiscard]] constexpr TriangleLabel decode_label(std::uint16_t code)
{
    return {code & ((1u << k_label_part_bits) - 1u), static_cast<Region>(code >> k_label_part_bits)};
}

/// The maps of all parts.
template <template <class> class Array>
struct ModelMaps : MapArrays<Array> {
    Array<MapRecord> records;     ///< #parts
    Array<std::uint16_t> labels;  ///< #triangles of the baked mesh, in its order, see decode_label; or none
    template <class Visit, class... Of>
    static constexpr void each(Visit&& visit, Of&... of)
    {
        visit("records", of.records...);
        MapArrays<Array>::each(visit, of...);
        visit("labels", of.labels...);
    }
};

/// One part's paper map. Lengths in model units, frame of the model.
struct MapView : MapGrid, MapArrays<model::ArrayView> {
    shape::Superquadricf superquadric;
};

/// True where no query can read outside the view's arrays and every number is finite and in its range: to be checked once
/// for a view over untrusted bytes. Cost: linear in base samples, corrections and gaps.
[[nodiscard]] bool is_consistent(const MapView& map) noexcept;
/// The entry of a sample of the base grid in the arrays of hits; that of the next hit, or of the padding, if it is none.
/// @pre the sample exists
[[nodiscard]] std::size_t hit_index(const MapView& map, std::size_t sample) noexcept;
/// The smoothed map at a hit. @pre has one; the entry is below the number of hits
[[nodiscard]] SmoothedSample smoothed_at(const MapView& map, std::size_t entry) noexcept;
/// Delta of eq. 12 at a sample of the base grid, times offset_scale. Logarithmic in the samples that have one.
[[nodiscard]] std::uint32_t offset_steps(const MapView& map, std::size_t sample) noexcept;

/// Version of the format of paper models. Others are refused: bake again.
inline constexpr std::uint32_t k_format_version = 14;

/// Everything a query of a paper model reads: spans over a blob that the caller owns, valid as long as it is. Any number of
/// threads may read one at a time.
struct ModelView {
    model::ModelView common{};  ///< header, superquadrics, triangles and their cells, distances; no central maps
    ModelMaps<model::ArrayView> maps{};
};

/// As ModelView, in owned arrays: bake makes it, serialize writes it. Several threads may read one at a time.
struct ModelData {
    model::ModelData common;
    ModelMaps<model::ArrayData> maps;

    /// Valid until the data changes.
    [[nodiscard]] ModelView view() const
    {
        ModelView view{common.view(), {}};
        const auto look = [](const char*, auto& span, const auto& array) { span = array; };
        ModelMaps<model::ArrayView>::each(look, view.maps, maps);
        return view;
    }
};

/// Verifies the bytes of a paper model as model::parse does those of a central one: everything is checked here, so that queries
/// need not. The bytes must be 8-byte aligned and outlive the view.
/// Failures: any status but Ok, view untouched; a central model is NotAModel. Cost: linear in the bytes, no allocation.
[[nodiscard]] model::ParseStatus parse(std::span<const std::byte> bytes, ModelView& view) noexcept;

/// Hash of the content: bake stores it, parse checks it.
[[nodiscard]] std::uint64_t content_hash(const ModelView& view) noexcept;

/// How many rays of a map meet what.
struct MapCounts {
    std::uint32_t hits = 0, caps = 0, misses = 0;  ///< samples of the finest grid
};
/// Linear in the samples.
[[nodiscard]] MapCounts counts_of(const MapView& map) noexcept;

/// The part's map, over the view's arrays. @pre the part exists
[[nodiscard]] MapView map_of(const ModelView& view, std::size_t part) noexcept;

/// False for a model that was baked without its smoothed map.
[[nodiscard]] constexpr bool has_smoothed_map(const ModelView& view) { return !view.maps.smoothed.empty(); }

/// Bits of a result's status beside those of query::Status.
enum Status : std::uint8_t {
    k_not_given = 128,  ///< the maps do not give what the options name (a margin, say): answered without it
};

/// How a query finds the foot of a point, where its line to the superquadric is a normal of it. The searches end at a sample of
/// the base grid on layer 2; on layer 3 one Newton step leads from the finest sample to the position for which the data of steps
/// 2 and 3 are interpolated (section 4.2.3).
enum class Projector : std::uint8_t {
    Newton,   ///< Newton's method from a table of starts: the exact foot
    Pyramid,  ///< the multiresolution search of eqs. 16 to 19, corrected (errata 5 to 7)
    Printed,  ///< the same to the letter: one direction, greatest I_S, no fallback; depth along the normal, no closest-point
              ///< steps
};

/// Options of queries that only a paper model answers, beside query::QueryOptions. They count on layers Two, Three and Gate.
struct QueryOptions {
    Projector projector = Projector::Newton;
    /// Layer Three, Projector::Newton: how often a contact's surface is looked up again at the point's projection on its tangent
    /// plane. 0: depth to the tangent plane where the foot's line meets the surface.
    int nearest_steps = 2;
    bool gaps = true;     ///< layer Three: openings behind the first surface; false: the paper's map, with its Q2 limit
    bool pruning = true;  ///< a part that proves a point free outweighs those that claim it (section 2); false: any claim counts
    friend constexpr bool operator==(const QueryOptions&, const QueryOptions&) = default;
};
/// Its numbers, whose ranges all doors take from here. A query does not check them.
inline constexpr NumberOption<QueryOptions> k_query_numbers[] = {{"nearest_steps", &QueryOptions::nearest_steps, {0, 100}}};

/// The first option of queries and forces that is not its default and that answers do not depend on. layer: the one that answers.
/// is_paper: the model is.
[[nodiscard]] constexpr std::optional<IdleOption> idle_option(const QueryOptions& options, bool is_paper,
                                                              const query::QueryOptions& query)
{
    constexpr QueryOptions k_plain{};
    const query::Layer layer = query.layer;
    if (query.gate != query::k_gate && layer != query::Layer::Gate)
        return IdleOption{"gate", "counts with the layer gate", "set 'layer' to gate, or leave the default"};
    const bool maps = layer != query::Layer::One && layer != query::Layer::Exact, finest = maps && layer != query::Layer::Two;
    const bool steps = options.nearest_steps != k_plain.nearest_steps;
    const auto idle = [&](const char* name) {
        if (!is_paper)
            return IdleOption{name, "counts for paper models, and this one is a central model",
                              "leave the default, or bake a paper model (projection normal)"};
        return maps ? IdleOption{name, "counts on layer 3 and the gate", "take one of these layers, or leave the default"}
                    : IdleOption{name, "counts on layers 2 and 3 and the gate", "take one of these layers, or leave the default"};
    };
    if (options.projector != k_plain.projector && !(is_paper && maps)) return idle("projector");
    if (steps && !(is_paper && finest)) return idle("nearest_steps");
    if (steps && options.projector != Projector::Newton)
        return IdleOption{"nearest_steps", "counts with the projector newton", "set 'projector' to newton, or leave the default"};
    if (options.gaps != k_plain.gaps && !(is_paper && finest)) return idle("gaps");
    if (options.pruning != k_plain.pruning && !(is_paper && maps)) return idle("pruning");
    if (query.offset && is_paper && !maps)
        return IdleOption{"offset", "is the maps', which answer layers 2 and 3 and the gate", "take one of these layers"};
    return std::nullopt;
}

/// A paper model as points, probes, pairs, scenes, skins, the haptic tick and the rest of sqmap query it: its view()
/// is a model::ModelView, and each query of that view reads the paper's maps. Answers of points are
/// certain only where no superquadric holds them, or on layer Exact. Status bits: query::Status and k_not_given. Total, noexcept,
/// no allocation. Any number of threads may query one; options() are changed between queries.
class Reading : query::Answers {
public:
    /// model: from parse; its bytes outlive this.
    explicit Reading(const ModelView& model, const QueryOptions& options = {}) noexcept;
    Reading(const Reading&) = delete;
    Reading& operator=(const Reading&) = delete;
    ~Reading() = default;

    /// Valid, and its copies too, as long as this lives where it is.
    [[nodiscard]] const model::ModelView& view() const noexcept { return view_; }
    /// The paper model with its maps.
    [[nodiscard]] const ModelView& model() const noexcept { return model_; }
    /// The options of queries from now on.
    [[nodiscard]] const QueryOptions& options() const noexcept { return options_; }
    /// Changes them, between queries.
    void set_options(const QueryOptions& options) noexcept { options_ = options; }

    /// The reading that a view stands for. @pre the view, or what it is a copy of, came from a Reading
    [[nodiscard]] static const Reading& of(const model::ModelView& view) noexcept
    {
        SQMAP_ASSERT(view.answers != nullptr);
        return static_cast<const Reading&>(*view.answers);
    }

private:
    ModelView model_;
    model::ModelView view_;
    QueryOptions options_;
};

// Doors open models of either kind (paper/model_file.h) and hold views of both: these say which one a view is of.

/// Hash of the content, whichever kind it is.
[[nodiscard]] std::uint64_t content_hash(const model::ModelView& view) noexcept;
/// True for the view of a Reading, or a copy of it.
[[nodiscard]] constexpr bool is_paper(const model::ModelView& view) { return view.answers != nullptr; }
/// The part's map. @pre is_paper(view), and the part exists
[[nodiscard]] inline MapView map_of(const model::ModelView& view, std::size_t part) noexcept
{
    return map_of(Reading::of(view).model(), part);
}
/// False for a paper model that was baked without its smoothed map; every central model has one.
[[nodiscard]] inline bool has_smoothed_map(const model::ModelView& view) noexcept
{
    return !is_paper(view) || has_smoothed_map(Reading::of(view).model());
}

}  // namespace sqmap::paper
