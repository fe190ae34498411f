// What a state sets up outside the loop: the allocating half.
#include "memory.h"

namespace sqmap::haptic {

State::State(std::span<const Zone> zones, const StateOptions& options)
    : zones_(zones.begin(), zones.end()),
      reports_(zones.size()),
      memory_(zones.size()),
      touches_(zones.size() * options.most_solids),
      most_solids_(options.most_solids),
      found_(options.most_contacts * options.most_solids),
      asked_(options.most_solids)
{
}

State::State(State&&) noexcept = default;
State& State::operator=(State&&) noexcept = default;
State::~State() = default;

}  // namespace sqmap::haptic
