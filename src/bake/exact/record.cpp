#include "record.h"

#include <algorithm>
#include <bit>

namespace sqmap::bake {

BrickRecord::BrickRecord(const model::ModelView& model, std::size_t brick)
{
    const model::CandidateRecord record = model::candidate_record(model, brick);
    wide_ = record.wide;
    occupied_ = record.occupied;
    packed_ = {model.near.data() + model.near_bricks[brick], record.size()};
}

void BrickRecord::add(std::uint32_t cell, std::span<const std::uint32_t> triangles, Numbers& numbers)
{
    occupied_ |= std::uint64_t{1} << cell;
    const std::size_t first = refs_.size();
    for (const std::uint32_t t : triangles) {
        std::uint32_t& number = numbers.of_[t];
        if (number == Numbers::k_none) {
            number = static_cast<std::uint32_t>(triangles_.size());
            triangles_.push_back(t);
            numbers.numbered_.push_back(t);
        }
        refs_.push_back(number);
    }
    std::sort(refs_.begin() + static_cast<std::ptrdiff_t>(first), refs_.end());
    list_values_ += model::list_size(std::span(refs_).subspan(first), model::CandidateRecord::k_max_triangles);
    if (list_values_ > model::CandidateRecord::k_max_list_values) refs_.resize(first);
    starts_.push_back(static_cast<std::uint32_t>(refs_.size()));
}

double BrickRecord::bytes() const
{
    return 2.0 * static_cast<double>(packed_.empty() ? model::packed_size(contents(), wide_) : packed_.size());
}

void BrickRecord::drop_lists()
{
    if (!packed_.empty()) {
        const model::CandidateList all = model::candidate_record(packed_.data(), wide_).all();
        all.each([&](std::uint32_t t) { triangles_.push_back(t); });
        starts_.resize(static_cast<std::size_t>(std::popcount(occupied_)) + 1);
    }
    packed_ = {};
    refs_.clear();
    std::fill(starts_.begin(), starts_.end(), 0u);
}

void BrickRecord::drop_triangles()
{
    drop_lists();
    triangles_.clear();
}

void BrickRecord::pack(std::vector<std::uint16_t>& out) const
{
    if (!packed_.empty()) {
        out.insert(out.end(), packed_.begin(), packed_.end());
        return;
    }
    const std::size_t first = out.size();
    out.resize(first + model::packed_size(contents(), wide_));
    model::pack_candidates(contents(), wide_, out.data() + first);
}

void keep_within(double bytes, std::vector<BrickRecord>& records)
{
    for (BrickRecord& record : records)
        if (record.triangle_count() > model::CandidateRecord::k_max_triangles) record.drop_triangles();
    for (const bool lists : {true, false}) {
        double all = 0;
        std::vector<std::size_t> order;
        for (std::size_t i = 0; i < records.size(); ++i) {
            if (!records[i].is_occupied()) continue;
            all += records[i].bytes();
            order.push_back(i);
        }
        std::stable_sort(order.begin(), order.end(),
                         [&](std::size_t a, std::size_t b) { return records[a].bytes() > records[b].bytes(); });
        for (std::size_t k = 0; k < order.size() && all > bytes; ++k) {
            BrickRecord& record = records[order[k]];
            all -= record.bytes();
            if (lists)
                record.drop_lists();
            else
                record.drop_triangles();
            all += record.bytes();
        }
    }
}

}  // namespace sqmap::bake
