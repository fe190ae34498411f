// The bodies that a tool touches, and the tool's zones: materials, modes, options (section 6.1).
// Plain data: any number of threads may read it.
#pragma once

#include "sqmap/haptic/texture.h"
#include "sqmap/haptic/wrench.h"
#include "sqmap/math/friction.h"
#include "sqmap/model/model.h"
#include "sqmap/query/probe.h"

#include <cstdint>
#include <limits>
#include <span>

namespace sqmap::haptic {

/// How the direction of the force follows from the samples.
enum class Kernel : std::uint8_t {
    Ball,   ///< the mean of depth times normal over the ball, from the depths on its surface alone (divergence theorem): nothing
            ///< jumps
    Shell,  ///< the mean of depth times normal over the samples: for maps whose normals are better than their depths
};

/// Smoothing of the field about a point. A turn of the surface is spread over a path of 2 radius. The depth stays within
/// `tolerance` of the true one (equal for 0); the direction is that of a surface rounded by about radius tan(turn / 2) / 4.
struct Smoothing {
    Kernel kernel = Kernel::Ball;
    double radius = 0.0025;     ///< m; Averaging::Ball: the ball's own
    std::uint32_t points = 48;  ///< samples on the sphere
    double tolerance = 0.0002;  ///< m
};

/// Samples for a ball as tool, radius in metres; on a ball of 5 mm they are 0.8 mm apart.
[[nodiscard]] constexpr Smoothing ball_of(double radius) noexcept
{
    return {.radius = radius, .points = 500, .tolerance = 0.0003};
}

/// The surface of a touched body.
struct Material {
    Friction friction = Friction::Coulomb;
    double mu_static = 0.4, mu_dynamic = 0.3;
    double f_c = 0.2;                  ///< N, eq. 33
    double k_f = 100;                  ///< 1/m, eq. 33
    const Texture* texture = nullptr;  ///< eq. 34; outlives the step
};

/// A baked model in metres, posed in the world. It may move: its twist counts, and it gets a wrench of its own.
struct TouchedBody {
    const model::ModelView* model = nullptr;  ///< from model::parse, in metres (see in_metres)
    Pose pose{};                              ///< mesh frame -> world, rigid
    Twist twist{};                            ///< of the mesh frame's origin; m/s and rad/s, world axes
    Material material{};
    /// The same mesh with its triangles, metres, mesh frame: for zones with a surface. Null: their points alone touch it.
    const query::Probe* surface = nullptr;
};

/// How a zone follows the device.
enum class Mode : std::uint8_t {
    Direct,   ///< the zone's points are at the device's pose
    Proxy,    ///< a proxy stays outside the surface and the device pulls it: for thin bodies and deep presses. Turns with it
    Coupled,  ///< a simulated body, joined to the device by springs and dampers in position and rotation
};

/// How a zone's contacts become one force. None depends on the number of points.
enum class Averaging : std::uint8_t {
    Patch,    ///< mean over the contacts, weighted by area; a new contact begins with weight zero (entry_depth)
    Stencil,  ///< the points are those of a Tool that is a Point: the force at the zone's tip, smoothed over a small sphere about
              ///< it
    Ball,     ///< the same points: a ball about the zone's tip, as deep as its deepest point
};

/// The trade-off between full force at edges and conserved energy; see docs/algorithms/haptics.md.
enum class Shading : std::uint8_t {
    Levelled,    ///< full spring force across edges: size from the mean depth, direction from the mean of the normals
    Consistent,  ///< the gradient of one potential, so that a closed path gives no energy: weaker at edges
    Mean,        ///< the paper's mean of the contacts' forces (section 6.1): weaker wherever normals differ
};

/// Forces of a zone. SI units.
struct ZoneOptions {
    Mode mode = Mode::Direct;
    Averaging averaging = Averaging::Patch;
    Smoothing smoothing{};  ///< Stencil and Ball: the one that the probe's points were made with
    Shading shading = Shading::Levelled;
    /// m, Patch: depth of full weight; 0: every contact has it, the paper's mean. A proxy has at least half of proxy_depth, so
    /// that friction does not swing between the few points that it rests on.
    double entry_depth = 0.0005;
    query::Layer layer = query::Layer::Three;  ///< One is answered by Two: a superquadric pushes from outside the surface
    std::uint32_t gate = query::k_gate;        ///< k_L of Layer::Gate; 0: never Layer 3
    /// Paper models: depths and normals of the smoothed map, and the surface moved out by eq. 12.
    bool smoothed_map = false, offset = false;
    double stiffness = 500;             ///< k of eqs. 21 and 32, N/m (errata 10)
    double damping = 0;                 ///< N s/m along the normal while pressing in; never pulls
    double tangential_stiffness = 500;  ///< of the sticking spring of Coulomb friction, N/m
    double torque_share = 1;            ///< of the torque that goes out; 0: force only
    /// Pre-contact braking: N s/m against the approach, from where the zone will be after brake_ahead seconds; 0: none. Costs
    /// a second query.
    double brake = 0, brake_ahead = 0.005;
    /// s: a jump of the force, as at the medial axis, decays to 1/e in this time; 0: jumps pass.
    double blend_time = 0.010;
    /// m, the encoder's step of a device without twists: the velocity is that over the longest past that one velocity fits to
    /// within this step; 0: over the last tick.
    double resolution = 0;
    /// m, Proxy with a Patch or a Ball (at most a fifth of its radius): the depth at which the proxy rests, so that many points
    /// bear it. The force is then smooth and the torque soft: as the tool turns, the bearing point moves across it. A Patch in
    /// something thinner rises until it no longer touches the far side. 0: it rests on one point.
    double proxy_depth = 0.002;
    /// m, Proxy. 0: the proxy goes to the allowed position nearest to the device, and so round what is thinner than the press is
    /// deep. Above 0 it stays above the device along the direction that it came from, which turns to the surface's normal (by
    /// all but 1/e) while the device moves so far across it: a leg or an ear is then held at any press.
    double side_path = 0;
    /// Coupled: spring and damper between device and body, and the body. Defaults: for a light desktop stylus (b 1 N s/m, a tick
    /// of delay); choose_coupling takes a device's own numbers. A light body is not noticed in free air.
    double coupling_stiffness = 450, coupling_rotational = 0.18;        ///< N/m, N m/rad
    double mass = 0.005, inertia = 2e-6;                                ///< kg, kg m^2 about every axis
    double coupling_damping = 0.2, coupling_rotational_damping = 8e-5;  ///< N s/m, N m s/rad
};

/// The same surface with more points.
struct DenserPoints {
    const query::Probe* probe = nullptr;  ///< in metres, the zone's frame
    std::span<const float> weights{};     ///< area per point; outlives the state
};

/// An impact zone (section 6.1): a part of the tool with one force.
struct Zone {
    const query::Probe* probe = nullptr;  ///< in metres; adjacent zones with one probe and one pose share a query
    bool in_world = false;                ///< the probe's points are in the world (Probe::move), not in the zone's frame
    std::uint32_t first = 0, count = std::numeric_limits<std::uint32_t>::max();  ///< the probe's points that belong to it
    Vec3d tip{};                       ///< Stencil and Ball: the centre of the points, the zone's frame
    std::span<const float> weights{};  ///< Patch: area per point, #points of the probe; empty: all alike. Outlives the state
    /// Patch, for a zone with all points of its probe: sets of ever more points of the same surface. A tick moves on by one set
    /// at most, to the next denser one only if that would have at most max_touching points in contact, so that large triangles
    /// touch between their corners too and small ones cost no more. The change of force is blended. Outlives the state.
    std::span<const DenserPoints> denser{};
    std::uint32_t max_touching = 1200;
    double radius = std::numeric_limits<double>::infinity();  ///< m, of the impact sphere about the zone's pose
    /// Patch, for a zone with all points of its probe: a closed surface with triangles, metres, the zone's frame. Its edges and
    /// faces are in contact where they meet those of TouchedBody::surface, each like one point of mean area: a ridge between two
    /// points is felt. Triangles are compared with triangles, whatever the layer. Their weight falls as more points touch; while
    /// 24 or more do, edges are not looked for. Null: points alone. Outlives the state.
    const query::Probe* surface = nullptr;
    ZoneOptions options{};
};

}  // namespace sqmap::haptic
