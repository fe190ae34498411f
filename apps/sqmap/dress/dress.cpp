// sqmap dress: a fitting without a window.
#include "commands.h"
#include "common/dress/avatar.h"
#include "common/dress/garment_file.h"
#include "common/layer_name.h"
#include "common/render/raycast.h"
#include "dress/held_tool.h"
#include "dress/worn.h"
#include "sqmap/io/model_file.h"
#include "sqmap/io/replace_file.h"
#include "sqmap/io/write_gltf.h"
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

struct Arguments {
    std::string avatar, animation, output, report, pictures, layer = "3";
    std::vector<std::string> garments;
    std::string device, tool_at;
    double walker = 0, seconds = 4, rate = 240, fps = 15, azimuth = 25, thinnest = 0.02;
    bool walk = false, paper_friction = false, self_collision = false;
    int iterations = 12;
};

/// What cannot be written, before anything is simulated.
class BadOutput : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// @throw BadOutput
void check_outputs(const Arguments& a)
{
    for (const auto& [option, file] : {std::pair{"-o ", a.output}, {"--report ", a.report}}) {
        const std::filesystem::path folder = std::filesystem::path(file).parent_path();
        if (!folder.empty() && !std::filesystem::is_directory(folder))
            throw BadOutput(option + file + ": there is no folder " + folder.string() + "\n  cure: make it first");
    }
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

void dress(const Arguments& a)
{
    check_outputs(a);
    // People see how far it is; files and pipes do not.
    const bool watched = ::isatty(STDERR_FILENO) == 1;
    const auto progress = [watched](const char* what, double done, double of) {
        if (watched) std::fprintf(stderr, done < of ? "\r%s %g of %g  " : "\r\033[K", what, done, of);
    };
    sim::Gait gait;
    if (!a.walk) gait.lower_at = gait.walk_at = INFINITY;
    Avatar avatar = a.avatar.empty()    ? walking_avatar(a.walker, gait, 0.022 * a.walker / 1.75, 0.3,
                                                         [&](std::size_t done, std::size_t of) {
                                                          progress("bone", static_cast<double>(done), static_cast<double>(of));
                                                      })
                    : is_gltf(a.avatar) ? skinned_avatar(a.avatar, a.walk, a.animation, 0.3)
                                        : still_avatar(a.avatar);
    std::vector<sqmap::Pose> poses(avatar.parts.size() + avatar.joints.size());
    avatar.pose(0, poses);
    std::vector<sim::Collider> solids;
    for (std::size_t p = 0; p < poses.size(); ++p)
        solids.push_back({p < avatar.parts.size() ? &avatar.parts[p].model : nullptr, poses[p], poses[p]});
    if (avatar.skin) solids[0].skin = avatar.skin->moving.get();
    const auto bone_name = [&](std::size_t p) -> const std::string& {
        return p < avatar.parts.size() ? avatar.parts[p].name : avatar.joints[p - avatar.parts.size()];
    };
    const FindBone find_bone = [&](const std::string& name) {
        std::string all;
        for (std::uint32_t p = 0; p < poses.size(); ++p) {
            if (bone_name(p) == name) return p;
            all += ", " + bone_name(p);
        }
        if (name != "world") throw GarmentFileError(name + " is none of the avatar's: world" + all);
        return sim::Cloth::k_world;
    };

    sim::ClothOptions options;
    options.layer = layer_named(a.layer).value();
    options.friction = a.paper_friction ? Friction::Paper : Friction::Coulomb;
    options.iterations = a.iterations;
    options.sweep_step = 0.5 * a.thinnest;
    options.self_collision = a.self_collision;
    std::vector<Worn> worn;
    for (const std::string& path : a.garments) {
        GarmentFile file = read_garment(path);
        sim::Cloth cloth(file.garment, file.fabric, options);
        if (avatar.skin) cloth.expect(avatar.skin->lattice);
        if (!file.waist_bone.empty()) {
            try {
                const std::uint32_t solid = find_bone(file.waist_bone);
                cloth.pin(file.garment.waist, solid, solid == sim::Cloth::k_world ? sqmap::Pose{} : poses[solid]);
            } catch (const GarmentFileError& e) {
                throw GarmentFileError(path + ": 'waist_bone' " + e.what());
            }
        }
        worn.push_back({std::move(file), std::move(cloth), {}, {}, {}, {}, {}, {}, {}, {}});
    }
    std::unique_ptr<HeldTool> held;
    if (!a.device.empty()) held = std::make_unique<HeldTool>(a.device, a.tool_at, solids, worn);
    for (std::size_t g = 0; g < worn.size(); ++g) {  // once none of them moves in memory any more
        worn[g].handling = std::make_unique<Handling>(worn[g].file, a.garments[g], solids, find_bone);
        worn[g].began_inside = sim::penetration(worn[g].cloth.positions(), {}, solids, 1).nodes;
    }

    const double dt = 1 / a.rate;
    const auto steps = static_cast<int>(std::lround(a.seconds * a.rate)),
               every = std::max(1, static_cast<int>(std::lround(a.rate / a.fps)));
    std::vector<io::MovingMesh> scene(avatar.parts.size());
    std::vector<double> times;
    const auto keep_frame = [&](double time) {
        times.push_back(time);
        for (std::size_t p = 0; p < scene.size(); ++p)
            if (avatar.skin)
                scene[p].shapes.push_back(avatar.skin->posed());
            else
                scene[p].keys.push_back({poses[p].rotation, poses[p].translation});
        for (Worn& w : worn) {
            w.shapes.emplace_back(w.cloth.positions().begin(), w.cloth.positions().end());
            w.deepest_walking = std::max(w.deepest_walking, sim::penetration(w.cloth.positions(), {}, solids, 1).nodes);
        }
        if (!a.pictures.empty()) {
            char name[32];
            std::snprintf(name, sizeof name, "%04zu.png", times.size() - 1);
            write_png(std::filesystem::path(a.pictures) / name, picture(avatar, solids, worn, a.azimuth));
        }
    };
    keep_frame(0);
    for (int step = 1; step <= steps; ++step) {
        const double time = step * dt;
        if (step % every == 0 || step == steps) progress("second", time, steps * dt);
        avatar.pose(time, poses);
        for (std::size_t p = 0; p < poses.size(); ++p) {
            solids[p].previous = solids[p].pose;
            solids[p].pose = poses[p];
        }
        if (held) held->before(time);
        for (Worn& w : worn) {
            w.handling->before(w.cloth, time, dt, solids);
            const sim::StepReport r = w.cloth.step(dt, solids);
            w.status |= r.status;
            w.caught += r.caught;
            w.max_contacts = std::max(w.max_contacts, r.contacts);
            w.drape.add(r, time);
            const double energy = r.kinetic + r.potential;
            if (std::isnan(w.start_energy)) w.start_energy = energy;
            w.max_energy = std::max(w.max_energy, energy);
            w.least_energy = std::min(w.least_energy, energy);
            const auto& s = r.seconds;
            for (const auto& [stage, seconds] : {std::pair{&w.predict, s.predict},
                                                 {&w.move, s.move},
                                                 {&w.query, s.query},
                                                 {&w.response, s.response},
                                                 {&w.threads, s.threads},
                                                 {&w.self, s.self},
                                                 {&w.collision, s.move + s.query}})
                stage->us.push_back(1e6 * seconds);
        }
        if (held) held->after(solids);
        if (step % every == 0 || step == steps) keep_frame(time);
    }

    for (std::size_t p = 0; p < avatar.parts.size(); ++p) {
        const Rgb c = srgb(k_skin);
        scene[p].name = avatar.parts[p].name;
        scene[p].positions = avatar.parts[p].mesh.vertices;
        scene[p].triangles = avatar.parts[p].mesh.triangles;
        scene[p].colour = {c.r, c.g, c.b};
        scene[p].times = times;
        // Who stands still has no animation.
        if (a.walker <= 0 && !(avatar.skin && a.walk)) scene[p].times.clear(), scene[p].keys.clear(), scene[p].shapes.clear();
        if (avatar.skin && !a.walk) scene[p].positions = avatar.skin->posed();
    }
    for (std::size_t g = 0; g < worn.size(); ++g) {
        const Rgb c = srgb(k_colours[g % std::size(k_colours)]);
        io::MovingMesh mesh;
        mesh.name = worn[g].file.name;
        mesh.positions = worn[g].shapes.front();
        mesh.triangles.assign(worn[g].cloth.triangles().begin(), worn[g].cloth.triangles().end());
        mesh.colour = {c.r, c.g, c.b};
        mesh.two_sided = true;
        mesh.times = times;
        mesh.shapes = std::move(worn[g].shapes);
        scene.push_back(std::move(mesh));
    }
    io::write_glb(a.output, scene);

    json report{{"avatar", a.avatar.empty() ? "capsule human" : a.avatar},
                {"height_m", avatar.height},
                {"steps_per_second", a.rate},
                {"layer", a.layer}};
    for (Worn& w : worn) {
        json garment = report_of(w, avatar.height, solids, steps * dt);
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
    if (held) {
        report["tool"] = held->report(steps * dt);
        const json& t = report["tool"];
        std::printf("tool: %llu ticks, %zu grasps; asked for at most %.3g N, sent %.3g N; the cloth ran at %.2f of real time%s\n",
                    t["ticks"].get<unsigned long long>(), t["grasps"].get<std::size_t>(), t["most_asked_N"].get<double>(),
                    t["most_sent_N"].get<double>(), t["cloth_s_per_s"].get<double>(),
                    t["gone_at_end"].get<bool>() ? "; the device was gone at the end" : "");
    }
    if (!a.report.empty()) {
        const std::string text = report.dump(1) + "\n";
        io::replace_file(a.report, std::as_bytes(std::span(text)));
    }
}

}  // namespace

void add_dress(CommandLine& line)
{
    const auto a = std::make_shared<Arguments>();
    Command command =
        line.add("dress", "Dress an avatar: cloth on a model, on a skinned mesh, or on a figure that walks; animation as glTF");
    Option avatar =
        command
            .option("--avatar", a->avatar,
                    "Model (.sqmap) of a solid, which stands still, or skinned mesh (.glb, .gltf) with its joints; metres, y up")
            .existing_file();
    Option walker =
        command.option("--figure", a->walker, "Instead: a figure of capsules on bones, this tall in metres").in_range(0.2, 5.0);
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
    command.option("--azimuth", a->azimuth, "Of the pictures, degrees; 0: from the front").shows_default();
    command.option("--seconds", a->seconds, "Time to simulate").in_range(0.01, 600.0).shows_default();
    command.option("--rate", a->rate, "Steps a second").in_range(10.0, 10000.0).shows_default();
    command.option("--fps", a->fps, "Frames a second that are written").in_range(0.1, 240.0).shows_default();
    command.option("--thinnest", a->thinnest, "Parts of the avatar at least this thick, in metres, are not tunnelled through")
        .in_range(0.001, 1.0)
        .shows_default();
    command.option("--iterations", a->iterations, "Of the threads' solver").in_range(1, 200).shows_default();
    command.option("--layer", a->layer, "Of the contacts: 2, 3 or exact").one_of({"2", "3", "exact"}).shows_default();
    command.flag("--paper-friction", a->paper_friction, "Friction of eq. 33 instead of Coulomb's");
    command.flag("--self-collision", a->self_collision, "Cloth feels itself (slow)");
    command.footer("Exit code: 0 done, 2 bad model or garment, or a file not written, 64 wrong usage, 70 internal error.");
    command.run([a] {
        if (a->avatar.empty() && a->walker <= 0) throw WrongUsage("dress", "give --avatar or --figure");
        const bool skinned = is_gltf(a->avatar);
        if (a->walk && a->walker <= 0 && !skinned)
            throw WrongUsage("--walk", "a baked model has no joints: give --figure, or --avatar a skinned .glb or .gltf");
        if (!a->animation.empty() && !(a->walk && skinned))
            throw WrongUsage("--animation", "goes with --walk and a skinned --avatar");
        try {
            dress(*a);
            return 0;
        } catch (const GarmentFileError& e) {
            std::fprintf(stderr, "%s\n", e.what());
        } catch (const BadOutput& e) {
            std::fprintf(stderr, "%s\n", e.what());
        } catch (const device::DeviceError& e) {
            std::fprintf(stderr, "%s\n", e.what());
        } catch (const AvatarError& e) {
            std::fprintf(stderr, "%s\n", e.what());
        } catch (const io::ModelFileError& e) {
            std::fprintf(stderr, "%s\n  cure: a model is what sqmap bake writes; a skinned mesh is a .glb or .gltf\n", e.what());
        } catch (const ImageError& e) {
            std::fprintf(stderr, "%s\n", e.what());
        }
        return 2;
    });
}

}  // namespace sqmap::app
