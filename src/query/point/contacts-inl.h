// Contacts of a probe, written as they are found.
#if defined(SQMAP_QUERY_POINT_CONTACTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_POINT_CONTACTS_INL_H
#undef SQMAP_QUERY_POINT_CONTACTS_INL_H
#else
#define SQMAP_QUERY_POINT_CONTACTS_INL_H
#endif

#include "math/lanes-inl.h"
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
    V3 point, normal;
    F depth;
    I index, part;
    M certain;
};

class ContactWriter {
public:
    explicit ContactWriter(std::span<ProbeContact> out) : out_(out) {}

    const ProbeResult& result() const { return result_; }
    std::size_t count() const { return result_.contacts; }
    void count_unseen() { ++result_.unseen; }

    void write(const ProbeContact& contact)
    {
        const std::size_t at = result_.contacts++;
        if (at < out_.size())
            out_[at] = contact;
        else
            result_.status |= k_probe_full;
    }

    /// As ProbeContact has them: eight words, and a ninth of part (16 bits), certain and status.
    HWY_INLINE void write(const ContactLanes& contacts, M which)
    {
        static_assert(sizeof(ProbeContact) == 36 && offsetof(ProbeContact, normal) == 12 && offsetof(ProbeContact, depth) == 24 &&
                      offsetof(ProbeContact, index) == 28 && offsetof(ProbeContact, part) == 32 &&
                      offsetof(ProbeContact, certain) == 34 && k_ok == 0);
        const auto packed = [&](F v) { return compress(v, which); };
        const auto &point = contacts.point, &normal = contacts.normal;
        const I ninth = hn::Or(contacts.part, hn::IfThenElseZero(hn::RebindMask(di, contacts.certain), set_int(1 << 16)));
        HWY_ALIGN float low[4 * k_lanes], high[4 * k_lanes];
        HWY_ALIGN std::int32_t last[k_lanes];
        hn::StoreInterleaved4(packed(point.x), packed(point.y), packed(point.z), packed(normal.x), df, low);
        hn::StoreInterleaved4(packed(normal.y), packed(normal.z), packed(contacts.depth), packed(hn::BitCast(df, contacts.index)),
                              df, high);
        hn::Store(compress(ninth, which), di, last);
        const std::size_t count = hn::CountTrue(df, which), at = std::min(result_.contacts, out_.size()),
                          space = std::min(count, out_.size() - at);
        auto* to = reinterpret_cast<std::byte*>(out_.data() + at);
        for (std::size_t i = 0; i < space; ++i, to += sizeof(ProbeContact)) {
            std::memcpy(to, low + 4 * i, 16);
            std::memcpy(to + 16, high + 4 * i, 16);
            std::memcpy(to + 32, last + i, 4);
        }
        result_.contacts += count;
        if (space < count) result_.status |= k_probe_full;
    }

private:
    std::span<ProbeContact> out_;
    ProbeResult result_;
};

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
