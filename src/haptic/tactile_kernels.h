// The inner part of a tactile pad's tick, for every instruction set: forces of many taxels at once. In double and in the order of
// the formulas, so that all give the same bits.
#pragma once

#include "sqmap/haptic/tactile.h"

namespace sqmap::haptic {

/// A tick as the kernel reads it.
struct TactileJob {
    const TactileOptions& options;
    Pose now, last;     ///< pad's frame -> the touched model's: at this tick and at the one before
    double inverse_dt;  ///< 1/s; 0: no slip
    std::span<const Vec3d> points, normals;
};

/// Writes the taxels that are in contact, and adds up their forces.
void add_forces(const TactileJob& job, std::span<const query::Contact> contacts, std::span<Taxel> taxels,
                TactileResult& result) noexcept;

}  // namespace sqmap::haptic
