// Constructors of the workspaces of contacts, which allocate outside the frame, and the question whether probes fit.
#include "query/probe/triangle_tree.h"
#include "sqmap/query/overlap.h"
#include "sqmap/query/separating.h"

#include <algorithm>
#include <bit>

namespace sqmap::query {

ContactWorkspace::ContactWorkspace(std::size_t contacts)
    : found_(contacts),
      contacts_(4 * contacts),
      kept_(4 * contacts),
      meetings_(contacts),
      parents_(5 * contacts),
      table_(2 * std::max(ContactWorkspace::k_least_slots, std::bit_ceil(20 * contacts)))
{
}

OverlapWorkspace::Side::Side(const TriangleTree& tree)
    : winding(tree.points()), change(3 * tree.size()), inside(3 * tree.size()), triangles(tree.size()), is_reached(tree.size())
{
}

OverlapWorkspace::OverlapWorkspace(const Probe& a, const Probe& b) : a_(a.triangles()), b_(b.triangles()) {}

bool OverlapWorkspace::Side::holds(const TriangleTree& tree) const noexcept
{
    return tree.points() <= winding.size() && tree.size() <= triangles.size();
}

bool OverlapWorkspace::holds(const Probe& a, const Probe& b) const noexcept
{
    return a_.holds(a.triangles()) && b_.holds(b.triangles());
}

SeparatingWorkspace::Side::Side(const TriangleTree& tree)
    : points(tree.points()),
      leaves(tree.columns().corners.size()),
      groups(tree.columns().leaves.size()),
      pieces(tree.size()),
      stack(tree.size()),
      is_reached(tree.size())
{
}

SeparatingWorkspace::SeparatingWorkspace(const Probe& a, const Probe& b)
    : a_(a.triangles()), b_(b.triangles()), facets_(k_facets), corners_(k_corners), visible_(k_facets), contacts_(k_contacts)
{
}

bool SeparatingWorkspace::Side::holds(const TriangleTree& tree) const noexcept
{
    return tree.points() <= points.size() && tree.size() <= stack.size();
}

bool SeparatingWorkspace::holds(const Probe& a, const Probe& b) const noexcept
{
    return a_.holds(a.triangles()) && b_.holds(b.triangles());
}

}  // namespace sqmap::query
