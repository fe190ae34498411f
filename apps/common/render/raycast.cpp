// Ray casting by the meshes' own trees: a key light, a hemisphere of sky light dimmed by ambient occlusion (cast once a vertex,
// so that it has no noise), lines at outlines and between groups, translucent layers composited front to back.
#include "common/render/raycast.h"

#include "parallel/for_each.h"
#include "sqmap/math/box.h"
#include "sqmap/mesh/bvh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>

namespace sqmap::app {
namespace {

using std::numbers::pi;

constexpr std::uint32_t k_nothing = 0xffffffff;  // no layer

/// The first surface that a sample meets. A line is drawn where two neighbours meet different ones.
struct Seen {
    std::uint32_t layer = k_nothing;
    std::uint32_t group = 0;
    float depth = std::numeric_limits<float>::infinity();
};

/// Cells of a triangle run in rows along its second edge: row i has 2 (detail - i) - 1 of them, upright and inverted by
/// turns.
std::uint32_t cell_at(std::uint32_t detail, double u, double v)
{
    const double n = detail;
    const auto i = std::min(static_cast<std::uint32_t>(std::max(u * n, 0.0)), detail - 1);
    const auto j = std::min(static_cast<std::uint32_t>(std::max(v * n, 0.0)), detail - 1 - i);
    const bool inverted = i + j + 1 < detail && u * n - i + v * n - j > 1;
    return i * (2 * detail - i) + 2 * j + (inverted ? 1 : 0);
}

/// The layers of a kind as one mesh with one tree.
class Tree {
public:
    Tree(const std::vector<Layer>& layers, bool translucent)
    {
        for (std::uint32_t i = 0; i < layers.size(); ++i) {
            if (layers[i].translucent != translucent) continue;
            const auto first = static_cast<std::uint32_t>(mesh_.vertices.size());
            starts_.push_back({static_cast<std::uint32_t>(mesh_.triangles.size()), i});
            mesh_.vertices.insert(mesh_.vertices.end(), layers[i].mesh.vertices.begin(), layers[i].mesh.vertices.end());
            for (const mesh::Triangle& t : layers[i].mesh.triangles)
                mesh_.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
        }
        if (!mesh_.triangles.empty()) bvh_.emplace(mesh_);
    }
    Tree(const Tree&) = delete;  // the tree refers to the mesh
    Tree& operator=(const Tree&) = delete;

    struct Found {
        mesh::Bvh::Hit hit;  ///< triangle: of its layer
        std::uint32_t layer;
    };
    [[nodiscard]] std::optional<Found> first(const mesh::Bvh::Ray& ray) const
    {
        std::optional<mesh::Bvh::Hit> hit;
        if (bvh_) hit = bvh_->first_hit(ray);
        if (!hit) return std::nullopt;
        const auto after = std::upper_bound(starts_.begin(), starts_.end(), hit->triangle,
                                            [](std::uint32_t triangle, const Start& s) { return triangle < s.triangle; });
        hit->triangle -= (after - 1)->triangle;
        return Found{*hit, (after - 1)->layer};
    }
    [[nodiscard]] bool meets_any(const mesh::Bvh::Ray& ray) const { return bvh_ && bvh_->meets_any(ray); }

private:
    struct Start {
        std::uint32_t triangle, layer;
    };
    mesh::Mesh mesh_;
    std::vector<Start> starts_;
    std::optional<mesh::Bvh> bvh_;
};

class Scene {
public:
    Scene(const std::vector<Layer>& layers, int sky_rays)
        : layers_(layers), sky_rays_(sky_rays), opaque_(layers, false), translucent_(layers, true)
    {
        sqmap::Box box;
        for (const Layer& layer : layers)
            for (const Vec3d& p : layer.mesh.vertices) extend(box, p);
        const double size = norm(box.hi - box.lo);
        for (const Layer& layer : layers) {
            normals_.push_back(corner_normals(layer.mesh));
            sky_.push_back(layer.translucent ? std::vector<float>(layer.mesh.vertices.size(), 1.0f)
                                             : sky_light(layer.mesh, size));
        }
    }

    struct Hit {
        std::uint32_t layer, triangle, colour;
        float depth;
        Vec3d normal;  // interpolated, unit
        float sky;
    };

