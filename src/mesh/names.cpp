// The printed names of admission's codes: scripts and users read them, so they stay.
#include "sqmap/mesh/admit.h"

#include <iterator>

namespace sqmap::mesh {

const char* name_of(Refusal refusal) noexcept
{
    static constexpr const char* k_names[] = {"",        "E_INDEX", "E_NONFINITE",   "E_EMPTY",
                                              "E_RANGE", "E_LIMIT", "E_NONMANIFOLD", "E_ORIENT",
                                              "E_FLAT",  "E_OPEN",  "E_REPAIR"};
    static_assert(std::size(k_names) == static_cast<std::size_t>(Refusal::Repair) + 1, "in the order of the enumeration");
    const auto i = static_cast<std::size_t>(refusal);
    return i < std::size(k_names) ? k_names[i] : "";
}

const char* name_of(RepairKind kind) noexcept
{
    static constexpr const char* k_names[] = {"triangulated",    "unused_vertices", "welded_vertices", "degenerate_faces",
                                              "duplicate_faces", "reoriented",      "flipped",         "split_vertices",
                                              "filled_holes",    "thickened",       "stitched_edges",  "inner_walls",
                                              "dropped_faces",   "cut_edges",       "dropped_sheets",  "wrapped"};
    static_assert(std::size(k_names) == static_cast<std::size_t>(RepairKind::Wrapped) + 1, "in the order of the enumeration");
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

}  // namespace sqmap::mesh
