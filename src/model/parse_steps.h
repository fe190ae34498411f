// The steps of parsing that central models and paper models share.
#pragma once

#include "model/schema.h"
#include "sqmap/model/parse.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace sqmap::model {

/// File identifier of a paper model, "SQMP" being that of a central one.
inline constexpr const char* k_paper_identifier = "SQPM";

/// Sets spans to the vectors of a verified table that are called so; a field that is not there makes an empty span.
class TableReader {
public:
    TableReader(const void* table, const flatbuffers::TypeTable& fields)
        : table_(static_cast<const flatbuffers::Table*>(table)), fields_(fields)
    {
    }
    template <class T>
    void operator()(const char* name, std::span<const T>& to) const
    {
        const auto* vector =
            table_->GetPointer<const flatbuffers::Vector<std::uint8_t>*>(directory_offset(field_of(fields_, name)));
        if (vector != nullptr) to = {reinterpret_cast<const T*>(vector->Data()), vector->size()};
    }

private:
    const flatbuffers::Table* table_;
    const flatbuffers::TypeTable& fields_;
};

/// Share of its distance from the origin by which rounding to float may have moved a vertex: twice 2^-24.
inline constexpr double k_input_rounding = 1.2e-7;

/// True where an array of a size has the entries from first on.
constexpr bool within(std::uint32_t first, std::uint64_t count, std::size_t size) { return std::uint64_t(first) + count <= size; }

/// Continues a hash (FNV-1a over 64-bit words) by an array.
template <class T>
void hash_bytes(std::uint64_t& hash, std::span<const T> values)
{
    const auto* bytes = reinterpret_cast<const unsigned char*>(values.data());
    std::size_t size = values.size_bytes();
    hash = (hash ^ size) * 0x100000001b3ull;
    for (; size >= 8; bytes += 8, size -= 8) {
        std::uint64_t word;
        std::memcpy(&word, bytes, 8);
        hash = (hash ^ word) * 0x100000001b3ull;
        hash ^= hash >> 29;
    }
    std::uint64_t word = 0;
    if (size > 0) std::memcpy(&word, bytes, size);
    hash = (hash ^ word) * 0x100000001b3ull;
}

/// Points v at the arrays, header and provenance of a verified table, and checks the hash of the content. end: the end of the
/// bytes that hold the table; its parts come last.
[[nodiscard]] ParseStatus read_model(const fb::Model& model, const std::byte* end, ModelView& v) noexcept;
/// Checks superquadrics, triangles and signed distances. @pre read_model
[[nodiscard]] ParseStatus check_surface(const ModelView& v) noexcept;
/// Checks the grid of the locator, or that there is none. @pre read_model
[[nodiscard]] ParseStatus check_cells(const ModelView& v) noexcept;
/// Checks the lists of the exact layer: all or none. rises: how many there are to be. @pre check_cells
[[nodiscard]] ParseStatus check_candidates(const ModelView& v, std::size_t rises) noexcept;

/// Checks the arrays of distances of a view whose triangles and pieces are already checked. Cost: linear in the arrays.
[[nodiscard]] ParseStatus check_distance(const ModelView& view) noexcept;

}  // namespace sqmap::model
