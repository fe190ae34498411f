// A cloth from a garment: threads along the edges and across them, masses, seams.
#include "cloth_state.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <stdexcept>

namespace sqmap::sim {

namespace {

void check(const Garment& garment)
{
    const std::size_t n = garment.start.size();
    if (garment.flat.size() != n)
        throw std::invalid_argument("a garment's flat pattern has another number of vertices than its start");
    if (garment.triangles.empty()) throw std::invalid_argument("a garment without triangles");
    for (const auto& t : garment.triangles)
        for (const std::uint32_t v : t)
            if (v >= n) throw std::invalid_argument("a garment's triangle names a vertex that is not there");
    for (const Seam& seam : garment.seams)
        for (const auto& pair : seam.pairs)
            if (pair[0] >= n || pair[1] >= n)
                throw std::invalid_argument("seam '" + seam.name + "' names a vertex that is not there");
    for (std::size_t i = 0; i < n; ++i)
        if (!is_finite(garment.start[i]) || !is_finite(garment.flat[i]))
            throw std::invalid_argument("a garment's vertex is not finite");
}

}  // namespace

Cloth::Cloth(const Garment& garment, const Fabric& fabric, const ClothOptions& options)
{
    check(garment);
    state_ = std::make_unique<State>(garment, fabric, options);
}

Cloth::State::State(const Garment& garment, const Fabric& f, const ClothOptions& o)
    : fabric(f),
      options(o),
      triangles(garment.triangles),
      contacts(garment.start, f.thickness, o.sweep_step, o.layer),
      interiors(garment.triangles, f.thickness, o.layer),
      settling(garment.triangles, garment.start.size(), f.thickness)
{
    info.m_gravity = to_bullet(o.gravity);
    const std::size_t n = garment.start.size();
    std::vector<btVector3> x(n);
    for (std::size_t i = 0; i < n; ++i) x[i] = to_bullet(garment.start[i]);
    body = std::make_unique<btSoftBody>(&info, static_cast<int>(n), x.data(), nullptr);
    body->getCollisionShape()->setMargin(static_cast<btScalar>(f.thickness));
    body->m_cfg.kDF = static_cast<btScalar>(std::min(1.0, f.friction));
    body->m_cfg.kSHR = 1;
    add_threads(garment);
    add_mass(garment);
    add_seams(garment);
    body->m_bUpdateRtCst = false;  // Bullet would take the start for the rest shape
    body->updateLinkConstants();
    if (o.self_collision) self = std::make_unique<SelfContacts>(garment.start, triangles, f.thickness);
    moving.resize(n);
    restless.resize(n);
    threads.resize(static_cast<std::size_t>(body->m_links.size()));
    weak.resize(threads.size(), 1);
    // Cloth that is sheared is longer along a diagonal, and right so.
    std::copy(diagonal.begin(), diagonal.end(), weak.begin());
    diagonal.resize(threads.size());
    speed.resize(n);
    tight.reserve(threads.size());
    predicted.resize(n);
    before.resize(n);
    bends.resize(n);
    position.assign(garment.start.begin(), garment.start.end());
    velocity.resize(n);
    previous = good = position;
    names = sewn_names();
}

void Cloth::State::add_threads(const Garment& garment)
{
    const auto material = [&](double stiffness) {
        btSoftBody::Material* m = body->appendMaterial();
        m->m_kLST = static_cast<btScalar>(std::clamp(stiffness, 0.0, 1.0));
        return m;
    };
    btSoftBody::Material *along = material(fabric.stretch), *across = material(1);
    struct Edge {
        std::uint32_t opposite[2] = {};
        int count = 0;
    };
    std::map<std::array<std::uint32_t, 2>, Edge> edges;
    for (const auto& t : garment.triangles) {
        body->appendFace(static_cast<int>(t[0]), static_cast<int>(t[1]), static_cast<int>(t[2]));
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3];
            Edge& edge = edges[{std::min(a, b), std::max(a, b)}];
            if (edge.count < 2) edge.opposite[edge.count] = t[(k + 2) % 3];
            ++edge.count;
        }
    }
    const auto link = [&](std::uint32_t a, std::uint32_t b, btSoftBody::Material* m) {
        body->appendLink(static_cast<int>(a), static_cast<int>(b), m, false);
        btSoftBody::Link& l = body->m_links[body->m_links.size() - 1];
        l.m_rl = static_cast<btScalar>(norm(garment.flat[a] - garment.flat[b]));
        l.m_c1 = l.m_rl * l.m_rl;
    };
    for (const auto& [ends, edge] : edges) {
        // The longest edge of both its triangles is a diagonal of the weave.
        const double length = norm(garment.flat[ends[0]] - garment.flat[ends[1]]);
        bool longest = edge.count == 2;
        for (int k = 0; k < std::min(edge.count, 2); ++k)
            for (const std::uint32_t end : ends)
                longest = longest && length > norm(garment.flat[edge.opposite[k]] - garment.flat[end]);
        link(ends[0], ends[1], longest ? across : along);
        if (edge.count == 2 && fabric.bend > 0)
            add_hinge(garment, {ends[0], ends[1], edge.opposite[0], edge.opposite[1]}, longest);
    }
    spread_hinges();
    body->randomizeConstraints();  // a sweep in the order of the weave would pull to one side
    diagonal.resize(static_cast<std::size_t>(body->m_links.size()));
    for (std::size_t l = 0; l < diagonal.size(); ++l) {
        const btSoftBody::Link& d = body->m_links[static_cast<int>(l)];
        if (d.m_material != across) continue;
        diagonal[l] = 1;
        shears.push_back({number(d.m_n[0]), number(d.m_n[1]), d.m_rl});
    }
}

