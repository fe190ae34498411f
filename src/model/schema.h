// The fields of sqmap.fbs by name.
#pragma once

#include "sqmap_generated.h"

#include <cstddef>
#include <string_view>

namespace sqmap::model {

/// Number of a field in its table; the table's number of fields where there is none of that name.
inline std::size_t field_of(const flatbuffers::TypeTable& table, std::string_view name) noexcept
{
    std::size_t i = 0;
    while (i < table.num_elems && name != table.names[i]) ++i;
    return i;
}

/// The position of a field's entry in a table's directory.
constexpr flatbuffers::voffset_t directory_offset(std::size_t field)
{
    return static_cast<flatbuffers::voffset_t>((field + 2) * sizeof(flatbuffers::voffset_t));
}

}  // namespace sqmap::model
