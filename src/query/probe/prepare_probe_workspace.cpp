// Constructors of workspaces for probes, which allocate: they run outside the tick.
#include "kept_probe.h"

namespace sqmap::query {

KeptProbe::KeptProbe(const Probe& probe)
    : due(probe.clusters() + Probe::k_cluster),  // read by whole vectors
      point_due(probe.clusters() * Probe::k_cluster),
      visited(probe.clusters())
{
}

ProbeWorkspace::ProbeWorkspace(const Probe& probe, std::size_t contacts)
    : contacts_(contacts), kept_(std::make_unique<KeptProbe>(probe))
{
}
ProbeWorkspace::ProbeWorkspace(ProbeWorkspace&& other) noexcept = default;
ProbeWorkspace& ProbeWorkspace::operator=(ProbeWorkspace&& other) noexcept = default;
ProbeWorkspace::~ProbeWorkspace() = default;

}  // namespace sqmap::query
