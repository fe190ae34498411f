#include "viewer/server/scene/object.h"

#include "sqmap/haptic/step.h"
#include "sqmap/math/box.h"
#include "sqmap/model/model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

namespace sqmap::viewer {

void Object::put_at(double scale, Vec3d at, Up upward)
{
    const model::Header& h = view.header;
    Box box = box_of(mesh.vertices);
    if (is_empty(box)) {
        const Vec3d middle = cast<double>(model::vec3(h.sphere)), reach = static_cast<double>(h.sphere[3]) * Vec3d{1, 1, 1};
        box = {middle - reach, middle + reach};
    }
    metres_per_unit = scale;
    metres = haptic::in_metres(view, scale);
    centre = h.unit * sqmap::centre(box) + frame().origin;
    up = upward;
    const Vec3d turned = turn() * (0.5 * scale * h.unit * size(box));
    half = {std::abs(turned.x), std::abs(turned.y), std::abs(turned.z)};
    position = at;
}

Mat3d Object::turn() const
{
    if (up == Up::Z) return {{{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}};
    if (up == Up::X) return {{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}}};
    return {};
}

sqmap::Pose Object::pose() const { return {turn(), position - metres_per_unit * (turn() * centre)}; }

Frame Object::frame() const
{
    const model::Header& h = view.header;
    return {{h.origin[0], h.origin[1], h.origin[2]}, h.unit};
}

Vec3f Object::world(Vec3d p) const
{
    const Vec3d in_mesh = view.header.unit * p + frame().origin;
    return cast<float>(metres_per_unit * (turn() * (in_mesh - centre)) + position);
}

Vec3d Object::mesh_units(Vec3d p) const { return (1 / metres_per_unit) * transpose_mul(turn(), p - position) + centre; }

mesh::Mesh part_mesh(const Object& object, const Parts& parts, std::uint32_t part)
{
    constexpr std::uint32_t k_none = std::numeric_limits<std::uint32_t>::max();
    mesh::Mesh out;
    std::vector<std::uint32_t> number(object.mesh.vertices.size(), k_none);
    for (std::uint32_t t = 0; t < object.mesh.triangles.size(); ++t) {
        if (parts.partition.part_of_triangle[t] != part) continue;
        mesh::Triangle corners = object.mesh.triangles[t];
        for (std::uint32_t& corner : corners) {
            std::uint32_t& at = number[corner];
            if (at == k_none) {
                at = static_cast<std::uint32_t>(out.vertices.size());
                out.vertices.push_back(object.mesh.vertices[corner]);
            }
            corner = at;
        }
        out.triangles.push_back(corners);
    }
    return out;
}

std::vector<std::uint8_t> made_up_triangles(const Object& object)
{
    std::vector<std::uint8_t> out;
    if (object.view.cure.rung == model::Rung::AsItIs) return out;
    for (std::size_t t = 0; t < object.mesh.triangles.size(); ++t) out.push_back(model::is_made_up(object.view, t) ? 1 : 0);
    return out;
}

bool are_of_one_mesh(const Object& a, const Object& b)
{
    if (a.mesh.triangles.empty() || a.mesh.vertices.size() != b.mesh.vertices.size()) return false;
    const Frame at_a = a.frame(), at_b = b.frame();
    const double close = 1e-5 * a.view.header.r_max * at_a.unit;  // rounded to float once more in between
    return std::abs(at_a.unit - at_b.unit) < 1e-5 * at_a.unit && norm(at_a.origin - at_b.origin) < close &&
           a.mesh.triangles == b.mesh.triangles;
}

std::vector<std::uint32_t> nearest_seeds(const mesh::Mesh& mesh, const mesh::DualGraph& dual,
                                         const std::vector<std::uint32_t>& seeds, const MayEnter& may_enter)
{
    struct Reach {
        double along;
        std::uint32_t triangle, seed;
        bool operator<(const Reach& o) const { return along > o.along; }
    };
    std::vector<std::uint32_t> owner(mesh.triangles.size(), k_no_seed);
    std::priority_queue<Reach> queue;
    for (std::uint32_t i = 0; i < seeds.size(); ++i) queue.push({0, seeds[i], i});
    while (!queue.empty()) {
        const Reach at = queue.top();
        queue.pop();
        if (owner[at.triangle] != k_no_seed) continue;
        owner[at.triangle] = at.seed;
        for (const std::uint32_t next : dual.neighbours[at.triangle]) {
            if (next == mesh::k_no_triangle || owner[next] != k_no_seed) continue;
            const double along =
                at.along + norm(mesh::triangle_centroid(mesh, next) - mesh::triangle_centroid(mesh, at.triangle));
            if (may_enter(next, along)) queue.push({along, next, at.seed});
        }
    }
    return owner;
}

void put_beside(Object& object, std::span<const ObjectPtr> others)
{
    constexpr std::size_t k_a_row = 3;
    object.position = {};
    if (others.empty()) return;
    const std::size_t row = others.size() / k_a_row;
    // All objects stand on one ground, at the lowest point of the first; the second row is behind the first.
    const double size = object.metres.header.r_max * object.metres.header.unit;
    object.position.y = others.front()->position.y - others.front()->half.y + object.half.y;
    object.position.z = -1.1 * size * static_cast<double>(row);
    double edge = others.front()->position.x - others.front()->half.x - 0.03;
    for (const ObjectPtr& other : others)
        if (std::abs(other->position.z - object.position.z) < 0.5 * size)
            edge = std::max(edge, other->position.x + other->half.x);
    object.position.x = edge + 0.03 + object.half.x;
}

}  // namespace sqmap::viewer
