#include "draft.h"

#include "sqmap/mesh/error.h"

#include <algorithm>
#include <map>
#include <optional>

namespace sqmap::bake {

using model::LocatorBrick;
using model::LocatorCell;
using model::LocatorCellKind;
using model::LocatorPlane;

namespace {

class Packer {
public:
    explicit Packer(model::ModelData& data) : data_(data), cell_(static_cast<double>(data.locator.cell))
    {
        data_.bricks.clear();
        data_.locator_cells.clear();
        data_.part_lists.clear();
        data_.planes.clear();
        data_.seeds.clear();
        data_.rises.clear();
        CellDraft any;
        any.parts[0] = 0;
        (void)list_index(any);  // so that there is one
    }

    void run(std::span<const BrickDraft> bricks)
    {
        for (const BrickDraft& brick : bricks) {
            const auto first = static_cast<std::uint32_t>(data_.locator_cells.size());
            if (brick.kind == BrickDraft::Kind::Free) {
                data_.bricks.push_back(LocatorBrick::free(model::encode_gap(brick.cells.front().gap, cell_)).word);
                continue;
            }
            const bool deep = brick.kind == BrickDraft::Kind::Deep;
            data_.bricks.push_back((deep ? LocatorBrick::deep(first) : LocatorBrick::stored(first)).word);
            for (const CellDraft& cell : brick.cells) add(cell);
        }
        // The eighths of divided cells, behind everything else.
        std::size_t at = 0;
        for (const BrickDraft& brick : bricks) {
            if (brick.kind == BrickDraft::Kind::Free) continue;
            for (const CellDraft& cell : brick.cells) add_eighths(at++, cell);
        }
        data_.rises.resize(model::padded_rises(data_.locator_cells.size()), model::k_no_rise);
    }

private:
    void add_eighths(std::size_t at, const CellDraft& cell)
    {
        if (cell.eighths.empty()) return;
        const std::size_t first = data_.locator_cells.size();
        if (first > model::k_max_first)
            throw mesh::InvalidInput("the locator needs more cells than it can name: use a larger target error");
        data_.locator_cells[at] = LocatorCell::divided(static_cast<std::uint32_t>(first)).word;
        for (const CellDraft& eighth : cell.eighths) add(eighth);
        for (std::size_t e = 0; e < cell.eighths.size(); ++e) add_eighths(first + e, cell.eighths[e]);
    }

    void add(const CellDraft& cell)
    {
        data_.locator_cells.push_back(word_of(cell));
        data_.rises.push_back(cell.rise);
    }

    std::uint32_t word_of(const CellDraft& cell)
    {
        if (cell.kind == LocatorCellKind::Free) return LocatorCell::free(model::encode_gap(cell.gap, cell_)).word;
        if (!cell.eighths.empty()) return 0;  // see add_eighths
        const std::optional<std::uint32_t> list = list_index(cell);
        const auto planes = static_cast<std::uint32_t>(cell.planes.size());
        const auto first = static_cast<std::uint32_t>(planes > 0 ? data_.planes.size() : add_chain(cell));
        if (first > model::k_max_first)
            throw mesh::InvalidInput("the locator needs more planes than a cell can name: use a larger target error");
        // Too many lists for one more: all parts are tried, and a plane's part may be another.
        const std::uint32_t index = list.value_or(0);
        for (const PartPlane& p : cell.planes) {
            std::uint32_t slot = model::k_list_length;
            for (std::uint32_t k = model::k_list_length; k-- > 0;)
                if (model::part_in_list(data_.part_lists[index], k) == p.part) slot = k;
            data_.planes.push_back(p.plane.with_slot(slot < model::k_list_length ? slot : 0u).word);
        }
        return LocatorCell::flat(list ? cell.kind : LocatorCellKind::Ambiguous, index, planes, first).word;
    }

