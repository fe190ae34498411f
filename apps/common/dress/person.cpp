#include "common/dress/person.h"

#include "sqmap/math/box.h"
#include "sqmap/mesh/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>

namespace sqmap::app {
namespace {

constexpr double k_grown = 1.75;  ///< m: the height that the lengths below are for
constexpr double k_melt = 0.011;  ///< m: over which capsules melt

/// Trunk, neck and head: all that lies on the middle or on both sides of it.
void add_trunk(std::vector<mesh::Capsule>& out)
{
    const auto both = [&](Vec3d a, Vec3d b, double ra, double rb) {
        out.push_back({a, b, ra, rb});
        out.push_back({{-a.x, a.y, a.z}, {-b.x, b.y, b.z}, ra, rb});
    };
    both({0.062, 1.435, -0.014}, {0.055, 1.30, -0.005}, 0.055, 0.094);  // ribs
    both({0.055, 1.345, -0.005}, {0.045, 1.22, 0.0}, 0.092, 0.092);
    both({0.085, 1.41, 0.012}, {0.165, 1.425, 0.004}, 0.046, 0.048);   // collar bones
    both({0.045, 1.22, 0.0}, {0.042, 1.11, 0.004}, 0.092, 0.080);      // down to the waist
    both({0.042, 1.11, 0.004}, {0.070, 0.985, -0.002}, 0.080, 0.096);  // to the hips
    both({0.070, 0.985, -0.002}, {0.078, 0.92, -0.004}, 0.096, 0.094);
    both({0.066, 0.95, -0.045}, {0.072, 0.895, -0.046}, 0.074, 0.066);     // seat
    both({0.068, 1.345, 0.036}, {0.085, 1.30, 0.040}, 0.058, 0.052);       // chest
    both({0.075, 1.36, -0.050}, {0.070, 1.24, -0.044}, 0.056, 0.050);      // shoulder blades
    both({0.030, 1.475, -0.022}, {0.150, 1.430, -0.010}, 0.036, 0.042);    // from the neck to the shoulder
    out.push_back({{0, 1.42, -0.012}, {0, 1.565, 0.004}, 0.055, 0.046});   // neck
    out.push_back({{0, 1.645, -0.012}, {0, 1.662, 0.004}, 0.073, 0.071});  // skull
    out.push_back({{0, 1.625, 0.014}, {0, 1.565, 0.052}, 0.060, 0.026});   // face to the chin
    out.push_back({{0, 1.640, 0.074}, {0, 1.598, 0.098}, 0.007, 0.013});   // nose
    both({0.076, 1.635, -0.004}, {0.079, 1.612, -0.002}, 0.011, 0.007);    // ears
}

void add_arm(std::vector<mesh::Capsule>& out, double side)
{
    const auto add = [&](Vec3d a, Vec3d b, double ra, double rb) {
        out.push_back({{side * a.x, a.y, a.z}, {side * b.x, b.y, b.z}, ra, rb});
    };
    add({0.165, 1.425, 0.0}, {0.225, 1.428, 0.0}, 0.056, 0.050);  // shoulder
    add({0.150, 1.385, 0.010}, {0.200, 1.420, 0.010}, 0.045, 0.044);
    add({0.225, 1.428, 0.0}, {0.33, 1.432, 0.004}, 0.050, 0.047);  // upper arm
    add({0.33, 1.432, 0.0}, {0.45, 1.43, 0.0}, 0.046, 0.038);
    add({0.45, 1.43, 0.0}, {0.53, 1.43, 0.002}, 0.038, 0.041);  // forearm
    add({0.53, 1.43, 0.002}, {0.685, 1.43, 0.0}, 0.040, 0.027);
    add({0.685, 1.43, 0.0}, {0.715, 1.43, 0.0}, 0.027, 0.025);  // wrist
    for (int k = 0; k < 4; ++k) {                               // palm and fingers, side by side
        const double z = 0.027 - 0.018 * k, length = std::array{0.070, 0.082, 0.076, 0.058}[static_cast<std::size_t>(k)];
        add({0.715, 1.43, 0.5 * z}, {0.785, 1.430, z}, 0.014, 0.0105);
        add({0.785, 1.430, z}, {0.785 + 0.55 * length, 1.426, 1.10 * z}, 0.0085, 0.0075);
        add({0.785 + 0.55 * length, 1.426, 1.10 * z}, {0.785 + length, 1.417, 1.13 * z}, 0.0075, 0.006);
    }
    add({0.725, 1.427, 0.018}, {0.755, 1.420, 0.046}, 0.014, 0.011);  // thumb
    add({0.755, 1.420, 0.046}, {0.795, 1.415, 0.062}, 0.010, 0.008);
}

void add_leg(std::vector<mesh::Capsule>& out, double side)
{
    const auto add = [&](Vec3d a, Vec3d b, double ra, double rb) {
        out.push_back({{side * a.x, a.y, a.z}, {side * b.x, b.y, b.z}, ra, rb});
    };
    add({0.092, 0.90, -0.002}, {0.094, 0.72, 0.004}, 0.083, 0.073);  // thigh
    add({0.094, 0.72, 0.004}, {0.095, 0.52, 0.002}, 0.071, 0.050);
    add({0.095, 0.52, 0.004}, {0.095, 0.47, 0.002}, 0.050, 0.046);    // knee
    add({0.095, 0.46, -0.006}, {0.095, 0.34, -0.018}, 0.044, 0.048);  // calf
    add({0.095, 0.34, -0.018}, {0.095, 0.12, -0.012}, 0.046, 0.029);
    add({0.095, 0.12, -0.012}, {0.095, 0.075, -0.012}, 0.029, 0.031);   // ankle
    add({0.095, 0.060, -0.020}, {0.095, 0.034, -0.038}, 0.030, 0.028);  // heel
    add({0.095, 0.070, 0.000}, {0.100, 0.034, 0.105}, 0.033, 0.024);    // foot
    add({0.095, 0.026, -0.020}, {0.090, 0.024, 0.110}, 0.020, 0.021);
    add({0.088, 0.024, 0.105}, {0.092, 0.020, 0.165}, 0.022, 0.017);  // toes
    add({0.112, 0.022, 0.090}, {0.118, 0.018, 0.140}, 0.020, 0.014);
}

/// Capsules that follow each other would bulge where their ends meet, by the melt of two equal distances: each end is drawn back
/// so far that the dent between two spheres makes up for it.
mesh::Capsule parted(mesh::Capsule c)
{
    const Vec3d axis = c.b - c.a;
    const double length = norm(axis);
    const auto back = [&](double radius) { return std::min(0.4 * length, std::sqrt(2 * k_melt * std::log(2.0) * radius)); };
    const double from_a = back(c.radius_a) / length, from_b = back(c.radius_b) / length, change = c.radius_b - c.radius_a;
    return {c.a + from_a * axis, c.b - from_b * axis, c.radius_a + from_a * change, c.radius_b - from_b * change};
}

double eased(double x)
{
    const double s = std::clamp(x, 0.0, 1.0);
    return s * s * (3 - 2 * s);
}

/// Goes from 0 to 1 while a coordinate goes from one value to another.
double passed(double x, double from, double to) { return eased((x - from) / (to - from)); }

/// Numbers of capsule_human's bones.
enum Which : std::uint16_t {
    Pelvis,
    Chest,
    Head,
    UpperArmL,
    ForearmL,
    UpperArmR,
    ForearmR,
    ThighL,
    ShinL,
    FootL,
    ThighR,
    ShinR,
    FootR
};

/// Shares of the bones in a vertex: a limb takes its share of what its parent has.
std::array<double, FootR + 1> shares(Vec3d p)
{
    std::array<double, FootR + 1> w{};
    const auto take = [&](Which from, Which to, double share) {
        const double part = w[from] * share;
        w[to] += part;
        w[from] -= part;
    };
    const bool left = p.x > 0;
    const double x = std::abs(p.x);
    w[Pelvis] = 1;
    take(Pelvis, Chest, passed(p.y, 1.00, 1.17));
    take(Chest, Head, passed(p.y, 1.49, 1.58) * (1 - passed(x, 0.09, 0.13)));
    // The ribs below the arm stay with the chest.
    const Which upper = left ? UpperArmL : UpperArmR, fore = left ? ForearmL : ForearmR;
    const double arm = passed(x, 0.125, 0.235) * passed(p.y, 1.29, 1.37);
    take(Chest, upper, arm);
    take(upper, fore, passed(x, 0.40, 0.50));
    // Between the legs the skin stays with the pelvis.
    const Which thigh = left ? ThighL : ThighR, shin = left ? ShinL : ShinR, foot = left ? FootL : FootR;
    const double between = passed(p.y, 0.78, 0.86) * (1 - passed(x, 0.005, 0.05));
    take(Pelvis, thigh, (1 - passed(p.y, 0.83, 0.98)) * (1 - between));
    take(thigh, shin, 1 - passed(p.y, 0.45, 0.55));
    take(shin, foot, 1 - passed(p.y, 0.07, 0.13));
    return w;
}

/// The four largest shares, which sum to 1 again.
void add_influences(const std::array<double, FootR + 1>& w, mesh::Influences& out)
{
    std::array<std::uint16_t, FootR + 1> order{};
    for (std::uint16_t b = 0; b < order.size(); ++b) order[b] = b;
    std::stable_sort(order.begin(), order.end(), [&](std::uint16_t a, std::uint16_t b) { return w[a] > w[b]; });
    std::array<std::uint16_t, 4> joints{};
    std::array<double, 4> weights{};
    double sum = 0;
    for (std::size_t k = 0; k < 4; ++k) {
        joints[k] = order[k];
        weights[k] = w[order[k]];
        sum += weights[k];
    }
    for (double& share : weights) share /= sum;
    out.joints.push_back(joints);
    out.weights.push_back(weights);
}

/// Unit, outward: the means of the triangles about each vertex by their areas.
std::vector<Vec3d> vertex_normals(const mesh::Mesh& mesh)
{
    std::vector<Vec3d> out(mesh.vertices.size());
    for (const auto& t : mesh.triangles) {
        const Vec3d area = cross(mesh.vertices[t[1]] - mesh.vertices[t[0]], mesh.vertices[t[2]] - mesh.vertices[t[0]]);
        for (const std::uint32_t v : t) out[v] += area;
    }
    for (Vec3d& n : out) n = normalized(n);
    return out;
}

}  // namespace

Person person(double height, double spacing)
{
    if (!(std::isfinite(height) && height > 0 && spacing > 0)) throw std::invalid_argument("a person's height must be positive");
    Person out;
    mesh::CapsuleSolid solid;
    solid.blend = k_melt;
    add_trunk(solid.capsules);
    for (const double side : {1.0, -1.0}) {
        add_arm(solid.capsules, side);
        add_leg(solid.capsules, side);
    }
    for (mesh::Capsule& c : solid.capsules) c = parted(c);
    out.mesh = mesh::polygonized(solid, spacing);
    const std::vector<Vec3d> normals = vertex_normals(out.mesh);
    for (std::size_t v = 0; v < normals.size(); ++v) {
        add_influences(shares(out.mesh.vertices[v]), out.influences);
        out.skin.push_back((height / k_grown) * (out.mesh.vertices[v] - k_skin_below * normals[v]));
    }
    out.bones = sim::capsule_human(height);
    for (Vec3d& v : out.mesh.vertices) v = (height / k_grown) * v;
    return out;
}

}  // namespace sqmap::app