void Cloth::State::add_hinge(const Garment& garment, const std::array<std::uint32_t, 4>& node, bool diagonal_edge)
{
    // The sum of Bergou et al., linear in the positions where nothing stretches. Their factor, 3 / area for every edge, is that
    // of a mesh whose edges take equal parts; on square cells a fold along the threads bends edges of one direction alone. 1 /
    // area, and half of it for diagonals, gives folds along threads and across them the energy of a sheet.
    std::array<Vec3d, 4> x;
    for (std::size_t k = 0; k < 4; ++k) x[k] = garment.flat[node[k]];
    const auto cotangent = [](Vec3d a, Vec3d b) { return dot(a, b) / norm(cross(a, b)); };
    const Vec3d edge = x[1] - x[0];
    const double area = 0.5 * (norm(cross(edge, x[2] - x[0])) + norm(cross(edge, x[3] - x[0])));
    const double c01 = cotangent(edge, x[2] - x[0]), c02 = cotangent(edge, x[3] - x[0]);
    const double c03 = cotangent(-1.0 * edge, x[2] - x[1]), c04 = cotangent(-1.0 * edge, x[3] - x[1]);
    const double give = (diagonal_edge ? 2 : 1) * area / fabric.bend;
    const std::array weight{c03 + c04, c01 + c02, -c01 - c03, -c02 - c04};
    if (!std::isfinite(c01 + c02 + c03 + c04)) return;  // a triangle without area bends with its neighbours
    Hinge& hinge = hinges.emplace_back(Hinge{node, {}, {{}, static_cast<float>(give)}});
    for (std::size_t k = 0; k < 4; ++k) hinge.weight[k] = static_cast<float>(weight[k]);
}

void Cloth::State::spread_hinges()
{
    // In the order of the weave each hinge waits for the nodes of the last one; the processor solves several at a time that lie
    // far apart.
    constexpr std::size_t k_apart = 16;
    std::vector<Hinge> spread;
    spread.reserve(hinges.size());
    const std::size_t rows = (hinges.size() + k_apart - 1) / k_apart;
    for (std::size_t row = 0; row < rows; ++row)
        for (std::size_t i = row; i < hinges.size(); i += rows) spread.push_back(hinges[i]);
    hinges = std::move(spread);
}

void Cloth::State::add_mass(const Garment& garment)
{
    std::vector<double> mass(garment.start.size());
    for (const auto& t : garment.triangles) {
        const double area = 0.5 * norm(cross(garment.flat[t[1]] - garment.flat[t[0]], garment.flat[t[2]] - garment.flat[t[0]]));
        for (const std::uint32_t v : t) mass[v] += fabric.density * area / 3;
    }
    for (std::size_t i = 0; i < mass.size(); ++i)
        body->setMass(static_cast<int>(i), static_cast<btScalar>(std::max(mass[i], 1e-9)));
}

void Cloth::State::add_seams(const Garment& garment)
{
    btSoftBody::Material* thread = body->appendMaterial();
    thread->m_kLST = 1;
    // One after the other: panels whose edges are all drawn together at once bulge, and their edges come so near each other
    // that an arm between them may keep them apart.
    double earlier = 0;
    for (const Seam& seam : garment.seams) {
        SeamLinks links;
        const bool closed = std::all_of(seam.pairs.begin(), seam.pairs.end(), [&](const auto& pair) {
            return norm(garment.start[pair[0]] - garment.start[pair[1]]) <= fabric.thickness;
        });
        links.age = closed ? k_sewing_time : -earlier;
        if (seam.sewn && !closed) earlier += k_sewing_time;
        links.first = body->m_links.size();
        links.sewn = links.carried = seam.sewn;
        for (const auto& pair : seam.pairs) body->appendLink(static_cast<int>(pair[0]), static_cast<int>(pair[1]), thread, false);
        links.count = body->m_links.size() - links.first;
        for (int i = 0; i < links.count; ++i) links.gap.push_back(body->m_links[links.first + i].m_rl);
        seams.push_back(std::move(links));
    }
}

std::vector<std::uint32_t> Cloth::State::sewn_names() const
{
    std::vector<std::uint32_t> name(position.size());
    std::iota(name.begin(), name.end(), 0u);
    const auto root = [&](std::uint32_t v) {
        while (name[v] != v) v = name[v] = name[name[v]];
        return v;
    };
    for (const SeamLinks& seam : seams)
        for (int i = 0; i < seam.count && seam.sewn; ++i) {
            const btSoftBody::Link& l = body->m_links[seam.first + i];
            const std::uint32_t a = root(number(l.m_n[0])), b = root(number(l.m_n[1]));
            name[std::max(a, b)] = std::min(a, b);
        }
    for (std::uint32_t v = 0; v < name.size(); ++v) name[v] = root(v);
    return name;
}

}  // namespace sqmap::sim
