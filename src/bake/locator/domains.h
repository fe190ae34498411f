// The parts whose charts answer in a cell.
#pragma once

#include "bake/locator/draft.h"
#include "sqmap/model/model.h"

#include <cstdint>

namespace sqmap::bake {

/// How a part's domain lies to a cube.
struct DomainTest {
    bool touches = false, holds = false;

    bool operator==(const DomainTest&) const = default;
};
[[nodiscard]] DomainTest test_domain(const model::Part& part, const CellCube& cube);
/// DomainTest::holds of a cube without extent, sooner.
[[nodiscard]] bool domain_holds(const model::Part& part, Vec3d p);

/// Sets the parts of a mixed cell's draft, best first: one that holds the whole cell suffices. owner: the part of the surface
/// that is nearest to the centre. The cell is ambiguous where there are too many, or none.
void list_parts(const LocatorSubject& subject, const CellCube& cube, std::uint32_t owner, CellDraft& draft);

}  // namespace sqmap::bake
