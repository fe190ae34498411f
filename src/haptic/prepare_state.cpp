// What a state sets up outside the loop: the allocating half.
#include "memory.h"

namespace sqmap::haptic {

State::State(std::span<const Zone> zones, const StateOptions& options)
    : zones_(zones.begin(), zones.end()),
      reports_(zones.size()),
      memory_(zones.size()),
      touches_(zones.size() * options.max_touched),
      max_touched_(options.max_touched),
      found_(options.max_contacts * options.max_touched),
      asked_(options.max_touched)
{
    std::size_t most = 0;
    for (const Zone& zone : zones_)
        if (zone.probe != nullptr && zone.options.averaging != Averaging::Patch) most = std::max(most, zone.probe->size());
    samples_.resize(most);
    trails_.resize(touches_.size() * most);
}

State::State(State&&) noexcept = default;
State& State::operator=(State&&) noexcept = default;
State::~State() = default;

}  // namespace sqmap::haptic
