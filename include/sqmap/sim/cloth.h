// Cloth on bodies: Bullet's soft body holds the threads, sqmap finds the contacts.
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

/// A body that cloth lies on: a model and its pose at the step's beginning and end. x_world = pose x_mesh, m. With a skin the
/// model is that of the bound mesh, the skin gives its shape in the world, and the poses move only nodes that are pinned to it.
/// A collider without a model has no contacts: it only carries pins.
struct Collider {
    const model::ModelView* model = nullptr;
    Pose previous{}, pose{};
    query::MovingSkin* skin = nullptr;
};

/// Options of a cloth. SI units, world axes.
struct ClothOptions {
    Vec3d gravity{0, -9.81, 0};
    query::Layer layer = query::Layer::Three;
    Friction friction = Friction::Coulomb;  ///< Coulomb: Fabric::friction is both coefficients
    double paper_friction = 0.002;          ///< f_c of eq. 33, N a node
    double paper_stiffness = 100;           ///< k_f of eq. 33 with depth in m, 1 / m
    int iterations = 12;                    ///< equal shares of a step, each of which is solved once, threads and contacts
    double max_speed = 10;                  ///< m / s: faster nodes are slowed to it, k_cloth_slowed
    double sweep_step = 0.01;               ///< m: colliders twice as thick are not tunnelled through
    bool self_collision = false;            ///< the cloth keeps thickness from itself and does not go through itself
};

/// Bits of StepReport::status.
enum ClothStatus : std::uint32_t {
    k_cloth_ok = 0,
    k_cloth_not_finite = 1,    ///< a node was NaN or infinite: the cloth was put back to the step before, at rest
    k_cloth_slowed = 2,        ///< a node was faster than max_speed
    k_cloth_full = 4,          ///< more contacts than the cloth keeps, four a node on average: the rest does not count
    k_cloth_coarse_sweep = 8,  ///< a node moved so far that contacts with thin parts may be missed: shorten the time step
    k_cloth_bad_step =
        16,  ///< dt or a pose was not finite or not positive, or a collider had a skin without expect(): nothing was done
    k_cloth_crowded = 32,  ///< more surfaces of a skinned collider at one node than a query examines
    k_cloth_stretched =
        64,  ///< a quarter of the threads are stretched by more than k_max_stretch: smaller steps, or more iterations
    k_cloth_tangled = 128,  ///< with self_collision: the cloth went through itself, as when held nodes leave it no path
};

/// Stretch, as a share of rest length, of k_cloth_stretched. Stiffness by position has no modulus: the strain that the solver
/// leaves grows with the square of the step, and it has no energy. So every sixteenth step measures the threads; the bit stays
/// until the next measurement.
constexpr double k_max_stretch = 0.1;

/// Seconds of CPU time in a step.
struct StepTime {
    double predict = 0;   ///< Bullet: forces, integration, its trees
    double move = 0;      ///< sqmap: the probe's points posed and its clusters refitted
    double query = 0;     ///< sqmap: contacts of all colliders
    double response = 0;  ///< contacts' share of the iterations
    double threads = 0;   ///< Bullet: links
    double self = 0;      ///< the cloth against itself
};

/// A step's outcome.
struct StepReport {
    std::uint32_t status = k_cloth_ok;
    std::size_t contacts = 0;  ///< nodes with one or more
    std::size_t caught = 0;    ///< of these, by the sweep alone
    double deepest = 0;        ///< m below the surface, of nodes at the end of the step, by the planes of their contacts
    double fastest = 0;        ///< m / s
    std::uint32_t fastest_node = 0;
    double kinetic = 0, potential = 0;  ///< J; potential: of gravity, none of the threads
    StepTime seconds;
};

/// Rest of a drape.
struct DrapeReport {
    bool at_rest = false;            ///< for the last quarter of a second no node was faster than the threshold
    double since = 0;                ///< s, once at rest: the end of the first quiet step
    double fastest = 0;              ///< m / s, in the last step
    std::uint32_t fastest_node = 0;  ///< whose
};

/// Decides from the steps, one after the other, whether a drape has come to rest. One thread at a time.
class Drape {
public:
    static constexpr double k_quiet = 0.25, k_slow = 0.05;  ///< s; m/s

    explicit Drape(double threshold = k_slow) : threshold_(threshold) {}  ///< m / s
    /// time: at the step's end, s.
    void add(const StepReport& step, double time) noexcept;
    [[nodiscard]] const DrapeReport& report() const noexcept { return report_; }  ///< of the steps so far
    [[nodiscard]] double threshold() const noexcept { return threshold_; }        ///< m / s

private:
    double threshold_;
    double quiet_since_ = -1;  ///< -1: none
    DrapeReport report_;
};

