// sqmap_bench: the project's method beside its peers, in one process, on the same frames.
#include "error.h"
#include "frames.h"
#include "io/replace_file.h"
#include "make_path.h"
#include "report.h"
#include "reproduce.h"
#include "sqmap/bake/bake_types.h"
#include "sqmap/io/model_file.h"
#include "sqmap/mesh/error.h"

#include <hwy/targets.h>
#include <CLI/CLI.hpp>

#include <cmath>
#include <cstdio>
#include <exception>
#include <map>
#include <memory>

namespace sqmap::bench {
namespace {

struct FramesOptions {
    Files files;
    std::filesystem::path path, json, series, cache = SQMAP_BENCH_CACHE;
    std::vector<std::string> methods;
    RaceOptions race;
    double target_error = bake::BakeOptions{}.target_error;
    std::string instructions;
    bool quiet = false;
};

const std::map<std::string, std::int64_t> k_instructions{{"sse4", HWY_SSE4}, {"avx2", HWY_AVX2}, {"avx512", HWY_AVX3}};

/// Lets sqmap's kernels use no wider set than name; an empty name leaves the machine's choice. Returns the set they run on.
std::string limit_instructions(const std::string& name)
{
    std::int64_t left = hwy::SupportedTargets();
    if (!name.empty()) {
        left &= ~(k_instructions.at(name) - 1);  // wider ones have the lower bits
        // Not DisableTargets: SupportedTargets, called above, has chosen among all already.
        hwy::SetSupportedTargetsForTest(left);
    }
    // The kernels exist for these sets of x86 alone.
    const std::int64_t compiled = HWY_SSE4 | HWY_AVX2 | HWY_AVX3;
    if ((left & compiled) != 0) left &= compiled;
    return hwy::TargetName(left & -left);
}

const MethodEntry& entry_of(const std::string& name)
{
    std::string known;
    for (const MethodEntry& entry : method_entries()) {
        if (entry.name == name) return entry;
        known += (known.empty() ? "" : ", ") + entry.name;
    }
    throw BenchError("--methods " + name + ": no such method\n  cure: any of " + known);
}

void run_frames(const FramesOptions& options)
{
    std::vector<const MethodEntry*> entries;
    for (const std::string& name : options.methods) {
        if (std::count(options.methods.begin(), options.methods.end(), name) > 1)
            throw BenchError("--methods " + name + ": named twice\n  cure: name it once");
        entries.push_back(&entry_of(name));
        if (entries.back()->make == nullptr)
            throw BenchError("--methods " + name + ": not compiled in\n  cure: install " + entries.back()->package +
                             ", configure and build again (./dev bench does all of it)");
    }
    if (options.methods.empty())
        for (const MethodEntry& entry : method_entries()) {
            if (entry.extra) continue;
            if (entry.make != nullptr)
                entries.push_back(&entry);
            else
                std::fprintf(stderr, "%s: left out, not compiled in (needs %s)\n", entry.name.c_str(), entry.package.c_str());
        }
    for (const auto& [option, file] : {std::pair{"--json", options.json}, std::pair{"--series", options.series}})
        if (!file.empty() && !std::filesystem::is_directory(file.has_parent_path() ? file.parent_path() : "."))
            throw BenchError(std::string(option) + ' ' + file.string() + ": no such folder\n  cure: make it, or name another");
    const std::string instructions = limit_instructions(options.instructions);
    const std::vector<Pose> path = read_path(options.path);
    const std::unique_ptr<Setting> setting = load_setting(options.files);
    setting->cache = options.cache;
    setting->target_error = options.target_error;
    const std::vector<std::vector<TrueContact>> truth = true_contacts(*setting, path);
    std::vector<std::unique_ptr<Method>> methods;
    std::vector<Contestant> contestants;
    for (const MethodEntry* entry : entries) {
        methods.push_back(entry->make(*setting, entry->argument));
        contestants.push_back({entry, methods.back().get()});
        if (!options.quiet) std::fprintf(stderr, "%s: built, %zu bytes\n", entry->name.c_str(), methods.back()->bytes);
    }
    const std::vector<Record> records = race(*setting, path, truth, contestants, options.race);
    const std::string text = json_text(records, {.object = options.files.object.filename().string(),
                                                 .probe = options.files.probe.filename().string(),
                                                 .path = options.path.filename().string(),
                                                 .instructions = instructions,
                                                 .passes = options.race.passes,
                                                 .object_triangles = setting->object.triangles.size(),
                                                 .probe_vertices = setting->probe.vertices.size()});
    io::replace_file(options.json, std::as_bytes(std::span(text)));
    if (!options.series.empty()) {
        const std::string series = series_text(records);
        io::replace_file(options.series, std::as_bytes(std::span(series)));
    }
    if (options.quiet) return;
    std::printf("%-14s %9s %9s %9s %11s %9s %9s %9s %9s\n", "method", "p50 us", "p99 us", "p99.9 us", "bytes", "contacts",
                "missed %", "false %", "depth %");
    for (const Record& r : records) {
        std::printf("%-14s %9.2f %9.2f %9.2f %11zu %9.1f", r.method.c_str(), r.p50_us, r.p99_us, r.p999_us, r.bytes, r.contacts);
        if (r.accuracy)
            for (const double value : {r.accuracy->missed_pct, r.accuracy->false_pct, r.accuracy->depth_error_mean_pct}) {
                if (std::isfinite(value))
                    std::printf(" %9.5f", value);
                else
                    std::printf(" %9s", "-");
            }
        std::printf("\n");
    }
}

void add_frames(CLI::App& app)
{
    const auto options = std::make_shared<FramesOptions>();
    CLI::App* command = app.add_subcommand("frames", "Run methods on a path, in turns, and write one record a method");
    command->add_option("--object", options->files.object, "Mesh of the object: closed")->required();
    command->add_option("--probe", options->files.probe, "Mesh of the probe")->required();
    command->add_option("--path", options->path, "CSV: poses of the probe in the object's frame")->required();
    command->add_option("--methods", options->methods, "Comma-separated names; default: the fixed ones that are compiled in")
        ->delimiter(',');
    command->add_option("--passes", options->race.passes, "Times that every frame is run")
        ->check(CLI::Range(20u, 100000u))
        ->capture_default_str();
    command
        ->add_option("--slow-frames", options->race.slow_frames, "Most frames for fcl_kdop_all and embree_exact, evenly spread")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    command->add_option("--block", options->race.block, "Frames a turn; 1: caches as the other methods left them")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    command->add_option("--target-error", options->target_error, "What sqmap's models are baked to, percent of R_max")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    command->add_option("--cache", options->cache, "Folder that keeps distance fields between runs; empty: none")
        ->capture_default_str();
    command->add_option("--instructions", options->instructions, "Widest set of sqmap's kernels; default: the machine's")
        ->check(CLI::IsMember(k_instructions));
    command->add_option("--json", options->json, "File to write")->required();
    command->add_option("--series", options->series, "CSV to write: every frame's median time and contacts");
    command->add_flag("--quiet", options->quiet, "Print nothing but errors");
    command->callback([options] { run_frames(*options); });
}

void add_path(CLI::App& app)
{
    struct Options {
        Files files;
        std::filesystem::path output, cache = SQMAP_BENCH_CACHE;
        std::string kind;
        std::uint32_t frames = 1000;
    };
    static const std::map<std::string, double> k_depths{{"light", 0.01}, {"deep", 0.03}, {"near", -0.01}};
    const auto options = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand("path", "Make a path on which the probe slides over the object");
    command->add_option("--object", options->files.object, "Mesh of the object: closed")->required();
    command->add_option("--probe", options->files.probe, "Mesh of the probe")->required();
    command->add_option("--kind", options->kind, "light: 1 % of the object's diagonal deep, deep: 3 %, near: a gap of 1 %")
        ->required()
        ->check(CLI::IsMember({"light", "deep", "near"}));
    command->add_option("--frames", options->frames, "Poses")->check(CLI::Range(1u, 1000000u))->capture_default_str();
    command->add_option("--cache", options->cache, "Folder that keeps distance fields between runs; empty: none")
        ->capture_default_str();
    command->add_option("-o,--output", options->output, "CSV to write")->required();
    command->callback([options] {
        const std::unique_ptr<Setting> setting = load_setting(options->files);
        setting->cache = options->cache;
        const std::string text =
            path_text(sliding_path(*setting, {.depth = k_depths.at(options->kind), .frames = options->frames}));
        io::replace_file(options->output, std::as_bytes(std::span(text)));
    });
}

void add_table(CLI::App& app)
{
    const auto files = std::make_shared<std::vector<std::filesystem::path>>();
    CLI::App* command = app.add_subcommand("table", "Print Markdown tables of the files that frames has written");
    command->add_option("files", *files, "JSON files")->required();
    command->callback([files] { std::fputs(tables(*files).c_str(), stdout); });
}

}  // namespace
}  // namespace sqmap::bench

int main(int argc, char** argv)
{
    CLI::App app{"sqmap_bench: sqmap beside its peers, in one process, on the same frames"};
    app.require_subcommand(1);
    app.footer("Exit code: 0 done, 2 bad input or nothing written, 64 wrong usage, 70 internal error.");
    sqmap::bench::add_frames(app);
    sqmap::bench::add_path(app);
    sqmap::bench::add_table(app);
    sqmap::bench::add_reproduce(app);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? 0 : 64;
    } catch (const sqmap::bench::BenchError& e) {
        std::fprintf(stderr, "sqmap_bench: %s\n", e.what());
        return 2;
    } catch (const sqmap::io::ModelFileError& e) {
        std::fprintf(stderr, "sqmap_bench: %s\n", e.what());
        return 2;
    } catch (const sqmap::mesh::Error& e) {
        std::fprintf(stderr, "sqmap_bench: %s\n", e.what());
        return 2;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "sqmap_bench: internal error: %s\n", e.what());
        return 70;
    }
    return 0;
}
