#include "candidate_lists.h"

#include "bake/exact/rise.h"
#include "bake/locator/near_triangles.h"
#include "budget.h"
#include "model/candidate_lists.h"
#include "model/locator_cells.h"
#include "sqmap/parallel/for_each.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>
#include <vector>

namespace sqmap::bake {

namespace {

using model::CandidateRecord;
using model::LocatorBrick;
using model::LocatorCell;
using model::LocatorCellKind;

/// Of a place, or of the eighths that it is divided in.
void set_rises(Rise& rise, model::ModelData& data, std::uint32_t index, Vec3d centre, double h,
               const std::vector<std::uint32_t>& near)
{
    const LocatorCell cell{data.places[index]};
    if (cell.is_divided()) {
        for (std::uint32_t i = 0; i < 8; ++i) {
            const Vec3d offset = 0.5 * h * Vec3d{(i & 1) != 0 ? 1. : -1., (i & 2) != 0 ? 1. : -1., (i & 4) != 0 ? 1. : -1.};
            set_rises(rise, data, cell.first() + i, centre + offset, 0.5 * h, near);
        }
    } else if (cell.kind() == LocatorCellKind::Mixed && cell.is_flat()) {
        data.rises[index] = rise(data, cell, centre, h, near);
    }
}

constexpr double k_least_near_share = 0.4;

/// What is left for the lists.
double near_budget(const model::ModelData& data, double target_error)
{
    const model::ModelView v = data.view();
    const std::size_t others = v.parts.size_bytes() + model::bytes_of<model::CentralArrays<model::ArrayView>>(v) +
                               model::bytes_of<model::MeshArrays<model::ArrayView>>(v) +
                               model::bytes_of<model::LocatorArrays<model::ArrayView>>(v) + v.rises.size_bytes() +
                               4 * v.bricks.size();
    const double all = model_byte_budget(v.triangle_part.size(), target_error);
    // A large map must not take them all.
    return std::max(all - static_cast<double>(others), k_least_near_share * all);
}

/// A brick's record before it is packed: see model::CandidateRecord.
struct Record {
    static constexpr std::uint32_t k_no_place = 0xffffffffu;

    std::uint64_t occupied = 0;
    std::vector<std::uint32_t> starts{0}, triangles, refs;
    std::span<const std::uint16_t> packed{};  ///< or as it was before an update

