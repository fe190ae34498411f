// The words of notes, which scripts and users read, and their records in the model file.
#include "sqmap/bake/notes.h"

#include <cmath>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string_view>

namespace sqmap {
namespace {

using model::NoteKind;
using model::NoteRecord;

template <class... F>
struct NoteCases : F... {
    using F::operator()...;
};
template <class... F>
NoteCases(F...) -> NoteCases<F...>;

std::string distances_text(const mesh::Distances& d, double r_max)
{
    char text[128];
    std::snprintf(text, sizeof text, "mean %.3g, p99 %.3g (%.2g %% of R_max), max %.3g", d.mean, d.p99, 100 * d.p99 / r_max,
                  d.max);
    return text;
}

std::string doubt_text(const DoubtNote& doubt, const mesh::SettingNames& names)
{
    char text[128];
    if (doubt.wrong > 0)
        std::snprintf(text, sizeof text, "W_LAYER3: %u of %u points on the wrong side on layer 3", doubt.wrong, doubt.points);
    else
        std::snprintf(text, sizeof text, "W_LAYER3: depths of layer 3 have a 99th percentile of %.3f %%", doubt.depth_p99);
    mesh::Words out(text);
    if (doubt.has_exact) return out.text() + ": use the exact layer, as auto and the page do";
    return out.with(": bake it with ", mesh::Setting::Exact).text(names);
}

NoteRecord blank(NoteKind kind, const char* name = "") noexcept
{
    NoteRecord out{};
    out.kind = kind;
    std::strncpy(out.name, name, sizeof out.name - 1);
    return out;
}

void put(double* values, const mesh::Distances& d) noexcept
{
    values[0] = d.mean;
    values[1] = d.p99;
    values[2] = d.max;
}

mesh::Distances distances_at(const double* values) noexcept { return {values[0], values[1], values[2]}; }

NoteRecord record_of_warning(const mesh::Warning& n) noexcept
{
    NoteRecord out = blank(NoteKind::Warning, mesh::name_of(n.kind));
    out.flag = n.at_least ? 1 : 0;
    out.counts[0] = n.count;
    out.counts[1] = n.triangles;
    out.counts[2] = n.wanted;
    out.values[0] = n.first;
    out.values[1] = n.second;
    return out;
}

/// The enumerator of that name, the last one being `last`.
template <class Kind>
std::optional<Kind> kind_named(std::string_view name, Kind last) noexcept
{
    for (int i = 0; i <= static_cast<int>(last); ++i)
        if (name == mesh::name_of(static_cast<Kind>(i))) return static_cast<Kind>(i);
    return std::nullopt;
}

std::optional<Note> note_of(const NoteRecord& r)
{
    switch (r.kind) {
        case NoteKind::Repaired:
            if (const auto kind = kind_named(r.name, mesh::RepairKind::Enclosed)) return mesh::RepairNote{*kind, r.counts[0]};
            return std::nullopt;
        case NoteKind::Moved:
            return MovedNote{distances_at(r.values), distances_at(r.values + 3), r.values[6]};
        case NoteKind::MovedBoundary:
            return MovedBoundaryNote{distances_at(r.values), r.values[6]};
        case NoteKind::MadeUp:
            return MadeUpNote{r.values[0]};
        case NoteKind::Warning:
            if (const auto kind = kind_named(r.name, mesh::WarningKind::Tolerance))
                return mesh::Warning{*kind, r.counts[0], r.flag != 0, r.values[0], r.values[1], r.counts[1], r.counts[2]};
            return std::nullopt;
        case NoteKind::OffTarget:
            return OffTargetNote{r.values[0], r.values[1]};
        case NoteKind::Doubt:
            return DoubtNote{static_cast<std::uint32_t>(r.counts[0]), static_cast<std::uint32_t>(r.counts[1]), r.values[0],
                             r.flag != 0};
    }
    return std::nullopt;
}

}  // namespace

bool is_about_model(const Note& note) noexcept
{
    return std::holds_alternative<OffTargetNote>(note) || std::holds_alternative<DoubtNote>(note);
}

std::string words(const Note& note, const mesh::SettingNames& names)
{
    char text[128];
    return std::visit(
        NoteCases{[](const mesh::RepairNote& n) { return "repaired: " + mesh::words(n); },
                  [&](const mesh::Warning& n) { return std::string(mesh::name_of(n.kind)) + ": " + mesh::words(n, names); },
                  [](const MovedNote& n) {
                      return "moved: from the file " + distances_text(n.from_input, n.r_max) + "; to the file " +
                             distances_text(n.to_input, n.r_max);
                  },
                  [](const MovedBoundaryNote& n) {
                      return "moved: from the file where it bounds the solid " + distances_text(n.from_input, n.r_max);
                  },
                  [&](const MadeUpNote& n) {
                      std::snprintf(text, sizeof text, "made up: %.3g %% of the area", 100 * n.share);
                      return std::string(text);
                  },
                  [&](const OffTargetNote& n) {
                      std::snprintf(text, sizeof text,
                                    "W_TARGET: target error of %g %% not reached: the best model found has %.3f %%", n.wanted,
                                    n.reached);
                      return std::string(text);
                  },
                  [&](const DoubtNote& n) { return doubt_text(n, names); }},
        note);
}

std::vector<std::string> words(std::span<const Note> notes, const mesh::SettingNames& names)
{
    std::vector<std::string> out;
    for (const Note& note : notes) out.push_back(words(note, names));
    return out;
}

NoteRecord record_of(const Note& note) noexcept
{
    NoteRecord out = std::visit(NoteCases{[](const mesh::RepairNote& n) {
                                              NoteRecord r = blank(NoteKind::Repaired, mesh::name_of(n.kind));
                                              r.counts[0] = n.count;
                                              return r;
                                          },
                                          [](const MovedNote& n) {
                                              NoteRecord r = blank(NoteKind::Moved);
                                              put(r.values, n.from_input);
                                              put(r.values + 3, n.to_input);
                                              r.values[6] = n.r_max;
                                              return r;
                                          },
                                          [](const MovedBoundaryNote& n) {
                                              NoteRecord r = blank(NoteKind::MovedBoundary);
                                              put(r.values, n.from_input);
                                              r.values[6] = n.r_max;
                                              return r;
                                          },
                                          [](const MadeUpNote& n) {
                                              NoteRecord r = blank(NoteKind::MadeUp);
                                              r.values[0] = n.share;
                                              return r;
                                          },
                                          [](const mesh::Warning& n) { return record_of_warning(n); },
                                          [](const OffTargetNote& n) {
                                              NoteRecord r = blank(NoteKind::OffTarget);
                                              r.values[0] = n.wanted;
                                              r.values[1] = n.reached;
                                              return r;
                                          },
                                          [](const DoubtNote& n) {
                                              NoteRecord r = blank(NoteKind::Doubt);
                                              r.flag = n.has_exact ? 1 : 0;
                                              r.counts[0] = n.wrong;
                                              r.counts[1] = n.points;
                                              r.values[0] = n.depth_p99;
                                              return r;
                                          }},
                                note);
    for (double& value : out.values)
        if (!std::isfinite(value)) value = 0;
    return out;
}

std::vector<NoteRecord> records_of(std::span<const Note> notes)
{
    std::vector<NoteRecord> out;
    for (const Note& note : notes) out.push_back(record_of(note));
    return out;
}

std::vector<Note> notes_of(std::span<const NoteRecord> records)
{
    std::vector<Note> out;
    for (const NoteRecord& record : records)
        if (const std::optional<Note> note = note_of(record)) out.push_back(*note);
    return out;
}

}  // namespace sqmap
