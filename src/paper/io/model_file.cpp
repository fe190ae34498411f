#include "sqmap/paper/model_file.h"

#include "io/model_table.h"
#include "model/notes_field.h"
#include "paper_generated.h"
#include "sqmap/io/model_file.h"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <utility>

namespace sqmap::paper {

std::vector<std::byte> serialize(const ModelData& data, std::span<const model::NoteRecord> notes)
{
    if (data.maps.records.empty()) return io::serialize(data.common, notes);
    flatbuffers::FlatBufferBuilder builder(1 << 20);
    const auto common = io::write_table(builder, data.common, notes);
    io::TableWriter writer(builder, *fb::MapsTypeTable());
    ModelMaps<model::ArrayData>::each(writer, data.maps);
    fb::MapsBuilder maps(builder);
    writer.add_fields([](flatbuffers::voffset_t) {});
    const auto finished = maps.Finish();
    fb::FinishPaperModelBuffer(builder,
                               fb::CreatePaperModel(builder, k_format_version, content_hash(data.view()), common, finished));
    return io::bytes_of(builder);
}

std::span<const model::NoteRecord> notes_of(std::span<const std::byte> bytes) noexcept
{
    const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
    if (bytes.size() < 16 || !fb::PaperModelBufferHasIdentifier(data)) return model::notes_of(bytes);
    return model::notes_of(*fb::GetPaperModel(data)->common());
}

std::string model_json(const model::ModelView& any, std::size_t total, std::span<const model::NoteRecord> notes)
{
    if (!is_paper(any)) return io::model_json(any, total, notes);
    using nlohmann::ordered_json;
    const ModelView& view = Reading::of(any).model();
    ordered_json out = ordered_json::parse(io::model_json(any, total, notes));
    char hash[20];
    std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(content_hash(view)));
    out["format_version"] = k_format_version;
    out["content_hash"] = hash;
    out["projection"] = "normal";
    out["bytes"]["normal_map"] = model::bytes_of(view.maps);
    for (std::size_t i = 0; i < view.maps.records.size(); ++i) {
        const MapView map = map_of(view, i);
        const MapCounts counts = counts_of(map);
        out["parts"][i]["q2_percent"] = 100 * static_cast<double>(map.q2_share);
        out["parts"][i]["vertices"] = map.vertex_count;
        out["parts"][i]["occluded_vertices"] = map.occluded_vertices;
        out["parts"][i]["rays"] = {{"hits", counts.hits}, {"caps", counts.caps}, {"misses", counts.misses}};
        out["parts"][i]["map"] = {{"rows", ((map.eta_count - 1) >> map.subdivisions) + 1},
                                  {"columns", map.omega_count >> map.subdivisions},
                                  {"subdivisions", map.subdivisions},
                                  {"smoothed", !map.smoothed.empty()}};
    }
    return out.dump(2);
}

model::ParseStatus AnyModel::parse(std::span<const std::byte> bytes)
{
    model::ModelView central;
    model::ParseStatus status = model::parse(bytes, central);
    if (status == model::ParseStatus::Ok) {
        central_ = central;
        reading_.reset();
    }
    if (status != model::ParseStatus::PaperModel) return status;
    ModelView paper;
    status = paper::parse(bytes, paper);
    if (status == model::ParseStatus::Ok) reading_ = std::make_unique<Reading>(paper);
    return status;
}

void AnyModel::set_options(const QueryOptions& options)
{
    if (reading_) reading_->set_options(options);
}

MappedModel::MappedModel(io::MappedBytes file, const std::filesystem::path& path) : file_(std::move(file))
{
    io::check(parse(bytes()), path);
}

}  // namespace sqmap::paper
