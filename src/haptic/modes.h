// How a zone follows the device: a function per haptic::Mode. Each gives the wrench on the hand and fills the zone's report.
#pragma once

#include "zone_tick.h"

namespace sqmap::haptic {

[[nodiscard]] Wrench direct(ZoneTick& tick);
[[nodiscard]] Wrench proxy(ZoneTick& tick);
[[nodiscard]] Wrench coupled(ZoneTick& tick);

}  // namespace sqmap::haptic