    enum class Kind { Opaque, Translucent };
    /// First surface of the layers of a kind along a ray.
    bool cast(Kind kind, const mesh::Bvh::Ray& ray, Hit& hit) const
    {
        const std::optional<Tree::Found> found = (kind == Kind::Opaque ? opaque_ : translucent_).first(ray);
        if (!found) return false;
        const double u = found->hit.u, v = found->hit.v, w = 1 - u - v;
        const std::uint32_t layer = found->layer, triangle = found->hit.triangle;
        const auto& n = normals_[layer][triangle];
        const mesh::Triangle& t = layers_[layer].mesh.triangles[triangle];
        const std::vector<float>& sky = sky_[layer];
        const std::uint32_t detail = layers_[layer].detail;
        hit = {layer,
               triangle,
               triangle * detail * detail + cell_at(detail, u, v),
               static_cast<float>(found->hit.t),
               normalized(w * n[0] + u * n[1] + v * n[2]),
               static_cast<float>(w * sky[t[0]] + u * sky[t[1]] + v * sky[t[2]])};
        return true;
    }

    /// True where nothing opaque stands in between; translucent layers let light and sky through.
    bool lit(const mesh::Bvh::Ray& ray) const { return !opaque_.meets_any(ray); }

private:
    /// Area-weighted vertex normals, but only over triangles within 40 degrees: creases stay sharp.
    static std::vector<std::array<Vec3d, 3>> corner_normals(const mesh::Mesh& mesh)
    {
        std::vector<std::vector<std::uint32_t>> around(mesh.vertices.size());
        std::vector<Vec3d> face(mesh.triangles.size());
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            const auto& [a, b, c] = mesh.triangles[t];
            face[t] = cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a]);
            for (const std::uint32_t v : mesh.triangles[t]) around[v].push_back(t);
        }
        std::vector<std::array<Vec3d, 3>> out(mesh.triangles.size());
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
            for (std::size_t i = 0; i < 3; ++i) {
                Vec3d sum{};
                for (const std::uint32_t other : around[mesh.triangles[t][i]])
                    if (dot(face[t], face[other]) > 0.766 * norm(face[t]) * norm(face[other])) sum += face[other];
                out[t][i] = normalized(norm_sq(sum) > 0 ? sum : face[t]);
            }
        return out;
    }

    /// Share of the sky that each vertex sees, cosine-weighted, within a quarter of the scene's size.
    std::vector<float> sky_light(const mesh::Mesh& mesh, double size) const
    {
        std::vector<Vec3d> normal(mesh.vertices.size());
        for (const auto& [a, b, c] : mesh.triangles) {
            const Vec3d n = cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a]);
            for (const std::uint32_t v : {a, b, c}) normal[v] += n;
        }
        std::vector<float> out(mesh.vertices.size());
        for (std::size_t v = 0; v < out.size(); ++v) {
            const Vec3d n = normalized(normal[v]);
            const Vec3d s = normalized(cross(n, std::abs(n.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0})), t = cross(n, s);
            int open = 0;
            for (int i = 0; i < sky_rays_; ++i) {
                // Fibonacci points on the disc, lifted to the hemisphere: cosine-weighted.
                const double r = std::sqrt((i + 0.5) / sky_rays_), angle = 2 * pi * i * (std::numbers::phi - 1);
                const Vec3d d = r * std::cos(angle) * s + r * std::sin(angle) * t + std::sqrt(1 - r * r) * n;
                open += lit({mesh.vertices[v] + 2e-4 * size * n, d, 0, 0.25 * size}) ? 1 : 0;
            }
            out[v] = static_cast<float>(open) / static_cast<float>(sky_rays_);
        }
        return out;
    }

    const std::vector<Layer>& layers_;
    int sky_rays_;
    Tree opaque_, translucent_;
    std::vector<std::vector<std::array<Vec3d, 3>>> normals_;
    std::vector<std::vector<float>> sky_;
};

/// The direction that azimuth 0 looks from: +z where y is up, +x where z is, +y where x is; the same for -y, -z, -x.
Vec3d front_of(Vec3d up)
{
    for (int i = 0; i < 3; ++i)
        if (up[i] != 0) {
            Vec3d front{};
            front[(i + 1) % 3] = 1;
            return front;
        }
    throw std::invalid_argument("render: no upward axis");
}

struct Camera {
    Vec3d eye, forward, right, up;
    double tan_half_x, tan_half_y;
};

