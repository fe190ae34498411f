// Notes as the model file keeps them: what bake had to say about the mesh and its model. Queries do not read them, so they are no
// part of ModelView. sqmap/bake/notes.h makes words of them.
// Plain data and pure functions: any number of threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace sqmap::model {

/// Kinds of notes, and which members of the record they use. New kinds come last: files hold these numbers.
enum class NoteKind : std::uint32_t {
    Repaired = 1,       ///< name; counts: what it changed
    Moved = 2,          ///< values: mean, p99, max from the input, the same to the input, R_max; mesh units
    MovedBoundary = 3,  ///< values: mean, p99, max from the input where it bounds the solid; the last one R_max
    MadeUp = 4,         ///< values: share of the area
    Warning = 5,        ///< name; counts: what it is about, triangles, wanted; values: two; flag: at least so many
    OffTarget = 6,      ///< values: wanted, reached, percent of R_max
    Doubt = 7,          ///< counts: points on the wrong side, points; values: p99 of the depth; flag: the exact layer is there
};

/// One note. Layout equals the FlatBuffers struct Note.
struct NoteRecord {
    char name[24];  ///< of a repair or a warning, "welded_vertices", "W_SELFX"; zeros from its end on
    NoteKind kind;
    std::uint32_t flag;  ///< 0 or 1
    std::uint64_t counts[3];
    double values[7];
};

/// The notes in a model file's bytes, whose lifetime they share; none in a model that was written before there were notes, and in
/// a paper model, which paper::notes_of reads. @pre parse of the bytes was Ok (not checked)
[[nodiscard]] std::span<const NoteRecord> notes_of(std::span<const std::byte> bytes) noexcept;

}  // namespace sqmap::model