    /// place_of: #triangles, of those that are in it already; k_no_place for others.
    void add(const std::vector<std::uint32_t>& near, std::vector<std::uint32_t>& place_of)
    {
        // Where a brick's lists are too long, the rest of its places tries all of the brick's triangles.
        const bool room = refs.size() + near.size() <= CandidateRecord::k_max_refs;
        for (const std::uint32_t t : near) {
            if (place_of[t] == k_no_place) {
                place_of[t] = static_cast<std::uint32_t>(triangles.size());
                triangles.push_back(t);
            }
            if (room) refs.push_back(place_of[t]);
        }
        starts.push_back(static_cast<std::uint32_t>(refs.size()));
    }
    model::UnpackedCandidates contents() const { return {occupied, starts, triangles, refs}; }
    std::size_t values(bool wide) const { return packed.empty() ? model::packed_size(contents(), wide) : packed.size(); }
    /// Each place tries all of the brick's triangles.
    void drop_lists(bool wide)
    {
        if (!packed.empty()) {
            const model::CandidateList all = model::candidate_record(packed.data(), wide).all();
            for (std::uint32_t i = 0; i < all.count; ++i) triangles.push_back(all[i]);
            starts.resize(static_cast<std::size_t>(std::popcount(occupied)) + 1);
        }
        packed = {};
        refs.clear();
        std::fill(starts.begin(), starts.end(), 0u);
    }
    /// Each place tries all triangles of the mesh.
    void drop_triangles(bool wide)
    {
        drop_lists(wide);
        triangles.clear();
    }
    void pack(bool wide, std::vector<std::uint16_t>& out) const
    {
        if (!packed.empty()) {
            out.insert(out.end(), packed.begin(), packed.end());
            return;
        }
        const std::size_t first = out.size();
        out.resize(first + values(wide));
        model::pack_candidates(contents(), wide, out.data() + first);
    }
};

/// A brick's record as it is in the model.
std::span<const std::uint16_t> packed_record(const model::ModelView& view, std::size_t brick)
{
    return {view.near.data() + view.near_bricks[brick], model::candidate_record(view, brick).size()};
}

/// Where they take more bytes, the longest bricks' lists go, and then, if that does not do, their triangles.
void keep_within(double budget, bool wide, std::vector<Record>& records)
{
    for (Record& record : records)
        if (record.triangles.size() > CandidateRecord::k_max_triangles) record.drop_triangles(wide);
    for (const bool lists : {true, false}) {
        const auto bytes_of = [&](const Record& r) { return 2.0 * static_cast<double>(r.values(wide)); };
        double bytes = 0;
        std::vector<std::size_t> order;
        for (std::size_t i = 0; i < records.size(); ++i) {
            if (records[i].occupied == 0) continue;
            bytes += bytes_of(records[i]);
            order.push_back(i);
        }
        std::stable_sort(order.begin(), order.end(),
                         [&](std::size_t a, std::size_t b) { return bytes_of(records[a]) > bytes_of(records[b]); });
        for (std::size_t k = 0; k < order.size() && bytes > budget; ++k) {
            Record& record = records[order[k]];
            bytes -= bytes_of(record);
            if (lists)
                record.drop_lists(wide);
            else
                record.drop_triangles(wide);
            bytes += bytes_of(record);
        }
    }
}

/// before, update: null, or what was there, of which places that are not reached keep their lists.
void bake_lists(const mesh::Solid& solid, const model::ModelView* before, const LocatorUpdate* update, double target_error,
                unsigned threads, model::ModelData& data)
{
    data.near_bricks.clear();
    data.near.clear();
    if (data.bricks.empty() || data.triangle_part.empty()) {
        data.rises.clear();
        return;
    }
    const model::Locator& l = data.locator;
    const bool wide = model::has_wide_candidates(data.triangle_part.size());
    std::vector<Record> records(data.bricks.size());
    parallel::for_each(data.bricks.size(), threads, [&](std::size_t b) {
        const LocatorBrick brick{data.bricks[b]};
        if (brick.is_free()) return;
        thread_local NearTriangles near_triangles;  // keeps its room
        Rise rise(solid);
        constexpr int n = model::k_brick;
        const double cell = static_cast<double>(l.cell);
        const Vec3d origin = cast<double>(model::vec3(l.origin));
        const Vec3d lowest = origin + n * cell *
                                          Vec3d{double(b % l.bricks[0]), double(b / l.bricks[0] % l.bricks[1]),
                                                double(b / (std::size_t{l.bricks[0]} * l.bricks[1]))};
        const bool deep = brick.is_deep();
        Record& record = records[b];
        std::vector<Vec3d> centres, group_centres;
        std::vector<std::uint32_t> places, numbers, kept;
        std::vector<std::size_t> group;
        std::vector<std::vector<std::uint32_t>> lists;
        std::vector<const std::vector<std::uint32_t>*> known;
        const std::uint32_t was = update != nullptr ? update->brick_before[b] : LocatorUpdate::k_no_brick;
        const std::uint64_t reached = was == LocatorUpdate::k_no_brick ? ~std::uint64_t{0} : update->reached[b];
        if (reached == 0) {
            record.occupied = model::candidate_record(*before, was).occupied;
            record.packed = packed_record(*before, was);
            return;
        }
        const double half = deep ? 0.5 * n * cell : 0.5 * cell;
        const Vec3d middle = lowest + 0.5 * n * cell * Vec3d{1, 1, 1};
        for (int k = 0; k < static_cast<int>(brick.cell_count()); ++k) {
            const std::uint32_t place = brick.first() + static_cast<std::uint32_t>(k);
            if (LocatorCell{data.places[place]}.is_free()) continue;
            record.occupied |= std::uint64_t{1} << k;
            places.push_back(place);
            numbers.push_back(static_cast<std::uint32_t>(k));
            if ((reached >> k & 1u) == 0) continue;
            if (update != nullptr && !update->near[b].empty()) known.push_back(&update->near[b][static_cast<std::size_t>(k)]);
            centres.push_back(deep ? middle : lowest + cell * Vec3d{k % n + 0.5, k / n % n + 0.5, k / (n * n) + 0.5});
        }
        // Eight places at a time: what can be nearest somewhere in the whole brick is four times as many.
        lists.resize(centres.size());
        for (std::uint32_t octant = 0; octant < 8; ++octant) {
            group.clear();
            group_centres.clear();
            Vec3d lo{INFINITY, INFINITY, INFINITY}, hi = -lo;
            for (std::size_t i = 0; i < centres.size(); ++i) {
                const Vec3d d = centres[i] - middle;
                if (!deep && ((d.x > 0 ? 1u : 0u) | (d.y > 0 ? 2u : 0u) | (d.z > 0 ? 4u : 0u)) != octant) continue;
                if (deep && octant > 0) continue;
                if (!known.empty() && !known[i]->empty()) {
                    lists[i] = *known[i];
                    continue;
                }
                group.push_back(i);
                group_centres.push_back(centres[i]);
                for (int k = 0; k < 3; ++k) {
                    lo[k] = std::min(lo[k], centres[i][k]);
                    hi[k] = std::max(hi[k], centres[i][k]);
                }
            }
            if (group.empty()) continue;
            const double side = std::max({hi.x - lo.x, hi.y - lo.y, hi.z - lo.z});
            const Vec3d group_middle = 0.5 * (lo + hi);
            near_triangles.begin(solid, group_middle, k_near_slack * (0.5 * side + half), group_centres,
                                 solid.closest_boundary(group_middle).distance);
            for (std::size_t i = 0; i < group.size(); ++i)
                lists[group[i]] = near_triangles(i, group_centres[i], k_near_slack * half, update == nullptr);
        }
        // A brick whose lists were too long to keep has none to take over, and gets none.
        bool no_lists = false, no_triangles = false;
        if (was != LocatorUpdate::k_no_brick && before->near_bricks[was] != model::k_no_candidates &&
            reached != ~std::uint64_t{0}) {
            const CandidateRecord r = model::candidate_record(*before, was);
            no_lists = r.ref_count() == 0;
            no_triangles = r.triangles == 0;
        }
        std::vector<std::uint32_t> place_of(data.triangle_part.size(), Record::k_no_place);
        for (std::size_t i = 0, fresh = 0; i < places.size(); ++i) {
            if ((reached >> numbers[i] & 1u) == 0) {
                const model::CandidateList list = model::candidate_list(*before, was, numbers[i]);
                kept.clear();
                for (std::uint32_t j = 0; j < list.count; ++j) kept.push_back(list[j]);
                record.add(kept, place_of);
                continue;
            }
            const std::vector<std::uint32_t>& near = lists[fresh];
            set_rises(rise, data, places[i], centres[fresh], k_near_slack * half, near);
            record.add(near, place_of);
            ++fresh;
        }
        if (no_lists) record.drop_lists(wide);
        if (no_triangles) record.drop_triangles(wide);
    });
    keep_within(near_budget(data, target_error), wide, records);
    for (std::size_t b = 0; b < records.size(); ++b) {
        const bool free = LocatorBrick{data.bricks[b]}.is_free();
        data.near_bricks.push_back(free ? model::k_no_candidates : static_cast<std::uint32_t>(data.near.size()));
        if (!free) records[b].pack(wide, data.near);
    }
}

}  // namespace

void bake_candidate_lists(const mesh::Solid& solid, double target_error, unsigned threads, model::ModelData& data)
{
    bake_lists(solid, nullptr, nullptr, target_error, threads, data);
}

void update_candidate_lists(const mesh::Solid& solid, const model::ModelView& before, const LocatorUpdate& update,
                            double target_error, unsigned threads, model::ModelData& data)
{
    bake_lists(solid, &before, &update, target_error, threads, data);
}

}  // namespace sqmap::bake
