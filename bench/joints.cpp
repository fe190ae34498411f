// Map of the error at joints of a skinned hand: the verdicts of rigid solids, one per joint, and of the lattice, along the
// normals of the exact skinned mesh; a picture of both and a table of the joints.
#include "common/layer_name.h"
#include "common/render/raycast.h"
#include "measure.h"
#include "skin_hand.h"

#include "sqmap/bake/bake_types.h"
#include "sqmap/bake/skin_lattice.h"
#include "sqmap/io/model_file.h"
#include "sqmap/io/read_skin.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/query/skin.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace sqmap;

constexpr std::uint32_t k_detail = 5;                 // cells along a triangle's edge
constexpr double k_step = 0.0005, k_farthest = 0.30;  // of R_max: along a normal
constexpr double k_low = 0.05, k_high = 5;            // % of R_max: the colours' ends
constexpr double k_wrong = 0.5;                       // % of R_max: what is counted

/// Which of the points are in contact.
using Verdicts = std::function<std::vector<bool>(const std::vector<Vec3d>&)>;

/// One position of the posed surface.
struct Position {
    Vec3d point, normal;
    double area = 0;
    std::size_t joint = 0;  ///< the nearest in the pose that the mesh was bound in
    bool boundary = false;  ///< of the skinned solid: not buried in it
};

/// For each position the distance from the surface of the farthest wrong verdict along its normal, outward or inward, that no
/// right verdict precedes; mesh units.
std::vector<double> errors_of(const std::vector<Position>& positions, const mesh::Solid& truth, double r_max,
                              const Verdicts& verdicts)
{
    std::vector<double> error(positions.size(), 0);
    for (const bool outward : {true, false}) {
        std::vector<std::size_t> left;
        for (std::size_t i = 0; i < positions.size(); ++i)
            if (positions[i].boundary) left.push_back(i);
        for (double s = k_step; s <= k_farthest && !left.empty(); s += k_step) {
            std::vector<Vec3d> points;
            for (const std::size_t i : left)
                points.push_back(positions[i].point + (outward ? s : -s) * r_max * positions[i].normal);
            const std::vector<bool> contact = verdicts(points);
            std::vector<std::size_t> still;
            for (std::size_t k = 0; k < left.size(); ++k) {
                if (contact[k] != outward || truth.inside(points[k]) == outward) continue;
                error[left[k]] = std::max(error[left[k]], truth.closest_boundary(points[k]).distance);
                still.push_back(left[k]);
            }
            left = std::move(still);
        }
    }
    return error;
}

app::Rgb colour_of(double percent)
{
    return app::error_colour(static_cast<float>(std::log(std::max(percent, k_low) / k_low) / std::log(k_high / k_low)));
}

/// The bone that moves each triangle most: a line between two of them goes round a joint.
std::vector<std::uint32_t> bones_of(const bench::Bound& bound)
{
    std::vector<std::uint32_t> bones;
    for (const mesh::Triangle& t : bound.mesh.triangles) {
        std::map<std::uint16_t, double> share;
        for (const std::uint32_t v : t)
            for (std::size_t k = 0; k < 4; ++k) share[bound.influences.joints[v][k]] += bound.influences.weights[v][k];
        bones.push_back(std::max_element(share.begin(), share.end(), [](const auto& a, const auto& b) {
                            return a.second < b.second;
                        })->first);
    }
    return bones;
}

void paste(app::Image& image, const app::Image& piece, int left, int top)
{
    for (int y = 0; y < piece.height; ++y)
        for (int x = 0; x < piece.width; ++x) image.at(left + x, top + y) = piece.at(x, y);
}

