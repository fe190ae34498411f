#include "sqmap/query/probe_workspace.h"

#include "kept_probe.h"
#include "query/probe/probe_job.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace sqmap::query {

namespace {

/// No point of the probe moved farther since the last query, but for the rounding of positions: for a point p of the sphere
/// about s, |(R' - R) p + t' - t| <= |(R' - R) s + t' - t| + |R' - R| |p - s|.
float motion_between(const KeptProbe& kept, const ProbeJob& job)
{
    // The differences of near numbers are exact, or nearly; products and sums are rounded by less than 1e-6 of them.
    float turned_sq = 0, moved_sq = 0;
    for (int i = 0; i < 3; ++i) {
        float moved = job.translation[i] - kept.translation[i];
        for (int k = 0; k < 3; ++k) {
            const float turned = job.rotation[3 * i + k] - kept.rotation[3 * i + k];
            turned_sq += turned * turned;
            moved += turned * job.sphere[k];
        }
        moved_sq += moved * moved;
    }
    return (std::sqrt(moved_sq) +
            std::sqrt(turned_sq) * (job.sphere[3] + 1e-5f * norm(Vec3f{job.sphere[0], job.sphere[1], job.sphere[2]}))) *
           (1 + 1e-5f);
}

}  // namespace

ModelKey::ModelKey(const model::ModelView& m) noexcept
    : bricks(m.bricks.data()),
      cells(m.locator_cells.size()),
      planes(m.planes.size()),
      candidates(m.near.size()),
      mesh_hash(m.mesh_hash),
      header(m.header)
{
}

bool ModelKey::is_of(const model::ModelView& m) const noexcept
{
    return bricks == m.bricks.data() && cells == m.locator_cells.size() && planes == m.planes.size() &&
           candidates == m.near.size() && mesh_hash == m.mesh_hash && std::memcmp(&header, &m.header, sizeof(header)) == 0;
}

KeptProbe* KeptProbe::advance(const ProbeJob& job, const Probe& of) noexcept
{
    // Planes and maps err near the surface, so that distances from it say nothing of their contacts.
    if (job.layer != Layer::Exact || job.first_only || point_due.size() != job.clusters * Probe::k_cluster) return nullptr;
    float moved = INFINITY;
    if (of.stamp() == stamp && model.is_of(job.model))
        moved = motion_between(*this, job);
    else
        model = ModelKey(job.model);
    stamp = of.stamp();
    std::copy(std::begin(job.rotation), std::end(job.rotation), rotation);
    std::copy(std::begin(job.translation), std::end(job.translation), translation);
    // Notes made between large steps are void before they are read, so a few small ones have to be seen first.
    constexpr float k_small = 0.06f;  // of a cell
    constexpr std::uint32_t k_calm = 4;
    calm = moved <= k_small * job.model.locator.cell ? std::min(calm + 1, k_calm) : 0;
    if (calm < k_calm) {
        known = false;
        return nullptr;
    }
    sum += static_cast<double>(moved);
    // Beyond, float would not tell small motions.
    if (!known || !(sum <= static_cast<double>(job.model.header.sphere[3]))) restart(job);
    travel = std::nextafter(static_cast<float>(sum), INFINITY);
    soon = travel + 0.15f * job.model.locator.cell;
    // Points far enough from contact rest for many ticks once they were measured; beside contacts, or in large steps, for few.
    constexpr std::size_t k_measured = 16;
    budget = contacts == 0 && moved <= 0.6f * k_small * job.model.locator.cell ? k_measured : 0;
    visits = 0;
    reuse.kept = true;
    return this;
}

void ProbeWorkspace::forget() noexcept
{
    if (kept_ != nullptr) kept_->known = false;
}
ProbeReuse ProbeWorkspace::reuse() const noexcept { return kept_ != nullptr ? kept_->reuse : ProbeReuse{}; }

void KeptProbe::restart(const ProbeJob& job) noexcept
{
    known = true;
    sum = 0;
    std::fill(due.begin(), due.end(), 0.f);
    const auto filled_up = point_due.begin() + static_cast<std::ptrdiff_t>(job.points);
    std::fill(point_due.begin(), filled_up, 0.f);
    std::fill(filled_up, point_due.end(), INFINITY);  // they never answer
    // A coordinate is rounded by at most 2.4e-7 of the sum of its terms' sizes, at either end of a motion; the distances that are
    // kept, travel and due by less. Positions are clamped to the grid within 0.001 of a cell.
    const float size = job.model.header.sphere[3];
    float terms = job.sphere[3] * job.scale + 4 * size;
    for (const float t : translation) terms += std::abs(t);
    margin = 4e-6f * terms + 0.002f * job.model.locator.cell;
}

}  // namespace sqmap::query