Camera camera_for(const std::vector<Layer>& layers, const View& view)
{
    const Vec3d up = view.up, front = front_of(up);
    const Vec3d side = cross(up, front);
    const double az = view.azimuth * pi / 180, el = view.elevation * pi / 180;
    const Vec3d towards_eye = std::cos(el) * (std::cos(az) * front + std::sin(az) * side) + std::sin(el) * up;

    Camera camera;
    camera.forward = -towards_eye;
    camera.right = normalized(cross(camera.forward, std::abs(dot(up, towards_eye)) > 0.999 ? front : up));
    camera.up = cross(camera.right, camera.forward);
    camera.tan_half_y = std::tan(14 * pi / 180);
    camera.tan_half_x = camera.tan_half_y * (view.width - view.margin) / view.height;
    // The nearest eye that sees every vertex with a margin: planes of the frustum pushed back until they hold all.
    double rightmost = -1e300, leftmost = -1e300, topmost = -1e300, bottommost = -1e300;
    const double fx = 0.94 * camera.tan_half_x, fy = 0.94 * camera.tan_half_y;
    for (const Layer& layer : layers)
        for (const Vec3d& p : layer.mesh.vertices) {
            const double x = dot(p, camera.right), y = dot(p, camera.up), z = dot(p, camera.forward);
            rightmost = std::max(rightmost, x - fx * z);
            leftmost = std::max(leftmost, -x - fx * z);
            topmost = std::max(topmost, y - fy * z);
            bottommost = std::max(bottommost, -y - fy * z);
        }
    const double z = std::min(-(rightmost + leftmost) / (2 * fx), -(topmost + bottommost) / (2 * fy));
    camera.eye = (rightmost - leftmost) / 2 * camera.right + (topmost - bottommost) / 2 * camera.up + z * camera.forward;
    return camera;
}

/// From behind the viewer's left shoulder.
Vec3d key_light(const Camera& camera) { return normalized(-1.0 * camera.forward + 0.75 * camera.up - 0.55 * camera.right); }

/// Sample i of count over a round lamp: shadows get soft edges.
Vec3d lamp_offset(int i, int count, const Camera& camera)
{
    constexpr double k_radius = 0.16;
    const double r = k_radius * std::sqrt((i + 0.5) / count), angle = 2 * pi * i * (std::numbers::phi - 1);
    return r * std::cos(angle) * camera.right + r * std::sin(angle) * camera.up;
}

Rgb shade(Rgb colour, const Scene::Hit& hit, Vec3d normal, const Camera& camera, Vec3d key, bool in_light)
{
    const double diffuse = std::max(0.0, dot(normal, key)) * (in_light ? 1.0 : 0.4);
    const double skyward = 0.5 + 0.5 * dot(normal, camera.up);
    const double head = std::max(0.0, -dot(normal, camera.forward));
    const auto light = static_cast<float>(0.62 * diffuse + (0.30 + 0.22 * skyward) * hit.sky * hit.sky + 0.12 * head);
    const Vec3d half = normalized(key - camera.forward);
    const auto gloss = static_cast<float>(in_light ? 0.10 * std::pow(std::max(0.0, dot(normal, half)), 40.0) : 0.0);
    return light * colour + gloss * Rgb{1, 1, 1};
}

const Rgb k_background{1, 1, 1};

/// Lines: a sample is inked when a neighbour within half a pixel shows another layer or group or lies far behind.
Image with_lines(const Image& image, const std::vector<Seen>& seen, int samples)
{
    const int width = image.width, height = image.height;
    Image inked = image;
    const int reach = std::max(1, samples / 2);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const auto at = [&](int u, int v) -> const Seen& {
                return seen[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u)];
            };
            const Seen& here = at(x, y);
            float ink = 0;
            for (int dy = -reach; dy <= reach; ++dy)
                for (int dx = -reach; dx <= reach; ++dx) {
                    const int u = x + dx, v = y + dy;
                    if (u < 0 || v < 0 || u >= width || v >= height) continue;
                    const Seen& there = at(u, v);
                    if (there.layer != here.layer)
                        ink = std::max(ink, 0.75f);
                    else if (here.layer != k_nothing) {
                        if (there.group != here.group) ink = std::max(ink, 0.65f);
                        if (there.depth - here.depth > 0.02f * here.depth) ink = std::max(ink, 0.55f);
                    }
                }
            if (ink > 0) inked.at(x, y) = (1 - ink) * image.at(x, y) + ink * srgb(0x20242a);
        }
    return inked;
}

}  // namespace

