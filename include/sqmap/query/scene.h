// Hundreds of posed bodies: which are near each other, and their contacts.
#pragma once

#include "sqmap/math/assert.h"
#include "sqmap/query/pair.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::query {

/// Names a body of a scene.
using BodyId = std::uint32_t;
/// Names none.
inline constexpr BodyId k_no_body = 0xffffffffu;

/// Bodies that are near each other, and which of the contacts are theirs.
struct ScenePair {
    BodyId a = k_no_body;
    BodyId b = k_no_body;                ///< none: the collider of query_probe
    std::uint32_t first = 0, count = 0;  ///< contacts[first, first + count)
    std::uint8_t status = k_ok;          ///< bits of Status
};

/// Contacts of a scene.
struct SceneResult {
    std::size_t pairs = 0;       ///< of near bodies, written or not
    std::size_t contacts = 0;    ///< written, of all pairs
    std::uint8_t status = k_ok;  ///< bits of Status
    bool pairs_full = false;     ///< more pairs than fit, the rest is counted and not queried: give a longer span of pairs
};

/// Bodies in one world. Adding and removing them may allocate and belongs outside the tick; all the rest is total, noexcept and
/// allocates nothing. For one thread at a time, queries included: they sort what has moved. Two scenes share nothing, so each
/// may have its thread. Answers depend on the bodies and their poses, not on how they got there
/// (which pairs a span that is too short holds may).
class Scene {
public:
    /// Maximum of contacts that a pair of bodies has in one direction; see PairWorkspace.
    explicit Scene(std::size_t contacts_in_a_direction = 4096);

    /// model, probe: as in Body; they outlive the body. The id of a removed body is given out again.
    BodyId add(const model::ModelView* model, const Probe* probe, const Pose& pose = {});
    /// Nothing happens where there is no such body. Cost: linear in the bodies.
    void remove(BodyId id);

    /// False where the pose is not finite or there is no such body: a body without a finite pose is near nothing, and queries
    /// say k_not_finite. Set the pose again when the body's probe has been moved out of its sphere.
    bool set_pose(BodyId id, const Pose& pose) noexcept;

    /// Number of bodies.
    [[nodiscard]] std::size_t size() const noexcept { return order_.size(); }
    /// @pre id is in the scene.
    [[nodiscard]] const Body& body(BodyId id) const noexcept
    {
        SQMAP_ASSERT(id < bodies_.size());
        return bodies_[id];
    }

    /// Pairs of bodies whose spheres touch and of which one has a map and the other vertices, or both triangles; a < b, in the
    /// order of a, then b. Cost: near linear in the bodies, and in the pairs that overlap along the world axis on which fewest
    /// do.
    [[nodiscard]] SceneResult pairs(std::span<ScenePair> pairs) noexcept;

    /// The same with their contacts, pair after pair; spheres count as larger by what the options move surfaces out.
    [[nodiscard]] SceneResult query_pairs(const PairOptions& options, std::span<ScenePair> pairs,
                                          std::span<PairContact> contacts) noexcept;

    /// Contacts of a collider's probe with the models of all bodies: the collider is b of each pair, whether or not it is itself
    /// in the scene; its model is not queried. A collider without a probe has none.
    [[nodiscard]] SceneResult query_probe(const Body& collider, const QueryOptions& options, std::span<ScenePair> pairs,
                                          std::span<PairContact> contacts) noexcept;

private:
    struct Entry {
        double lo;  ///< where the body's sphere begins on the axis; infinity without a finite pose
        BodyId id;
    };
    struct PairList;
    static constexpr std::size_t k_block = 8;

    void update() noexcept;
    /// Pairs of bodies at most slack apart.
    SceneResult find(double slack, std::span<ScenePair> pairs) noexcept;
    /// The most that options move any body's surface out.
    double largest_reach(const QueryOptions& options) const noexcept;
    void choose_axis() noexcept;
    void sort() noexcept;
    void narrow() noexcept;
    /// Some sphere of sorted_[first, first + k_block) may be at most slack from s.
    bool any_near(std::size_t s, std::size_t first, float slack) const noexcept;
    /// The spans that pairs and contacts are written to.
    struct Output {
        std::span<ScenePair> pairs;
        std::span<PairContact> contacts;
    };
    /// Queries the pairs that were found; collider: b of each, or null.
    SceneResult query(SceneResult result, const Body* collider, const PairOptions& options, const Output& to) noexcept;

    std::vector<Body> bodies_;     // by id
    std::vector<Sphere> spheres_;  // by id, the world's frame; radius below zero without a finite pose
    std::vector<BodyId> free_;
    std::vector<Entry> order_;               // of bodies in the scene, by lo
    std::vector<Sphere> sorted_;             // their spheres, in that order
    std::vector<float> x_, y_, z_, radius_;  // and again, about the first, a little larger; whole blocks
    std::size_t posed_ = 0;                  // of order_: those with a finite pose come first
    double largest_radius_ = 0;
    int axis_ = 0;
    bool stale_ = true;  // order_ and what follows it
    PairWorkspace workspace_;
};

}  // namespace sqmap::query
