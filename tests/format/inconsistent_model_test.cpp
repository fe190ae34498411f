// Models with a valid hash that contradict themselves are refused.
#include "queried_model.h"

#include "model/bound_tree.h"
#include "model/candidate_lists.h"
#include "model/central_cells.h"
#include "model/locator_cells.h"
#include "support/baked_shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace sqmap::io {
namespace {

using model::ModelData;
using model::ModelView;
using model::ParseStatus;

struct Lie {
    const char* name;
    std::function<void(ModelData&)> change;
};
void PrintTo(const Lie& lie, std::ostream* out) { *out << lie.name; }

class InconsistentModel : public testing::TestWithParam<Lie> {};

TEST_P(InconsistentModel, IsRefusedThoughItsHashIsRight)
{
    const ParseStatus status = parse_changed(GetParam().change);
    EXPECT_TRUE(status == ParseStatus::BadStructure || status == ParseStatus::BadValue) << model::to_string(status);
}

constexpr float k_nan = std::numeric_limits<float>::quiet_NaN();
constexpr float k_inf = std::numeric_limits<float>::infinity();

std::uint16_t cell_of(model::CellKind kind, std::uint32_t payload) { return model::CentralCell::of(kind, payload).word; }

/// A cell of part 0 that is split; with its children.
std::uint16_t& split_child(ModelData& m, std::size_t child)
{
    for (const model::Part& p : m.parts)
        for (std::uint32_t i = 0; i < p.cells.count; ++i) {
            const model::CentralCell cell{m.cells[p.cells.first + i]};
            if (cell.kind() == model::CellKind::Split)
                return m.splits[model::k_split_size * (p.splits.first + cell.payload()) + model::k_split_cells + child];
        }
    throw std::logic_error("the model has no split cell");
}

/// The position of the first brick's record of near triangles.
std::uint32_t& stored_near(ModelData& m)
{
    const auto it =
        std::find_if(m.near_bricks.begin(), m.near_bricks.end(), [](std::uint32_t b) { return b != model::k_no_candidates; });
    if (it == m.near_bricks.end()) throw std::logic_error("the model has no near triangles");
    return *it;
}

/// The first list of a record that has lists, and the last value of one whose last triangles are not sixteen.
std::uint16_t* first_list(ModelData& m)
{
    const model::CandidateRecord r = model::candidate_record(m.near.data() + stored_near(m), false);
    return m.near.data() + (r.lists - m.near.data());
}
std::uint16_t& last_word(ModelData& m)
{
    for (const std::uint32_t first : m.near_bricks) {
        if (first == model::k_no_candidates) continue;
        const model::CandidateRecord r = model::candidate_record(m.near.data() + first, false);
        const std::size_t words = model::mask_words(r.triangles), steps = model::mask_words(words);
        if (r.triangles % 16 == 0) continue;
        for (std::uint32_t k = 0; k < r.cells(); ++k)
            if (r.starts[k] < r.starts[k + 1] && (r.lists[r.starts[k] + steps - 1] >> (words - 1) % 16 & 1) != 0)
                return m.near[static_cast<std::size_t>(r.lists - m.near.data()) + r.starts[k + 1] - 1u];
    }
    throw std::logic_error("no list has the last triangles of its brick");
}

/// The first cell that is not free.
std::uint32_t& occupied_cell(ModelData& m)
{
    const auto it = std::find_if(m.locator_cells.begin(), m.locator_cells.end(), [](std::uint32_t p) {
        return !model::LocatorCell{p}.is_free() && !model::LocatorCell{p}.is_divided();
    });
    if (it == m.locator_cells.end()) throw std::logic_error("the model has no occupied cell");
    return *it;
}

/// The first cell that planes answer for, with a list that has room for another part.
std::uint32_t& flat_cell(ModelData& m)
{
    const auto it = std::find_if(m.locator_cells.begin(), m.locator_cells.end(), [&](std::uint32_t p) {
        return model::LocatorCell{p}.is_flat() && m.part_lists[model::LocatorCell{p}.list()] >> 24 == model::k_no_part;
    });
    if (it == m.locator_cells.end()) throw std::logic_error("the model has no flat cell");
    return *it;
}

/// The first cell that is searched from several seeds.
std::uint32_t& cell_of_a_chain(ModelData& m)
{
    const auto it = std::find_if(m.locator_cells.begin(), m.locator_cells.end(), [&](std::uint32_t p) {
        return model::LocatorCell{p}.has_seeds() && !model::is_last_seed(m.seeds[model::LocatorCell{p}.first()]);
    });
    if (it != m.locator_cells.end()) return *it;
    // Planes answer everywhere: one cell asks two seeds instead.
    m.seeds.push_back({0, 0});
    const auto first = static_cast<std::uint32_t>(m.seeds.size());
    m.seeds.push_back({0, 0x8000});
    for (std::uint32_t k = 0; k < model::k_max_seeds; ++k) m.seeds.push_back({0, 0x8000 | model::k_last_seed});
    std::uint32_t& cell = flat_cell(m);
    cell = (cell & 0x7ffu) | first << 14;
    return cell;
}

/// The first brick that is stored cell by cell.
std::uint32_t& stored_brick(ModelData& m)
{
    const auto it = std::find_if(m.bricks.begin(), m.bricks.end(), [](std::uint32_t b) {
        return (b & (model::LocatorBrick::k_free | model::LocatorBrick::k_deep)) == 0;
    });
    if (it == m.bricks.end()) throw std::logic_error("the model has no stored brick");
    return *it;
}

/// The first cell of the tree of bounds that is divided.
std::size_t divided_bound(const ModelData& m)
{
    const auto& bounds = m.distance.bounds;
    const auto it = std::find_if(bounds.begin(), bounds.end(), [](std::uint16_t b) { return (b & model::k_bound_leaf) == 0; });
    if (it == bounds.end()) throw std::logic_error("the tree has no divided cell");
    return static_cast<std::size_t>(it - bounds.begin());
}

const Lie k_lies[] = {
    {"no_parts", [](ModelData& m) { m.parts.clear(); }},
    {"origin_nan", [](ModelData& m) { m.header.origin[1] = std::numeric_limits<double>::quiet_NaN(); }},
    {"unit_zero", [](ModelData& m) { m.header.unit = 0; }},
    {"unit_negative", [](ModelData& m) { m.header.unit = -1; }},
    {"unit_inf", [](ModelData& m) { m.header.unit = std::numeric_limits<double>::infinity(); }},
    {"r_max_zero", [](ModelData& m) { m.header.r_max = 0; }},
    {"r_max_nan", [](ModelData& m) { m.header.r_max = std::numeric_limits<double>::quiet_NaN(); }},
    {"sphere_nan", [](ModelData& m) { m.header.sphere[3] = k_nan; }},
    {"sphere_radius_negative", [](ModelData& m) { m.header.sphere[3] = -1; }},
    {"projection_unknown", [](ModelData& m) { m.header.projection = 2; }},
    {"projection_of_a_paper_model", [](ModelData& m) { m.header.projection = 1; }},
    {"part_without_a_central_map", [](ModelData& m) { m.parts[0].base = 0; }},
    {"quantisation_nan", [](ModelData& m) { m.header.quantisation = std::numeric_limits<double>::quiet_NaN(); }},
    {"a_zero", [](ModelData& m) { m.parts[0].a[0] = 0; }},
    {"a_negative", [](ModelData& m) { m.parts[0].a[2] = -m.parts[0].a[2]; }},
    {"a_nan", [](ModelData& m) { m.parts[0].a[1] = k_nan; }},
    {"eps_below_range", [](ModelData& m) { m.parts[0].eps[0] = 0.05f; }},
    {"eps_above_range", [](ModelData& m) { m.parts[0].eps[1] = 2.1f; }},
    {"eps_nan", [](ModelData& m) { m.parts[0].eps[0] = k_nan; }},
    {"eps_negative", [](ModelData& m) { m.parts[0].eps[1] = -1; }},
    {"rotation_inf", [](ModelData& m) { m.parts[0].rotation[4] = k_inf; }},
    {"rotation_not_a_rotation", [](ModelData& m) { m.parts[0].rotation[4] *= 1.5f, m.parts[0].rotation[0] += 0.5f; }},
    {"translation_nan", [](ModelData& m) { m.parts[0].translation[0] = k_nan; }},
    {"taper_beyond_range", [](ModelData& m) { m.parts[0].taper[0] = 1.5f; }},
    {"taper_nan", [](ModelData& m) { m.parts[0].taper[1] = k_nan; }},
    {"bend_inf", [](ModelData& m) { m.parts[0].bend = k_inf; }},
    {"bend_negative", [](ModelData& m) { m.parts[0].bend = -1; }},
    {"certificate_nan", [](ModelData& m) { m.parts[0].largest_f = k_nan; }},
    {"part_sphere_nan", [](ModelData& m) { m.parts[0].sphere[0] = k_nan; }},
    {"part_sphere_negative", [](ModelData& m) { m.parts[0].sphere[3] = -0.5f; }},
    {"chart_rows_not_orthogonal", [](ModelData& m) { m.parts[0].chart_rows[1] += 0.5f; }},
    {"chart_rows_nan", [](ModelData& m) { m.parts[0].chart_rows[8] = k_nan; }},
    {"chart_centre_inf", [](ModelData& m) { m.parts[0].chart_centre[0] = -k_inf; }},
    {"chart_box_empty", [](ModelData& m) { m.parts[0].chart_lo[0] = m.parts[0].chart_hi[0]; }},
    {"w_step_zero", [](ModelData& m) { m.parts[0].w_step = 0; }},
    {"w_step_negative", [](ModelData& m) { m.parts[0].w_step = -m.parts[0].w_step; }},
    {"w_min_negative", [](ModelData& m) { m.parts[0].w_min = -0.1f; }},
    {"w_range_overflows", [](ModelData& m) { m.parts[0].w_step = 1e36f; }},
    {"area_nan", [](ModelData& m) { m.parts[0].area = k_nan; }},
    {"centre_winding_huge", [](ModelData& m) { m.parts[0].centre_winding = std::numeric_limits<std::int32_t>::min(); }},
    {"base_zero", [](ModelData& m) { m.parts[0].base = 0; }},
    {"base_not_of_blocks", [](ModelData& m) { m.parts[0].base += 1; }},
    {"base_doubled", [](ModelData& m) { m.parts[0].base *= 2; }},
    {"base_huge", [](ModelData& m) { m.parts[0].base = 0xfffffffcu; }},
    {"sample_count_short", [](ModelData& m) { --m.parts[0].samples.count; }},
    {"samples_beyond_end", [](ModelData& m) { m.parts.back().samples.first += 1; }},
    {"samples_wrap_around", [](ModelData& m) { m.parts[0].samples.first = 0xffffffffu; }},
    {"samples_missing", [](ModelData& m) { m.samples.pop_back(); }},
    {"cell_count_long", [](ModelData& m) { ++m.parts[0].cells.count; }},
    {"cells_beyond_end", [](ModelData& m) { m.parts.back().cells.first += 1; }},
    {"cells_missing", [](ModelData& m) { m.cells.clear(); }},
    {"block_count_short", [](ModelData& m) { --m.parts[0].blocks.count; }},
    {"blocks_beyond_end", [](ModelData& m) { m.parts.back().blocks.first += 1; }},
    {"splits_beyond_end", [](ModelData& m) { m.parts.back().splits.first += 1; }},
    {"splits_missing", [](ModelData& m) { m.splits.clear(); }},
    {"splits_cut", [](ModelData& m) { m.splits.pop_back(); }},
    {"specials_beyond_end", [](ModelData& m) { m.parts.back().specials.first += 1; }},
    {"specials_wrap_around", [](ModelData& m) { m.parts[0].specials.first = 0xfffffff0u; }},
    {"specials_missing", [](ModelData& m) { m.specials.clear(); }},
    {"pool_beyond_end", [](ModelData& m) { m.parts.back().pool.first += 1; }},
    {"pool_missing", [](ModelData& m) { m.pool.clear(); }},
    {"special_points_behind_pool", [](ModelData& m) { m.specials[0] = m.parts[0].pool.count; }},
    {"special_points_far_away", [](ModelData& m) { m.specials[0] = 0xffffffffu; }},
    {"uniform_payload", [](ModelData& m) { m.cells[0] = cell_of(model::CellKind::Uniform, 2); }},
    {"single_payload", [](ModelData& m) { m.cells[0] = cell_of(model::CellKind::Single, 2 * model::CentralCell::k_foreign); }},
    {"split_payload", [](ModelData& m) { m.cells[0] = cell_of(model::CellKind::Split, m.parts[0].splits.count); }},
    {"layered_payload", [](ModelData& m) { m.cells[0] = cell_of(model::CellKind::Layered, 0x3fff); }},
    {"split_child_payload", [](ModelData& m) { split_child(m, 3) = cell_of(model::CellKind::Layered, 0x3fff); }},
    {"split_of_itself",
     [](ModelData& m) {
         // Every cell of the part is this one split, and so are its children: endless if nobody counted.
         model::Part& p = m.parts[0];
         for (std::uint32_t i = 0; i < p.cells.count; ++i)
             if (const model::CentralCell cell{m.cells[p.cells.first + i]}; cell.kind() == model::CellKind::Split) {
                 const std::size_t record = model::k_split_size * (p.splits.first + std::size_t(cell.payload()));
                 for (std::uint32_t k = 0; k < 4; ++k) m.splits[record + model::k_split_cells + k] = cell.word;
                 return;
             }
         throw std::logic_error("the model has no split cell");
     }},
    {"layered_record_behind_pool",
     [](ModelData& m) {
         model::Part& p = m.parts[0];
         const std::uint32_t last = p.pool.count - 1;
         m.specials[p.specials.first] = last;
         m.pool[p.pool.first + last] = 15;
         m.cells[p.cells.first] = cell_of(model::CellKind::Layered, 0);
     }},
    {"vertex_nan", [](ModelData& m) { m.vertices[7] = k_nan; }},
    {"vertex_inf", [](ModelData& m) { m.vertices.back() = k_inf; }},
    {"vertices_not_by_three", [](ModelData& m) { m.vertices.push_back(0); }},
    {"vertices_missing", [](ModelData& m) { m.vertices.clear(); }},
    {"triangle_index", [](ModelData& m) { m.triangles16[5] = static_cast<std::uint16_t>(m.vertices.size() / 3); }},
    {"triangles_not_by_three", [](ModelData& m) { m.triangles16.pop_back(); }},
    {"triangles_of_both_widths", [](ModelData& m) { m.triangles32.assign(3, 0); }},
    {"triangle_part_missing_one", [](ModelData& m) { m.triangle_part.pop_back(); }},
    {"triangle_of_no_part", [](ModelData& m) { m.triangle_part[0] = static_cast<std::uint16_t>(m.parts.size()); }},
    {"locator_origin_nan", [](ModelData& m) { m.locator.origin[2] = k_nan; }},
    {"locator_origin_inf", [](ModelData& m) { m.locator.origin[0] = -k_inf; }},
    {"locator_cell_nan", [](ModelData& m) { m.locator.cell = k_nan; }},
    {"locator_cell_inf", [](ModelData& m) { m.locator.cell = k_inf; }},
    {"locator_cell_zero", [](ModelData& m) { m.locator.cell = 0; }},
    {"locator_cell_negative", [](ModelData& m) { m.locator.cell = -m.locator.cell; }},
    {"locator_bricks_zero", [](ModelData& m) { m.locator.bricks[1] = 0; }},
    {"locator_bricks_one_more", [](ModelData& m) { ++m.locator.bricks[2]; }},
    {"locator_bricks_wrap_around", [](ModelData& m) { m.locator.bricks[0] += 0x80000000u; }},
    {"locator_bricks_huge",
     [](ModelData& m) {
         // As many as are stored, in a row that is longer than a column of cells may be.
         m.locator.bricks[0] = 300;
         m.locator.bricks[1] = m.locator.bricks[2] = 1;
         m.bricks.assign(300, m.bricks.front());
     }},
    {"locator_header_without_bricks",
     [](ModelData& m) {
         m.bricks.clear();
         m.locator_cells.clear();
         m.part_lists.clear();
         m.planes.clear();
         m.seeds.clear();
     }},
    {"cells_without_bricks",
     [](ModelData& m) {
         m.bricks.clear();
         m.locator = {};
     }},
    {"seeds_without_bricks",
     [](ModelData& m) {
         m.bricks.clear();
         m.locator_cells.clear();
         m.part_lists.clear();
         m.locator = {};
     }},
    {"bricks_missing_one", [](ModelData& m) { m.bricks.pop_back(); }},
    {"brick_beyond_cells", [](ModelData& m) { stored_brick(m) = static_cast<std::uint32_t>(m.locator_cells.size() - 63); }},
    {"brick_far_away", [](ModelData& m) { stored_brick(m) = 0x3fffffffu; }},
    {"deep_brick_beyond_cells",
     [](ModelData& m) { stored_brick(m) = model::LocatorBrick::k_deep | static_cast<std::uint32_t>(m.locator_cells.size()); }},
    {"deep_brick_far_away", [](ModelData& m) { stored_brick(m) = 0x7fffffffu; }},
    {"deep_brick_of_a_free_cell",
     [](ModelData& m) {
         // The reader takes what a deep brick holds for occupied, so that a free cell's gap would be an index of seeds.
         m.locator_cells.push_back(0xfffffffcu);
         stored_brick(m) = model::LocatorBrick::k_deep | static_cast<std::uint32_t>(m.locator_cells.size() - 1);
     }},
    {"eighths_beyond_cells",
     [](ModelData& m) {
         std::uint32_t& cell = occupied_cell(m);
         cell = model::LocatorCell::divided(static_cast<std::uint32_t>(m.locator_cells.size() - 7)).word;
     }},
    {"eighths_of_their_own_eighth",
     [](ModelData& m) {
         std::uint32_t& cell = occupied_cell(m);
         cell = model::LocatorCell::divided(static_cast<std::uint32_t>(&cell - m.locator_cells.data())).word;
     }},
    {"bounds_missing_one", [](ModelData& m) { m.distance.bounds.pop_back(); }},
    {"bounds_missing_eight", [](ModelData& m) { m.distance.bounds.resize(m.distance.bounds.size() - 8); }},
    {"bounds_beyond_end", [](ModelData& m) { m.distance.bounds[0] = 0x7fff; }},
    {"bounds_that_go_around", [](ModelData& m) { m.distance.bounds[divided_bound(m)] = 0; }},
    {"bounds_of_themselves",
     [](ModelData& m) {
         const std::size_t at = divided_bound(m);
         m.distance.bounds[at] = static_cast<std::uint16_t>(at / 8);
     }},
    {"bounds_root_nan", [](ModelData& m) { m.distance.header.root[1] = k_nan; }},
    {"bounds_half_zero", [](ModelData& m) { m.distance.header.half = 0; }},
    {"bounds_half_inf", [](ModelData& m) { m.distance.header.half = k_inf; }},
    {"input_of_both_kinds",
     [](ModelData& m) { m.input.coordinates32.assign(m.input.coordinates64.begin(), m.input.coordinates64.end()); }},
    {"input_missing_one", [](ModelData& m) { m.input.coordinates64.pop_back(); }},
    {"input_elsewhere", [](ModelData& m) { m.input.coordinates64[7] += 1e-5 * m.header.unit; }},
    {"input_nan", [](ModelData& m) { m.input.coordinates64[7] = static_cast<double>(k_nan); }},
    {"input_without_numbers", [](ModelData& m) { m.input.source_triangle.clear(); }},
    {"input_vertex_numbers_missing_one", [](ModelData& m) { m.input.source_vertex.pop_back(); }},
    {"band_negative", [](ModelData& m) { m.distance.header.band = -1; }},
    {"band_nan", [](ModelData& m) { m.distance.header.band = k_nan; }},
    {"hierarchy_entries_more", [](ModelData& m) { m.distance.header.entries += model::k_hierarchy_leaf; }},
    {"hierarchy_entries_none", [](ModelData& m) { m.distance.header.entries = 0; }},
    {"hierarchy_entries_huge", [](ModelData& m) { m.distance.header.entries = 0xffffffffu; }},
    {"hierarchy_entries_missing", [](ModelData& m) { m.distance.entries16.clear(); }},
    {"hierarchy_entries_missing_some", [](ModelData& m) { m.distance.entries16.pop_back(); }},
    {"hierarchy_entries_twice",
     [](ModelData& m) { m.distance.entries32.assign(m.distance.entries16.begin(), m.distance.entries16.end()); }},
    {"hierarchy_entry_of_no_triangle", [](ModelData& m) { m.distance.entries16.back() = 0xffff; }},
    {"hierarchy_groups_missing_one", [](ModelData& m) { m.distance.groups.pop_back(); }},
    {"hierarchy_group_origin_nan", [](ModelData& m) { m.distance.groups[0].origin[2] = k_nan; }},
    {"hierarchy_group_step_zero", [](ModelData& m) { m.distance.groups[0].step = 0; }},
    {"hierarchy_nodes_missing", [](ModelData& m) { m.distance.nodes.clear(); }},
    {"hierarchy_nodes_one_more", [](ModelData& m) { m.distance.nodes.push_back(m.distance.nodes.back()); }},
    {"hierarchy_node_origin_inf", [](ModelData& m) { m.distance.nodes[0].origin[0] = k_inf; }},
    {"hierarchy_node_step_nan", [](ModelData& m) { m.distance.nodes[0].step = k_nan; }},
    {"hierarchy_without_a_mesh",
     [](ModelData& m) {
         m.vertices.clear();
         m.triangles16.clear();
         m.triangle_part.clear();
         m.near_bricks.clear();
         m.near.clear();
         m.rises.clear();
     }},
    {"polytope_sides_missing", [](ModelData& m) { m.polytope_sides.clear(); }},
    {"polytope_ends_missing_one", [](ModelData& m) { m.polytope_ends.pop_back(); }},
    {"polytope_that_ends_before_it_begins", [](ModelData& m) { m.polytope_ends[0] = m.polytope_ends[1] + 1; }},
    {"polytope_beyond_end", [](ModelData& m) { m.polytope_ends.back() += 1; }},
    {"polytope_of_too_many_sides",
     [](ModelData& m) {
         m.polytope_sides.insert(m.polytope_sides.end(), 65, m.polytope_sides.front());
         m.polytope_ends.back() += 65;
     }},
    {"polytope_side_of_no_number", [](ModelData& m) { m.polytope_sides[3].offset = k_nan; }},
    {"polytope_side_of_no_direction", [](ModelData& m) { m.polytope_sides[3].normal = {0, 0, 0}; }},
    {"bound_figures_missing_one", [](ModelData& m) { m.bound_figures.pop_back(); }},
    {"bound_figures_of_no_number", [](ModelData& m) { m.bound_figures[0].volume[1] = k_inf; }},
    {"near_missing", [](ModelData& m) { m.near.clear(); }},
    {"near_bricks_missing", [](ModelData& m) { m.near_bricks.clear(); }},
    {"near_bricks_missing_one", [](ModelData& m) { m.near_bricks.pop_back(); }},
    {"near_brick_of_no_record", [](ModelData& m) { stored_near(m) = model::k_no_candidates; }},
    {"near_brick_beyond_end", [](ModelData& m) { stored_near(m) = static_cast<std::uint32_t>(m.near.size() - 2); }},
    {"near_record_of_other_cells", [](ModelData& m) { m.near[stored_near(m)] ^= 1; }},
    {"near_list_that_ends_before_it_begins", [](ModelData& m) { m.near[stored_near(m) + model::CandidateRecord::k_head + 1] = 0xffff; }},
    {"near_list_beyond_end",
     [](ModelData& m) {
         for (std::size_t i = stored_near(m) + model::CandidateRecord::k_head; i < m.near.size(); ++i) m.near[i] = 0xffff;
     }},
    {"near_triangles_beyond_end", [](ModelData& m) { m.near[stored_near(m) + 4] = 0xffff; }},
    {"near_list_of_other_triangles", [](ModelData& m) { first_list(m)[0] ^= 1; }},
    {"near_list_without_triangles", [](ModelData& m) { first_list(m)[1] = 0; }},
    {"near_list_of_no_table", [](ModelData& m) { last_word(m) = 0xffff; }},
    {"near_triangle_that_is_none",
     [](ModelData& m) {
         const model::CandidateRecord r = model::candidate_record(m.near.data() + stored_near(m), false);
         m.near[static_cast<std::size_t>(r.table - m.near.data())] = 0xffff;
     }},
    {"locator_cells_missing", [](ModelData& m) { m.locator_cells.clear(); }},
    {"locator_cells_missing_one", [](ModelData& m) { m.locator_cells.pop_back(); }},
    {"cell_list_beyond_end",
     [](ModelData& m) {
         std::uint32_t& cell = occupied_cell(m);
         cell = (cell & ~(0x1ffu << 2)) | static_cast<std::uint32_t>(m.part_lists.size()) << 2;
     }},
    {"cell_seed_beyond_end",
     [](ModelData& m) {
         std::uint32_t& cell = cell_of_a_chain(m);
         cell = (cell & 0x3fffu) | static_cast<std::uint32_t>(m.seeds.size()) << 14;
     }},
    {"cell_planes_beyond_end",
     [](ModelData& m) {
         std::uint32_t& cell = flat_cell(m);
         cell = (cell & 0x3fffu) | static_cast<std::uint32_t>(m.planes.size() - model::LocatorCell{cell}.planes() + 1) << 14;
     }},
    {"planes_missing", [](ModelData& m) { m.planes.clear(); }},
    {"plane_of_no_part",
     [](ModelData& m) { m.planes[model::LocatorCell{flat_cell(m)}.first()] |= 3u << 29; }},
    {"plane_reach_of_nothing", [](ModelData& m) { m.locator.plane_reach = 0; }},
    {"plane_reach_nan", [](ModelData& m) { m.locator.plane_reach = NAN; }},
    {"rises_missing", [](ModelData& m) { m.rises.clear(); }},
    {"rises_missing_some", [](ModelData& m) { m.rises.resize(m.rises.size() - 4); }},
    {"cell_seed_far_away", [](ModelData& m) { occupied_cell(m) |= 0xffffc000u; }},
    {"part_lists_missing", [](ModelData& m) { m.part_lists.clear(); }},
    {"list_of_no_part",
     [](ModelData& m) { m.part_lists[0] = (m.part_lists[0] & 0xffff00ffu) | static_cast<std::uint32_t>(m.parts.size()) << 8; }},
    {"seeds_missing",
     [](ModelData& m) {
         (void)cell_of_a_chain(m);
         m.seeds.clear();
     }},
    {"seed_of_no_part",
     [](ModelData& m) {
         std::uint32_t& direction = m.seeds[model::LocatorCell{cell_of_a_chain(m)}.first()].direction;
         direction = (direction & ~0xffu) | static_cast<std::uint32_t>(m.parts.size());
     }},
    {"seed_chain_without_end",
     [](ModelData& m) {
         (void)cell_of_a_chain(m);
         m.seeds.back().extent &= ~model::k_last_seed;
     }},
    {"seed_chain_too_long",
     [](ModelData& m) {
         const std::uint32_t first = model::LocatorCell{cell_of_a_chain(m)}.first();
         for (std::uint32_t k = 0; k < model::k_max_seeds; ++k) {
             m.seeds[first + k].extent &= ~model::k_last_seed;
             m.seeds[first + k].direction &= ~0xffu;
         }
     }},
    {"seed_choice_beyond_chain", [](ModelData& m) { m.seeds[model::LocatorCell{cell_of_a_chain(m)}.first() - 1].direction |= 7u << 21; }},
    {"seed_chain_without_choices",
     [](ModelData& m) {
         // The chain starts the array, so that nothing stands before it.
         std::uint32_t& cell = cell_of_a_chain(m);
         m.seeds.erase(m.seeds.begin(), m.seeds.begin() + model::LocatorCell{cell}.first());
         const std::uint32_t kept = cell & 0x3fffu;
         for (std::uint32_t& p : m.locator_cells) p = model::LocatorCell{p}.is_free() ? p : kept;
     }},
    {"locator_of_more_parts_than_a_byte_names",
     [](ModelData& m) {
         while (m.parts.size() < 300) m.parts.push_back(m.parts[0]);
     }},
};

INSTANTIATE_TEST_SUITE_P(Format, InconsistentModel, testing::ValuesIn(k_lies),
                         [](const auto& lie) { return std::string(lie.param.name); });

}  // namespace
}  // namespace sqmap::io
