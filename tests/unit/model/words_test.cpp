// Decoding gives back what was encoded: words of central cells, locator cells and candidate lists.
#include "model/candidate_lists.h"
#include "model/central_cells.h"
#include "model/locator_cells.h"
#include "support/baked_shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <vector>

namespace sqmap::model {
namespace {

TEST(Words, ASampleIsStoredToHalfAStep)
{
    test::Random random(1);
    const SampleRange range = SampleRange::around(0.7, 31);
    EXPECT_TRUE(range.holds(0.7, 31));
    EXPECT_FALSE(range.holds(0.1, 31));
    EXPECT_FALSE(range.holds(0.7, 90));
    for (int i = 0; i < 10000; ++i) {
        const double w = random.between(0.7, 31), step = static_cast<double>(range.w_step);
        EXPECT_NEAR(static_cast<double>(range.decode(range.encode(w))), w, 0.51 * step);
        EXPECT_LE(static_cast<double>(range.decode(range.encode_down(w))), w);
        EXPECT_GE(static_cast<double>(range.decode(range.encode_up(w))), w);
        const double gain = random.between(-3, 3);
        EXPECT_NEAR(step * static_cast<double>(decode_slope(range.encode_slope(gain))), gain, 0.51 * step);
    }
}

TEST(Words, ADeviationIsRoundedUpToItsCode)
{
    test::Random random(2);
    const DeviationCodes codes(1e-4f);
    for (int i = 0; i < 1000; ++i) {
        const double e = std::exp(random.between(std::log(1e-6), std::log(10)));
        const auto code = codes.at_least(e);
        ASSERT_TRUE(code.has_value());
        EXPECT_GE(codes[*code], e);
        if (*code > 0) {
            EXPECT_LT(codes[*code - 1u], e);
        }
        EXPECT_NEAR(static_cast<double>(deviation_of_code(*code, 1e-4f)) / codes[*code], 1, 1e-6);
    }
    EXPECT_FALSE(codes.at_least(1e30).has_value());
}

TEST(Words, ACentralCellKeepsItsFields)
{
    for (const bool foreign : {false, true})
        for (std::uint32_t code = 0; code < 256; ++code) {
            const CentralCell cell = CentralCell::single(code, foreign);
            EXPECT_EQ(cell.kind(), CellKind::Single);
            EXPECT_EQ(cell.deviation_code(), code);
            EXPECT_EQ(cell.foreign(), foreign);
            EXPECT_TRUE(cell.has_valid_bits());
        }
    EXPECT_TRUE(CentralCell::uniform(true).inside());
    EXPECT_FALSE(CentralCell::uniform(false).inside());
    EXPECT_EQ(CentralCell::of(CellKind::Layered, k_max_payload - 1).payload(), k_max_payload - 1);
    EXPECT_EQ(CentralCell::of(CellKind::Layered, k_max_payload - 1).kind(), CellKind::Layered);
}

TEST(Words, ALayeredHeadKnowsItsRecordsLength)
{
    for (int sheets = 0; sheets <= k_max_sheets; ++sheets) {
        const auto n = static_cast<std::uint32_t>(sheets);
        const LayeredHead bilinear = LayeredHead::of_bilinear(sheets, true), mixed = LayeredHead::of_mixed(sheets, false);
        EXPECT_TRUE(bilinear.bilinear() && bilinear.foreign() && !bilinear.divided());
        EXPECT_EQ(bilinear.record_size(), 1 + 5 * n);
        EXPECT_FALSE(mixed.bilinear() || mixed.foreign() || mixed.divided());
        EXPECT_EQ(mixed.record_size(), 3 + 3 * n);
        for (int second = 0; second <= k_max_sheets; ++second) {
            const LayeredHead divided = LayeredHead::of_divided(sheets, second, true);
            EXPECT_TRUE(divided.divided() && divided.foreign() && !divided.bilinear());
            EXPECT_EQ(divided.sheets(), sheets);
            EXPECT_EQ(divided.second_sheets(), second);
            EXPECT_EQ(divided.record_size(), 4 + 3 * (n + static_cast<std::uint32_t>(second)));
        }
    }
}

TEST(Words, ABorderLineKeepsItsEnds)
{
    for (std::uint32_t from = 0; from < 256; from += 7)
        for (std::uint32_t to = 0; to < 256; to += 5) {
            const BorderLine line = border_line(border_line_word(from, to));
            EXPECT_EQ(line.from.u, border_point(from).u);
            EXPECT_EQ(line.from.v, border_point(from).v);
            EXPECT_EQ(line.to.u, border_point(to).u);
            EXPECT_EQ(line.to.v, border_point(to).v);
        }
}

TEST(Words, ALocatorCellKeepsItsFields)
{
    test::Random random(3);
    for (int i = 0; i < 10000; ++i) {
        const std::uint32_t list = random.below(k_max_lists), planes = random.below(k_max_planes + 1),
                            first = random.below(k_max_first);
        for (const LocatorCellKind kind : {LocatorCellKind::Inside, LocatorCellKind::Mixed, LocatorCellKind::Ambiguous}) {
            const LocatorCell cell = LocatorCell::flat(kind, list, planes, first);
            EXPECT_EQ(cell.kind(), kind);
            EXPECT_EQ(cell.list(), list);
            EXPECT_EQ(cell.planes(), planes);
            EXPECT_EQ(cell.first(), first);
            EXPECT_FALSE(cell.is_free() || cell.is_divided());
            EXPECT_EQ(cell.is_flat(), planes > 0);
            EXPECT_EQ(cell.has_seeds(), planes == 0);
        }
        EXPECT_TRUE(LocatorCell::divided(first).is_divided());
        EXPECT_EQ(LocatorCell::divided(first).first(), first);
        EXPECT_TRUE(LocatorCell::free(first).is_free());
        EXPECT_EQ(LocatorCell::free(first).gap(), first);
        EXPECT_TRUE(LocatorBrick::free(first).is_free());
        EXPECT_EQ(LocatorBrick::free(first).gap(), first);
        EXPECT_TRUE(LocatorBrick::deep(first).is_deep());
        EXPECT_EQ(LocatorBrick::deep(first).first(), first);
        EXPECT_EQ(LocatorBrick::deep(first).cell_count(), 1u);
        EXPECT_EQ(LocatorBrick::stored(first).cell_count(), 64u);
    }
}

TEST(Words, AGapIsNeverLongerThanTheTruth)
{
    test::Random random(4);
    for (int i = 0; i < 1000; ++i) {
        const double cell = random.between(0.01, 0.2), gap = cell * random.between(0, 100);
        const double stored = encode_gap(gap, cell) * static_cast<double>(k_gap_step) * cell;
        EXPECT_LE(stored, gap);
        EXPECT_GE(stored, gap * (1 - 2e-5) - cell / 64);
    }
}

TEST(Words, APlaneKeepsItsFields)
{
    test::Random random(5);
    constexpr float k_reach = 23;
    for (int i = 0; i < 2000; ++i) {
        const Vec3d n = random.direction();
        const double distance = random.between(-1, 22);
        const LocatorPlane plane = LocatorPlane::towards(3.0 * n).with_distance(distance, k_reach).with_slot(2).joined();
        EXPECT_GT(dot(cast<double>(plane.normal()), n), 0.9999);
        EXPECT_EQ(plane.slot(), 2u);
        EXPECT_TRUE(plane.is_joined());
        EXPECT_EQ(plane.with_slot(0).slot(), 0u);
        // The code is the square root's: half a step of it.
        const double share = std::sqrt((distance + 1) / k_reach), step = 1.0 / LocatorPlane::k_max_distance;
        EXPECT_NEAR(static_cast<double>(plane.distance(k_reach)), distance, k_reach * (share + step) * step + 1e-5);
    }
    EXPECT_FALSE(LocatorPlane::holds_distance(-1.01, k_reach));
    EXPECT_FALSE(LocatorPlane::holds_distance(22.01, k_reach));
}

TEST(Words, ASeedKeepsItsFields)
{
    test::Random random(6);
    for (int i = 0; i < 2000; ++i) {
        const std::uint32_t part = random.below(255);
        const double cell = random.between(0.01, 0.1), length = cell * random.between(-60, 60), reach = random.between(0, 31);
        const Vec3d n = random.direction();
        const Seed seed = as_last(with_reach(with_distance(make_seed(part, n), length, cell), reach));
        EXPECT_EQ(seed_part(seed), part);
        EXPECT_GT(dot(cast<double>(seed_normal(seed)), n), 0.99999);
        EXPECT_NEAR(seed_distance(seed) * static_cast<double>(k_seed_distance_step) * cell, length, 0.51 * cell / 512);
        EXPECT_EQ(seed_reach(seed), static_cast<std::uint32_t>(reach * 8));
        EXPECT_TRUE(is_last_seed(seed));
        EXPECT_FALSE(is_last_seed(as_not_last(seed)));
        EXPECT_EQ(as_not_last(seed).extent | k_last_seed, seed.extent);
    }
    std::uint32_t choices = 0;
    for (std::uint32_t octant = 0; octant < 8; ++octant) choices = with_seed_choice(choices, octant, (3 * octant + 1) % 8);
    for (std::uint32_t octant = 0; octant < 8; ++octant) EXPECT_EQ(seed_choice(choices, octant), (3 * octant + 1) % 8);
}

TEST(Words, AListOfPartsKeepsItsOrder)
{
    const PartList parts{7, 250, 3, k_no_part};
    EXPECT_EQ(decode_list(encode_list(parts)), parts);
    for (std::uint32_t slot = 0; slot < k_list_length; ++slot) EXPECT_EQ(part_in_list(encode_list(parts), slot), parts[slot]);
}

TEST(Words, ARiseIsNeverLessThanTheTruth)
{
    for (double rise = 0; rise < 0.5; rise += 0.003) {
        const std::uint8_t code = encode_rise(rise);
        if (code == k_no_rise) {
            EXPECT_GT(rise, 0.245);
            continue;
        }
        EXPECT_GE(static_cast<double>(code) * static_cast<double>(k_rise_step), rise);
    }
}

TEST(Words, ARecordOfCandidatesReadsBackAsItsLists)
{
    test::Random random(7);
    for (const bool wide : {false, true})
        for (const std::uint32_t triangles : {1u, 2u, 3u, 128u, 129u, 257u, 900u, 60000u}) {
            std::vector<std::uint32_t> table(triangles), starts{0}, refs;
            for (std::uint32_t& t : table) t = random.below(wide ? 200000u : 60000u);
            std::vector<std::uint32_t> cells;
            std::uint64_t occupied = 0;
            for (std::uint32_t cell = random.below(5); cell < 64; cell += 1 + random.below(7)) {
                occupied |= std::uint64_t{1} << cell;
                cells.push_back(cell);
                if (cells.size() != 2)  // the second has all triangles of the brick
                    for (std::uint32_t k = random.below(std::min(triangles, 5u)), step = 1 + triangles / 9; k < triangles;
                         k += 1 + random.below(step))
                        refs.push_back(k);
                starts.push_back(static_cast<std::uint32_t>(refs.size()));
            }
            const UnpackedCandidates contents{occupied, starts, table, refs};
            std::vector<std::uint16_t> values(packed_size(contents, wide));
            pack_candidates(contents, wide, values.data());
            const CandidateRecord record = candidate_record(values.data(), wide);
            EXPECT_EQ(record.size(), values.size());
            EXPECT_EQ(record.cells(), cells.size());
            for (std::size_t i = 0; i < cells.size(); ++i) {
                const CandidateList list = record.of_cell(cells[i]);
                const bool all = i == 1;
                ASSERT_EQ(list.count, all ? triangles : starts[i + 1] - starts[i]);
                std::vector<std::int32_t> read(list.count);
                list.read(0, list.count, read.data());
                for (std::uint32_t k = 0; k < list.count; ++k) {
                    const std::uint32_t expected = table[all ? k : refs[starts[i] + k]];
                    EXPECT_EQ(list[k], expected);
                    EXPECT_EQ(static_cast<std::uint32_t>(read[k]), expected);
                }
                std::uint32_t visited = 0;
                list.each([&](std::uint32_t t) { EXPECT_EQ(t, static_cast<std::uint32_t>(read[visited++])); });
                EXPECT_EQ(visited, list.count);
            }
        }
}

}  // namespace
}  // namespace sqmap::model
