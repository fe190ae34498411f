#include "sqmap/model/notes.h"

#include "model/notes_field.h"
#include "model/parse_steps.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace sqmap::model {
namespace {

static_assert(sizeof(NoteRecord) == sizeof(fb::Note) && alignof(NoteRecord) == alignof(fb::Note));

/// Letters, digits and underscores, then zeros to the end.
bool is_name(const char (&name)[24]) noexcept
{
    const auto* const end = std::find(std::begin(name), std::end(name), '\0');
    const bool is_word = std::all_of(std::begin(name), end, [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
    });
    return is_word && end != std::end(name) && std::all_of(end, std::end(name), [](char c) { return c == '\0'; });
}

bool is_valid(const NoteRecord& note) noexcept
{
    const auto kind = static_cast<std::uint32_t>(note.kind);
    if (kind < 1 || kind > static_cast<std::uint32_t>(NoteKind::Doubt) || note.flag > 1 || !is_name(note.name)) return false;
    const bool is_named = note.kind == NoteKind::Repaired || note.kind == NoteKind::Warning;
    if (is_named != (note.name[0] != '\0')) return false;
    return std::all_of(std::begin(note.values), std::end(note.values), [](double value) { return std::isfinite(value); });
}

}  // namespace

std::uint64_t hash_of(std::span<const NoteRecord> notes) noexcept
{
    std::uint64_t hash = 0xcbf29ce484222325ull;
    hash_bytes(hash, notes);
    return hash;
}

std::span<const NoteRecord> notes_of(const fb::Model& model) noexcept
{
    std::span<const NoteRecord> notes;
    TableReader(&model, *fb::ModelTypeTable())("notes", notes);
    return notes;
}

ParseStatus check_notes(const fb::Model& model) noexcept
{
    const std::span<const NoteRecord> notes = notes_of(model);
    if (notes.empty()) return ParseStatus::Ok;
    if (hash_of(notes) != model.notes_hash()) return ParseStatus::BadHash;
    return std::all_of(notes.begin(), notes.end(), is_valid) ? ParseStatus::Ok : ParseStatus::BadValue;
}

std::span<const NoteRecord> notes_of(std::span<const std::byte> bytes) noexcept
{
    const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
    if (bytes.size() < 16 || !fb::ModelBufferHasIdentifier(data)) return {};
    return notes_of(*fb::GetModel(data));
}

}  // namespace sqmap::model