/// Cloth of threads. Seams that are sewn at first are drawn together one after the other, in half a second each, during which the
/// cloth has no weight. Not copyable, movable; a moved-from cloth may only be destroyed or assigned to. Set-up allocates and may
/// throw; a step allocates only with self_collision. Thread safety: one thread at a time, const functions included; several
/// cloths at once, also on the same models and skins while nobody steps a skin.
class Cloth {
public:
    /// @throw std::invalid_argument for a garment with indices out of range, without a triangle, or with positions not finite
    Cloth(const Garment& garment, const Fabric& fabric, const ClothOptions& options = {});
    ~Cloth();
    Cloth(Cloth&&) noexcept;
    Cloth& operator=(Cloth&&) noexcept;

    /// Prepares for colliders with skins; call it before the first step with one. Allocates about 2 kB per node.
    void expect(const query::SkinLattice& lattice);

    /// One step of dt seconds. Pinned nodes ride their colliders. Bad input (k_cloth_bad_step) changes nothing.
    /// Cost: linear in the nodes, threads and contacts, times the iterations.
    StepReport step(double dt, std::span<const Collider> colliders) noexcept;

    /// Moves what is still inside colliders with skins out of them, nodes and points of triangles and edges, without a
    /// change of speed: for the positions that are shown or written. Contacts of a step are planes, found before the last of its
    /// motion and by options.layer; here the exact layer is queried until nothing is inside, a few times at most. Between two
    /// parts of a body that leave no space something may stay inside. The edges of closed seams are brought together, which a
    /// pull draws apart. Returns how many points were moved out. No allocation. Cost: exact queries of the nodes and of points of
    /// all triangles, about as much as a step.
    std::size_t settle(std::span<const Collider> colliders) noexcept;

    [[nodiscard]] std::size_t size() const noexcept;                                         ///< number of nodes
    [[nodiscard]] std::span<const std::array<std::uint32_t, 3>> triangles() const noexcept;  ///< of the garment
    [[nodiscard]] std::span<const Vec3d> positions() const noexcept;                         ///< world, m; until the next step
    [[nodiscard]] std::span<const Vec3d> velocities() const noexcept;  ///< m / s, world; until the next step
    /// Query points of the last step, world, m: a little more than the thickness below each node that is in contact.
    [[nodiscard]] std::span<const Vec3d> query_points() const noexcept;
    /// For each vertex, the mean over its triangles of the largest stretch of their edges, length over rest length less 1.
    [[nodiscard]] std::vector<double> strain() const;
    /// Number of its self-crossings now: an edge through the interior of a triangle; sewn pairs count as one vertex. Allocates.
    [[nodiscard]] std::size_t crossings() const;

    static constexpr std::uint32_t k_world = 0xffffffffu;  ///< for a collider's number: no collider
    /// Nodes keep their present position relative to a collider (its number at step, pose: its present one); k_world: in the
    /// world.
    /// @throw std::invalid_argument for a node that does not exist
    void pin(std::span<const std::uint32_t> nodes, std::uint32_t collider, const Pose& pose);
    /// Nodes that are not pinned stay as they are.
    void unpin(std::span<const std::uint32_t> nodes);

    [[nodiscard]] std::size_t seams() const noexcept;  ///< number of the garment's seams
    void cut(std::size_t seam);                        ///< @throw std::out_of_range unless seam < seams(); as do the next two
    void sew(std::size_t seam);                        ///< threads draw the edges together over half a second
    /// Largest distance of a pair of the seam, m.
    [[nodiscard]] double gap(std::size_t seam) const;

    /// Holds a node and those within radius, m, of it by springs, at their positions relative to a tool (world, m). stiffness:
    /// N/m, of all springs together. Held nodes still have contacts; pinned ones are not held. Threads that run to the grip are
    /// not drawn longer than 1.3 times: a tool that goes on stretches the springs.
    /// @throw std::invalid_argument for a node that does not exist or a stiffness that is not positive
    void grasp(std::uint32_t node, double radius, Vec3d tool, double stiffness = 500);
    void drag(Vec3d tool) noexcept;                ///< moves the tool; ignored unless finite
    void release();                                ///< ends the grasp; the tension is zero then
    [[nodiscard]] Vec3d tension() const noexcept;  ///< N, world, on the tool, by the springs

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Largest penetration depths of cloth in colliders, m; zero if nothing is inside. In a union of colliders the deepest one
/// counts, which bounds the depth in the union from below.
struct Penetration {
    double nodes = 0, interiors = 0;
    Vec3d node_at{}, interior_at{};  ///< their positions, world
};
/// How triangles are sampled: a grid of barycentric coordinates, corners left out.
struct PenetrationOptions {
    int steps = 3;  ///< per edge
    query::Layer layer = query::Layer::Exact;
};
/// Queries the models at the nodes and at samples within the triangles (skins: all points at once). World, m. Allocates.
/// Cost: an exact query per point and collider. Any thread.
/// @pre triangles index nodes
[[nodiscard]] Penetration penetration(std::span<const Vec3d> nodes, std::span<const std::array<std::uint32_t, 3>> triangles,
                                      std::span<const Collider> colliders, const PenetrationOptions& options = {});

}  // namespace sqmap::sim
