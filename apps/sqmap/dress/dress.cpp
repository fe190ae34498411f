// sqmap dress: a fitting without a window.
#include "commands.h"
#include "common/dress/avatar.h"
#include "common/dress/garment_file.h"
#include "common/layer_name.h"
#include "common/render/raycast.h"
#include "dress/held_tool.h"
#include "dress/worn.h"
#include "io/replace_file.h"
#include "sqmap/io/model_file.h"
#include "sqmap/io/write_mesh.h"
#include "sqmap/sim/cloth.h"

#include <nlohmann/json.hpp>

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

namespace sqmap::app {
namespace {

using nlohmann::json;

constexpr unsigned k_colours[] = {0x3b6ea5, 0xb5563c, 0x5a8f4a, 0x8a5fa0, 0xc29a3a};
constexpr unsigned k_skin = 0xd9b99b;

bool is_gltf(const std::filesystem::path& path)
{
    const std::string ending = path.extension().string();
    return ending == ".glb" || ending == ".gltf" || ending == ".GLB" || ending == ".GLTF";
}

struct DressArguments {
    std::string avatar, animation, output, report, pictures, layer = "3";
    std::vector<std::string> garments;
    std::string device, tool_at;
    double walker = 0, seconds = 4, rate = 240, fps = 15, azimuth = 25, thinnest = 0.02;
    bool walk = false, paper_friction = false, self_collision = false;
    int iterations = 12;
};

/// Thrown for an output that cannot be written, before anything is simulated.
class BadOutput : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// @throw BadOutput, io::ModelFileError
void check_outputs(const DressArguments& a)
{
    io::check_output(a.output, {a.avatar});
    io::check_output(a.report, {a.avatar, a.output});
    const std::string end = std::filesystem::path(a.output).extension().string();
    if (end != ".glb" && end != ".GLB") throw BadOutput("-o " + a.output + ": what is written is a .glb\n  cure: that ending");
    std::error_code error;
    if (!a.pictures.empty() && !std::filesystem::is_directory(a.pictures) &&
        !std::filesystem::create_directory(a.pictures, error))
        throw BadOutput("--pictures " + a.pictures + ": the folder cannot be made");
}

Image picture(const Avatar& avatar, std::span<const sim::Collider> solids, const std::vector<Worn>& worn, double azimuth)
{
    std::vector<Layer> layers;
    for (std::size_t p = 0; p < avatar.parts.size(); ++p) {
        Layer layer{avatar.parts[p].mesh, {}, 1, {}, false};
        if (avatar.skin) layer.mesh.vertices = avatar.skin->posed();
        for (Vec3d& v : layer.mesh.vertices) v = solids[p].pose.rotation * v + solids[p].pose.translation;
        layer.colours.assign(layer.mesh.triangles.size(), srgb(k_skin));
        layers.push_back(std::move(layer));
    }
    for (std::size_t g = 0; g < worn.size(); ++g) {
        const auto at = worn[g].cloth.positions();
        Layer layer{{{at.begin(), at.end()}, {}}, {}, 1, {}, false};
        for (const auto& t : worn[g].cloth.triangles()) layer.mesh.triangles.push_back(t);
        layer.colours.assign(layer.mesh.triangles.size(), srgb(k_colours[g % std::size(k_colours)]));
        layers.push_back(std::move(layer));
    }
    View view;
    view.azimuth = azimuth;
    view.width = 480;
    view.height = 640;
    return render(layers, view);
}

/// People see how far it is; files and pipes do not.
void show_progress(const char* what, double done, double of)
{
    static const bool k_watched = ::isatty(STDERR_FILENO) == 1;
    if (k_watched) std::fprintf(stderr, done < of ? "\r%s %g of %g  " : "\r\033[K", what, done, of);
}

Avatar avatar_of(const DressArguments& a)
{
    sim::Gait gait;
    if (!a.walk) gait.lower_at = gait.walk_at = INFINITY;
    if (a.avatar.empty())
        return walking_avatar(a.walker, gait, k_figure_spacing, k_figure_error, [](std::size_t done, std::size_t of) {
            show_progress("stage", static_cast<double>(done), static_cast<double>(of));
        });
    return is_gltf(a.avatar) ? skinned_avatar(a.avatar, a.walk, a.animation, 0.3) : still_avatar(a.avatar);
}

sim::ClothOptions cloth_options(const DressArguments& a)
{
    sim::ClothOptions options;
    options.layer = layer_named(a.layer).value();
    options.friction = a.paper_friction ? Friction::Paper : Friction::Coulomb;
    options.iterations = a.iterations;
    options.sweep_step = 0.5 * a.thinnest;
    options.self_collision = a.self_collision;
    return options;
}

/// The avatar, what it wears, and the tool: one fitting from its first step to its last.
class Dressing {
public:
    /// @throw AvatarError, GarmentFileError, device::DeviceError, io::ModelFileError
    explicit Dressing(const DressArguments& a);
    Dressing(const Dressing&) = delete;
    Dressing& operator=(const Dressing&) = delete;

