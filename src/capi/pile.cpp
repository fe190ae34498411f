// Many bodies that move, behind the C interface.
#include "sqmap/bulk/pile.h"
#include "objects.h"
#include "structs.h"

#include <bit>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace sqmap::capi {
namespace {

using bulk::PilePair;
static_assert(sizeof(sqmap_pile_pair) == sizeof(PilePair) && offsetof(sqmap_pile_pair, b) == offsetof(PilePair, b) &&
              offsetof(sqmap_pile_pair, first) == offsetof(PilePair, first) &&
              offsetof(sqmap_pile_pair, count) == offsetof(PilePair, count) &&
              offsetof(sqmap_pile_pair, found) == offsetof(PilePair, found) &&
              offsetof(sqmap_pile_pair, meetings) == offsetof(PilePair, meetings) &&
              offsetof(sqmap_pile_pair, regions) == offsetof(PilePair, regions) &&
              offsetof(sqmap_pile_pair, status) == offsetof(PilePair, status));
static_assert(std::endian::native == std::endian::little);  // the low byte of its status of 16 bits is C's of 8

/// A pile and what its bodies are made of, by their numbers.
struct KeptPile {
    explicit KeptPile(std::size_t contacts) : pile(contacts) {}

    struct Kept {
        std::shared_ptr<Model> model;
        std::shared_ptr<query::Probe> probe;
    };
    bulk::Pile pile;
    std::vector<Kept> kept;

    [[nodiscard]] bool has(std::size_t number) const { return number < kept.size() && kept[number].probe != nullptr; }
};

Handles<KeptPile, 6>& piles() { return table<KeptPile, 6>(); }

/// Poses of bodies that there are. All are read before one is set.
void move_bodies(KeptPile& p, const sqmap_pile_step& step)
{
    if (step.count > p.kept.size())
        throw Failure{SQMAP_E_ARGUMENT, "step.count",
                      "is " + std::to_string(step.count) + ", of " + std::to_string(p.kept.size()) + " bodies",
                      "give a pose for each number that a body was given, and no more"};
    const std::vector<Pose> poses = poses_of(step.pose, step.count, "step.pose");
    for (std::size_t i = 0; i < poses.size(); ++i)
        if (p.has(i)) (void)p.pile.set_pose(static_cast<query::BodyId>(i), poses[i]);
}

}  // namespace
}  // namespace sqmap::capi

using namespace sqmap;

sqmap_code sqmap_make_pile(size_t contacts, sqmap_pile* pile)
{
    return capi::opened(pile, "pile", capi::piles(), [&] {
        if (contacts < 1 || contacts > 100'000'000)
            throw capi::Failure{SQMAP_E_ARGUMENT, "contacts", "is " + std::to_string(contacts),
                                "give a number from 1 to 100,000,000"};
        return std::make_shared<capi::KeptPile>(contacts);
    });
}

sqmap_code sqmap_close_pile(sqmap_pile pile)
{
    return capi::guarded([&] { capi::piles().close(pile.id, "pile"); });
}

sqmap_code sqmap_add_body(sqmap_pile pile, const sqmap_body* body, uint32_t* number)
{
    return capi::guarded([&] {
        capi::KeptPile& p = *capi::piles().find(pile.id, "pile");
        const sqmap_body& in = capi::needed(body, "body");
        std::uint32_t& out = capi::needed(number, "number");
        capi::KeptPile::Kept kept;
        if (in.model.id != 0) kept.model = capi::model_of(in.model, "body.model");
        kept.probe = capi::probes().find(in.probe.id, "body.probe");
        if (kept.probe->triangle_count() == 0)
            throw capi::Failure{SQMAP_E_MISSING, "body.probe", "has no triangles",
                                mesh::Words("take a probe with triangles").with(": ", mesh::Setting::SolidProbe)};
        const Pose pose = capi::pose_of(in.pose, "body.pose");
        p.kept.reserve(p.kept.size() + 1);
        out = p.pile.add(kept.model != nullptr ? &kept.model->view() : nullptr, kept.probe.get(), pose);
        if (out >= p.kept.size()) p.kept.resize(std::size_t{out} + 1);
        p.kept[out] = std::move(kept);
    });
}

sqmap_code sqmap_remove_body(sqmap_pile pile, uint32_t number)
{
    return capi::guarded([&] {
        capi::KeptPile& p = *capi::piles().find(pile.id, "pile");
        if (!p.has(number))
            throw capi::Failure{SQMAP_E_ARGUMENT, "number", "is " + std::to_string(number) + ", which no body has",
                                "give a number that was given to a body"};
        p.pile.remove(number);
        p.kept[number] = {};
    });
}

sqmap_code sqmap_query_pile(sqmap_pile pile, const sqmap_pile_step* step, sqmap_pile_contacts* contacts)
{
    return capi::guarded([&] {
        capi::KeptPile& p = *capi::piles().find(pile.id, "pile");
        const sqmap_pile_step in = capi::taken(step, "step");
        sqmap_pile_contacts out = capi::taken(&capi::needed(contacts, "contacts"), "contacts");
        bulk::PileOptions how{{in.is_first_only != 0, in.per_region}, capi::threads_of(in.threads, "step.threads")};
        if (in.pose != nullptr) capi::move_bodies(p, in);
        const bulk::PileResult result = p.pile.query(how);
        out.pairs = reinterpret_cast<const sqmap_pile_pair*>(result.pairs.data());
        out.contacts = reinterpret_cast<const sqmap_surface_contact*>(result.contacts.data());
        out.pair_count = result.pairs.size();
        out.count = result.contacts.size();
        out.near = result.near;
        out.status = result.status;
        capi::give(contacts, out);
    });
}
