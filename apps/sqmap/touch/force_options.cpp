#include "touch/force_options.h"

#include "touch/names.h"

#include <cstdio>
#include <tuple>

namespace sqmap::app {
namespace {

/// Adds the options of the surface and of moving objects.
void add_object_options(Command& command, TouchOptions& o)
{
    Command surface = command.titled("Surface");
    surface.option("--texture", o.texture.kind, "none, gaussian, image:FILE.png (square, black is deep), ridges, weave or bumps");
    surface.option("--texture-depth", o.texture.depth, "m, of the deepest; of noise two standard deviations").above_zero(0.1);
    surface.option("--texture-wavelength", o.texture.wavelength, "m: shortest of the noise, a period, of an image a pixel")
        .above_zero(1);
    surface.option("--texture-seed", o.texture.seed, "Of the noise");
    Command moving = command.titled("Objects that move");
    moving.option("--object-mass", o.body.mass, "kg; the tool pushes them; 0: they are fixed").not_below_zero(1e6);
    moving.option("--object-spring", o.body.spring, "N/m that holds each at its position, critically damped; 0: free")
        .not_below_zero(1e6);
    moving.vector("--sway", o.body.sway, "m along x, y, z, to and fro");
    moving.option("--sway-period", o.body.sway_period, "s").above_zero(1e6);
}

}  // namespace

void add_force_options(Command& command, TouchOptions& o)
{
    Command forces = command.titled("Forces");
    const auto number = [&](const char* name, double& value, const char* words) {
        forces.option(name, value, words).not_below_zero(1e6);
    };
    number("--stiffness", o.zone.stiffness, "k, N/m (eqs. 21 and 32)");
    number("--damping", o.zone.damping, "N s/m along the normal while pressing in");
    forces.choice("--mode", o.zone.mode, k_modes, "How the tool follows the device", "direct|proxy|coupled");
    forces.choice("--shading", o.zone.shading, k_shadings,
                  "Full force across edges, the gradient of one potential, or the mean of the contacts' forces",
                  "levelled|consistent|mean");
    forces.choice(
        "--force", o.paper_force, k_forces,
        "paper: eqs. 21, 26, 32 and 33 on the smoothed map, averaged (section 6), of models baked with --projection normal",
        "full|paper");
    forces.choice("--projector", o.paper.projector, k_projectors, "How feet are found on models baked with --projection normal",
                  "newton|pyramid|printed");
    forces.flag("--offset", o.zone.offset, "Move the surface out by eq. 12, against tunnelling");
    forces.choice("--layer", o.zone.layer, k_touch_layers,
                  "Layer to query; auto: exact for a sphere or a point, 3 for a mesh and for --force paper",
                  "auto|2|3|gate|exact");
    forces
        .option("--gate", o.zone.gate,
                "k_L: --layer gate reads layer 3 for a part with fewer base samples than this times its vertices")
        .in_range(0, 4294967295.);
    forces.number(option_named(paper::k_query_numbers, "nearest_steps"), o.paper,
                  "Paper models, layer 3, Newton's foot: steps to the nearest surface; 0: the surface on the foot's line");
    forces.flag("--no-gaps", o.no_gaps, "Paper models: the first surface alone, as printed, not the openings behind it");
    forces.flag("--no-pruning", o.no_pruning, "Paper models: any part's claim counts where parts overlap");
    forces.choice("--friction", o.material.friction, k_frictions, "How the surface rubs; paper is eq. 33 as printed",
                  "none|coulomb|paper");
    number("--mu-static", o.material.mu_static, "Coulomb friction before slipping");
    number("--mu-dynamic", o.material.mu_dynamic, "Coulomb friction while slipping");
    number("--f-c", o.material.f_c, "f_c of eq. 33, N");
    number("--k-f", o.material.k_f, "k_f of eq. 33, 1/m");
    number("--brake", o.zone.brake, "N s/m against the approach before contact; 0: none");
    forces.option("--proxy-depth", o.zone.proxy_depth, "m that the proxy of a mesh or a sphere lies in the surface")
        .in_range(0., 0.05);
    number("--blend", o.zone.blend_time, "s in which a jump of the foot point fades to 1/e; 0: jumps pass");
    Command coupling = command.titled("Coupling (--mode coupled); default: taken from the device");
    const auto wish = [&](const char* name, std::optional<double>& value, const char* words) {
        coupling.option(name, value, words).not_below_zero(1e6);
    };
    wish("--coupling-stiffness", o.coupling.stiffness, "N/m between device and body");
    wish("--coupling-damping", o.coupling.damping, "N s/m");
    wish("--coupling-turn-stiffness", o.coupling.rotational, "N m/rad");
    wish("--coupling-turn-damping", o.coupling.rotational_damping, "N m s/rad");
    coupling.option("--mass", o.zone.mass, "kg of the body").above_zero(1e6);
    coupling.option("--inertia", o.coupling.inertia, "kg m^2; default: from mass and tool").above_zero(1e6);
    forces.choice("--smoothing-kernel", o.kernel, k_kernels,
                  "Direction from depths alone, or from the map's normals (sphere, point)", "ball|shell");
    forces.option("--smoothing-tolerance", o.tolerance, "m, by which smoothed depth may differ from true (sphere, point)")
        .not_below_zero(0.1)
        .shows_default("0.0003 of a sphere, 0.0002 of a point");
    number("--zone", o.zone_radius, "Impact zone of a mesh: m about its centre that count; 0: the whole tool");
    add_object_options(command, o);
}

void finish_force_options(const Command& command, TouchOptions& o)
{
    o.paper.gaps = !o.no_gaps;
    o.paper.pruning = !o.no_pruning;
    if (!o.paper_force) return;
    if (!command.given("--friction")) o.material.friction = Friction::Paper;
    if (!command.given("--blend")) o.zone.blend_time = 0;
}

void warn_of_idle(const Command& command, const TouchOptions& o)
{
    const bool coulomb = o.material.friction == Friction::Coulomb, paper = o.material.friction == Friction::Paper;
    const bool texture = o.texture.kind != "none", sways = norm_sq(o.body.sway) > 0;
    const std::tuple<const char*, bool, const char*> k_needs[] = {
        {"--mu-static", coulomb, "--friction coulomb"},
        {"--mu-dynamic", coulomb, "--friction coulomb"},
        {"--f-c", paper, "--friction paper"},
        {"--k-f", paper, "--friction paper"},
        {"--proxy-depth", o.zone.mode == haptic::Mode::Proxy && !o.tool.starts_with("point"),
         "--mode proxy and a mesh or a sphere"},
        {"--brake", o.zone.mode != haptic::Mode::Proxy, "--mode direct or coupled"},
        {"--tool-touching", !o.tool.starts_with("point") && !o.tool.starts_with("sphere"), "a mesh as tool"},
        {"--edges", !o.tool.starts_with("point") && !o.tool.starts_with("sphere"), "a mesh as tool"},
        {"--shading", !o.paper_force, "--force full"},
        {"--mass", o.zone.mode == haptic::Mode::Coupled, "--mode coupled"},
        {"--texture-depth", texture, "--texture"},
        {"--texture-wavelength", texture, "--texture"},
        {"--texture-seed", o.texture.kind == "gaussian", "--texture gaussian"},
        {"--object-spring", o.body.mass > 0, "--object-mass"},
        {"--sway-period", sways, "--sway"}};
    for (const auto& [option, counts, needs] : k_needs)
        if (!counts && command.given(option)) std::fprintf(stderr, "warning: %s counts with %s only\n", option, needs);
}

}  // namespace sqmap::app
