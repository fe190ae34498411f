// A baked map seen through a view, and packed behind those of other parts.
#include "sqmap/paper/bake.h"

#include <cstddef>
#include <cstdint>

namespace sqmap::paper {

MapView Map::view() const
{
    MapView v;
    static_cast<MapGrid&>(v) = *this;
    v.superquadric = superquadric;
    MapArrays<model::ArrayView>::each([](const char*, auto& span, const auto& array) { span = array; }, v, *this);
    return v;
}

std::size_t Map::stored_bytes() const
{
    return sizeof(superquadric) + 8 * sizeof(std::uint32_t) + model::bytes_of<MapArrays<model::ArrayData>>(*this);
}

void append_map(const Map& m, ModelMaps<model::ArrayData>& all)
{
    MapRecord& record = all.records.emplace_back();
    record.grid = m;
    const auto behind = [](const char*, model::Slice& slice, const auto& some, auto& array) {
        slice = {static_cast<std::uint32_t>(array.size()), static_cast<std::uint32_t>(some.size())};
        array.insert(array.end(), some.begin(), some.end());
    };
    MapArrays<model::ArrayData>::each(behind, record.slices, m, all);
}

}  // namespace sqmap::paper
