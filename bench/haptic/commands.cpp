// sqmap_measure haptic: the tables of docs/data/haptics.
#include "../error.h"
#include "../measure.h"
#include "common/layer_name.h"
#include "hand.h"
#include "io/replace_file.h"
#include "slide.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <map>
#include <memory>

namespace sqmap::bench {
namespace {

struct SlideCommand {
    std::vector<std::filesystem::path> meshes;
    std::filesystem::path csv;
    SlideOptions options;
    int positions = 500;
    paper::MapOptions maps;
    bool paper = false;
};

void write_ticks(const Slide& slide, const std::filesystem::path& file)
{
    if (file.empty()) return;
    const std::string text = slide_csv(slide);
    io::replace_file(file, std::as_bytes(std::span(text)));
}

void run_slide(const SlideCommand& c)
{
    std::printf("%-18s %-6s | %-35s | %-35s | %-23s | %-23s | %s\n", "", "", "edges < 45 deg: max step, N",
                "elsewhere: max step, N", "felt - true depth, mm", "onset, mm", "normal, deg");
    std::printf("%-18s %-6s | %7s %7s %7s %5s %5s | %7s %7s %7s %5s %5s | %7s %7s %7s | %7s %7s %7s | %6s %6s\n", "mesh", "ticks",
                "mesh", "shaded", "ours", "/mesh", "/shad", "mesh", "shaded", "ours", "/mesh", "/shad", "median", "p99", "max",
                "median", "p99", "max", "median", "p95");
    for (const std::filesystem::path& file : c.meshes) {
        const TouchObject object(file);
        const Slide s = slide(object, c.options);
        const Steps mild = steps_of(s, false), sharp = steps_of(s, true);
        std::vector<double> off;
        for (const SlideTick& t : s.ticks)
            if (t.true_depth > 0) off.push_back(1e3 * std::abs(t.effective_depth - t.true_depth));
        std::sort(off.begin(), off.end());
        const auto at = [&](double q) {
            return off.empty() ? 0.
                               : off[std::min(off.size() - 1, static_cast<std::size_t>(q * static_cast<double>(off.size())))];
        };
        const Onset o = onset(object, c.options, c.positions);
        const NormalError n = normal_error(object, c.options, c.positions);
        const auto ratio = [](double a, double b) { return b > 0 ? a / b : 0.; };
        std::printf("%-18s %6zu", file.stem().string().c_str(), s.ticks.size());
        for (const Steps& k : {mild, sharp})
            std::printf(" | %7.4f %7.4f %7.4f %5.3f %5.3f", k.max[0], k.max[1], k.max[2], ratio(k.max[2], k.max[0]),
                        ratio(k.max[2], k.max[1]));
        std::printf(" | %7.4f %7.4f %7.4f | %7.4f %7.4f %7.4f | %6.3f %6.3f\n", at(0.5), at(0.99), at(1), 1e3 * o.median,
                    1e3 * o.p99, 1e3 * o.max, n.median, n.p95);
        std::fflush(stdout);
        write_ticks(s, c.csv);
    }
}

/// Fig. 13b of the paper's own maps: greatest and 99th percentile of the steps.
void run_paper_slide(const SlideCommand& c)
{
    struct Column {
        const char* name;
        std::size_t of;  // Steps
    };
    constexpr Column k_columns[] = {{"mesh", 0}, {"shaded", 1}, {"map", 3}, {"smoothed", 4}, {"averaged", 5}};
    std::printf("%-18s %-6s | %-44s | %-44s | %s\n", "", "", "edges < 45 deg: max step, N", "elsewhere: max step, N",
                "all: 99th percentile, N");
    std::printf("%-18s %-6s", "mesh", "ticks");
    for (int block = 0; block < 3; ++block) {
        std::printf(" |");
        for (const Column& column : k_columns) std::printf(" %8s", column.name);
    }
    std::printf("\n");
    int below[2] = {}, below_mean = 0, below_map = 0;
    for (const std::filesystem::path& file : c.meshes) {
        const TouchObject object(file, TouchObject::Models::Both, c.maps);
        const Slide s = slide(object, c.options);
        const Steps parts[] = {steps_of(s, false), steps_of(s, true), steps_of(s)};
        std::printf("%-18s %6zu", file.stem().string().c_str(), s.ticks.size());
        for (const Steps& k : parts) {
            std::printf(" |");
            for (const Column& column : k_columns) std::printf(" %8.4f", &k == &parts[2] ? k.p99[column.of] : k.max[column.of]);
        }
        std::printf("\n");
        std::fflush(stdout);
        for (int i = 0; i < 2; ++i) below[i] += parts[i].max[4] < parts[i].max[1] ? 1 : 0;
        below_mean += parts[2].p99[4] < parts[2].p99[1] ? 1 : 0;
        below_map += parts[2].p99[4] < std::min(parts[2].p99[0], parts[2].p99[3]) ? 1 : 0;
        write_ticks(s, c.csv);
    }
    std::printf("smoothed map below force shading: %d, %d and %d of %zu\n", below[0], below[1], below_mean, c.meshes.size());
    std::printf("99th percentile below the map's and the mesh's: %d of %zu\n", below_map, c.meshes.size());
}

void add_maps(CLI::App& command, SlideCommand& c)
{
    command.add_flag("--paper", c.paper, "The paper's force on paper models instead");
    command.add_option("--map-smoothing", c.maps.smoothing, "What is smoothed: surface or distances")
        ->transform(CLI::CheckedTransformer(std::map<std::string, paper::Smoothing>{{"surface", paper::Smoothing::Surface},
                                                                                    {"distances", paper::Smoothing::Distances}}));
    command.add_option("--map-length", c.maps.smoothing_length, "Of the surface's smoothing, share of R_max")
        ->check(CLI::Range(1e-3, 0.1))
        ->capture_default_str();
    command.add_option("--map-radius", c.maps.smoothing_radius, "Of the distances' kernel, base samples")
        ->check(CLI::Range(0, 8))
        ->capture_default_str();
    command.add_option("--map-kernel", c.maps.smoothing_kernel, "binomial, box or gaussian")
        ->transform(CLI::CheckedTransformer(
            std::map<std::string, paper::SmoothingKernel>{{"binomial", paper::SmoothingKernel::Binomial},
                                                          {"box", paper::SmoothingKernel::Box},
                                                          {"gaussian", paper::SmoothingKernel::Gaussian}}));
}

void add_slide(CLI::App& app)
{
    const auto c = std::make_shared<SlideCommand>();
    haptic::ZoneOptions& zone = c->options.zone;
    zone.layer = query::Layer::Exact;
    CLI::App* command = app.add_subcommand("slide", "Fig. 13: steps of the force while sliding at 0.1 m/s, 1 kHz");
    command->add_option("meshes", c->meshes, "Closed meshes; scaled to R_max = 0.3 m")->required()->check(CLI::ExistingFile);
    command->add_flag("--sphere", c->options.sphere, "A sphere of 5 mm instead of a point");
    command->add_option("--depth", c->options.depth, "m")->check(CLI::Range(1e-6, 0.1))->capture_default_str();
    command->add_option("--stiffness", c->options.stiffness, "N/m")->check(CLI::Range(1e-3, 1e6))->capture_default_str();
    command->add_option("--radius", zone.smoothing.radius, "Of the smoothing, m")
        ->check(CLI::Range(1e-6, 0.1))
        ->capture_default_str();
    command->add_option("--tolerance", zone.smoothing.tolerance, "Of the felt depth, m")
        ->check(CLI::Range(0., 0.1))
        ->capture_default_str();
    command->add_option("--points", zone.smoothing.points, "Samples of the stencil")
        ->check(CLI::Range(1, 4096))
        ->capture_default_str();
    command->add_option("--blend", zone.blend_time, "s; 0: none")->check(CLI::Range(0., 10.))->capture_default_str();
    command->add_option("--planes", c->options.planes, "Sections along each axis")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    command->add_option("--positions", c->positions, "For onset and normal")
        ->check(CLI::Range(1, 1000000))
        ->capture_default_str();
    command->add_option("--kernel", zone.smoothing.kernel, "shell or ball")
        ->transform(CLI::CheckedTransformer(
            std::map<std::string, haptic::Kernel>{{"shell", haptic::Kernel::Shell}, {"ball", haptic::Kernel::Ball}}));
    command->add_option("--layer", zone.layer, "3 or exact")
        ->transform(CLI::CheckedTransformer(app::layers_by_name({query::Layer::Three, query::Layer::Exact})));
    command->add_flag_callback(
        "--consistent", [c] { c->options.zone.shading = haptic::Shading::Consistent; }, "The gradient of one potential");
    add_maps(*command, *c);
    command->add_option("--csv", c->csv, "Every tick of the last mesh");
    command->callback([c] { c->paper ? run_paper_slide(*c) : run_slide(*c); });
}

void add_energy(CLI::App& app)
{
    const auto c = std::make_shared<SlideCommand>();
    CLI::App* command =
        app.add_subcommand("energy", "Work of the force around closed paths of 3 mm, as a share of the work it moves");
    command->add_option("meshes", c->meshes, "Closed meshes; scaled to R_max = 0.3 m")->required()->check(CLI::ExistingFile);
    command->add_flag("--sphere", c->options.sphere, "A sphere of 5 mm instead of a point");
    command->add_option("--positions", c->positions, "Paths per mesh")->check(CLI::Range(1, 1000000))->capture_default_str();
    c->options.zone.layer = query::Layer::Exact;
    command->add_option("--layer", c->options.zone.layer, "3 or exact")
        ->transform(CLI::CheckedTransformer(app::layers_by_name({query::Layer::Three, query::Layer::Exact})));
    add_maps(*command, *c);
    command->callback([c] {
        c->options.zone.blend_time = 0;
        const bool paper = c->paper;
        const int rubbed = paper ? 25 : 0;
        std::printf("%-18s | %-*s | %s\n%-18s", "", 52 + rubbed, paper ? "eq. 26, a point on the smoothed map" : "consistent",
                    paper ? "the same averaged over an impact sphere" : "levelled", "mesh");
        for (int i = 0; i < 2; ++i) {
            std::printf(" | %9s %9s %9s %11s %10s", "median", "least", "most", "asked, mJ", "sent, mJ");
            if (paper) std::printf(" %13s %10s", "eq. 33: asked", "sent, mJ");
        }
        std::printf("\n");
        for (const std::filesystem::path& file : c->meshes) {
            const TouchObject object(file, paper ? TouchObject::Models::Paper : TouchObject::Models::Central, c->maps);
            std::printf("%-18s", file.stem().string().c_str());
            for (int i = 0; i < 2; ++i) {
                c->options.zone.shading = i == 0 ? haptic::Shading::Consistent : haptic::Shading::Levelled;
                const Force force = !paper ? Force::Full : i == 0 ? Force::Smoothed : Force::Averaged;
                const Energy e = energy(object, c->options, force, c->positions);
                std::printf(" | %9.6f %9.6f %9.6f %11.4f %10.4f", e.median, e.least, e.worst, 1e3 * e.commanded, 1e3 * e.sent);
                if (paper) std::printf(" %13.4f %10.4f", 1e3 * e.rubbed_commanded, 1e3 * e.rubbed_sent);
            }
            std::printf("\n");
            std::fflush(stdout);
        }
    });
}

struct HandCommand {
    std::vector<std::filesystem::path> paths;
    std::filesystem::path meshes, series;
    std::vector<std::string> by;
    int passes = 10, divide = 0, touching = 0;
    double spacing = 0;
    bool paper = false, edges = false, exact = false;
};

/// OBJECT.PROBE.KIND.csv
HandPath hand_path(const HandCommand& c, const std::filesystem::path& path)
{
    const std::string name = path.filename().string();
    const std::size_t a = name.find('.'), b = name.find('.', a + 1);
    if (a == std::string::npos || b == std::string::npos) throw BenchError(name + ": not OBJECT.PROBE.KIND.csv");
    HandPath out{{c.meshes / (name.substr(0, a) + ".obj"), c.meshes / (name.substr(a + 1, b - a - 1) + ".obj")},
                 path,
                 c.spacing,
                 c.touching,
                 c.divide,
                 {},
                 c.paper,
                 c.edges,
                 c.exact};
    for (const std::string& by : c.by)
        if (by != name.substr(0, a)) out.by.push_back(c.meshes / (by + ".obj"));
    return out;
}

void add_hand(CLI::App& app)
{
    const auto c = std::make_shared<HandCommand>();
    CLI::App* tick =
        app.add_subcommand("tick", "CPU time of a tick of a hand on its paths: query, force, torque, friction, safety filter");
    CLI::App* density = app.add_subcommand("density", "Force of a hand against one with every triangle split in four");
    for (CLI::App* command : {tick, density}) {
        command->add_option("paths", c->paths, "OBJECT.PROBE.KIND.csv")->required()->check(CLI::ExistingFile);
        command->add_option("--meshes", c->meshes, "Folder of the meshes")->required()->check(CLI::ExistingDirectory);
        command->add_option("--spacing", c->spacing, "Of the points that stand for the hand's surface, m; 0: its vertices")
            ->check(CLI::Range(0., 1.))
            ->capture_default_str();
        command->add_option("--touching", c->touching, "Denser points while no more than so many would touch; 0: not")
            ->check(CLI::Range(0, 100000))
            ->capture_default_str();
        command->add_option("--divide", c->divide, "Split every triangle of the hand in four so many times first")
            ->check(CLI::Range(0, 3))
            ->capture_default_str();
    }
    tick->add_option("--by", c->by, "Names of objects that stand by, 40 cm away; the path's own is left out");
    tick->add_flag("--paper", c->paper, "The paper's force on paper models instead");
    tick->add_flag("--edges", c->edges, "Edges and faces of the hand touch too");
    tick->add_flag("--exact", c->exact, "The exact layer instead of layer 3");
    tick->add_option("--passes", c->passes, "Times that every path is run")->check(CLI::Range(1, 10000))->capture_default_str();
    tick->add_option("--series", c->series, "CSV of every tick of the last path: medians over the passes");
    tick->callback([c] {
        std::printf("%-36s %8s %8s %8s | %9s %9s | %9s %9s | %9s %8s\n", "path", "p50 us", "p99 us", "p99.9 us", "query p50",
                    "p99.9 us", "scene p50", "p99.9 us", "contacts", "ticks");
        for (const std::filesystem::path& path : c->paths) {
            const TickCost t = tick_cost(hand_path(*c, path), c->passes);
            std::printf("%-36s %8.1f %8.1f %8.1f | %9.1f %9.1f | %9.1f %9.1f | %9.1f %8u\n", path.stem().string().c_str(), t.p50,
                        t.p99, t.p999, t.query_p50, t.query_p999, t.scene_p50, t.scene_p999, t.contacts, t.ticks);
            std::fflush(stdout);
            if (c->series.empty() || &path != &c->paths.back()) continue;
            std::string csv = "tick,contacts,query_us,tick_us\n";
            for (std::size_t i = 0; i < t.series.size(); ++i) {
                const TickCost::Tick& s = t.series[i];
                csv += std::to_string(i) + ',' + std::to_string(s.contacts) + ',' + std::to_string(s.query_us) + ',' +
                       std::to_string(s.us) + '\n';
            }
            io::replace_file(c->series, std::as_bytes(std::span(csv)));
        }
    });
    density->callback([c] {
        std::printf("%-36s %6s %9s %9s %6s | %-26s | %-26s | %-20s | %s\n", "path", "ticks", "contacts", "dense", "< 5 %",
                    "of force, %: median p95 max", "of k depth", "torque, %: median p95", "equal weights: of k depth");
        for (const std::filesystem::path& path : c->paths) {
            const DensityChange d = density_change(hand_path(*c, path), true), n = density_change(hand_path(*c, path), false);
            std::printf("%-36s %6u %9.1f %9.1f %6.1f | %8.3f %8.3f %8.3f | %8.3f %8.3f %8.3f | %8.3f %8.3f | %8.3f %8.3f\n",
                        path.stem().string().c_str(), d.touching, d.contacts, d.dense_contacts, d.within_5, d.force_median,
                        d.force_p95, d.force_max, d.share_median, d.share_p95, d.share_max, d.torque_median, d.torque_p95,
                        n.share_median, n.share_p95);
            std::fflush(stdout);
        }
    });
}

}  // namespace
}  // namespace sqmap::bench

int sqmap::bench::measure_haptic(int argc, char** argv)
{
    CLI::App app("Figures of haptic rendering", "sqmap_measure haptic");
    app.require_subcommand(1);
    add_slide(app);
    add_energy(app);
    add_hand(app);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? 0 : 64;
    }
    return 0;
}
