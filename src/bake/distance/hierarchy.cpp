// Groups of near triangles by the surface area heuristic: J. Goldsmith, J. Salmon, "Automatic creation of object hierarchies for
// ray tracing", IEEE CG&A 7(5), 1987. Only cuts that leave full groups on one side are tried, so that no index has to be stored.
#include "bake/distance/distance.h"

#include "model/flags.h"
#include "model/hierarchy.h"
#include "sqmap/math/box.h"

#include <algorithm>
#include <numeric>

namespace sqmap::bake {

namespace {

using model::k_hierarchy_leaf;
using model::k_hierarchy_width;

double area(const Boxf& box)
{
    const Vec3d d = cast<double>(box.hi) - cast<double>(box.lo);
    return d.x * d.y + d.y * d.z + d.z * d.x;
}

class Grouping {
public:
    explicit Grouping(std::span<const Boxf> boxes)
        : boxes_(boxes), order_(boxes.size()), is_before_(boxes.size()), area_after_(boxes.size())
    {
        std::iota(order_.begin(), order_.end(), 0u);
        for (int k = 0; k < 3; ++k) {
            const auto key = [&](std::uint32_t i) { return boxes_[i].lo[k] + boxes_[i].hi[k]; };
            along_[k] = order_;
            std::sort(along_[k].begin(), along_[k].end(),
                      [&](std::uint32_t a, std::uint32_t b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
        }
        std::size_t unit = k_hierarchy_leaf;
        while (unit < order_.size()) unit *= k_hierarchy_width;
        divide(0, order_.size(), unit);
    }
    const std::vector<std::uint32_t>& order() const { return order_; }

private:
    /// Into groups of unit entries, and those further.
    void divide(std::size_t first, std::size_t last, std::size_t unit)
    {
        while (last - first <= unit) {
            if (unit == k_hierarchy_leaf) return;
            unit /= k_hierarchy_width;
        }
        double least = INFINITY;
        std::size_t cut = first + unit;
        int axis = 0;
        for (int k = 0; k < 3; ++k) {
            const std::vector<std::uint32_t>& along = along_[k];
            Boxf box;
            for (std::size_t i = last; i-- > first;) {
                extend(box, boxes_[along[i]]);
                if ((i - first) % unit == 0) area_after_[i] = area(box);
            }
            box = {};
            for (std::size_t i = first; i < last; ++i) {
                if (i > first && (i - first) % unit == 0) {
                    const double cost =
                        area(box) * static_cast<double>(i - first) + area_after_[i] * static_cast<double>(last - i);
                    if (cost < least) {
                        least = cost;
                        cut = i;
                        axis = k;
                    }
                }
                extend(box, boxes_[along[i]]);
            }
        }
        for (std::size_t i = first; i < last; ++i) {
            order_[i] = along_[axis][i];
            is_before_[order_[i]] = i < cut ? 1 : 0;
        }
        // Each side stays sorted along all axes.
        for (int k = 0; k < 3; ++k)
            if (k != axis)
                std::stable_partition(along_[k].begin() + static_cast<std::ptrdiff_t>(first),
                                      along_[k].begin() + static_cast<std::ptrdiff_t>(last),
                                      [&](std::uint32_t i) { return is_before_[i] != 0; });
        divide(first, cut, unit);
        divide(cut, last, unit);
    }

    std::span<const Boxf> boxes_;
    std::vector<std::uint32_t> along_[3], order_;  ///< sorted along each axis within every group; the result
    std::vector<std::uint8_t> is_before_;
    std::vector<double> area_after_;
};

/// A leaf's triangles, three corners each.
using Corners = std::vector<Vec3d>;

/// A box about a leaf's triangles, before it is stored.
struct LeafBox {
    Vec3d centre;
    std::uint8_t normal[2];
    std::uint8_t turn;
};

struct Range {
    double lo = INFINITY, hi = -INFINITY;
};
Range range_of(const Corners& corners, Vec3d axis)
{
    Range range;
    for (const Vec3d& p : corners) {
        range.lo = std::min(range.lo, dot(axis, p));
        range.hi = std::max(range.hi, dot(axis, p));
    }
    return range;
}

/// Along the mean normal, turned so that its widths have the least product.
LeafBox box_about(const Corners& corners)
{
    constexpr unsigned k_turn_step = 15;
    Vec3d normal{};
    for (std::size_t i = 0; i < corners.size(); i += 3) normal += cross(corners[i + 1] - corners[i], corners[i + 2] - corners[i]);
    LeafBox box{};
    model::encode_axis(normal, box.normal[0], box.normal[1]);
    const Vec3f n = model::decode_axis(box.normal[0], box.normal[1]);
    double least = INFINITY;
    for (unsigned turn = 0; turn < 255; turn += k_turn_step) {
        const model::BoxAxes axes = model::box_axes(n, static_cast<std::uint8_t>(turn));
        Vec3d centre{};
        double widths = 1;
        for (int k = 0; k < 3; ++k) {
            const Vec3d axis = cast<double>(axes.axis[k]);
            const Range range = range_of(corners, axis);
            centre += 0.5 * (range.lo + range.hi) * axis;
            if (k > 0) widths *= range.hi - range.lo;
        }
        if (!(widths < least)) continue;
        least = widths;
        box.turn = static_cast<std::uint8_t>(turn);
        box.centre = centre;
    }
    return box;
}

/// Half height and half widths that hold the corners.
Vec3d extents_of(const Corners& corners, Vec3d centre, const model::BoxAxes& axes)
{
    Vec3d extents;
    for (int k = 0; k < 3; ++k) {
        const Vec3d axis = cast<double>(axes.axis[k]);
        const Range range = range_of(corners, axis);
        extents[k] = std::max(range.hi - dot(axis, centre), dot(axis, centre) - range.lo);
    }
    return extents;
}

/// The leaves' boxes in the group, centres as codes. Returns the extents that these centres need.
std::vector<Vec3d> put_boxes(std::span<const Corners> leaves, const std::vector<LeafBox>& boxes, model::HierarchyGroup& group)
{
    std::vector<Vec3d> extents;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        Vec3d centre;
        for (int k = 0; k < 3; ++k) {
            const double steps = (boxes[i].centre[k] - static_cast<double>(group.origin[k])) / static_cast<double>(group.step);
            group.centre[k][i] = static_cast<std::uint8_t>(std::clamp(std::round(steps), 0.0, 255.0));
            centre[k] = static_cast<double>(group.origin[k]) + static_cast<double>(group.step) * group.centre[k][i];
        }
        for (int k = 0; k < 2; ++k) group.normal[k][i] = boxes[i].normal[k];
        group.turn[i] = boxes[i].turn;
        const Vec3f n = model::decode_axis(group.normal[0][i], group.normal[1][i]);
        extents.push_back(extents_of(leaves[i], centre, model::box_axes(n, group.turn[i])));
    }
    return extents;
}

model::HierarchyGroup make_group(std::span<const Corners> leaves)
{
    model::HierarchyGroup group{};
    std::vector<LeafBox> boxes;
    for (const Corners& leaf : leaves) boxes.push_back(box_about(leaf));
    double extent = 0;
    for (int k = 0; k < 3; ++k) {
        Range range;
        for (const LeafBox& box : boxes) {
            range.lo = std::min(range.lo, box.centre[k]);
            range.hi = std::max(range.hi, box.centre[k]);
        }
        group.origin[k] = static_cast<float>(range.lo);
        extent = std::max(extent, range.hi - range.lo);
    }
    group.step = std::max(static_cast<float>(extent / 255), 1e-30f);
    const std::vector<Vec3d> extents = put_boxes(leaves, boxes, group);
    Vec3d greatest{};
    for (const Vec3d& e : extents)
        for (int k = 0; k < 3; ++k) greatest[k] = std::max(greatest[k], e[k]);
    // Room for what rounding takes.
    group.height_step = std::max(static_cast<float>(greatest[0] / 254.9), 1e-30f);
    group.width_step = std::max(static_cast<float>(std::max(greatest[1], greatest[2]) / 254.9), 1e-30f);
    const auto code = [](double value, float step) {
        return static_cast<std::uint8_t>(std::clamp(std::ceil(value / static_cast<double>(step) + 1e-3), 0.0, 255.0));
    };
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        group.height[i] = code(extents[i][0], group.height_step);
        for (int k = 0; k < 2; ++k) group.width[k][i] = code(extents[i][k + 1], group.width_step);
    }
    return group;
}

}  // namespace

void bake_hierarchy(model::ModelData& data)
{
    const model::ModelView view = data.view();
    std::vector<model::HierarchyNode>& nodes = data.distance.nodes;
    std::vector<model::HierarchyGroup>& groups = data.distance.groups;
    std::vector<std::uint32_t> entries;
    const auto triangles = static_cast<std::uint32_t>(view.triangle_part.size());
    std::vector<std::uint32_t> primitives;
    std::vector<const float*> corners;
    for (std::uint32_t t = 0; t < triangles; ++t) {
        if ((view.triangle_part[t] & (model::k_buried | model::k_crossed)) != 0) continue;
        primitives.push_back(t);
        for (std::uint32_t k = 0; k < 3; ++k)
            corners.push_back(view.vertices.data() + 3 * std::size_t{model::triangle_vertex(view, t, k)});
    }
    for (std::uint32_t i = 0; i < view.piece_triangle.size(); ++i) {
        primitives.push_back(triangles + i);
        for (std::uint32_t k = 0; k < 3; ++k) corners.push_back(view.pieces.data() + 9 * std::size_t{i} + 3 * k);
    }
    if (primitives.empty() || primitives.size() > model::k_max_hierarchy_entries) return;
    std::vector<Boxf> boxes(primitives.size());
    for (std::size_t i = 0; i < corners.size(); ++i) extend(boxes[i / 3], model::vec3(corners[i]));
    const Grouping grouping(boxes);
    const std::vector<std::uint32_t>& order = grouping.order();
    for (const std::uint32_t i : order) entries.push_back(primitives[i]);
    const auto count = static_cast<std::uint32_t>(entries.size());
    std::vector<Corners> leaves(model::leaf_count(count));
    std::vector<Boxf> below(model::group_count(count));
    for (std::uint32_t i = 0; i < count; ++i) {
        for (std::size_t k = 0; k < 3; ++k)
            leaves[i / k_hierarchy_leaf].push_back(cast<double>(model::vec3(corners[3 * std::size_t{order[i]} + k])));
        extend(below[i / k_hierarchy_leaf / k_hierarchy_width], boxes[order[i]]);
    }
    for (std::size_t first = 0; first < leaves.size(); first += k_hierarchy_width)
        groups.push_back(
            make_group(std::span(leaves).subspan(first, std::min<std::size_t>(k_hierarchy_width, leaves.size() - first))));
    entries.resize(std::size_t{model::leaf_count(count)} * k_hierarchy_leaf, entries.back());
    const model::HierarchyLevels levels = model::hierarchy_levels(count);
    nodes.resize(levels.first[levels.count]);
    for (std::uint32_t level = levels.count; level-- > 0;) {
        std::vector<Boxf> here(levels.first[level + 1] - levels.first[level]);
        for (std::uint32_t i = 0; i < below.size(); ++i) extend(here[i / k_hierarchy_width], below[i]);
        for (std::uint32_t n = 0; n < here.size(); ++n) {
            const std::uint32_t first = n * k_hierarchy_width,
                                end =
                                    std::min<std::uint32_t>(first + k_hierarchy_width, static_cast<std::uint32_t>(below.size()));
            nodes[levels.first[level] + n] = model::encode_node(below.data() + first, end - first);
        }
        below = std::move(here);
    }
    data.distance.header.entries = count;
    if (triangles + view.piece_triangle.size() <= 0x10000)
        data.distance.entries16.assign(entries.begin(), entries.end());
    else
        data.distance.entries32 = std::move(entries);
}

}  // namespace sqmap::bake
