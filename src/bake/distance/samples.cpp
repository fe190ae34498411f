// Farthest-point sampling: each sample is the candidate that is farthest from those before it (T. Gonzalez, "Clustering to
// minimize the maximum intercluster distance", Theoretical Computer Science 38, 1985).
#include "bake/distance/distance.h"

#include "math/random.h"
#include "model/bound_tree.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sqmap::bake {

namespace {

constexpr std::size_t k_kept_samples = 1024;
constexpr std::size_t k_candidates = 32768;

struct Candidate {
    Vec3d point, normal;
    double distance_sq = INFINITY;  ///< to the samples
};

/// Evenly spread by area over what of the surface is boundary as a whole.
std::vector<Candidate> candidates_of(const mesh::Solid& solid)
{
    const mesh::Mesh& mesh = solid.mesh();
    const auto corner = [&](std::size_t t, std::size_t k) { return mesh.vertices[mesh.triangles[t][k]]; };
    const auto across = [&](std::size_t t) { return cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0)); };
    std::vector<double> areas;
    double sum = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        areas.push_back(sum += solid.boundary()[t] == mesh::Boundary::Whole ? norm(across(t)) : 0);
    std::vector<Candidate> candidates;
    SplitMix64 random(1);
    for (std::size_t i = 0; i < k_candidates && sum > 0; ++i) {
        const double at = sum * (static_cast<double>(i) + random.uniform()) / k_candidates;
        const auto found = std::upper_bound(areas.begin(), areas.end(), at);
        const auto t = static_cast<std::size_t>(std::min(found, areas.end() - 1) - areas.begin());
        double u = random.uniform(), v = random.uniform();
        if (u + v > 1) {
            u = 1 - u;
            v = 1 - v;
        }
        candidates.push_back({corner(t, 0) + u * (corner(t, 1) - corner(t, 0)) + v * (corner(t, 2) - corner(t, 0)), across(t)});
    }
    return candidates;
}

}  // namespace

void bake_samples(const mesh::Solid& solid, model::ModelData& data)
{
    std::vector<Candidate> candidates = candidates_of(solid);
    std::size_t next = 0;
    while (data.distance.samples.size() < k_kept_samples && next < candidates.size() && candidates[next].distance_sq > 0) {
        const Candidate sample = candidates[next];
        data.distance.samples.push_back(model::encode_sample(data.distance.header, sample.point, sample.normal));
        for (std::size_t i = 0; i < candidates.size(); ++i) {
            Candidate& c = candidates[i];
            c.distance_sq = std::min(c.distance_sq, norm_sq(c.point - sample.point));
            if (c.distance_sq > candidates[next].distance_sq) next = i;
        }
    }
}

}  // namespace sqmap::bake
