// The printed names and words of an admission: scripts and users read them, so they stay.
#include "sqmap/mesh/admission.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <iterator>
#include <stdexcept>

namespace sqmap {

std::string words(const OptionRange& range)
{
    char text[64];
    std::snprintf(text, sizeof text, "from %g to %g", range.least, range.max);
    return text;
}

void refuse_option_name() { throw std::out_of_range("no option has this name"); }

}  // namespace sqmap

namespace sqmap::mesh {

const char* name_of(Refusal refusal) noexcept
{
    static constexpr const char* k_names[] = {"",         "E_INDEX",       "E_NONFINITE", "E_EMPTY",    "E_RANGE",
                                              "E_LIMIT",  "E_NONMANIFOLD", "E_ORIENT",    "E_FLAT",     "E_OPEN",
                                              "E_REPAIR", "E_FORMAT",      "E_TRUNCATED", "E_INTERNAL", "E_FILE"};
    static_assert(std::size(k_names) == static_cast<std::size_t>(Refusal::File) + 1, "in the order of the enumeration");
    const auto i = static_cast<std::size_t>(refusal);
    return i < std::size(k_names) ? k_names[i] : "";
}

const char* name_of(RepairKind kind) noexcept
{
    static constexpr const char* k_names[] = {
        "triangulated",  "unused_vertices", "welded_vertices", "degenerate_faces", "duplicate_faces", "reoriented",
        "flipped",       "split_vertices",  "filled_holes",    "thickened",        "stitched_edges",  "inner_walls",
        "dropped_faces", "cut_edges",       "dropped_sheets",  "wrapped",          "enclosed"};
    static_assert(std::size(k_names) == static_cast<std::size_t>(RepairKind::Enclosed) + 1, "in the order of the enumeration");
    const auto i = static_cast<std::size_t>(kind);
    return i < std::size(k_names) ? k_names[i] : "";
}

const char* name_of(WarningKind kind) noexcept
{
    static constexpr const char* k_names[] = {"W_SELFX",   "W_CAVITY",    "W_FLIPPED", "W_UNIT",     "W_DEGENERATE",
                                              "W_SURFACE", "W_THICKNESS", "W_DROPPED", "W_TOLERANCE"};
    static_assert(std::size(k_names) == static_cast<std::size_t>(WarningKind::Tolerance) + 1, "in the order of the enumeration");
    const auto i = static_cast<std::size_t>(kind);
    return i < std::size(k_names) ? k_names[i] : "";
}

const char* name_of(Admission admission) noexcept
{
    switch (admission) {
        case Admission::Accept:
            return "ACCEPT";
        case Admission::Repaired:
            return "REPAIRED";
        case Admission::Closed:
            return "CLOSED";
        case Admission::Wrapped:
            return "WRAPPED";
        case Admission::Refused:
            break;
    }
    return "REFUSED";
}

const SettingNames k_cpp_settings({{Setting::Repair, "AdmitOptions::repair"},
                                   {Setting::MaxFilled, "AdmitOptions::max_filled"},
                                   {Setting::Surface, "AdmitOptions::accept_surface"},
                                   {Setting::Thickness, "AdmitOptions::thickness"},
                                   {Setting::PlateThickness, "AdmitOptions::thickness"},
                                   {Setting::Unit, "AdmitOptions::unit"},
                                   {Setting::MaxBytes, "ReadLimits::max_bytes"},
                                   {Setting::MaxFaces, "ReadLimits::max_faces"},
                                   {Setting::MaxComponents, "AdmitOptions::max_components"},
                                   {Setting::MaxCuredFaces, "AdmitOptions::max_cured_faces"},
                                   {Setting::MaxWrappedFaces, "WrapOptions::max_triangles"},
                                   {Setting::WrapTolerance, "WrapOptions::tolerance"},
                                   {Setting::MaxCells, "WrapOptions::max_cells"},
                                   {Setting::MaxParts, "BakeOptions::max_parts"},
                                   {Setting::TargetError, "BakeOptions::target_error"},
                                   {Setting::Exact, "BakeOptions::exact"},
                                   {Setting::KeepInput, "BakeOptions::keep_input"},
                                   {Setting::Packages, "RewriteOptions::packages"},
                                   {Setting::SolidProbe, "query::Probe(points, triangles)"},
                                   {Setting::Bake, "bake_mesh"},
                                   {Setting::BakedMesh, "bake::baked_mesh"}},
                                  " = ", [](Setting setting, std::string_view word) {
                                      std::string out(word);
                                      if (setting == Setting::Unit) return std::string(word == "mm" ? "1e-3" : word);
                                      if (setting != Setting::Repair || out.empty()) return out;
                                      out[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(out[0])));
                                      return "Repair::" + out;
                                  });

std::string Words::text(const SettingNames& names) const
{
    constexpr std::string_view k_or = " or ";
    std::string out;
    for (const Clause& c : clauses_) {
        const char* const name = c.setting ? names.name(*c.setting) : nullptr;
        if (c.setting && name == nullptr) continue;
        out += c.before;
        if (c.setting) {
            out += name;
            const std::string_view values = c.value;
            for (std::size_t at = 0; at < values.size();) {
                const std::size_t end = std::min(values.find(k_or, at), values.size());
                out += (at == 0 ? names.equals() : k_or.data()) + names.value(*c.setting, values.substr(at, end - at));
                at = end == values.size() ? end : end + k_or.size();
            }
        }
        out += c.after;
    }
    return out;
}

std::string words(const RepairNote& repair)
{
    return std::string(name_of(repair.kind)) + " (" + std::to_string(repair.count) + ")";
}

std::string words(const Warning& w, const SettingNames& names)
{
    const std::string count = std::to_string(w.count);
    char text[200] = "";
    switch (w.kind) {
        case WarningKind::SelfIntersections:
            return (w.at_least ? "at least " : "") + count +
                   " pairs of faces intersect; the solid is where the winding number is positive";
        case WarningKind::Cavities:
            return count + " shells are cavities inside others";
        case WarningKind::Flipped:
            return count + " faces were inside out and have been turned";
        case WarningKind::Unit:
            return Words("more than 50 units wide")
                .with(": if that is not metres, say so with ", Setting::Unit)
                .with(" (such as ", Setting::Unit, "mm", ")")
                .text(names);
        case WarningKind::Degenerate:
            return count + " faces have no area and could not be removed without opening the mesh";
        case WarningKind::Surface:
            return "open surface with " + count + " boundary edges: it has no inside";
        case WarningKind::Thickness:
            return Words("the mesh is closed and not flat: ", Setting::Thickness, "", " was not used").text(names);
        case WarningKind::DroppedSurface:
            std::snprintf(text, sizeof text,
                          "%s dropped triangles with an area of %.3g stand out of the solid by up to %.3g: they bound nothing",
                          count.c_str(), w.first, w.second);
            return text;
        case WarningKind::Tolerance:
            std::snprintf(text, sizeof text,
                          "%llu triangles, 99 %% of their area within %.3g %% of R_max of the file; asked were %llu and %.3g %%",
                          static_cast<unsigned long long>(w.triangles), 100 * w.first, static_cast<unsigned long long>(w.wanted),
                          100 * w.second);
            return Words(text)
                .with(": see ", Setting::MaxWrappedFaces)
                .with(", ", Setting::WrapTolerance)
                .with(", ", Setting::MaxCells)
                .text(names);
    }
    return text;
}

}  // namespace sqmap::mesh
