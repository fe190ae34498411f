// Construction and destruction of a state: the half that allocates.
#include "memory.h"

namespace sqmap::haptic {

State::State(std::span<const Zone> zones, const StateOptions& options) : data_(std::make_unique<Data>())
{
    Data& d = *data_;
    d.zones.assign(zones.begin(), zones.end());
    d.reports.resize(zones.size());
    d.memory.resize(zones.size());
    d.touches.resize(zones.size() * options.max_touched);
    d.max_touched = options.max_touched;
    d.found.resize(options.max_contacts * options.max_touched);
    d.queries.resize(options.max_touched);
    std::size_t samples = 0;
    for (const Zone& zone : d.zones)
        if (zone.probe != nullptr && zone.options.averaging != Averaging::Patch) samples = std::max(samples, zone.probe->size());
    d.samples.resize(samples);
    d.trails.resize(d.touches.size() * samples);
}

State::State(State&&) noexcept = default;
State& State::operator=(State&&) noexcept = default;
State::~State() = default;

}  // namespace sqmap::haptic
