#include "sqmap/io/model_file.h"

#include "io/replace_file.h"
#include "model/notes_field.h"
#include "model_table.h"
#include "platform/files.h"
#include "sqmap/io/read.h"

#include <cstring>
#include <string>
#include <system_error>
#include <utility>

namespace sqmap::io {

namespace fb = model::fb;

namespace {

flatbuffers::Offset<fb::Distance> write_distance(flatbuffers::FlatBufferBuilder& builder, const model::ModelData& data)
{
    if (data.distance.bounds.empty()) return {};
    TableWriter writer(builder, *fb::DistanceTypeTable());
    model::DistanceArrays<model::ArrayData>::each(writer, data.distance);
    fb::DistanceHeader header;
    std::memcpy(static_cast<void*>(&header), &data.distance.header, sizeof(header));
    fb::DistanceBuilder table(builder);
    writer.add_fields([&](flatbuffers::voffset_t field) {
        if (field == fb::Distance::VT_HEADER) table.add_header(&header);
    });
    return table.Finish();
}

flatbuffers::Offset<fb::Input> write_input(flatbuffers::FlatBufferBuilder& builder, const model::ModelData& data)
{
    if (!model::has_input(data.view())) return {};
    TableWriter writer(builder, *fb::InputTypeTable());
    model::InputArrays<model::ArrayData>::each(writer, data.input);
    fb::InputBuilder table(builder);
    writer.add_fields([](flatbuffers::voffset_t) {});
    return table.Finish();
}

flatbuffers::Offset<fb::Cure> write_cure(flatbuffers::FlatBufferBuilder& builder, const model::ModelData& data)
{
    const model::Cure& c = data.cure;
    if (c.rung == model::Rung::AsItIs) return {};
    const auto cells = builder.CreateVector(data.made_up_cells);
    return fb::CreateCure(builder, static_cast<std::uint32_t>(c.rung), c.from_mean, c.from_p99, c.from_max, c.to_mean, c.to_p99,
                          c.to_max, c.made_up_share, cells);
}

}  // namespace

flatbuffers::Offset<fb::Model> write_table(flatbuffers::FlatBufferBuilder& builder, const model::ModelData& data,
                                           std::span<const model::NoteRecord> notes)
{
    TableWriter writer(builder, *fb::ModelTypeTable());
    model::each_surface_array(writer, data);
    model::each_cell_array(writer, data);
    if (!data.polytope_ends.empty()) model::BoundArrays<model::ArrayData>::each(writer, data);
    writer.set("distance", write_distance(builder, data));
    writer.set("cure", write_cure(builder, data));
    writer.set("input", write_input(builder, data));
    const model::Measured& m = data.measured;
    const auto measured = fb::CreateMeasured(builder, m.points, m.missed, m.false_contacts, m.eq35_mean, m.eq35_p99, m.eq35_max,
                                             m.depth_median, m.depth_p95, m.depth_p99, m.depth_max, m.normal_median, m.q2_share,
                                             m.layer1_depth_p99, m.layer2_depth_p99);
    if (!notes.empty()) writer.set("notes", builder.CreateVectorOfStructs(notes.data(), notes.size()));
    const auto made_by = builder.CreateString(data.made_by);
    const auto source = builder.CreateString(data.source);
    const auto options = builder.CreateString(data.options);
    writer.set("measured", measured);
    writer.set("made_by", made_by);
    writer.set("source", source);
    writer.set("options", options);
    fb::Header header;
    fb::Locator locator;
    static_assert(sizeof(header) == sizeof(model::Header) && sizeof(locator) == sizeof(model::Locator));
    std::memcpy(static_cast<void*>(&header), &data.header, sizeof(header));
    std::memcpy(static_cast<void*>(&locator), &data.locator, sizeof(locator));
    fb::ModelBuilder table(builder);
    table.add_mesh_hash(data.mesh_hash);
    table.add_content_hash(model::content_hash(data.view()));
    writer.add_fields([&](flatbuffers::voffset_t field) {
        if (field == fb::Model::VT_LOCATOR) table.add_locator(&locator);
        if (field == fb::Model::VT_HEADER) table.add_header(&header);
        if (field == fb::Model::VT_NOTES_HASH && !notes.empty()) table.add_notes_hash(model::hash_of(notes));
        if (field == fb::Model::VT_VERSION) table.add_version(model::k_format_version);
    });
    return table.Finish();
}

std::vector<std::byte> bytes_of(const flatbuffers::FlatBufferBuilder& builder)
{
    const auto* begin = reinterpret_cast<const std::byte*>(builder.GetBufferPointer());
    return {begin, begin + builder.GetSize()};
}

std::vector<std::byte> serialize(const model::ModelData& data, std::span<const model::NoteRecord> notes)
{
    flatbuffers::FlatBufferBuilder builder(1 << 20);
    fb::FinishModelBuffer(builder, write_table(builder, data, notes));
    return bytes_of(builder);
}

SectionBytes section_bytes(const model::ModelView& v, std::size_t total)
{
    SectionBytes s;
    s.total = total;
    s.superquadrics = v.parts.size_bytes();
    s.polytopes = model::bytes_of<model::BoundArrays<model::ArrayView>>(v);
    s.map = model::bytes_of<model::CentralArrays<model::ArrayView>>(v);
    s.locator = model::bytes_of<model::LocatorArrays<model::ArrayView>>(v);
    s.distance = model::bytes_of(v.distance);
    s.exact = model::bytes_of<model::CandidateArrays<model::ArrayView>>(v);
    s.mesh = model::bytes_of<model::MeshArrays<model::ArrayView>>(v);
    s.input = model::bytes_of(v.input);
    return s;
}

void write_model(const model::ModelData& data, const std::filesystem::path& path) { replace_file(path, serialize(data)); }

MappedBytes::MappedBytes(const std::filesystem::path& path, std::uint64_t offset, std::uint64_t size)
{
    const platform::Mapping file = platform::map_file(path, offset, size);
    if (file.error == std::errc::invalid_argument)
        throw ModelFileError(path.string() + " is empty or not a file: give a model, which a bake makes of a mesh");
    if (file.error == std::errc::result_out_of_range || offset % 8 != 0) {
        platform::unmap(file);
        throw ModelFileError(path.string() + ": no model stands at byte " + std::to_string(offset) +
                             ": the file was cut or changed");
    }
    if (file.error == std::errc::no_such_file_or_directory) throw ModelFileError(path.string() + ": " + k_no_file);
    if (file.error)
        throw ModelFileError((file.was_opened ? "cannot map " : "cannot open ") + path.string() + ": " + file.error.message());
    mapping_ = file.pages;
    skip_ = file.skip;
    size_ = file.size;
}

MappedBytes::~MappedBytes() { platform::unmap({mapping_, skip_, size_, {}, true}); }

MappedBytes::MappedBytes(MappedBytes&& other) noexcept
    : mapping_(std::exchange(other.mapping_, nullptr)), skip_(other.skip_), size_(other.size_)
{
}

void check(model::ParseStatus status, const std::filesystem::path& path)
{
    if (status == model::ParseStatus::Ok) return;
    throw ModelFileError(path.string() + ": " + model::to_string(status) + "\n  cure: " + model::cure_of(status));
}

MappedModel::MappedModel(const std::filesystem::path& path) : file_(path) { check(model::parse(bytes(), view_), path); }

}  // namespace sqmap::io
