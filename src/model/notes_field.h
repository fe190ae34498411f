// Notes in the table of a model, which stands alone in a central model's file and beside the maps in that of a paper model.
#pragma once

#include "model/schema.h"
#include "sqmap/model/notes.h"
#include "sqmap/model/parse.h"

#include <cstdint>
#include <span>

namespace sqmap::model {

/// The table's notes. @pre the table is verified
[[nodiscard]] std::span<const NoteRecord> notes_of(const fb::Model& model) noexcept;
/// Checks names, kinds, numbers and the hash of notes.
[[nodiscard]] ParseStatus check_notes(const fb::Model& model) noexcept;
/// The notes' hash as the file keeps it.
[[nodiscard]] std::uint64_t hash_of(std::span<const NoteRecord> notes) noexcept;

}  // namespace sqmap::model
