#include "key_table.h"

namespace sqmap::mesh {

std::size_t KeyTable::slot_of(LatticePoint p) const
{
    std::uint64_t h = 0;
    for (const std::int32_t c : p) h = (h ^ static_cast<std::uint32_t>(c)) * 0x9e3779b97f4a7c15ull;
    h ^= h >> 29;
    std::size_t slot = h & (slots_.size() - 1);
    while (slots_[slot] != k_absent && points_[slots_[slot]] != p) slot = (slot + 1) & (slots_.size() - 1);
    return slot;
}

void KeyTable::grow()
{
    slots_.assign(slots_.empty() ? 1024 : 2 * slots_.size(), k_absent);
    for (std::uint32_t i = 0; i < points_.size(); ++i) slots_[slot_of(points_[i])] = i;
}

std::uint32_t KeyTable::insert(LatticePoint p)
{
    if (2 * points_.size() >= slots_.size()) grow();
    std::uint32_t& slot = slots_[slot_of(p)];
    if (slot == k_absent) {
        slot = size();
        points_.push_back(p);
    }
    return slot;
}

std::uint32_t KeyTable::find(LatticePoint p) const { return slots_.empty() ? k_absent : slots_[slot_of(p)]; }

}  // namespace sqmap::mesh
