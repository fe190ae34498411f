// Contacts of a probe, written as they are found.
#if defined(SQMAP_QUERY_PROBE_CONTACTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_PROBE_CONTACTS_INL_H
#undef SQMAP_QUERY_PROBE_CONTACTS_INL_H
#else
#define SQMAP_QUERY_PROBE_CONTACTS_INL_H
#endif

#include "math/lanes-inl.h"
#include "query/caller_frame.h"
#include "query/locator/locate_point.h"
#include "query/probe/probe_job.h"
#include "sqmap/query/probe.h"

#include <algorithm>
#include <cstddef>
#include <span>

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

using namespace sqmap::HWY_NAMESPACE;

/// A contact for each lane, model space.
struct ContactLanes {
    V3 witness, normal;
    F depth;
    I index, part;
    M certain;
};

class ContactWriter {
public:
    explicit ContactWriter(const ProbeJob& job)
        : caller_(job.caller),
          out_(job.out),
          cured_(job.layer == Layer::Exact || job.layer == Layer::One || job.model.made_up_cells.empty() ? nullptr : &job.model)
    {
        result_.anchor = job.caller.anchor;
    }

    const ProbeResult& result() const { return result_; }
    std::size_t count() const { return result_.contacts; }
    void count_unseen() { ++result_.unseen; }

    void write(const Contact& contact)
    {
        const std::size_t at = result_.contacts++;
        if (at < out_.size())
            out_[at] = caller_.convert(marked(contact));
        else
            result_.status |= k_full;
    }

    /// As Contact has them: eight words, and a ninth of part (16 bits), certain and status.
    HWY_INLINE void write(const ContactLanes& contacts, M which)
    {
        static_assert(sizeof(Contact) == 36 && offsetof(Contact, normal) == 12 && offsetof(Contact, depth) == 24 &&
                      offsetof(Contact, index) == 28 && offsetof(Contact, part) == 32 && offsetof(Contact, certain) == 34 &&
                      k_ok == 0);
        const auto packed = [&](F v) { return compress(v, which); };
        const V3 point = in_caller_frame(contacts.witness), normal = turned(contacts.normal);
        const F depth = hn::Mul(set(caller_.unit), contacts.depth);
        I ninth = hn::Or(contacts.part, hn::IfThenElseZero(hn::RebindMask(di, contacts.certain), set_int(1 << 16)));
        if (cured_ != nullptr) ninth = hn::Or(ninth, made_up(contacts));
        HWY_ALIGN float low[4 * k_lanes], high[4 * k_lanes];
        HWY_ALIGN std::int32_t last[k_lanes];
        hn::StoreInterleaved4(packed(point.x), packed(point.y), packed(point.z), packed(normal.x), df, low);
        hn::StoreInterleaved4(packed(normal.y), packed(normal.z), packed(depth), packed(hn::BitCast(df, contacts.index)), df,
                              high);
        hn::Store(compress(ninth, which), di, last);
        const std::size_t count = count_of(which), at = std::min(result_.contacts, out_.size()),
                          space = std::min(count, out_.size() - at);
        auto* to = reinterpret_cast<std::byte*>(out_.data() + at);
        for (std::size_t i = 0; i < space; ++i, to += sizeof(Contact)) {
            std::memcpy(to, low + 4 * i, 16);
            std::memcpy(to + 16, high + 4 * i, 16);
            std::memcpy(to + 32, last + i, 4);
        }
        result_.contacts += count;
        if (space < count) result_.status |= k_full;
    }

private:
    /// The status of contacts whose points lie in marked cells, where the ninth word has it.
    HWY_NOINLINE I made_up(const ContactLanes& contacts) const
    {
        HWY_ALIGN float x[k_lanes], y[k_lanes], z[k_lanes];
        HWY_ALIGN std::int32_t status[k_lanes];
        const auto below = [&](F point, F normal) { return hn::Sub(point, hn::Mul(contacts.depth, normal)); };
        hn::Store(below(contacts.witness.x, contacts.normal.x), df, x);
        hn::Store(below(contacts.witness.y, contacts.normal.y), df, y);
        hn::Store(below(contacts.witness.z, contacts.normal.z), df, z);
        for (std::size_t i = 0; i < k_lanes; ++i)
            status[i] =
                is_made_up_at(*cured_, {x[i], y[i], z[i]}) ? static_cast<std::int32_t>(std::uint32_t{k_made_up} << 24) : 0;
        return hn::Load(di, status);
    }
    // As CallerFrame::convert.
    HWY_INLINE V3 turned(const V3& v) const
    {
        if (!caller_.is_turned) return v;
        const float* r = caller_.rotation;
        return {row_dot(r, v), row_dot(r + 3, v), row_dot(r + 6, v)};
    }
    HWY_INLINE V3 in_caller_frame(const V3& p) const
    {
        const F unit = set(caller_.unit);
        const V3 v = turned({hn::Mul(unit, p.x), hn::Mul(unit, p.y), hn::Mul(unit, p.z)});
        const float* t = caller_.translation;
        return {hn::Add(v.x, set(t[0])), hn::Add(v.y, set(t[1])), hn::Add(v.z, set(t[2]))};
    }

    Contact marked(Contact contact) const
    {
        if (cured_ != nullptr && is_made_up_at(*cured_, contact.witness - contact.depth * contact.normal))
            contact.status |= k_made_up;
        return contact;
    }

    const CallerFrame& caller_;
    std::span<Contact> out_;
    const model::ModelView* cured_;  ///< null where no contact can be marked
    ProbeResult result_;
};

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
