#include "partition.h"

#include <algorithm>
#include <map>
#include <numeric>

namespace sqmap::decompose {

namespace {

using Pair = std::pair<std::uint32_t, std::uint32_t>;
using Kinds = std::map<Pair, CutKind>;

Pair pair_of(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

Kinds kinds_of(const Partition& partition)
{
    Kinds kinds;
    for (const Boundary& b : partition.boundaries) kinds[{b.part_a, b.part_b}] = b.kind;
    return kinds;
}

using FormerLabels = std::vector<std::vector<std::uint32_t>>;  // of each label, those that it had before

/// Why boundaries stood before labels changed.
struct Reasons {
    const Kinds& kinds;
    const FormerLabels& former;
    CutKind inside;  ///< of a new boundary, inside a former label
};

/// Boundaries from the labels. One that stood for several reasons keeps the strongest.
std::vector<Boundary> boundaries_of(const CutSurface& s, const Partition& partition, const Reasons& reasons)
{
    std::map<Pair, double> length;
    for (std::uint32_t t = 0; t < s.area.size(); ++t)
        for (int e = 0; e < 3; ++e) {
            const std::uint32_t o = s.graph.neighbours[t][e];
            if (o == mesh::k_no_triangle || o < t) continue;
            const std::uint32_t a = partition.part_of_triangle[t], b = partition.part_of_triangle[o];
            if (a != b) length[pair_of(a, b)] += s.edge_length[t][e];
        }
    std::vector<Boundary> boundaries;
    for (const auto& [pair, l] : length) {
        CutKind strongest = CutKind::Error;
        bool found = false;
        for (const auto fa : reasons.former[pair.first])
            for (const auto fb : reasons.former[pair.second]) {
                const auto it = reasons.kinds.find(pair_of(fa, fb));
                if (it == reasons.kinds.end()) continue;
                strongest = found ? std::min(strongest, it->second) : it->second;
                found = true;
            }
        boundaries.push_back({pair.first, pair.second, found ? strongest : reasons.inside, l});
    }
    return boundaries;
}

// Pieces of the triangles that are edge-connected and have the same side.
template <class Side>
std::vector<std::vector<std::uint32_t>> pieces_of(const CutSurface& s, std::span<const std::uint32_t> triangles,
                                                  const std::vector<Side>& side_of_triangle)
{
    std::vector<std::uint8_t> inside(s.area.size(), 0);
    for (const auto t : triangles) inside[t] = 1;
    std::vector<std::vector<std::uint32_t>> pieces;
    for (const auto seed : triangles) {
        if (inside[seed] != 1) continue;
        pieces.emplace_back(1, seed);
        auto& piece = pieces.back();
        inside[seed] = 2;
        for (std::size_t i = 0; i < piece.size(); ++i)
            for (const auto o : s.graph.neighbours[piece[i]])
                if (o != mesh::k_no_triangle && inside[o] == 1 && side_of_triangle[o] == side_of_triangle[seed]) {
                    inside[o] = 2;
                    piece.push_back(o);
                }
    }
    return pieces;
}

}  // namespace

std::vector<std::uint32_t> triangles_of(const Partition& partition, std::uint32_t part)
{
    std::vector<std::uint32_t> out;
    for (std::uint32_t t = 0; t < partition.part_of_triangle.size(); ++t)
        if (partition.part_of_triangle[t] == part) out.push_back(t);
    return out;
}

Partition components(const CutSurface& s)
{
    Partition partition;
    const std::vector<std::uint32_t> all = all_triangles(s);
    partition.part_of_triangle.assign(all.size(), 0);
    for (const auto& piece : pieces_of(s, all, std::vector<std::uint8_t>(all.size(), 0))) {
        for (const auto t : piece) partition.part_of_triangle[t] = partition.part_count;
        ++partition.part_count;
    }
    return partition;
}

std::uint32_t apply_cut(const CutSurface& s, Partition& partition, const PartCut& cut)
{
    std::vector<std::uint8_t> side(s.area.size(), 0);
    for (std::size_t i = 0; i < cut.triangles.size(); ++i) side[cut.triangles[i]] = cut.near[i];
    std::vector<std::vector<std::uint32_t>> pieces;
    while (true) {  // the smallest piece below the limit changes side, until none is left
        pieces = pieces_of(s, cut.triangles, side);
        if (pieces.size() < 2) return 1;
        const std::vector<std::uint32_t>* smallest = nullptr;
        double least = cut.least_area;
        for (const auto& piece : pieces)
            if (const double a = s.area_of(piece); a < least) {
                least = a;
                smallest = &piece;
            }
        if (!smallest) break;
        for (const auto t : *smallest) side[t] ^= 1;
    }
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < pieces.size(); ++i) order.emplace_back(-s.area_of(pieces[i]), i);
    std::sort(order.begin(), order.end());
    const Kinds kinds = kinds_of(partition);
    FormerLabels former;
    for (std::uint32_t l = 0; l < partition.part_count; ++l) former.push_back({l});
    for (std::size_t i = 1; i < order.size(); ++i) {
        for (const auto t : pieces[order[i].second]) partition.part_of_triangle[t] = partition.part_count;
        ++partition.part_count;
        former.push_back({cut.part});
    }
    partition.boundaries = boundaries_of(s, partition, {kinds, former, cut.kind});
    return static_cast<std::uint32_t>(pieces.size());
}

void apply_merge(const CutSurface& s, Partition& partition, std::uint32_t a, std::uint32_t b)
{
    const Kinds kinds = kinds_of(partition);
    const std::uint32_t last = partition.part_count - 1;
    FormerLabels former;
    for (std::uint32_t l = 0; l < last; ++l) former.push_back({l == b ? last : l});
    const std::uint32_t kept = a == last ? b : a;
    former[kept] = {a, b};
    for (auto& l : partition.part_of_triangle) {
        if (l == a || l == b)
            l = kept;
        else if (l == last)
            l = b;
    }
    partition.part_count = last;
    partition.boundaries = boundaries_of(s, partition, {kinds, former, CutKind::Error});
}

void order_by_area(const CutSurface& s, Partition& partition)
{
    std::vector<double> area(partition.part_count, 0.0);
    for (std::uint32_t t = 0; t < s.area.size(); ++t) area[partition.part_of_triangle[t]] += s.area[t];
    // Parts of (nearly) equal area keep the order of their least triangle.
    std::vector<std::uint32_t> first(partition.part_count, mesh::k_no_triangle);
    for (std::uint32_t t = static_cast<std::uint32_t>(s.area.size()); t-- > 0;) first[partition.part_of_triangle[t]] = t;
    std::vector<std::uint32_t> order(partition.part_count), rank(partition.part_count);
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(),
              [&](auto a, auto b) { return area[a] != area[b] ? area[a] > area[b] : first[a] < first[b]; });
    for (std::uint32_t i = 0; i < order.size(); ++i) rank[order[i]] = i;
    for (auto& l : partition.part_of_triangle) l = rank[l];
    for (Boundary& b : partition.boundaries) {
        const auto [x, y] = pair_of(rank[b.part_a], rank[b.part_b]);
        b.part_a = x;
        b.part_b = y;
    }
    std::sort(partition.boundaries.begin(), partition.boundaries.end(),
              [](const Boundary& a, const Boundary& b) { return pair_of(a.part_a, a.part_b) < pair_of(b.part_a, b.part_b); });
}

