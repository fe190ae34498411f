// Cloth on bodies: Bullet's soft body carries the threads, sqmap the contacts.
#pragma once

#include "sqmap/math/friction.h"
#include "sqmap/query/skin.h"
#include "sqmap/query/swept.h"
#include "sqmap/sim/garment.h"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace sqmap::sim {

/// A collider that cloth lies on: a model and where it is, at the step's beginning and end. x_world = pose x_mesh, m. With a skin
/// the model is that of the bound mesh, and the skin says where it is, in the world; the poses move what is pinned to it alone.
/// Without a model there is nothing to lie on: a joint that pins ride.
struct Collider {
    const model::ModelView* model = nullptr;
    Pose previous{}, pose{};
    query::MovingSkin* skin = nullptr;
};

struct ClothOptions {
    Vec3d gravity{0, -9.81, 0};
    query::Layer layer = query::Layer::Three;
    Friction friction = Friction::Coulomb;  ///< Coulomb: Fabric::friction is both coefficients
    double paper_friction = 0.002;          ///< f_c of eq. 33, N a node
    double paper_stiffness = 100;           ///< k_f of eq. 33 with depth in m, 1 / m
    int iterations = 12;                    ///< of the threads' solver, each followed by the contacts
    double max_speed = 10;                  ///< m / s: faster nodes are slowed to it, k_cloth_slowed
    double sweep_step = 0.01;               ///< m: colliders twice as thick are not tunnelled through
    bool self_collision = false;            ///< the cloth keeps thickness from itself, and does not go through itself on the way
};

enum ClothStatus : std::uint32_t {
    k_cloth_ok = 0,
    k_cloth_not_finite = 1,    ///< a node was NaN or infinite: the cloth was put back to the step before, at rest
    k_cloth_slowed = 2,        ///< a node was faster than max_speed
    k_cloth_full = 4,          ///< more contacts than there is room for
    k_cloth_coarse_sweep = 8,  ///< a node moved so far that thin parts may have been missed
    k_cloth_bad_step = 16,     ///< dt or a pose was not finite or not positive, or a skin was not expected: nothing was done
    k_cloth_crowded = 32,      ///< more places of a skinned collider at one node than are looked at
    k_cloth_stretched =
        64,  ///< a quarter of the threads are stretched by more than k_max_stretch: smaller steps, or more iterations
    k_cloth_tangled = 128,  ///< with self_collision: the cloth went through itself, as where what is held leaves it no way
};

/// Of rest length. Stiffness by position has no modulus: what the solver leaves of a strain grows with the square of the step,
/// and no energy can be given for it. So the threads are looked at, every sixteenth step; the bit stays until the next look.
constexpr double k_max_stretch = 0.1;

/// Seconds of CPU time.
struct StepTime {
    double predict = 0;   ///< Bullet: forces, integration, its trees
    double move = 0;      ///< sqmap: the probe's points posed and its clusters refitted
    double query = 0;     ///< sqmap: contacts of all colliders
    double response = 0;  ///< contacts' share of the iterations
    double threads = 0;   ///< Bullet: links
    double self = 0;      ///< the cloth against itself
};

struct StepReport {
    std::uint32_t status = k_cloth_ok;
    std::size_t contacts = 0;  ///< nodes with one or more
    std::size_t caught = 0;    ///< of which the sweep alone saw
    double deepest = 0;        ///< m below the surface, of nodes at the end of the step; by the planes of their contacts
    double fastest = 0;        ///< m / s
    std::uint32_t fastest_node = 0;
    double kinetic = 0, potential = 0;  ///< J; potential: of gravity, none of the threads
    StepTime seconds;
};

/// Whether a drape has come to rest.
struct DrapeReport {
    bool at_rest = false;            ///< for the last quarter of a second no node was faster than the threshold
    double since = 0;                ///< s, where it is: when the first step of that kind ended
    double fastest = 0;              ///< m / s, in the last step
    std::uint32_t fastest_node = 0;  ///< whose
};

