// The printed names of what the gate says: scripts and users read them, so they stay.
#include "sqmap/mesh/admit.h"

namespace sqmap::mesh {

const char* name_of(Refusal refusal) noexcept
{
    switch (refusal) {
        case Refusal::None:
            return "";
        case Refusal::Index:
            return "E_INDEX";
        case Refusal::NonFinite:
            return "E_NONFINITE";
        case Refusal::Empty:
            return "E_EMPTY";
        case Refusal::Range:
            return "E_RANGE";
        case Refusal::Limit:
            return "E_LIMIT";
        case Refusal::NonManifold:
            return "E_NONMANIFOLD";
        case Refusal::Orient:
            return "E_ORIENT";
        case Refusal::Flat:
            return "E_FLAT";
        case Refusal::Open:
            return "E_OPEN";
        case Refusal::Repair:
            return "E_REPAIR";
    }
    return "";
}

const char* name_of(RepairKind kind) noexcept
{
    switch (kind) {
        case RepairKind::Triangulated:
            return "triangulated";
        case RepairKind::UnusedVertices:
            return "unused_vertices";
        case RepairKind::WeldedVertices:
            return "welded_vertices";
        case RepairKind::DegenerateFaces:
            return "degenerate_faces";
        case RepairKind::DuplicateFaces:
            return "duplicate_faces";
        case RepairKind::Reoriented:
            return "reoriented";
        case RepairKind::Flipped:
            return "flipped";
        case RepairKind::SplitVertices:
            return "split_vertices";
        case RepairKind::FilledHoles:
            return "filled_holes";
        case RepairKind::Thickened:
            return "thickened";
        case RepairKind::Stitched:
            return "stitched_edges";
        case RepairKind::DroppedWalls:
            return "inner_walls";
        case RepairKind::DroppedFaces:
            return "dropped_faces";
        case RepairKind::CutEdges:
            return "cut_edges";
        case RepairKind::DroppedSheets:
            return "dropped_sheets";
        case RepairKind::Wrapped:
            return "wrapped";
    }
    return "";
}

const char* name_of(WarningKind kind) noexcept
{
    switch (kind) {
        case WarningKind::SelfIntersections:
            return "W_SELFX";
        case WarningKind::Cavities:
            return "W_CAVITY";
        case WarningKind::DroppedSurface:
            return "W_DROPPED";
        case WarningKind::Tolerance:
            return "W_TOLERANCE";
        case WarningKind::Flipped:
            return "W_FLIPPED";
        case WarningKind::Unit:
            return "W_UNIT";
        case WarningKind::Degenerate:
            return "W_DEGENERATE";
        case WarningKind::Surface:
            return "W_SURFACE";
        case WarningKind::Thickness:
            return "W_THICKNESS";
    }
    return "";
}

}  // namespace sqmap::mesh