Partition grown(const CutSurface& s, const Partition& partition, std::vector<std::uint32_t> labels, FormerLabels former)
{
    // The largest piece of each label stays; what is apart from it goes to the labels around it, triangle by triangle.
    std::vector<std::vector<std::uint32_t>> largest(former.size());
    for (std::vector<std::uint32_t>& piece : pieces_of(s, all_triangles(s), labels)) {
        if (labels[piece.front()] == mesh::k_no_triangle) continue;
        std::vector<std::uint32_t>& kept = largest[labels[piece.front()]];
        if (s.area_of(piece) > s.area_of(kept)) kept.swap(piece);
    }
    labels.assign(labels.size(), mesh::k_no_triangle);
    std::vector<std::uint32_t> queue;
    const auto grow = [&](std::uint32_t t, std::uint32_t label) {
        labels[t] = label;
        queue.push_back(t);
    };
    std::size_t next = 0;
    const auto spread = [&] {
        for (; next < queue.size(); ++next)
            for (const std::uint32_t o : s.graph.neighbours[queue[next]])
                if (o != mesh::k_no_triangle && labels[o] == mesh::k_no_triangle) grow(o, labels[queue[next]]);
    };
    for (std::uint32_t l = 0; l < largest.size(); ++l)
        for (const std::uint32_t t : largest[l]) grow(t, l);
    spread();
    for (std::uint32_t t = 0; t < labels.size(); ++t) {
        if (labels[t] != mesh::k_no_triangle) continue;
        grow(t, static_cast<std::uint32_t>(former.size()));  // of a component without a part
        former.emplace_back();
        spread();
    }
    Partition out{std::move(labels), static_cast<std::uint32_t>(former.size()), {}};
    out.boundaries = boundaries_of(s, out, {kinds_of(partition), former, CutKind::Error});
    order_by_area(s, out);
    // Labels without a triangle have come last.
    out.part_count = 1 + *std::max_element(out.part_of_triangle.begin(), out.part_of_triangle.end());
    return out;
}

Partition carried_over(const mesh::Mesh& mesh, const Partition& coarse, std::vector<std::uint32_t> labels)
{
    FormerLabels former;
    for (std::uint32_t l = 0; l < coarse.part_count; ++l) former.push_back({l});
    return grown(CutSurface(mesh), coarse, std::move(labels), std::move(former));
}

}  // namespace sqmap::decompose
