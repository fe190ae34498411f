// Bytes of a model that are damaged, missing or absurd: nothing of them is followed.
#include "bake/bake.h"
#include "queried_model.h"

#include "model/locator_cells.h"
#include "support/baked_shapes.h"

#include <gtest/gtest.h>

#include <cstring>

namespace sqmap::io {
namespace {

using model::ModelData;
using model::ModelView;
using model::ParseStatus;

TEST(ModelFile, EveryTruncationIsRefused)
{
    const std::vector<std::byte> bytes = serialize(torus_model());
    std::vector<std::size_t> lengths;
    for (std::size_t n = 0; n < 128; ++n) lengths.push_back(n);
    for (std::size_t n = 1; n <= 64; ++n) lengths.push_back(bytes.size() - n);
    for (std::size_t i = 1; i < 200; ++i) lengths.push_back(bytes.size() * i / 200);
    for (const std::size_t n : lengths)
        EXPECT_NE(parse_and_query(std::span(bytes).first(n)), ParseStatus::Ok) << n << " of " << bytes.size() << " bytes";
}

TEST(ModelFile, BytesBehindTheEndAreRefused)
{
    for (const std::size_t extra : {1u, 7u, 8u, 64u, 4096u}) {
        std::vector<std::byte> bytes = serialize(torus_model());
        bytes.resize(bytes.size() + extra, std::byte{0x5a});
        EXPECT_NE(parse_and_query(bytes), ParseStatus::Ok) << extra << " bytes too many";
    }
}

TEST(ModelFile, NoFlippedBitCrashesAndNoneInAnArrayPasses)
{
    const std::vector<std::byte> good = serialize(torus_model());
    Bytes arena(good);
    const std::span<std::byte> bytes = arena.span();
    ModelView v;
    ASSERT_EQ(model::parse(bytes, v), ParseStatus::Ok);
    const std::byte* arrays_begin = reinterpret_cast<const std::byte*>(v.triangle_part.data());
    const std::byte* arrays_end = reinterpret_cast<const std::byte*>(v.parts.data() + v.parts.size());
    ASSERT_LT(arrays_begin, arrays_end) << "the writer's order of arrays changed: adapt this test";
    const std::size_t stride = std::max<std::size_t>(1, good.size() / 4000);
    test::Random random(11);
    std::size_t tried = 0;
    const auto flip = [&](std::size_t at, unsigned bit) {
        bytes[at] ^= std::byte(1u << bit);
        ModelView view;
        const ParseStatus status = model::parse(bytes, view);
        const bool in_array = bytes.data() + at >= arrays_begin && bytes.data() + at < arrays_end;
        if (status == ParseStatus::Ok) {
            interrogate(view, at);
            // The lengths and the padding between arrays are no array; a length that changes changes what is hashed.
            const bool padding = good[at] == std::byte{0};
            EXPECT_FALSE(in_array && !padding) << "byte " << at << " bit " << bit;
        }
        bytes[at] ^= std::byte(1u << bit);
        ++tried;
    };
    for (std::size_t at = 0; at < std::min<std::size_t>(256, good.size()); ++at)
        for (unsigned bit = 0; bit < 8; ++bit) flip(at, bit);
    for (std::size_t at = random.below(stride); at < good.size(); at += stride) flip(at, random.below(8));
    EXPECT_GT(tried, 3000u);
}

TEST(ModelFile, RandomDamageWithAValidHashNeverCrashes)
{
    // The hash tells accidents, not malice: a writer of hostile models computes it, too.
    test::Random random(17);
    const auto damage = [&](auto& values) {
        using T = std::decay_t<decltype(values[0])>;
        if (values.empty()) return;
        const std::size_t at = random.below(values.size());
        auto* raw = reinterpret_cast<unsigned char*>(&values[at]);
        raw[random.below(sizeof(T))] = static_cast<unsigned char>(random.bits());
    };
    int passed = 0;
    for (int i = 0; i < 1500; ++i) {
        ModelData data = torus_model();
        const std::uint32_t times = 1 + random.below(3);
        for (std::uint32_t k = 0; k < times; ++k) switch (random.below(16)) {
                case 0:
                    damage(data.samples);
                    break;
                case 1:
                    damage(data.cells);
                    break;
                case 2:
                    damage(data.blocks);
                    break;
                case 3:
                    damage(data.splits);
                    damage(data.specials);
                    break;
                case 4:
                    damage(data.pool);
                    break;
                case 5:
                    damage(data.vertices);
                    break;
                case 6:
                    damage(data.triangles16);
                    break;
                case 7:
                    damage(data.bricks);
                    break;
                case 8:
                    damage(data.locator_cells);
                    break;
                case 9:
                    damage(data.part_lists);
                    break;
                case 10:
                    damage(data.seeds);
                    damage(data.planes);
                    break;
                case 11: {
                    std::span<model::Locator> locator(&data.locator, 1);
                    damage(locator);
                    break;
                }
                case 12:
                    damage(data.near);
                    break;
                case 13:
                    damage(data.distance.nodes);
                    damage(data.distance.groups);
                    damage(data.distance.entries16);
                    break;
                case 14: {
                    damage(data.distance.bounds);
                    std::span<model::DistanceHeader> header(&data.distance.header, 1);
                    damage(header);
                    break;
                }
                default:
                    damage(data.parts);
                    break;
            }
        if (parse_and_query(serialize(data), static_cast<std::uint64_t>(i)) == ParseStatus::Ok) ++passed;
    }
    EXPECT_GT(passed, 100) << "damage that the values' ranges allow should reach the queries";
}

TEST(ModelFile, AGridOfAbsurdSizeIsSafeToAsk)
{
    for (const float cell : {1e-45f, 1e-38f, 1e-20f, 1e20f, 3e38f})
        for (const float origin : {0.f, -3e38f, 3e38f}) {
            const ParseStatus status = parse_changed([&](ModelData& m) {
                m.locator.cell = cell;
                m.locator.origin[1] = origin;
            });
            EXPECT_TRUE(status == ParseStatus::Ok || status == ParseStatus::BadValue) << model::to_string(status);
        }
}

/// Asks a model again and again, each time without another field of its root table: a writer may leave an array out instead of
/// storing an empty one, and its pointer is null.
void query_without_each_field(const ModelData& data)
{
    const std::vector<std::byte> good = serialize(data);
    const auto read = [&](std::size_t at, auto value) {
        std::memcpy(&value, good.data() + at, sizeof value);
        return value;
    };
    const std::size_t table = read(0, std::uint32_t{});
    const std::size_t vtable = static_cast<std::size_t>(static_cast<std::int64_t>(table) - read(table, std::int32_t{}));
    const std::size_t end = vtable + read(vtable, std::uint16_t{});
    ASSERT_GT(end, vtable + 40);
    for (std::size_t slot = vtable + 4; slot < end; slot += 2) {
        std::vector<std::byte> bytes = good;
        bytes[slot] = bytes[slot + 1] = std::byte{0};
        (void)parse_and_query(bytes);
    }
}

TEST(ModelFile, AFieldThatIsNotThereIsNeverFollowed)
{
    query_without_each_field(torus_model());
    test::Baked surface{{}, bake::bake(test::small_torus(), false, {.exact = false})};
    query_without_each_field(surface.result.model);
}

TEST(ModelFile, AFieldThatIsNotThereIsNeverFollowedFromAnEmptyGrid)
{
    ModelData empty_grid = torus_model();
    for (std::uint32_t& b : empty_grid.bricks) b = model::LocatorBrick::k_free;
    empty_grid.locator_cells.clear();
    query_without_each_field(empty_grid);
}

}  // namespace
}  // namespace sqmap::io
