// Fig. 13: a probe slides over an object; the force step between consecutive ticks, beside the mesh's and force shading's.
#pragma once

#include "object.h"

#include <optional>
#include <string>

namespace sqmap::bench {

struct SlideOptions {
    bool sphere = false;       ///< 5 mm instead of a point
    double depth = 0.001;      ///< m below the surface
    double stiffness = 500;    ///< N/m
    haptic::ZoneOptions zone;  ///< layer, smoothing, shading, blending
    int planes = 3;            ///< sections along each axis
};

/// The map and the options that give the force.
enum class Force {
    Full,        ///< of the central model, with the options' zone
    Unsmoothed,  ///< the paper's, of a single point, on the map as it is
    Smoothed,    ///< the same on the smoothed map
    Averaged,    ///< and averaged over an impact sphere about the point, of the options' smoothing radius
};

/// One tick of a slide.
struct SlideTick {
    Vec3d at{};
    Vec3d mesh{}, shaded{}, ours{};              ///< N
    Vec3d unsmoothed{}, smoothed{}, averaged{};  ///< N, of the paper's maps, where the object has them
    double true_depth = 0, effective_depth = 0;
    bool sharp = false;  ///< an edge that turns by 45 degrees or more is in reach, or the nearest face flips
};

/// One object, all sections: the ways one after the other; first[i] is where way i begins.
struct Slide {
    std::vector<SlideTick> ticks;
    std::vector<std::size_t> first;
};
[[nodiscard]] Slide slide(const TouchObject& object, const SlideOptions& options);

/// Greatest and 99th percentile of |F_i - F_(i-1)|, N, a method.
struct Steps {
    double max[6] = {}, p99[6] = {};  ///< mesh, shading, ours, unsmoothed, smoothed, averaged
    std::size_t count = 0;
};
/// sharp: of ticks at sharp edges, or of the others; not given: of all.
[[nodiscard]] Steps steps_of(const Slide& slide, std::optional<bool> sharp = {});

/// Onset of force for a tool that comes from outside along the normal at random points of the surface: m outside it (negative:
/// inside).
struct Onset {
    double median = 0, p99 = 0, max = 0;  ///< of the absolute value, m
};
[[nodiscard]] Onset onset(const TouchObject& object, const SlideOptions& options, int positions);

/// Angle between the force of a point 1 mm deep and the true normal, degrees, at points where the surface is smooth: no edge
/// within 2 mm turns by more than 10 degrees.
struct NormalError {
    double median = 0, p95 = 0, max = 0;
    std::size_t positions = 0;
};
[[nodiscard]] NormalError normal_error(const TouchObject& object, const SlideOptions& options, int positions);

/// Energy that the force gives around closed ways of 3 mm about places of the surface, share of what it moves: positive is
/// gained. Of the field: at every position without memory of the last, and along pieces so short that their number does not
/// count. And J given, at most, by a device that goes the ten ways with most gain around 100 times at 0.1 m/s and 1 kHz, each
/// force held for a tick: as commanded, and behind the safety filter.
struct Energy {
    double worst = 0, median = 0, least = 0;       ///< greatest, of the absolute value, and least
    double commanded = 0, sent = 0;                ///< J
    double rubbed_commanded = 0, rubbed_sent = 0;  ///< the same with the friction of eq. 33
    std::size_t paths = 0;
};
/// Energy of a force; for the paper's forces also with the friction of eq. 33.
[[nodiscard]] Energy energy(const TouchObject& object, const SlideOptions& options, Force force, int positions);

[[nodiscard]] std::string slide_csv(const Slide& slide);

}  // namespace sqmap::bench
