// Many bodies that move: poses in, complete contacts out, on all cores.
#pragma once

#include "sqmap/query/contacts.h"
#include "sqmap/query/scene.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace sqmap::bulk {

/// Two bodies that are near each other, and which of the contacts are theirs.
struct PilePair {
    query::BodyId a = query::k_no_body, b = query::k_no_body;  ///< a < b
    std::size_t first = 0, count = 0;                          ///< contacts[first, first + count)
    std::size_t found = 0, meetings = 0, regions = 0;          ///< as of query::ContactResult
    std::uint16_t status = query::k_ok;                        ///< bits of Status and ContactStatus
    std::uint8_t reserved[sizeof(std::size_t) - 2] = {};       ///< zero: equal pairs have equal bytes
};

/// Contacts of a pile.
struct PileResult {
    std::span<const PilePair> pairs{};                  ///< that have a contact or a status, in the order of a, then b
    std::span<const query::SurfaceContact> contacts{};  ///< pair after pair, each as query_contacts gives them
    std::size_t near = 0;                               ///< pairs whose spheres touch
    std::uint16_t status = query::k_ok;                 ///< bits of Status and ContactStatus, of all
};

/// How a pile is queried.
struct PileOptions {
    query::ContactOptions contacts{};  ///< of each pair; first_only: of each pair the first
    unsigned threads = 0;              ///< one a core; the result does not depend on it
};

/// Bodies in one world. Which of them are near each other is kept from one query to the next and mended. A query gives, to the
/// bit, what query_contacts gives of each pair alone, whatever was queried before. For one thread at a time; two piles share
/// nothing.
class Pile {
public:
    /// contacts: of a pair, as of ContactWorkspace, for which there is space at first; a query of a pair that has more makes
    /// more.
    explicit Pile(std::size_t contacts = 4096);
    ~Pile();
    Pile(const Pile&) = delete;
    Pile& operator=(const Pile&) = delete;

    /// model, probe: as in query::Body; they outlive the body. The id of a removed body is given out again. Allocates.
    query::BodyId add(const model::ModelView* model, const query::Probe* probe, const Pose& pose = {});
    /// Nothing happens where there is no such body. Cost: linear in the bodies.
    void remove(query::BodyId id);
    /// False where the pose is not finite or there is no such body: a body without a finite pose is near nothing, and queries say
    /// k_not_finite.
    bool set_pose(query::BodyId id, const Pose& pose) noexcept;

    /// Number of bodies.
    [[nodiscard]] std::size_t size() const noexcept;
    /// @pre id is in the pile
    [[nodiscard]] const query::Body& body(query::BodyId id) const noexcept;

    /// Complete contacts of all pairs of bodies that are near each other. What the result points to is the pile's, valid until
    /// its next query. Allocates where there are more pairs or contacts than ever before. Cost: query_contacts of each pair,
    /// shared by the threads, which are started and joined each time.
    [[nodiscard]] PileResult query(const PileOptions& options = {});

private:
    struct Worker;
    std::size_t capacity_;  ///< of a new worker
    query::Scene scene_;
    std::vector<query::ScenePair> near_;
    std::vector<std::unique_ptr<Worker>> workers_;
    std::vector<PilePair> pairs_;
    std::vector<query::SurfaceContact> contacts_;
};

}  // namespace sqmap::bulk
