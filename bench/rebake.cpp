// Measures the cost of rebaking one part of a model that moves, and checks the result.
#include "sqmap/bake/rebake.h"
#include "measure.h"
#include "sqmap/bake/evaluate.h"
#include "sqmap/bake_mesh.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/solid.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace {

using namespace sqmap;

/// The part's vertices moved along its first moment's direction from the object's middle, less towards its borders.
std::vector<Vec3d> bent(const mesh::Mesh& mesh, const decompose::Partition& partition, std::uint32_t part, double by)
{
    std::vector<std::uint8_t> own(mesh.vertices.size(), 0), others(mesh.vertices.size(), 0);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const std::uint32_t v : mesh.triangles[t]) (partition.part_of_triangle[t] == part ? own : others)[v] = 1;
    std::vector<Vec3d> border, out = mesh.vertices;
    Vec3d own_mean{}, mean{};
    double count = 0;
    for (std::size_t v = 0; v < own.size(); ++v) {
        mean += mesh.vertices[v] / static_cast<double>(own.size());
        if (own[v] != 0 && others[v] != 0) border.push_back(mesh.vertices[v]);
        if (own[v] != 0 && others[v] == 0) own_mean += mesh.vertices[v], count += 1;
    }
    if (count == 0) return out;
    const Vec3d direction = normalized(cross(own_mean / count - mean, Vec3d{0.3, 0.9, 0.2}));
    std::vector<double> inwards(own.size(), 0);
    double farthest = 0;
    for (std::size_t v = 0; v < own.size(); ++v) {
        if (own[v] == 0 || others[v] != 0) continue;
        double nearest = INFINITY;
        for (const Vec3d& b : border) nearest = std::min(nearest, norm(b - mesh.vertices[v]));
        inwards[v] = border.empty() ? 1 : nearest;
        farthest = std::max(farthest, inwards[v]);
    }
    for (std::size_t v = 0; v < own.size(); ++v) {
        const double share = inwards[v] / farthest;
        out[v] += by * share * share * direction;
    }
    return out;
}

}  // namespace

int sqmap::bench::measure_rebake(int argc, char** argv)
{
    double move = 0.01;
    bool quick = false;
    int first = 1;
    for (; first < argc && argv[first][0] == '-'; ++first) {
        if (std::string(argv[first]) == "--quick") quick = true;
        if (std::string(argv[first]) == "--move" && first + 1 < argc) move = std::atof(argv[++first]);
    }
    if (first >= argc) return k_wrong_usage;
    for (int i = first; i < argc; ++i) {
        const AdmittedMesh admitted = admit_mesh(argv[i]);
        if (admitted.refused()) return 2;
        const BakedModel baked = bake_mesh(admitted, {.bake = {.threads = 1}});
        const mesh::Mesh& mesh = baked.mesh.mesh;
        double whole = 0;
        std::printf("%s: %zu triangles, %zu parts; bake", argv[i], mesh.triangles.size(), baked.model.common.parts.size());
        for (const auto& [stage, seconds] : baked.report.seconds) {
            std::printf(" %s %.0f", stage.c_str(), 1e3 * seconds);
            whole += seconds;
        }
        std::printf(" ms, all %.0f ms\n", 1e3 * whole);
        const double r_max = mesh::largest_vertex_distance(mesh);
        std::vector<double> totals;
        for (std::uint32_t part = 0; part < baked.model.common.parts.size(); ++part) {
            const std::vector<Vec3d> moved = bent(mesh, baked.report.partition, part, move * r_max);
            const bake::RebakeResult again =
                bake::rebake(baked.model.common, moved, {.fineness = baked.report.fineness, .threads = 1});
            double sum = 0;
            std::printf("  part %2u: %5zu triangles moved, %2zu maps, %zu fitted;", part, again.report.changed_triangles,
                        again.report.remade.size(), again.report.refitted.size());
            for (const auto& [stage, seconds] : again.report.seconds) {
                std::printf(" %s %.0f", stage.c_str(), 1e3 * seconds);
                sum += seconds;
            }
            totals.push_back(sum);
            mesh::Mesh posed = mesh;
            for (std::size_t v = 0; v < moved.size(); ++v)
                posed.vertices[v] = cast<double>(model::to_model_space(baked.model.common.header, moved[v]));
            const mesh::Solid solid(posed, mesh::find_self_intersections(posed).crossed);
            std::printf(" ms, all %.0f ms; %zu kB of near lists, before %zu;", 1e3 * sum, 2 * again.model.near.size() / 1000,
                        2 * baked.model.common.near.size() / 1000);
            for (const query::Layer layer :
                 quick ? std::vector<query::Layer>{} : std::vector{query::Layer::Three, query::Layer::Exact}) {
                bake::EvaluateOptions check;
                check.layer = layer;
                check.points = 4000;
                if (layer == query::Layer::Exact) check.verdict_band = 1e-5;
                const bake::Evaluation e = bake::evaluate(again.model.view(), solid, check);
                std::printf(" %s %u + %u wrong, depth p99 %.3f %%;", layer == query::Layer::Exact ? "exact" : "L3", e.missed,
                            e.false_contacts, e.depth.p99);
            }
            std::printf("\n");
        }
        std::sort(totals.begin(), totals.end());
        std::printf("  a part: least %.0f, median %.0f, most %.0f ms\n", 1e3 * totals.front(), 1e3 * totals[totals.size() / 2],
                    1e3 * totals.back());
    }
    return 0;
}
