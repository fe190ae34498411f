// How often the mesh gate repaired something.
#pragma once

#include "sqmap/mesh/admission.h"

#include <cstdint>

namespace sqmap::mesh {

/// Count of the note of that kind; 0 without one.
inline std::uint64_t repaired(const AdmitResult& result, RepairKind kind)
{
    for (const RepairNote& r : result.repairs)
        if (r.kind == kind) return r.count;
    return 0;
}

}  // namespace sqmap::mesh
