// What a frame's kernel works on: plain data, set up once a frame, the same for every instruction set.
#pragma once

#include "sqmap/query/probe.h"

namespace sqmap::query {

struct ProbeJob {
    ProbeJob(const model::ModelView& m, const Probe& p, const Pose& pose, const ProbeOptions& o,
             std::span<ProbeContact> out) noexcept;

    const model::ModelView& model;
    const float *x, *y, *z;
    const std::uint32_t* point;
    const float *centre_x, *centre_y, *centre_z, *radius;
    const float *group_x, *group_y, *group_z, *group_radius;
    std::size_t clusters, groups, points;
    float sphere[4];

    // Place in the probe -> model space, and how lengths scale.
    float rotation[9], translation[3], scale;
    bool finite;

    Layer layer;
    bool exact;
    bool first_only;
    std::span<ProbeContact> out;
};

}  // namespace sqmap::query
