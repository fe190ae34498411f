#include "model/parse_steps.h"

#include "model/bound_tree.h"
#include "model/hierarchy.h"

#include <cmath>

namespace sqmap::model {

namespace {

bool finite(const float* values, int count)
{
    for (int i = 0; i < count; ++i)
        if (!std::isfinite(values[i])) return false;
    return true;
}

/// A divided cell's eighths come after it, so that no walk goes around.
bool is_tree(std::span<const std::uint16_t> bounds)
{
    if (bounds.size() < 8 || bounds.size() % 8 != 0 || bounds.size() > k_max_bounds) return false;
    for (std::size_t i = 0; i < bounds.size(); ++i)
        if ((bounds[i] & k_bound_leaf) == 0 && (bounds[i] <= i / 8 || bounds[i] >= bounds.size() / 8)) return false;
    return true;
}

ParseStatus check_hierarchy(const ModelView& view)
{
    const DistanceArrays<ArrayView>& d = view.distance;
    const std::uint32_t entries = d.header.entries;
    const std::size_t primitives = view.triangle_part.size() + view.piece_triangle.size();
    if (entries > primitives || entries > k_max_hierarchy_entries) return ParseStatus::BadStructure;
    const HierarchyLevels levels = hierarchy_levels(entries);
    if (d.groups.size() != group_count(entries) || d.nodes.size() != levels.first[levels.count]) return ParseStatus::BadStructure;
    const std::size_t stored = std::size_t{leaf_count(entries)} * k_hierarchy_leaf;
    if ((!d.entries16.empty() && !d.entries32.empty()) || d.entries16.size() + d.entries32.size() != stored)
        return ParseStatus::BadStructure;
    for (const std::uint32_t e : d.entries16)
        if (e >= primitives) return ParseStatus::BadStructure;
    for (const std::uint32_t e : d.entries32)
        if (e >= primitives) return ParseStatus::BadStructure;
    for (const HierarchyNode& n : d.nodes)
        if (!finite(n.origin, 3) || !(n.step > 0) || !std::isfinite(n.step)) return ParseStatus::BadValue;
    for (const HierarchyGroup& g : d.groups) {
        if (!finite(g.origin, 3)) return ParseStatus::BadValue;
        for (const float step : {g.step, g.width_step, g.height_step})
            if (!(step > 0) || !std::isfinite(step)) return ParseStatus::BadValue;
    }
    return ParseStatus::Ok;
}

}  // namespace

ParseStatus check_distance(const ModelView& view) noexcept
{
    const DistanceArrays<ArrayView>& d = view.distance;
    const DistanceHeader& h = d.header;
    if (d.bounds.empty())
        return d.samples.empty() && d.nodes.empty() && d.groups.empty() && d.entries16.empty() && d.entries32.empty()
                   ? ParseStatus::Ok
                   : ParseStatus::BadStructure;
    if (!finite(h.root, 3) || !(h.half > 0) || !std::isfinite(h.half) || !(h.band >= 0) || !std::isfinite(h.band))
        return ParseStatus::BadValue;
    if (!is_tree(d.bounds)) return ParseStatus::BadStructure;
    return check_hierarchy(view);
}

}  // namespace sqmap::model