/// Prints the share of the boundary's area that is wrong beyond k_wrong, and at which joints.
void report(const char* pose, const char* method, const std::vector<Position>& positions, const std::vector<double>& error,
            double r_max, const io::SkinnedSoup& skin)
{
    double area = 0, wrong = 0, largest = 0;
    struct Joint {
        double area = 0, wrong = 0, largest = 0;
    };
    std::map<std::size_t, Joint> joints;
    for (std::size_t i = 0; i < positions.size(); ++i) {
        if (!positions[i].boundary) continue;
        const double percent = 100 * error[i] / r_max;
        Joint& j = joints[positions[i].joint];
        area += positions[i].area;
        j.area += positions[i].area;
        largest = std::max(largest, percent);
        j.largest = std::max(j.largest, percent);
        if (percent > k_wrong) {
            wrong += positions[i].area;
            j.wrong += positions[i].area;
        }
    }
    std::printf("%s, %s: %.2f %% of the surface is off by more than %.1f %% of R_max, at most by %.2f %%\n", pose, method,
                100 * wrong / area, k_wrong, largest);
    for (const auto& [j, at] : joints)
        if (at.largest > k_low)
            std::printf("  %-34s %5.1f %% of what is off, %5.1f %% of the surface there; at most %.2f %%\n",
                        skin.skeleton[j].name.c_str(), wrong > 0 ? 100 * at.wrong / wrong : 0, 100 * at.wrong / at.area,
                        at.largest);
}

struct Options {
    query::Layer layer = query::Layer::Exact;
    double least_weight = 0.05;
    app::View view{.azimuth = 60, .elevation = 15, .up = {0, 0, -1}, .width = 380, .height = 360, .shadows = false};
};

Options parsed(int argc, char** argv)
{
    Options o;
    for (int i = 3; i + 1 < argc; i += 2) {
        const std::string name = argv[i], value = argv[i + 1];
        if (name == "--layer") o.layer = app::layer_named(value).value_or(query::Layer::Three);
        if (name == "--solids") o.least_weight = std::atof(argv[i + 1]);
        if (name == "--azimuth") o.view.azimuth = std::atof(argv[i + 1]);
        if (name == "--elevation") o.view.elevation = std::atof(argv[i + 1]);
    }
    return o;
}

/// Positions spread over the posed surface. joints: of the skeleton, in the bound mesh's frame.
std::vector<Position> positions_of(const bench::Bound& bound, const mesh::Mesh& posed, const mesh::Solid& truth,
                                   const std::vector<Vec3d>& joints, double r_max)
{
    std::vector<Position> out;
    for (const auto& [i, j, k] : posed.triangles) {
        const auto& at = posed.vertices;
        const auto& was = bound.mesh.vertices;
        const Vec3d n = cross(at[j] - at[i], at[k] - at[i]);
        for (std::uint32_t cell = 0; cell < k_detail * k_detail; ++cell) {
            const auto w = app::cell_centre(k_detail, cell);
            Position position{.point = w[0] * at[i] + w[1] * at[j] + w[2] * at[k], .normal = normalized(n)};
            const Vec3d bound_position = w[0] * was[i] + w[1] * was[j] + w[2] * was[k];
            const auto nearer = [&](Vec3d a, Vec3d b) { return norm_sq(a - bound_position) < norm_sq(b - bound_position); };
            position.joint = static_cast<std::size_t>(std::min_element(joints.begin(), joints.end(), nearer) - joints.begin());
            position.area = norm(n) / (2 * k_detail * k_detail);
            const Vec3d beside = 1e-6 * r_max * position.normal;
            position.boundary = truth.inside(position.point - beside) && !truth.inside(position.point + beside);
            out.push_back(position);
        }
    }
    return out;
}

struct HandPose {
    const char* name;
    double curl;
    bool pointing;
};
constexpr std::array<HandPose, 3> k_poses{{{"half closed", 0.5, false}, {"fist", 1, false}, {"pointing", 1, true}}};
constexpr std::array<const char*, 2> k_methods{"rigid solids", "lattice"};

/// Both methods on one skin, and the picture of where they are wrong.
class JointMap {
public:
    JointMap(const io::SkinnedSoup& skin, const Options& options)
        : skin_(skin),
          options_(options),
          baked_(skin, bake::SkinLatticeOptions{}.cell),
          solids_(baked_.bound, skin.skeleton.size(), options.least_weight)
    {
        for (const io::SkinJoint& j : skin.skeleton)
            joints_.push_back(sqmap::inverse({j.inverse_bind.linear, j.inverse_bind.shift}).translation);
        image_ = app::Image(static_cast<int>(k_poses.size()) * options.view.width,
                            static_cast<int>(k_methods.size()) * options.view.height, app::srgb(0xffffff));
        image_ = app::Image(image_.width + app::scale_width(image_, scale_), image_.height, app::srgb(0xffffff));
    }

