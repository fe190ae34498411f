// A workspace keeps of a probe how far it has travelled against a model, and how far its clusters and points may travel before
// one of them can be in the solid.
#pragma once

#include "sqmap/model/model.h"
#include "sqmap/query/probe_workspace.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::query {

struct ProbeJob;

/// A model by the position and the size of its arrays, and by what they are about.
struct ModelKey {
    const void* bricks = nullptr;
    std::size_t cells = 0, planes = 0, candidates = 0;
    std::uint64_t mesh_hash = 0;
    model::Header header{};

    ModelKey() = default;
    explicit ModelKey(const model::ModelView& model) noexcept;
    [[nodiscard]] bool is_of(const model::ModelView& model) const noexcept;
};

/// Lengths are in model units. The travel is the sum, over queries, of a bound of how far any point of the probe moved. A cluster
/// or point that was found a length away from the solid is due when the travel has grown by that length.
struct KeptProbe {
    static constexpr float k_always = -1;  ///< due: of contacts

    explicit KeptProbe(const Probe& probe);
    static KeptProbe* of(const ProbeWorkspace& workspace) noexcept { return workspace.kept_.get(); }
    static std::span<Contact> contacts_of(ProbeWorkspace& workspace) noexcept { return workspace.contacts_; }

    /// Adds the motion since the last query. Returns null where nothing is kept of such a job: it runs as without.
    KeptProbe* advance(const ProbeJob& job, const Probe& of) noexcept;

    ModelKey model;
    std::uint64_t stamp = 0;                      ///< of the probe's positions
    float rotation[9] = {}, translation[3] = {};  ///< of the last query
    bool known = false;                           ///< what is due is about this model, these positions and this travel
    std::uint32_t calm = 0;                       ///< small motions since the last large one
    double sum = 0;                               ///< the travel
    float travel = 0;                             ///< rounded up
    float soon = 0;            ///< what is due until then is looked at beside what is due now, so that both rest for longer
    float margin = 0;          ///< bound of what rounding adds to a motion, or takes from a length
    std::size_t budget = 0;    ///< points that this query may measure so that they rest
    std::size_t contacts = 0;  ///< of the last query
    std::vector<float> due;    ///< clusters, filled up
    std::vector<float> point_due;
    std::vector<std::uint32_t> visited;  ///< clusters whose points were looked at
    std::size_t visits = 0;
    ProbeReuse reuse;

private:
    void restart(const ProbeJob& job) noexcept;
};

}  // namespace sqmap::query
