// A paper model: superquadrics, the paper's own maps of their parts and, where it was baked so, triangles with the exact layer.
// Everything else of sqmap queries it through a Reading.
#pragma once

#include "sqmap/math/assert.h"
#include "sqmap/model/model_data.h"
#include "sqmap/model/parse.h"
#include "sqmap/paper/map.h"
#include "sqmap/query/body.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace sqmap::paper {

/// Version of the format of paper models. Others are refused: bake again.
inline constexpr std::uint32_t k_format_version = 12;

/// Everything a query of a paper model reads: spans over a blob that the caller owns, valid as long as it is. Any number of
/// threads may read one at a time.
struct ModelView {
    model::ModelView common{};  ///< header, superquadrics, triangles and their cells, distances; no central maps
    MapArrays<model::ArrayView> maps{};
};

/// As ModelView, in owned arrays: bake makes it, serialize writes it. Several threads may read one at a time.
struct ModelData {
    model::ModelData common;
    MapArrays<model::ArrayData> maps;

    /// Valid until the data changes.
    [[nodiscard]] ModelView view() const
    {
        ModelView view{common.view(), {}};
        const auto look = [](const char*, auto& span, const auto& array) { span = array; };
        MapArrays<model::ArrayView>::each(look, view.maps, maps);
        return view;
    }
};

/// Verifies the bytes of a paper model as model::parse does those of a central one: everything is checked here, so that queries
/// need not. The bytes must be 8-byte aligned and outlive the view.
/// Failures: any status but Ok, view untouched; a central model is NotAModel. Cost: linear in the bytes, no allocation.
[[nodiscard]] model::ParseStatus parse(std::span<const std::byte> bytes, ModelView& view) noexcept;

/// Hash of the content: bake stores it, parse checks it.
[[nodiscard]] std::uint64_t content_hash(const ModelView& view) noexcept;

/// The part's map, over the view's arrays. @pre the part exists
[[nodiscard]] MapView map_of(const ModelView& view, std::size_t part) noexcept;

/// False for a model that was baked without its smoothed map.
[[nodiscard]] constexpr bool has_smoothed_map(const ModelView& view) { return !view.maps.smoothed.empty(); }

/// Bits of a result's status beside those of query::Status.
enum Status : std::uint8_t {
    k_not_given = 128,  ///< the maps do not give what the options name (a margin, say): answered without it
};

/// How a query finds the foot of a point, where its line to the superquadric is a normal of it.
enum class Projector : std::uint8_t {
    Newton,   ///< Newton's method from a table of starts: the exact foot
    Pyramid,  ///< the multiresolution search of eqs. 16 to 19, corrected (errata 5 to 7): a sample of the grid
    Printed,  ///< the same to the letter: one direction, greatest I_S, no fallback; the sample's own distance, no closest-point
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
};

/// A paper model as points, probes, pairs, scenes, skins, the haptic tick and the rest of sqmap query it: its view() stands
/// wherever a model::ModelView does, and whatever is asked of that is answered from the paper's maps. Answers of points are
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
