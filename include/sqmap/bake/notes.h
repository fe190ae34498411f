// Notes: facts about a mesh and its model as data. words() makes a line of each, and the model file keeps them as records.
// Plain data and pure functions: any number of threads.
#pragma once

#include "sqmap/mesh/admission.h"
#include "sqmap/model/notes.h"

#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace sqmap {

/// How far a cure moved the surface; lengths in units of the result.
struct MovedNote {
    mesh::Distances from_input, to_input;
    double r_max = 0;  ///< largest distance between two vertices
};
/// The same from the input where that bounds the solid, of a wrapped mesh.
struct MovedBoundaryNote {
    mesh::Distances from_input;
    double r_max = 0;
};
/// The share of the area where a cure made the surface up.
struct MadeUpNote {
    double share = 0;
};
/// Layer 3 of the model errs more than was asked; percent of R_max.
struct OffTargetNote {
    double wanted = 0, reached = 0;
};
/// Layer 3 of the model may not be relied on.
struct DoubtNote {
    std::uint32_t wrong = 0, points = 0;  ///< points on the wrong side, of those measured
    double depth_p99 = 0;                 ///< percent of R_max
    bool has_exact = false;               ///< the model has the exact layer, which answers instead
};
/// One thing that a caller should know about a mesh or its model.
using Note = std::variant<mesh::RepairNote, MovedNote, MovedBoundaryNote, MadeUpNote, mesh::Warning, OffTargetNote, DoubtNote>;

/// True of a note about the model, false of one about its mesh.
[[nodiscard]] bool is_about_model(const Note& note) noexcept;

/// One line, with settings as the door names them. @throw std::bad_alloc
[[nodiscard]] std::string words(const Note& note, const mesh::SettingNames& names = mesh::k_cpp_settings);
/// The same of each. @throw std::bad_alloc
[[nodiscard]] std::vector<std::string> words(std::span<const Note> notes, const mesh::SettingNames& names = mesh::k_cpp_settings);

/// The note as the model file keeps it. Numbers that are not finite become 0.
[[nodiscard]] model::NoteRecord record_of(const Note& note) noexcept;
/// The same of each. @throw std::bad_alloc
[[nodiscard]] std::vector<model::NoteRecord> records_of(std::span<const Note> notes);
/// The notes of a model file; those whose repair or warning a later version gave its name are left out. @throw std::bad_alloc
[[nodiscard]] std::vector<Note> notes_of(std::span<const model::NoteRecord> records);

}  // namespace sqmap