    /// The index of a list of the cell's parts, and behind them the parts of its planes, which decide no verdict.
    std::optional<std::uint32_t> list_index(const CellDraft& cell)
    {
        model::PartList parts = cell.parts;
        for (const PartPlane& p : cell.planes) {
            const auto part = static_cast<std::uint8_t>(p.part);
            const auto at = std::find_if(parts.begin(), parts.end(), [&](auto q) { return q == part || q == model::k_no_part; });
            if (at != parts.end()) *at = part;
        }
        const std::uint32_t list = model::encode_list(parts);
        if (const auto found = lists_.find(list); found != lists_.end()) return found->second;
        if (lists_.size() == model::k_max_lists) return std::nullopt;
        const auto index = static_cast<std::uint32_t>(lists_.size());
        lists_.emplace(list, index);
        data_.part_lists.push_back(list);
        return index;
    }

    /// Returns the index of its first seed.
    std::size_t add_chain(const CellDraft& cell)
    {
        auto& seeds = data_.seeds;
        if (cell.seeds.size() > 1) seeds.push_back({cell.choices, 0});
        const std::size_t first = seeds.size();
        seeds.insert(seeds.end(), cell.seeds.begin(), cell.seeds.end());
        seeds.back() = model::as_last(seeds.back());
        return first;
    }

    model::ModelData& data_;
    double cell_;
    std::map<std::uint32_t, std::uint32_t> lists_;  ///< word of a list -> its index
};

/// The gap that a code stands for, to within a step. Packing it again gives the same code.
double gap_of(const model::ModelData& data, std::uint32_t code)
{
    return (code + 0.5) * static_cast<double>(model::k_gap_step) * static_cast<double>(data.locator.cell);
}

CellDraft unpacked(const model::ModelData& data, std::size_t index)
{
    const LocatorCell cell{data.locator_cells[index]};
    CellDraft draft;
    draft.kind = cell.kind();
    if (cell.is_free()) {
        draft.gap = gap_of(data, cell.gap());
        return draft;
    }
    if (cell.is_divided()) {
        for (std::uint32_t e = 0; e < 8; ++e) draft.eighths.push_back(unpacked(data, cell.first() + e));
        return draft;
    }
    draft.parts = model::decode_list(data.part_lists[cell.list()]);
    if (!data.rises.empty()) draft.rise = data.rises[index];
    for (std::uint32_t k = 0; k < cell.planes(); ++k) {
        const LocatorPlane plane{data.planes[cell.first() + k]};
        draft.planes.push_back({plane.with_slot(0), draft.parts[plane.slot()]});
    }
    if (!draft.planes.empty()) return draft;
    std::uint32_t at = cell.first();
    do draft.seeds.push_back(model::as_not_last(data.seeds[at]));
    while (!model::is_last_seed(data.seeds[at++]));
    if (draft.seeds.size() > 1) draft.choices = data.seeds[cell.first() - 1].direction;
    return draft;
}

}  // namespace

void pack(std::span<const BrickDraft> bricks, model::ModelData& data) { Packer(data).run(bricks); }

std::vector<BrickDraft> unpack(const model::ModelData& data)
{
    std::vector<BrickDraft> bricks;
    for (const std::uint32_t word : data.bricks) {
        const LocatorBrick brick{word};
        BrickDraft& to = bricks.emplace_back();
        if (brick.is_free()) {
            to.kind = BrickDraft::Kind::Free;
            to.cells.emplace_back().gap = gap_of(data, brick.gap());
            continue;
        }
        to.kind = brick.is_deep() ? BrickDraft::Kind::Deep : BrickDraft::Kind::Stored;
        for (std::uint32_t k = 0; k < brick.cell_count(); ++k) to.cells.push_back(unpacked(data, brick.first() + k));
    }
    return bricks;
}

std::size_t packed_bytes(const model::ModelData& data) { return model::bytes_of<model::LocatorArrays<model::ArrayData>>(data); }

}  // namespace sqmap::bake
