#include "domains.h"

#include "model/central_map.h"
#include "model/chart.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sqmap::bake {

namespace {

/// Higher where a part sees a single surface at p rather than layers.
double fitness(const model::ModelView& view, std::uint32_t part, Vec3d p)
{
    const model::CentralMap map(view, view.parts[part]);
    const model::ChartPoint q = model::to_chart(map.to_chart_frame(cast<float>(p)));
    const model::Leaf leaf = map.leaf_at(q.face, q.s, q.t);
    return leaf.kind == model::CellKind::Layered ? (leaf.bilinear ? 1 : 0) : 2;
}

}  // namespace

DomainTest test_domain(const model::Part& part, const CellCube& cube)
{
    const Vec3d d = cube.centre - cast<double>(model::vec3(part.chart_centre));
    Vec3d rows[3];
    for (int i = 0; i < 3; ++i) rows[i] = cast<double>(model::vec3(part.chart_rows + 3 * i));
    const Vec3d directions[9] = {rows[0],           rows[1],           rows[2],           rows[0] + rows[1], rows[0] - rows[1],
                                 rows[0] + rows[2], rows[0] - rows[2], rows[1] + rows[2], rows[1] - rows[2]};
    const double h = cube.half();
    DomainTest test{true, true};
    for (int i = 0; i < 9; ++i) {
        const Vec3d& n = directions[i];
        const double value = dot(n, d), reach = 1.0001 * h * (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
        const double lo = part.chart_lo[i], hi = part.chart_hi[i], slack = 1e-5 * (hi - lo);
        if (value + reach < lo - slack || value - reach > hi + slack) test.touches = false;
        if (value - reach < lo + slack || value + reach > hi - slack) test.holds = false;
    }
    return test;
}

bool domain_holds(const model::Part& part, Vec3d p)
{
    const Vec3d d = p - cast<double>(model::vec3(part.chart_centre));
    const auto row = [&](int i) { return cast<double>(model::vec3(part.chart_rows + 3 * i)); };
    const auto holds = [&](int i, Vec3d n) {
        const double value = dot(n, d), lo = part.chart_lo[i], hi = part.chart_hi[i], slack = 1e-5 * (hi - lo);
        return value >= lo + slack && value <= hi - slack;
    };
    const Vec3d x = row(0), y = row(1), z = row(2);
    return holds(0, x) && holds(1, y) && holds(2, z) && holds(3, x + y) && holds(4, x - y) && holds(5, x + z) &&
           holds(6, x - z) && holds(7, y + z) && holds(8, y - z);
}

void list_parts(const LocatorSubject& subject, const CellCube& cube, std::uint32_t owner, CellDraft& draft)
{
    const model::ModelView& view = subject.model;
    std::vector<std::uint32_t> touching;
    std::int64_t holder = -1;
    double best = -1;
    for (std::uint32_t i = 0; i < view.parts.size(); ++i) {
        const DomainTest test = test_domain(view.parts[i], cube);
        if (!test.touches) continue;
        touching.push_back(i);
        if (!test.holds) continue;
        // One that sees a single surface there rather than layers, and the owner of the surface rather than another.
        const double score = fitness(view, i, cube.centre) + (i == owner ? 0.5 : 0);
        if (score > best) {
            best = score;
            holder = i;
        }
    }
    if (holder >= 0) touching = {static_cast<std::uint32_t>(holder)};
    if (touching.size() > model::k_list_length || touching.empty()) {
        draft.kind = model::LocatorCellKind::Ambiguous;  // held by none: free by the cover, but let the query say so
        return;
    }
    std::stable_partition(touching.begin(), touching.end(), [&](std::uint32_t i) { return i == owner; });
    for (std::size_t i = 0; i < touching.size(); ++i) draft.parts[i] = static_cast<std::uint8_t>(touching[i]);
}

}  // namespace sqmap::bake
