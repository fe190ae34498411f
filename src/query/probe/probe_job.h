// The input of the kernels of probe queries: plain data, set up once a query, the same for every instruction set.
#pragma once

#include "query/caller_frame.h"
#include "sqmap/query/probe.h"

namespace sqmap::query {

struct KeptProbe;

/// Positions in model space, as the kernels read them.
struct PointBatch {
    static constexpr std::size_t k_size = 64;  ///< a multiple of a cluster
    std::size_t count = 0;
    float x[k_size], y[k_size], z[k_size];  ///< filled up to a whole cluster
    std::uint32_t point[k_size];
    std::uint8_t unproven[k_size];  ///< see ProbeJob

    explicit PointBatch(std::span<const Vec3f> points) noexcept;
};

struct ProbeJob {
    /// @pre touched has a model, collider a probe
    ProbeJob(const Body& touched, const Body& collider, const QueryOptions& o, std::span<Contact> contacts) noexcept;
    /// Points where they are, without clusters; contacts in model space.
    ProbeJob(const model::ModelView& m, PointBatch& points, const QueryOptions& o, std::span<Contact> contacts) noexcept;

    const model::ModelView& model;
    const float *x, *y, *z;
    const std::uint32_t* point;
    const float *centre_x = nullptr, *centre_y = nullptr, *centre_z = nullptr, *radius = nullptr;
    const float *group_x = nullptr, *group_y = nullptr, *group_z = nullptr, *group_radius = nullptr;
    std::size_t clusters = 0, groups = 0, points;
    float sphere[4] = {};
    /// Set to 1 for points whose free verdict is not proven: by the locator, on layer Exact by float. May be null.
    std::uint8_t* unproven = nullptr;

    // Position in the probe -> model space, and how lengths scale.
    float rotation[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, translation[3] = {}, scale = 1;
    bool finite = true;

    /// Moves a position of the probe to model space.
    Vec3f in_model_space(Vec3f p) const
    {
        const float* r = rotation;
        return {r[0] * p.x + r[1] * p.y + r[2] * p.z + translation[0], r[3] * p.x + r[4] * p.y + r[5] * p.z + translation[1],
                r[6] * p.x + r[7] * p.y + r[8] * p.z + translation[2]};
    }

    Layer layer;  ///< One, Two, Three, Exact, or Gate
    std::uint32_t gate;
    bool first_only;
    KeptProbe* kept = nullptr;  ///< of earlier ticks; null: nothing is known
    CallerFrame caller;         ///< of the contacts that are written
    std::span<Contact> out;
};

}  // namespace sqmap::query
