#include "sqmap/io/model_file.h"

#include "sqmap/io/replace_file.h"

#include "sqmap_generated.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>

namespace sqmap::io {

namespace fb = model::fb;

std::vector<std::byte> serialize(const model::ModelData& data)
{
    const model::ModelView view = data.view();
    flatbuffers::FlatBufferBuilder builder(1 << 20);
    fb::Header header;
    static_assert(sizeof(header) == sizeof(model::Header));
    std::memcpy(static_cast<void*>(&header), &data.header, sizeof(header));
    const auto parts = builder.CreateVectorOfStructs(reinterpret_cast<const fb::Part*>(data.parts.data()), data.parts.size());
    const auto samples = builder.CreateVector(data.samples);
    const auto offsets = builder.CreateVector(data.offsets);
    const auto smoothing = builder.CreateVector(data.smoothing);
    const auto cells = builder.CreateVector(data.cells);
    const auto blocks = builder.CreateVectorOfStructs(reinterpret_cast<const fb::Block*>(data.blocks.data()), data.blocks.size());
    const auto splits = builder.CreateVector(data.splits);
    const auto specials = builder.CreateVector(data.specials);
    const auto pool = builder.CreateVector(data.pool);
    const auto vertices = builder.CreateVector(data.vertices);
    const auto triangles16 = builder.CreateVector(data.triangles16);
    const auto triangles32 = builder.CreateVector(data.triangles32);
    const auto triangle_part = builder.CreateVector(data.triangle_part);
    const auto piece_triangle = builder.CreateVector(data.piece_triangle);
    const auto pieces = builder.CreateVector(data.pieces);
    flatbuffers::Offset<fb::NormalMaps> normal_maps;
    if (!data.normal_parts.empty()) {
        const auto structs = [&](const auto& values, auto* as) {
            return builder.CreateVectorOfStructs(reinterpret_cast<decltype(as)>(values.data()), values.size());
        };
        const auto normal_parts = structs(data.normal_parts, static_cast<const fb::NormalPart*>(nullptr));
        const auto distance = builder.CreateVector(data.normal_distance);
        const auto normal = builder.CreateVector(data.normal_normal);
        const auto cuts = builder.CreateVector(data.normal_cuts);
        const auto offset = builder.CreateVector(data.normal_offset);
        const auto correction_rows = builder.CreateVector(data.correction_rows);
        const auto gap_rows = builder.CreateVector(data.gap_rows);
        const auto corrections = structs(data.corrections, static_cast<const fb::VertexCorrection*>(nullptr));
        const auto gaps = structs(data.gaps, static_cast<const fb::MapGap*>(nullptr));
        const auto seeds = structs(data.seeds, static_cast<const fb::FootSeed*>(nullptr));
        const auto smoothed = structs(data.normal_smoothed, static_cast<const fb::SmoothedSample*>(nullptr));
        normal_maps = fb::CreateNormalMaps(builder, normal_parts, distance, normal, cuts, offset, correction_rows, gap_rows,
                                           corrections, gaps, seeds, smoothed);
    }
    fb::Locator locator;
    std::memcpy(static_cast<void*>(&locator), &data.locator, sizeof(locator));
    const auto bricks = builder.CreateVector(data.bricks);
    const auto places = builder.CreateVector(data.places);
    const auto part_lists = builder.CreateVector(data.part_lists);
    const auto planes = builder.CreateVector(data.planes);
    const auto seeds =
        builder.CreateVectorOfStructs(reinterpret_cast<const fb::Seed*>(data.locator_seeds.data()), data.locator_seeds.size());
    const auto near_bricks = builder.CreateVector(data.near_bricks);
    const auto near = builder.CreateVector(data.near);
    const auto rises = builder.CreateVector(data.rises);
    const model::Measured& m = data.measured;
    const auto measured = fb::CreateMeasured(builder, m.points, m.missed, m.false_contacts, m.eq35_mean, m.eq35_p99, m.eq35_max,
                                             m.depth_median, m.depth_p95, m.depth_p99, m.depth_max, m.normal_median, m.q2_share,
                                             m.layer1_depth_p99, m.layer2_depth_p99);
    const auto made_by = builder.CreateString(data.made_by);
    const auto source = builder.CreateString(data.source);
    const auto options = builder.CreateString(data.options);
    fb::FinishModelBuffer(
        builder, fb::CreateModel(builder, model::k_format_version, model::content_hash(view), &header, parts, samples, offsets,
                                 smoothing, cells, blocks, splits, specials, pool, vertices, triangles16, triangles32,
                                 triangle_part, piece_triangle, pieces, normal_maps, &locator, bricks, places, part_lists, planes,
                                 seeds, near_bricks, near, rises, measured, made_by, source, options, data.mesh_hash));
    const auto* begin = reinterpret_cast<const std::byte*>(builder.GetBufferPointer());
    return {begin, begin + builder.GetSize()};
}

SectionBytes section_bytes(const model::ModelView& v, std::size_t total)
{
    SectionBytes s;
    s.total = total;
    s.superquadrics = v.parts.size_bytes();
    const model::NormalArrays& n = v.normal;
    s.normal_map = n.parts.size_bytes() + n.distance.size_bytes() + n.normal.size_bytes() + n.cuts.size_bytes() +
                   n.offset.size_bytes() + n.correction_rows.size_bytes() + n.gap_rows.size_bytes() + n.corrections.size_bytes() +
                   n.gaps.size_bytes() + n.seeds.size_bytes() + n.smoothed.size_bytes();
    s.map = v.samples.size_bytes() + v.offsets.size_bytes() + v.smoothing.size_bytes() + v.cells.size_bytes() +
            v.blocks.size_bytes() + v.splits.size_bytes() + v.specials.size_bytes() + v.pool.size_bytes();
    s.locator =
        v.bricks.size_bytes() + v.places.size_bytes() + v.part_lists.size_bytes() + v.planes.size_bytes() + v.seeds.size_bytes();
    s.exact = v.near_bricks.size_bytes() + v.near.size_bytes() + v.rises.size_bytes();
    s.mesh = v.vertices.size_bytes() + v.triangles16.size_bytes() + v.triangles32.size_bytes() + v.triangle_part.size_bytes() +
             v.piece_triangle.size_bytes() + v.pieces.size_bytes();
    return s;
}

void write_model(const model::ModelData& data, const std::filesystem::path& path) { replace_file(path, serialize(data)); }

MappedModel::MappedModel(const std::filesystem::path& path)
{
    const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (fd < 0) throw ModelFileError("cannot open " + path.string() + ": " + std::strerror(errno));
    struct stat info {};
    if (::fstat(fd, &info) != 0 || !S_ISREG(info.st_mode) || info.st_size == 0) {
        ::close(fd);
        throw ModelFileError(path.string() + " is empty or not a file: bake a model with 'sqmap bake MESH -o MODEL'");
    }
    size_ = static_cast<std::size_t>(info.st_size);
    data_ = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, fd, 0);
    ::close(fd);
    if (data_ == MAP_FAILED) {
        data_ = nullptr;
        throw ModelFileError("cannot map " + path.string() + ": " + std::strerror(errno));
    }
    const model::ParseStatus status = model::parse(bytes(), view_);
    if (status != model::ParseStatus::Ok) {
        ::munmap(data_, size_);
        data_ = nullptr;
        throw ModelFileError(path.string() + ": " + model::to_string(status) +
                             (status == model::ParseStatus::NotAModel ? ": bake a mesh with 'sqmap bake MESH -o MODEL'" : ""));
    }
}

MappedModel::~MappedModel()
{
    if (data_ != nullptr) ::munmap(data_, size_);
}

MappedModel::MappedModel(MappedModel&& other) noexcept : data_(other.data_), size_(other.size_), view_(other.view_)
{
    other.data_ = nullptr;
}

}  // namespace sqmap::io