    void run(std::size_t p)
    {
        const std::vector<Affine> maps = bench::maps_of(skin_, k_poses[p].curl, k_poses[p].pointing);
        app::Layer drawn{.mesh = baked_.bound.mesh, .detail = k_detail, .groups = bones_of(baked_.bound)};
        drawn.mesh.vertices = mesh::skinned(baked_.bound.mesh.vertices, baked_.bound.influences, maps);
        const mesh::Solid truth(drawn.mesh, mesh::find_self_intersections(drawn.mesh).crossed);
        if (!baked_.posed->pose(maps)) throw std::runtime_error("a pose is not finite");
        const std::vector<Position> positions = positions_of(baked_.bound, drawn.mesh, truth, joints_, baked_.r_max);
        const std::array<Verdicts, 2> verdicts{[&](const auto& points) { return by_solids(maps, points); },
                                               [&](const auto& points) { return by_lattice(points); }};
        for (std::size_t m = 0; m < k_methods.size(); ++m) {
            const std::vector<double> error = errors_of(positions, truth, baked_.r_max, verdicts[m]);
            report(k_poses[p].name, k_methods[m], positions, error, baked_.r_max, skin_);
            drawn.colours.clear();
            for (const double e : error) drawn.colours.push_back(colour_of(100 * e / baked_.r_max));
            const app::View& view = options_.view;
            const int left = static_cast<int>(p) * view.width, top = static_cast<int>(m) * view.height;
            paste(image_, app::render({drawn}, view), left, top);
            const int dot = app::text_dot(image_);
            app::draw_text(image_, left + 6 * dot, top + 6 * dot, dot, std::string(k_methods[m]) + ", " + k_poses[p].name,
                           app::srgb(0x30343a));
        }
    }

    void write(const char* path)
    {
        app::draw_scale(image_, scale_);
        app::write_png(path, image_);
    }

private:
    std::vector<bool> by_solids(const std::vector<Affine>& maps, const std::vector<Vec3d>& points) const
    {
        std::vector<double> depth(points.size(), -1);
        solids_.query_depths(maps, points, options_.layer, depth);
        std::vector<bool> contact;
        for (const double d : depth) contact.push_back(d >= 0);
        return contact;
    }
    std::vector<bool> by_lattice(const std::vector<Vec3d>& points)
    {
        query::SkinWorkspace workspace(baked_.lattice, points);
        std::vector<query::SkinContact> contacts(points.size());
        const auto r =
            query::query_skin({&baked_.model, &*baked_.posed, points, {}}, {.layer = options_.layer}, workspace, contacts);
        std::vector<bool> contact(points.size(), false);
        for (std::size_t c = 0; c < r.contacts; ++c) contact[contacts[c].index] = true;
        return contact;
    }

    const io::SkinnedSoup& skin_;
    Options options_;
    bench::BakedSkin baked_;
    bench::Solids solids_;
    std::vector<Vec3d> joints_;  ///< in the bound mesh's frame
    app::Scale scale_{.title = {"off by,", "% of R_max"},
                      .colour = app::error_colour,
                      .ticks = {{0, "< 0.05"}, {0.25f, "0.16"}, {0.5f, "0.5"}, {0.75f, "1.6"}, {1, "> 5"}}};
    app::Image image_;
};

}  // namespace

int sqmap::bench::measure_joints(int argc, char** argv)
{
    if (argc < 3 || argc % 2 == 0) return k_wrong_usage;
    const std::optional<io::SkinnedSoup> skin = bench::read_skin(argv[1]);
    if (!skin) return 2;
    JointMap map(*skin, parsed(argc, argv));
    for (std::size_t p = 0; p < k_poses.size(); ++p) map.run(p);
    map.write(argv[2]);
    return 0;
}
