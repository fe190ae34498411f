// The state of a cloth: Bullet's soft body with threads, seams and pins, and the contacts that sqmap finds. One thread at a time.
#pragma once

#include "contacts.h"
#include "interiors.h"
#include "self_contacts.h"
#include "settling.h"

#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyInternals.h>

namespace sqmap::sim {

inline constexpr double k_sewing_time = 0.5;  ///< s: in which a seam is drawn together

struct Cloth::State {
    struct SeamLinks {
        int first = 0, count = 0;  ///< of the body's links
        bool sewn = true;
        std::vector<btScalar> gap;  ///< rest lengths at the time of sewing
        double age = 0;             ///< negative while it waits for the seams before it
        bool carried = true;        ///< hands carry the cloth: its first sewing
        /// True once its edges are drawn together.
        [[nodiscard]] bool is_closed() const { return sewn && age >= k_sewing_time; }
    };
    struct Pin {
        std::uint32_t node, collider;
        Vec3d local;     ///< position in the collider's frame
        Vec3d from, to;  ///< in this step
        btScalar mass;
    };
    struct Restless {
        Vec3f path{};                   ///< of the last step in which it stirred
        float turns = 0, leash = 1e9f;  ///< recent reversals; m
    };
    /// A node on a spring to its position in a tool's grip.
    struct Held {
        std::uint32_t node;
        Vec3d offset;  ///< from the tool
    };
    /// A link between two nodes: with Moving the data of Bullet's own, in an eighth of the bytes. The solver reads them a dozen
    /// times a step, and the contacts wait for all that these reads push out of the caches.
    struct Thread {
        std::uint32_t a, b;
        float stiff, rest_sq;  ///< inverse masses over stiffness, zero where it is cut or a diagonal; Bullet's c1
    };
    /// A diagonal of the weave, which resists shear.
    struct Shear {
        std::uint32_t a, b;
        float rest;
    };
    /// The force of a hinge, or of all hinges on a node, and how far a hinge gives.
    struct Bending {
        Vec3f force{};         ///< N; of a hinge on each node by its weight
        float compliance = 0;  ///< m / N, of a hinge's weighted sum; 0 for a node
    };
    /// Two triangles beside an edge: the edge's ends and the corners opposite. The weighted sum of their positions is the bending
    /// (Bergou et al. 2006).
    struct Hinge {
        std::array<std::uint32_t, 4> node;
        std::array<float, 4> weight;
        Bending bending;
    };

    /// A thread in a pull: the end nearer to the hand follows the other one.
    struct Pulled {
        std::uint32_t near, far;
        float max;  ///< m
    };

    /// One of the equal shares that a step is solved in (Macklin et al. 2019). done: the part of the step that is over with it.
    struct Share {
        double dt, done, part;
    };

    // cloth_setup.cpp
    State(const Garment& garment, const Fabric& f, const ClothOptions& o);
    void add_threads(const Garment& garment);
    /// The bending across an edge, in a pattern that is flat.
    void add_hinge(const Garment& garment, const std::array<std::uint32_t, 4>& node, bool diagonal_edge);
    /// Orders the hinges so that neighbours in the list lie far apart in the cloth.
    void spread_hinges();
    void add_mass(const Garment& garment);
    void add_seams(const Garment& garment);
    /// A number for each node; nodes that are sewn together have the same.
    std::vector<std::uint32_t> sewn_names() const;

    // cloth_handling.cpp
    void set_seams(double dt);
    void move_pins(std::span<const Collider> colliders);
    /// The springs of the grip, by extended position-based dynamics (Macklin et al. 2016): as stiff as they are said to be,
    /// whatever the step and the shares. Adds to the step's mean tension.
    void solve_held(const Share& share);

    // pulling.cpp
    /// Orders the threads from the far end of the cloth to the nodes that a tool holds; none where it holds nothing.
    void find_pulled();
    /// Draws nodes back whose threads a pull has made too long, in one sweep from the far end to the tool.
    void solve_pulled();

    // cloth_solver.cpp
    /// Copies Bullet's nodes at the beginning of a step.
    void take_nodes();
    /// Copies Bullet's links, where one has changed.
    void take_links();
    /// Moves nodes on by their speed and weight, pinned ones to where they are in this share.
    void advance(const Share& share, Vec3d gravity);
    /// A sweep of Bullet's PSolve_Links.
    void solve_threads();
    /// Solves threads again that were too long as the step began: those that bear a pull.
    void solve_tight();
    /// Chooses them.
    void find_tight();
    /// Adds up the forces of the hinges on each node.
    void sum_bending();
    /// Bending and shear, with what cloth loses of either.
    void solve_bending(const Share& share);
    void solve_shear(const Share& share);
    /// Raises the nodes of triangles that a collider pierces, each by its weight at the point; in a share with friction. null: at
    /// the end of the step.
    void push_interiors_out(const Share* share);
    /// Moves nodes out of half-spaces as they are in a share, with friction.
    void push_out(const Share& share);
    /// Moves nodes out of the half-spaces that were found at the end of the step.
    void push_out_last();
    /// Nodes take the speed that the share's solution gave them.
    void take_speeds(double dt);
    /// Cuts the path of each node to max_speed, so that the sweep can follow it.
    void limit(double dt, StepReport& report);
    /// Stills nodes that go to and fro without end while no collider moves and the cloth as a whole hardly does.
    void still_restless(double dt, bool colliders_stand);
    void finish(double dt, bool colliders_stand, StepReport& report);
    /// True if a quarter of the threads, diagonals of the weave too, are longer than k_max_stretch allows; measured now and then.
    bool stretched();

    btSoftBody::Node& node(std::size_t i) { return body->m_nodes[static_cast<int>(i)]; }
    std::uint32_t number(const btSoftBody::Node* n) const { return static_cast<std::uint32_t>(n - &body->m_nodes[0]); }

    Fabric fabric;
    ClothOptions options;
    btSoftBodyWorldInfo info;
    std::unique_ptr<btSoftBody> body;
    std::vector<Moving> moving;
    std::vector<Restless> restless;
    double last_kinetic = 0;
    std::vector<Moving> before;           ///< the nodes as a share begins
    std::vector<Bending> bends;           ///< of all hinges on each node
    std::vector<Vec3f> speed, predicted;  ///< m / s; positions as a share is predicted
    std::vector<Hinge> hinges;
    std::vector<Shear> shears;
    std::vector<Thread> tight;           ///< threads that were too long as the step began
    std::vector<std::uint8_t> weak;      ///< diagonals and seams
    std::vector<std::uint8_t> diagonal;  ///< of each link: whether it is one of shears
    bool links_changed = true;
    std::uint32_t steps = 0;
    bool was_stretched = false;
    std::vector<Thread> threads;  ///< Bullet's links, in their order
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<Vec3d> position, previous, good, velocity;
    std::vector<SeamLinks> seams;
    std::vector<Pin> pins;
    std::vector<Held> held;
    std::vector<Pulled> pulled;  ///< empty where nothing is held
    double grip_stiffness = 0;   ///< N / m, of all the springs
    Vec3d tool{}, tension{};
    std::unique_ptr<SelfContacts> self;  ///< null without self_collision
    std::vector<std::uint32_t> names;    ///< sewn_names() now
    Contacts contacts;
    Interiors interiors;
    Settling settling;
};

}  // namespace sqmap::sim
