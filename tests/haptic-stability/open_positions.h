// Finds positions at which a surface can be touched.
#pragma once

#include "sqmap/query/point.h"
#include "support/parsed.h"

#include <algorithm>
#include <vector>

namespace sqmap::test {

inline constexpr double k_size = 0.3;  ///< m: R_max of the baked models
/// The share of the bound with which baked models are pressed. The bound is that of a plane's spring. Where the nearest surface
/// point jumps from one side of a thin part to the other, force changes faster than any spring's, and at the bound nothing is
/// left to damp that.
inline constexpr double k_share = 0.8;

/// Positions to which a tool of 2 cm can come and go along the normal without meeting anything.
struct OpenPosition {
    Vec3d point, out, along;
};

inline std::vector<OpenPosition> open_positions(const Parsed& parsed, const model::ModelView& model, std::size_t count)
{
    const auto free = [&](const Vec3d& metres) { return !query::query_point(model, metres).contact; };
    std::vector<double> sum;
    double total = 0;
    const mesh::Mesh& mesh = parsed.mesh();
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) sum.push_back(total += mesh::triangle_area(mesh, t));
    Random random(17);
    std::vector<OpenPosition> positions;
    for (int tries = 0; tries < 20000 && positions.size() < count; ++tries) {
        const auto t = static_cast<std::size_t>(std::lower_bound(sum.begin(), sum.end(), total * random.uniform()) - sum.begin());
        if (t >= mesh.triangles.size()) continue;
        const auto& k = mesh.triangles[t];
        const Vec3d a = mesh.vertices[k[0]], b = mesh.vertices[k[1]], c = mesh.vertices[k[2]];
        const Vec3d out = normalized(cross(b - a, c - a)), centre = (a + b + c) / 3.;
        const double* o = model.header.origin;
        const Vec3d at = model.header.unit * centre + Vec3d{o[0], o[1], o[2]};
        bool open = !free(at - 0.002 * out);
        for (int i = 2; i <= 50 && open; ++i) open = free(at + 0.0005 * i * out);
        if (open) positions.push_back({at, out, normalized(b - a)});
    }
    return positions;
}

}  // namespace sqmap::test
