// The broad phase of a scene, then each pair by whichever thread is free; results are put together in the order of the pairs.
#include "sqmap/bulk/pile.h"

#include "parallel/for_each.h"

#include <algorithm>
#include <atomic>

namespace sqmap::bulk {

/// A thread's own: the space of a pair, and the contacts of all pairs that it has done.
struct Pile::Worker {
    explicit Worker(std::size_t first_capacity) : capacity(first_capacity), space(first_capacity) {}

    /// None is lost: a pair that has more contacts than there is space for is queried again with four times as much.
    query::ContactResult query(const query::Body& a, const query::Body& b, const query::ContactOptions& options)
    {
        for (;;) {
            const query::ContactResult found = query::query_contacts(a, b, options, space);
            if ((found.status & query::k_full) == 0 || capacity >= k_max_contacts) return found;
            capacity *= 4;
            space = query::ContactWorkspace(capacity);
        }
    }

    static constexpr std::size_t k_max_contacts = std::size_t{1} << 28;

    /// A pair that has something to say, and where its contacts begin.
    struct Done {
        std::size_t near;  ///< number of the pair
        PilePair pair;
    };
    std::size_t capacity;
    query::ContactWorkspace space;
    std::vector<query::SurfaceContact> contacts;
    std::vector<Done> done;
};

Pile::Pile(std::size_t contacts) : capacity_(std::max<std::size_t>(contacts, 1)), scene_(1) {}
Pile::~Pile() = default;

query::BodyId Pile::add(const model::ModelView* model, const query::Probe* probe, const Pose& pose)
{
    return scene_.add(model, probe, pose);
}
void Pile::remove(query::BodyId id) { scene_.remove(id); }
bool Pile::set_pose(query::BodyId id, const Pose& pose) noexcept { return scene_.set_pose(id, pose); }
std::size_t Pile::size() const noexcept { return scene_.size(); }
const query::Body& Pile::body(query::BodyId id) const noexcept { return scene_.body(id); }

PileResult Pile::query(const PileOptions& options)
{
    query::SceneResult near = scene_.pairs(near_);
    if (near.pairs_full) {
        near_.resize(near.pairs + near.pairs / 4);
        near = scene_.pairs(near_);
    }
    const std::size_t threads = std::clamp<std::size_t>(near.pairs, 1, parallel::thread_count(options.threads));
    while (workers_.size() < threads) workers_.push_back(std::make_unique<Worker>(capacity_));
    std::atomic<std::size_t> next{0};
    parallel::for_each(threads, static_cast<unsigned>(threads), [&](std::size_t w) {
        Worker& worker = *workers_[w];
        worker.contacts.clear();
        worker.done.clear();
        for (std::size_t i = next++; i < near.pairs; i = next++) {
            const query::BodyId a = near_[i].a, b = near_[i].b;
            const query::ContactResult found = worker.query(scene_.body(a), scene_.body(b), options.contacts);
            if (found.found == 0 && found.status == query::k_ok) continue;
            worker.done.push_back({i,
                                   {a,
                                    b,
                                    worker.contacts.size(),
                                    found.contacts.size(),
                                    found.found,
                                    found.meetings,
                                    found.regions,
                                    found.status,
                                    {}}});
            worker.contacts.insert(worker.contacts.end(), found.contacts.begin(), found.contacts.end());
        }
    });

    // Each worker's pairs are in order.
    PileResult out;
    out.near = near.pairs;
    out.status = near.status;
    pairs_.clear();
    contacts_.clear();
    std::vector<std::size_t> at(threads, 0);
    for (;;) {
        std::size_t first = threads;
        for (std::size_t w = 0; w < threads; ++w) {
            const auto& done = workers_[w]->done;
            if (at[w] < done.size() && (first == threads || done[at[w]].near < workers_[first]->done[at[first]].near)) first = w;
        }
        if (first == threads) break;
        const Worker& worker = *workers_[first];
        PilePair pair = worker.done[at[first]++].pair;
        const auto from = worker.contacts.begin() + static_cast<std::ptrdiff_t>(pair.first);
        pair.first = contacts_.size();
        contacts_.insert(contacts_.end(), from, from + static_cast<std::ptrdiff_t>(pair.count));
        pairs_.push_back(pair);
        out.status |= pair.status;
    }
    out.pairs = pairs_;
    out.contacts = contacts_;
    return out;
}

}  // namespace sqmap::bulk