    /// All steps, with the frames that are kept of them.
    void run();
    /// The animation as glTF.
    void write();
    /// Prints what became of each garment; the same as JSON.
    [[nodiscard]] json report();

private:
    [[nodiscard]] std::uint32_t find_bone(const std::string& name) const;
    void put_on(const std::string& path, const sim::ClothOptions& options);
    void step(double time);
    void keep_frame(double time);

    const DressArguments& a_;
    double dt_;
    int steps_;
    Avatar avatar_;
    std::vector<sqmap::Pose> poses_;
    std::vector<sim::Collider> solids_;
    std::vector<Worn> worn_;
    std::unique_ptr<HeldTool> held_;
    std::vector<io::MovingMesh> scene_;
    std::vector<double> times_;
};

Dressing::Dressing(const DressArguments& a)
    : a_(a), dt_(1 / a.rate), steps_(static_cast<int>(std::lround(a.seconds * a.rate))), avatar_(avatar_of(a))
{
    poses_.resize(avatar_.parts.size() + avatar_.joints.size());
    avatar_.pose(0, poses_);
    for (std::size_t p = 0; p < poses_.size(); ++p)
        solids_.push_back({p < avatar_.parts.size() ? &avatar_.parts[p].model : nullptr, poses_[p], poses_[p]});
    if (avatar_.skin) solids_[0].skin = avatar_.skin->moving.get();
    const sim::ClothOptions options = cloth_options(a);
    for (const std::string& path : a.garments) put_on(path, options);
    if (!a.device.empty()) held_ = std::make_unique<HeldTool>(a.device, a.tool_at, solids_, worn_);
    for (std::size_t g = 0; g < worn_.size(); ++g) {  // once none of them moves in memory any more
        worn_[g].handling = std::make_unique<Handling>(worn_[g].file, a.garments[g], solids_,
                                                       [this](const std::string& name) { return find_bone(name); });
        worn_[g].began_inside = sim::penetration(worn_[g].cloth.positions(), {}, solids_, {.steps = 1}).nodes;
    }
    scene_.resize(avatar_.parts.size());
}

std::uint32_t Dressing::find_bone(const std::string& name) const
{
    std::string all;
    for (std::uint32_t p = 0; p < poses_.size(); ++p) {
        const std::string& bone = p < avatar_.parts.size() ? avatar_.parts[p].name : avatar_.joints[p - avatar_.parts.size()];
        if (bone == name) return p;
        all += ", " + bone;
    }
    if (name != "world") throw GarmentFileError(name + " is none of the avatar's: world" + all);
    return sim::Cloth::k_world;
}

void Dressing::put_on(const std::string& path, const sim::ClothOptions& options)
{
    GarmentFile file = read_garment(path);
    sim::Cloth cloth(file.garment, file.fabric, options);
    if (avatar_.skin) cloth.expect(avatar_.skin->lattice);
    if (!file.waist_bone.empty()) {
        try {
            const std::uint32_t solid = find_bone(file.waist_bone);
            cloth.pin(file.garment.waist, solid, solid == sim::Cloth::k_world ? sqmap::Pose{} : poses_[solid]);
        } catch (const GarmentFileError& e) {
            throw GarmentFileError(path + ": 'waist_bone' " + e.what());
        }
    }
    worn_.push_back({std::move(file), std::move(cloth), {}, {}, {}, {}, {}, {}, {}, {}});
}

void Dressing::keep_frame(double time)
{
    times_.push_back(time);
    for (std::size_t p = 0; p < scene_.size(); ++p)
        if (avatar_.skin)
            scene_[p].shapes.push_back(avatar_.skin->posed());
        else
            scene_[p].keys.push_back({poses_[p].rotation, poses_[p].translation});
    for (Worn& w : worn_) {
        (void)w.cloth.settle(solids_);
        w.shapes.emplace_back(w.cloth.positions().begin(), w.cloth.positions().end());
        w.deepest_walking = std::max(w.deepest_walking, sim::penetration(w.cloth.positions(), {}, solids_, {.steps = 1}).nodes);
    }
    if (a_.pictures.empty()) return;
    char name[32];
    std::snprintf(name, sizeof name, "%04zu.png", times_.size() - 1);
    write_png(std::filesystem::path(a_.pictures) / name, picture(avatar_, solids_, worn_, a_.azimuth));
}

void Dressing::step(double time)
{
    avatar_.pose(time, poses_);
    for (std::size_t p = 0; p < poses_.size(); ++p) {
        solids_[p].previous = solids_[p].pose;
        solids_[p].pose = poses_[p];
    }
    if (held_) held_->before(time);
    for (Worn& w : worn_) {
        w.handling->before(w.cloth, time, dt_, solids_);
        w.add(w.cloth.step(dt_, solids_), time);
    }
    if (held_) held_->after(solids_);
}

void Dressing::run()
{
    const int every = std::max(1, static_cast<int>(std::lround(a_.rate / a_.fps)));
    keep_frame(0);
    for (int i = 1; i <= steps_; ++i) {
        const bool kept = i % every == 0 || i == steps_;
        if (kept) show_progress("second", i * dt_, steps_ * dt_);
        step(i * dt_);
        if (kept) keep_frame(i * dt_);
    }
}

void Dressing::write()
{
    std::vector<io::MovingMesh> scene = std::move(scene_);
    for (std::size_t p = 0; p < avatar_.parts.size(); ++p) {
        const Rgb c = srgb(k_skin);
        scene[p].name = avatar_.parts[p].name;
        scene[p].positions = avatar_.parts[p].mesh.vertices;
        scene[p].triangles = avatar_.parts[p].mesh.triangles;
        scene[p].colour = {c.r, c.g, c.b};
        scene[p].times = times_;
        // A figure that stands still has no animation.
        if (!(avatar_.skin && a_.walk)) scene[p].times.clear(), scene[p].keys.clear(), scene[p].shapes.clear();
        if (avatar_.skin && !a_.walk) scene[p].positions = avatar_.skin->posed();
    }
    for (std::size_t g = 0; g < worn_.size(); ++g) {
        const Rgb c = srgb(k_colours[g % std::size(k_colours)]);
        io::MovingMesh mesh;
        mesh.name = worn_[g].file.name;
        mesh.positions = worn_[g].shapes.front();
        mesh.triangles.assign(worn_[g].cloth.triangles().begin(), worn_[g].cloth.triangles().end());
        mesh.colour = {c.r, c.g, c.b};
        mesh.two_sided = true;
        mesh.times = times_;
        mesh.shapes = std::move(worn_[g].shapes);
        scene.push_back(std::move(mesh));
    }
    io::write_glb(a_.output, scene);
}

json Dressing::report()
{
    json report{{"avatar", a_.avatar.empty() ? "capsule human" : a_.avatar},
                {"height_m", avatar_.height},
                {"steps_per_second", a_.rate},
                {"layer", a_.layer}};
    for (Worn& w : worn_) {
        json garment = report_of(w, avatar_.height, solids_, steps_ * dt_);
        std::printf("%s: %zu vertices, %s; %s; deepest node %.2f mm (%.3f %% of height), inside triangles %.2f mm (%.3f %%)\n",
                    w.file.name.c_str(), w.cloth.size(), w.file.fabric_name.c_str(), text_of(w.drape.report()).c_str(),
                    1e3 * garment["penetration_at_end"]["nodes_m"].get<double>(),
                    garment["penetration_at_end"]["nodes_percent_of_height"].get<double>(),
                    1e3 * garment["penetration_at_end"]["interiors_m"].get<double>(),
                    garment["penetration_at_end"]["interiors_percent_of_height"].get<double>());
        std::printf(
            "  a step, us of CPU time: collision %.0f (points %.0f, query %.0f), response %.0f, threads %.0f, prediction %.0f\n",
            garment["us_per_step"]["collision"]["mean"].get<double>(),
            garment["us_per_step"]["points_moved"]["mean"].get<double>(), garment["us_per_step"]["query"]["mean"].get<double>(),
            garment["us_per_step"]["response"]["mean"].get<double>(), garment["us_per_step"]["threads"]["mean"].get<double>(),
            garment["us_per_step"]["prediction"]["mean"].get<double>());
        for (const json& s : garment["status"]) std::printf("  %s\n", s.get<std::string>().c_str());
        report["garments"].push_back(std::move(garment));
    }
    if (held_) {
        report["tool"] = held_->report(steps_ * dt_);
        const json& t = report["tool"];
        std::printf("tool: %llu ticks, %zu grasps; commanded at most %.3g N, sent %.3g N; the cloth ran at %.2f of real time%s\n",
                    t["ticks"].get<unsigned long long>(), t["grasps"].get<std::size_t>(), t["most_asked_N"].get<double>(),
                    t["most_sent_N"].get<double>(), t["cloth_s_per_s"].get<double>(),
                    t["gone_at_end"].get<bool>() ? "; the device was gone at the end" : "");
    }
    return report;
}

void dress(const DressArguments& a)
{
    Dressing dressing(a);
    dressing.run();
    dressing.write();
    const json report = dressing.report();
    if (a.report.empty()) return;
    const std::string text = report.dump(1) + "\n";
    io::replace_file(a.report, std::as_bytes(std::span(text)));
}

}  // namespace

void add_dress(CommandLine& line)
{
    const auto a = std::make_shared<DressArguments>();
    Command command =
        line.add("dress", "Dress an avatar: cloth on a model, on a skinned mesh, or on a figure that walks; animation as glTF");
    Option avatar =
        command
            .option("--avatar", a->avatar,
                    "Model (.sqmap) of a solid, which stands still, or skinned mesh (.glb, .gltf) with its joints; metres, y up")
            .existing_file();
    Option walker = command.option("--figure", a->walker, "Instead: a figure of capsules on bones, this tall in metres")
                        .in_range(0.2, 5.0)
                        .shows_default("");
    avatar.excludes(walker);
    command.flag("--walk", a->walk,
                 "The figure lowers its arms after 1 s and walks from 2 s on; a skinned mesh goes over to its animation from "
                 "1 s to 2 s and plays it; otherwise either stands");
    command.option("--animation", a->animation, "Which of a skinned mesh's animations --walk plays; default: the first");
    command.option("--garment", a->garments, "Garment (.json); several are worn, but do not feel each other")
        .required()
        .existing_file();
    command.option("-o,--output", a->output, "Animation to write (.glb)").required();
    command.option("--report", a->report, "Write penetration, strain and time by stage, as JSON");
    command.option("--pictures", a->pictures, "Folder for a picture of each frame; made where it is not there");
    const Option device = command.option(
        "--device", a->device,
        "A tool that grasps: simulated[:hand=], whose hand follows the garment's pull, or a kind that sqmap devices lists "
        "(its first button grasps). The cloth then keeps to the clock");
    command.option("--tool-at", a->tool_at, "X,Y,Z, m: where the device's origin is; default 0,0,0").needs(device);
    command.option("--azimuth", a->azimuth, "Of the pictures, degrees; 0: from the front");
    command.option("--seconds", a->seconds, "Time to simulate").in_range(0.01, 600.0);
    command.option("--rate", a->rate, "Steps a second").in_range(10.0, 10000.0);
    command.option("--fps", a->fps, "Frames a second that are written").in_range(0.1, 240.0);
    command.option("--thinnest", a->thinnest, "Parts of the avatar at least this thick, in metres, are not tunnelled through")
        .in_range(0.001, 1.0);
    command.option("--iterations", a->iterations, "Of the threads' solver").in_range(1, 200);
    command.option("--layer", a->layer, "Of the contacts: 2, 3 or exact").one_of({"2", "3", "exact"});
    command.flag("--paper-friction", a->paper_friction, "Friction of eq. 33 instead of Coulomb's");
    command.flag("--self-collision", a->self_collision, "Cloth feels itself (slow)");
    command.footer("Exit code: 0 done, 2 bad model or garment, or a file not written, 64 wrong usage, 70 internal error.");
    command.run<GarmentFileError, BadOutput, io::ModelFileError, device::DeviceError, AvatarError, ImageError>([a] {
        if (a->avatar.empty() && a->walker <= 0) throw WrongUsage("dress", "give --avatar or --figure");
        const bool skinned = is_gltf(a->avatar);
        if (a->walk && a->walker <= 0 && !skinned)
            throw WrongUsage("--walk", "a baked model has no joints: give --figure, or --avatar a skinned .glb or .gltf");
        if (!a->animation.empty() && !(a->walk && skinned))
            throw WrongUsage("--animation", "goes with --walk and a skinned --avatar");
        check_outputs(*a);
        try {
            dress(*a);
        } catch (const io::ModelFileError& e) {
            std::fprintf(stderr, "%s\n  cure: a model is what sqmap bake writes; a skinned mesh is a .glb or .gltf\n", e.what());
            return 2;
        }
        return 0;
    });
}

}  // namespace sqmap::app
