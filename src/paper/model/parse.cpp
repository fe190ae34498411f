#include "sqmap/paper/model.h"

#include "model/locator_cells.h"
#include "model/parse_steps.h"
#include "paper/model/codes.h"
#include "paper_generated.h"

#include <algorithm>

namespace sqmap::paper {

namespace {

using model::LocatorCell;
using model::ParseStatus;
using model::within;

static_assert(sizeof(MapRecord) == sizeof(fb::MapRecord) && alignof(MapRecord) == alignof(fb::MapRecord));
static_assert(sizeof(VertexCorrection) == sizeof(fb::VertexCorrection) &&
              alignof(VertexCorrection) == alignof(fb::VertexCorrection));
static_assert(sizeof(MapGap) == sizeof(fb::MapGap) && alignof(MapGap) == alignof(fb::MapGap));
static_assert(sizeof(FootSeed) == sizeof(fb::FootSeed) && alignof(FootSeed) == alignof(fb::FootSeed));
static_assert(sizeof(HitRank) == sizeof(fb::HitRank) && alignof(HitRank) == alignof(fb::HitRank));

/// Checks that a part's map lies within the arrays, and then what it says.
ParseStatus check_map(const ModelView& view, std::size_t index)
{
    bool inside = true;
    const auto check = [&](const char*, const model::Slice& slice, const auto& array) {
        inside = inside && within(slice.first, slice.count, array.size());
    };
    MapArrays<model::ArrayView>::each(check, view.maps.records[index].slices, view.maps);
    if (!inside) return ParseStatus::BadStructure;
    return is_consistent(map_of(view, index)) ? ParseStatus::Ok : ParseStatus::BadValue;
}

/// No labels, or one a triangle, of a part and a region that there are.
bool has_good_labels(const ModelView& v)
{
    if (v.maps.labels.empty()) return true;
    return v.maps.labels.size() == v.common.header.triangle_count &&
           std::all_of(v.maps.labels.begin(), v.maps.labels.end(), [&](std::uint16_t code) {
               const TriangleLabel label = decode_label(code);
               return label.part < v.common.parts.size() && label.region <= Region::Q2;
           });
}

/// Cells lead to triangles alone: of each only its kind is stored.
ParseStatus check_bare_cells(const model::ModelView& v)
{
    if (const ParseStatus status = model::check_cells(v); status != ParseStatus::Ok || v.bricks.empty()) return status;
    if (!model::has_exact(v) || !v.part_lists.empty() || !v.planes.empty() || !v.seeds.empty()) return ParseStatus::BadStructure;
    for (const std::uint32_t word : v.locator_cells)
        if (!LocatorCell{word}.is_free() && (word & ~LocatorCell::k_kind_mask) != 0) return ParseStatus::BadStructure;
    return ParseStatus::Ok;
}

/// A paper model has no central maps beside its own, and the superquadrics alone bound its parts.
bool has_no_charts(const model::ModelView& v)
{
    if (!v.polytope_ends.empty()) return false;
    if (model::bytes_of<model::CentralArrays<model::ArrayView>>(v) != 0) return false;
    for (const model::Part& part : v.parts)
        if (part.base != 0) return false;
    return true;
}

}  // namespace

std::uint64_t content_hash(const ModelView& view) noexcept
{
    std::uint64_t hash = model::content_hash(view.common);
    ModelMaps<model::ArrayView>::each([&](const char*, const auto& array) { model::hash_bytes(hash, array); }, view.maps);
    return hash;
}

std::uint64_t content_hash(const model::ModelView& view) noexcept
{
    return is_paper(view) ? content_hash(Reading::of(view).model()) : model::content_hash(view);
}

ParseStatus parse(std::span<const std::byte> bytes, ModelView& view) noexcept
{
    const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
    if (bytes.size() < 16) return ParseStatus::Truncated;
    if (!fb::PaperModelBufferHasIdentifier(data)) return ParseStatus::NotAModel;
    flatbuffers::Verifier verifier(data, bytes.size(), 16, 100000);
    if (!fb::VerifyPaperModelBuffer(verifier)) return ParseStatus::Truncated;
    const fb::PaperModel* model = fb::GetPaperModel(data);
    if (model->version() != k_format_version) return ParseStatus::WrongVersion;
    if (model->common() == nullptr || model->maps() == nullptr) return ParseStatus::BadStructure;
    ModelView v;
    ParseStatus status = model::read_model(*model->common(), bytes.data() + bytes.size(), v.common);
    if (status != ParseStatus::Ok) return status;
    ModelMaps<model::ArrayView>::each(model::TableReader(model->maps(), *fb::MapsTypeTable()), v.maps);
    if (content_hash(v) != model->content_hash()) return ParseStatus::BadHash;
    if (v.common.header.projection != 1 || !has_no_charts(v.common) || v.maps.records.size() != v.common.parts.size())
        return ParseStatus::BadStructure;
    status = model::check_surface(v.common);
    for (std::size_t i = 0; i < v.maps.records.size() && status == ParseStatus::Ok; ++i) status = check_map(v, i);
    if (status == ParseStatus::Ok && !has_good_labels(v)) status = ParseStatus::BadValue;
    if (status == ParseStatus::Ok) status = check_bare_cells(v.common);
    if (status == ParseStatus::Ok) status = model::check_candidates(v.common, 0);
    if (status == ParseStatus::Ok) view = v;
    return status;
}

}  // namespace sqmap::paper