/// Tells it from the steps, one after the other.
class Drape {
public:
    static constexpr double k_quiet = 0.25, k_slow = 0.05;  ///< s; m/s

    explicit Drape(double threshold = k_slow) : threshold_(threshold) {}  ///< m / s
    /// time: at the step's end, s.
    void add(const StepReport& step, double time) noexcept;
    [[nodiscard]] const DrapeReport& report() const noexcept { return report_; }
    [[nodiscard]] double threshold() const noexcept { return threshold_; }

private:
    double threshold_;
    double quiet_since_ = -1;  ///< or none
    DrapeReport report_;
};

/// Seams that are sewn at first are drawn together one after the other, in half a second each, in which the cloth has no weight.
/// Not copyable, movable. Set-up allocates and may throw; a step allocates only where self_collision is on.
class Cloth {
public:
    /// @throw std::invalid_argument for a garment with indices out of range, without a triangle, or with places not finite
    Cloth(const Garment& garment, const Fabric& fabric, const ClothOptions& options = {});
    ~Cloth();
    Cloth(Cloth&&) noexcept;
    Cloth& operator=(Cloth&&) noexcept;

    /// Before the first step with a collider that has a skin: room for asking it. Allocates, about 2 kB a node.
    void expect(const query::SkinLattice& lattice);

    /// One step of dt seconds. Pinned nodes ride their colliders. Never throws.
    StepReport step(double dt, std::span<const Collider> colliders) noexcept;

    [[nodiscard]] std::size_t size() const noexcept;
    [[nodiscard]] std::span<const std::array<std::uint32_t, 3>> triangles() const noexcept;
    [[nodiscard]] std::span<const Vec3d> positions() const noexcept;   ///< world, m
    [[nodiscard]] std::span<const Vec3d> velocities() const noexcept;  ///< m / s
    /// Where the last step asked the colliders about each node: a little more than the thickness below it where it touches.
    [[nodiscard]] std::span<const Vec3d> query_points() const noexcept;
    /// Of each vertex: the mean over its triangles of the largest stretch of their edges, length over rest length less 1.
    [[nodiscard]] std::vector<double> strain() const;
    /// How often it goes through itself now (crossings.h); what is sewn together is one.
    [[nodiscard]] std::size_t crossings() const;

    /// Nodes keep their place relative to a collider (its number at step), as they are now; k_world: where they are.
    static constexpr std::uint32_t k_world = 0xffffffffu;
    void pin(std::span<const std::uint32_t> nodes, std::uint32_t collider, const Pose& pose);
    void unpin(std::span<const std::uint32_t> nodes);

    [[nodiscard]] std::size_t seams() const noexcept;
    void cut(std::size_t seam);  ///< @pre seam < seams(); so below
    void sew(std::size_t seam);  ///< threads draw the edges together over half a second
    /// Largest distance of a pair of the seam, m.
    [[nodiscard]] double gap(std::size_t seam) const;

    /// Holds a node and what is within radius of it by springs, at their places relative to a tool; tension is what it feels.
    /// stiffness: N/m, of all of them together; what is held still lies on colliders. Nodes that are pinned are not held.
    void grasp(std::uint32_t node, double radius, Vec3d tool, double stiffness = 500);
    void drag(Vec3d tool) noexcept;
    void release();
    [[nodiscard]] Vec3d tension() const noexcept;  ///< N, on the tool, of the springs

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Deepest places of cloth in colliders, asked of the models point by point (skins: all points at once): nodes, and samples
/// within triangles (a grid of barycentric coordinates with the given steps an edge, corners left out). m; zero where nothing is
/// inside. Of a union of colliders the deepest collider counts, which bounds the depth in the union from below.
struct Penetration {
    double nodes = 0, interiors = 0;
    Vec3d node_at{}, interior_at{};  ///< where, world
};
[[nodiscard]] Penetration penetration(std::span<const Vec3d> nodes, std::span<const std::array<std::uint32_t, 3>> triangles,
                                      std::span<const Collider> colliders, int steps, query::Layer layer = query::Layer::Exact);

}  // namespace sqmap::sim
