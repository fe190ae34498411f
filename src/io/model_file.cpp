#include "sqmap/io/model_file.h"

#include "model/schema.h"
#include "platform/files.h"
#include "sqmap/io/replace_file.h"

#include <cstring>
#include <string>

namespace sqmap::io {

namespace fb = model::fb;

namespace {

/// Offsets of a table's vectors, strings and tables, by field.
class TableWriter {
public:
    TableWriter(flatbuffers::FlatBufferBuilder& builder, const flatbuffers::TypeTable& fields)
        : builder_(builder), fields_(fields), offsets_(fields.num_elems, 0)
    {
    }
    /// A vector: in the visits of model/arrays.h.
    template <class T>
    void operator()(const char* name, const std::vector<T>& values)
    {
        // Numbers too are written as structs are; FlatBuffers' lower functions differ between its versions.
        offsets_.at(model::field_of(fields_, name)) = builder_.CreateVectorOfStructs(values.data(), values.size()).o;
    }
    template <class T>
    void set(const char* name, flatbuffers::Offset<T> offset)
    {
        offsets_.at(model::field_of(fields_, name)) = offset.o;
    }
    /// As generated writers do, from the last field to the first. add(field): fields that are no offsets.
    template <class Add>
    void add_fields(Add&& add)
    {
        for (std::size_t field = offsets_.size(); field-- > 0;) {
            if (offsets_[field] != 0)
                builder_.AddOffset(model::directory_offset(field), flatbuffers::Offset<void>(offsets_[field]));
            else
                add(model::directory_offset(field));
        }
    }

private:
    flatbuffers::FlatBufferBuilder& builder_;
    const flatbuffers::TypeTable& fields_;
    std::vector<flatbuffers::uoffset_t> offsets_;
};

flatbuffers::Offset<fb::NormalMaps> write_normal_maps(flatbuffers::FlatBufferBuilder& builder, const model::ModelData& data)
{
    if (data.normal.parts.empty()) return {};
    TableWriter writer(builder, *fb::NormalMapsTypeTable());
    model::NormalArrays<model::ArrayData>::each(writer, data.normal);
    fb::NormalMapsBuilder table(builder);
    writer.add_fields([](flatbuffers::voffset_t) {});
    return table.Finish();
}

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

flatbuffers::Offset<fb::Cure> write_cure(flatbuffers::FlatBufferBuilder& builder, const model::ModelData& data)
{
    const model::Cure& c = data.cure;
    if (c.rung == model::Rung::AsItIs) return {};
    const auto cells = builder.CreateVector(data.made_up_cells);
    return fb::CreateCure(builder, static_cast<std::uint32_t>(c.rung), c.from_mean, c.from_p99, c.from_max, c.to_mean, c.to_p99,
                          c.to_max, c.made_up_share, cells);
}

}  // namespace

std::vector<std::byte> serialize(const model::ModelData& data)
{
    flatbuffers::FlatBufferBuilder builder(1 << 20);
    TableWriter writer(builder, *fb::ModelTypeTable());
    model::each_array_before_normal(writer, data);
    writer.set("normal_maps", write_normal_maps(builder, data));
    model::each_array_behind_normal(writer, data);
    writer.set("distance", write_distance(builder, data));
    writer.set("cure", write_cure(builder, data));
    const model::Measured& m = data.measured;
    const auto measured = fb::CreateMeasured(builder, m.points, m.missed, m.false_contacts, m.eq35_mean, m.eq35_p99, m.eq35_max,
                                             m.depth_median, m.depth_p95, m.depth_p99, m.depth_max, m.normal_median, m.q2_share,
                                             m.layer1_depth_p99, m.layer2_depth_p99);
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
        if (field == fb::Model::VT_VERSION) table.add_version(model::k_format_version);
    });
    fb::FinishModelBuffer(builder, table.Finish());
    const auto* begin = reinterpret_cast<const std::byte*>(builder.GetBufferPointer());
    return {begin, begin + builder.GetSize()};
}

SectionBytes section_bytes(const model::ModelView& v, std::size_t total)
{
    SectionBytes s;
    s.total = total;
    s.superquadrics = v.parts.size_bytes();
    s.normal_map = model::bytes_of(v.normal);
    s.map = model::bytes_of<model::CentralArrays<model::ArrayView>>(v);
    s.locator = model::bytes_of<model::LocatorArrays<model::ArrayView>>(v);
    s.distance = model::bytes_of(v.distance);
    s.exact = model::bytes_of<model::CandidateArrays<model::ArrayView>>(v);
    s.mesh = model::bytes_of<model::MeshArrays<model::ArrayView>>(v);
    return s;
}

void write_model(const model::ModelData& data, const std::filesystem::path& path) { replace_file(path, serialize(data)); }

MappedModel::MappedModel(const std::filesystem::path& path) : MappedModel(path, 0, 0) {}

MappedModel::MappedModel(const std::filesystem::path& path, std::uint64_t offset, std::uint64_t size)
{
    const platform::Mapping file = platform::map_file(path, offset, size);
    if (file.error == std::errc::invalid_argument)
        throw ModelFileError(path.string() + " is empty or not a file: bake a model with 'sqmap bake MESH -o MODEL'");
    if (file.error == std::errc::result_out_of_range || offset % 8 != 0) {
        platform::unmap(file);
        throw ModelFileError(path.string() + ": no model stands at byte " + std::to_string(offset) +
                             ": the file was cut or changed");
    }
    if (file.error)
        throw ModelFileError((file.was_opened ? "cannot map " : "cannot open ") + path.string() + ": " + file.error.message());
    mapping_ = file.pages;
    skip_ = file.skip;
    size_ = file.size;
    const model::ParseStatus status = model::parse(bytes(), view_);
    if (status != model::ParseStatus::Ok) {
        platform::unmap(file);
        mapping_ = nullptr;
        throw ModelFileError(path.string() + ": " + model::to_string(status) +
                             (status == model::ParseStatus::NotAModel ? ": bake a mesh with 'sqmap bake MESH -o MODEL'" : ""));
    }
}

MappedModel::~MappedModel() { platform::unmap({mapping_, skip_, size_, {}, true}); }

MappedModel::MappedModel(MappedModel&& other) noexcept
    : mapping_(other.mapping_), skip_(other.skip_), size_(other.size_), view_(other.view_)
{
    other.mapping_ = nullptr;
}

}  // namespace sqmap::io