std::array<double, 3> cell_centre(std::uint32_t detail, std::uint32_t cell)
{
    std::uint32_t i = 0;
    while (i + 1 < detail && cell >= (i + 1) * (2 * detail - i - 1)) ++i;
    const std::uint32_t k = cell - i * (2 * detail - i);
    const double within = k % 2 == 0 ? 1.0 / 3 : 2.0 / 3;
    const double u = (i + within) / detail, v = (k / 2 + within) / detail;
    return {1 - u - v, u, v};
}

double broad_azimuth(const mesh::Mesh& mesh, Vec3d up)
{
    constexpr int k_step = 5;
    const Vec3d front = front_of(up), side = cross(up, front);
    double best = 0, broadest = -1;
    for (int degrees = 0; degrees < 180; degrees += k_step) {
        const double az = degrees * pi / 180;
        const Vec3d towards = std::cos(az) * front + std::sin(az) * side;
        double area = 0;
        for (const auto& [a, b, c] : mesh.triangles)
            area += std::abs(dot(towards, cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a])));
        // A round mesh has no broadest side: rounding must not choose one.
        if (area > broadest * 1.001) {
            broadest = area;
            best = degrees;
        }
    }
    return best + 25;
}

Image render(const std::vector<Layer>& layers, const View& view)
{
    std::size_t triangles = 0;
    for (const Layer& layer : layers) triangles += layer.mesh.triangles.size();
    if (triangles == 0 || view.width - view.margin < 1 || view.height < 1 || view.samples < 1 || view.sky_rays < 1)
        throw std::invalid_argument("render: nothing to draw");
    const Scene scene(layers, view.sky_rays);
    const Camera camera = camera_for(layers, view);
    const Vec3d key = key_light(camera);
    const int width = view.width * view.samples, height = view.height * view.samples;
    Image image(width, height, {});
    std::vector<Seen> seen(image.pixels.size());

    const auto draw_row = [&](int y) {
        for (int x = 0; x < width; ++x) {
            const double sx = (2 * (x + 0.5) / (width - view.margin * view.samples) - 1) * camera.tan_half_x,
                         sy = (1 - 2 * (y + 0.5) / height) * camera.tan_half_y;
            const Vec3d direction = camera.forward + sx * camera.right + sy * camera.up;
            // Opaque surfaces come first: a translucent one may lie right on them and must not hide them from a later ray.
            Scene::Hit ground;
            Rgb behind = k_background;
            double end = std::numeric_limits<double>::infinity();
            if (scene.cast(Scene::Kind::Opaque, {camera.eye, direction}, ground)) {
                const Layer& layer = layers[ground.layer];
                const double facing = -dot(ground.normal, direction) / norm(direction);
                const Vec3d normal = facing < 0 ? -ground.normal : ground.normal;
                const Vec3d point = camera.eye + static_cast<double>(ground.depth) * direction;
                const Vec3d lamp =
                    key + lamp_offset(x % view.samples + y % view.samples * view.samples, view.samples * view.samples, camera);
                const bool in_light = !view.shadows || scene.lit({point + 1e-3 * ground.depth * normal, lamp});
                behind = shade(layer.colours[ground.colour], ground, normal, camera, key, in_light);
                seen[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] = {
                    ground.layer, layer.groups.empty() ? 0 : layer.groups[ground.triangle], ground.depth};
                end = ground.depth;
            }
            Rgb colour{};
            float through = 1;
            double from = 0;
            Scene::Hit hit;
            constexpr int k_max_layers = 48;
            for (int depth = 0;
                 depth < k_max_layers && scene.cast(Scene::Kind::Translucent, {camera.eye, direction, from, end}, hit); ++depth) {
                from = static_cast<double>(hit.depth) * (1 + 1e-5);
                const double facing = -dot(hit.normal, direction) / norm(direction);
                if (facing <= 0) continue;  // back of a translucent surface: nothing to add
                // More opaque towards its rim, as thin glass is: the shape reads without hiding what is inside.
                const auto alpha = static_cast<float>(0.34 + 0.6 * std::pow(1 - facing, 2.0));
                colour =
                    colour + (through * alpha) * shade(layers[hit.layer].colours[hit.colour], hit, hit.normal, camera, key, true);
                through *= 1 - alpha;
            }
            colour = colour + through * behind;
            image.at(x, y) = colour;
        }
    };
    parallel::for_each(static_cast<std::size_t>(height), view.threads, [&](std::size_t y) { draw_row(static_cast<int>(y)); });
    return shrunk(with_lines(image, seen, view.samples), view.samples);
}

}  // namespace sqmap::app
