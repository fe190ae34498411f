#include "sqmap/bake_mesh.h"

#include "bake_options.h"
#include "commands.h"
#include "common/program_words.h"
#include "common/reports.h"
#include "io/replace_file.h"
#include "load_options.h"
#include "sqmap/io/model_file.h"
#include "sqmap/paper/bake.h"
#include "sqmap/paper/model_file.h"

#include <unistd.h>
#include <nlohmann/json.hpp>

#include <cstdio>
#include <memory>
#include <span>

namespace sqmap::app {
namespace {

using nlohmann::ordered_json;

/// Progress as one line that rewrites itself on a terminal and stays silent in a pipe.
void show_progress(const char* stage, double done)
{
    if (::isatty(STDERR_FILENO) == 0) return;
    std::fprintf(stderr, "\r%-12s %3.0f %%  ", stage, 100 * done);
    if (done >= 1) std::fprintf(stderr, "\r%-24s\r", "");
    std::fflush(stderr);
}

ordered_json report_json(const BakedModel& baked)
{
    ordered_json out;
    out["parts"] = ordered_json::array();
    const model::ModelView view = baked.model.common.view();
    for (std::size_t i = 0; i < baked.report.parts.size(); ++i) {
        const bake::PartReport& p = baked.report.parts[i];
        out["parts"].push_back({{"area", p.area},
                                {"volume", p.volume},
                                {"solid_volume", p.solid_volume},
                                {"q2_share", p.q2_share},
                                {"largest_f", p.certificate.largest_f},
                                {"tolerance", p.certificate.tolerance},
                                {"fallback", p.fallback},
                                {"base", p.base},
                                {"map_bytes", p.map_bytes},
                                {"bounds", ordered_json::parse(io::bounds_json(view, i))}});
    }
    out["bounds"] = ordered_json::parse(io::bounds_json(view, view.parts.size()));
    for (const auto& [stage, seconds] : baked.report.seconds) out["cpu_seconds"][stage] = seconds;
    out["target_met"] = baked.report.target_met;
    out["verdict"] = mesh::name_of(baked.mesh.admission);
    out["notes"] = words(baked.notes, k_program_settings);
    out["cure"] = ordered_json::parse(io::cure_json(baked.model.common.cure));
    out["measured"] = ordered_json::parse(io::measured_json(baked.model.common.measured));
    return out;
}

struct BakeArguments {
    std::string mesh, model, report;
    MeshOptions load;
    BakeSettings bake;
    std::string given;  ///< the options that change the model, as they were given
};

/// @throw io::ModelFileError
void write(const BakedModel& baked, const BakeArguments& o)
{
    // The report first: where it cannot be written, no model is left behind either.
    if (!o.report.empty()) {
        const std::string text = report_json(baked).dump(2) + '\n';
        io::replace_file(o.report, std::as_bytes(std::span(text)));
    }
    baked.save(o.model);
}

/// Which parts of a paper model stay above --max-q2, and why.
void print_hidden_parts(const BakedModel& baked, const BakeArguments& o)
{
    if (o.bake.projection != "normal" || !o.bake.given("--max-q2")) return;
    std::string above;
    for (std::size_t i = 0; i < baked.report.parts.size(); ++i) {
        const double share = baked.report.parts[i].q2_share;
        if (share <= o.bake.bake.max_q2_share) continue;
        char text[60];
        std::snprintf(text, sizeof text, "%s%zu (%.2f %%)", above.empty() ? "" : ", ", i, 100 * share);
        above += text;
    }
    if (above.empty()) return;
    std::printf("  more than %.3g %% Q2 (--max-q2) in parts %s: %s\n", 100 * o.bake.bake.max_q2_share, above.c_str(),
                baked.report.parts.size() >= o.bake.bake.max_parts ? "--max-parts stops the cuts"
                                                                   : "no cut of theirs shows more of the surface");
}

void print(const BakedModel& baked, const BakeArguments& o)
{
    const std::size_t bytes = std::filesystem::file_size(o.model);
    double seconds = 0;
    for (const auto& [stage, s] : baked.report.seconds) seconds += s;
    for (const Note& note : baked.notes)
        if (is_about_model(note)) std::printf("%s\n", words(note, k_program_settings).c_str());
    std::printf("%s: %zu parts, %.0f kB, baked in %.2f s of CPU time\n", o.model.c_str(), baked.report.parts.size(),
                static_cast<double>(bytes) / 1000, seconds);
    print_measured(baked.model.common.measured);
    print_hidden_parts(baked, o);
}

int run(const BakeArguments& o)
{
    try {
        io::check_output(o.model, {o.mesh});
        io::check_output(o.report, {o.mesh, o.model});
        AdmittedMesh loaded = admit_mesh(o.mesh, o.load);
        if (loaded.refused() || !loaded.repairs.empty() || !loaded.warnings.empty())
            std::fprintf(loaded.refused() ? stderr : stdout, "%s: %s", o.mesh.c_str(), report(loaded).c_str());
        if (loaded.refused()) return 2;
        BakeMeshOptions options = bake_options(o.bake);
        options.provenance = {.made_by = "sqmap " SQMAP_VERSION, .options = o.given};
        options.bake.progress = show_progress;
        const BakedModel baked = bake_mesh(std::move(loaded), options);
        write(baked, o);
        print(baked, o);
        return 0;
    } catch (const mesh::RefusedMesh& e) {
        std::fprintf(stderr, "%s: REFUSED %s\n  cure: %s\n", o.mesh.c_str(), e.what(),
                     e.diagnosis().cure.text(k_program_settings).c_str());
    } catch (const mesh::Error& e) {
        std::fprintf(stderr, "%s: %s\n", o.mesh.c_str(), e.what());
    }
    return 2;
}

}  // namespace

void add_bake(CommandLine& line)
{
    const auto options = std::make_shared<BakeArguments>();
    Command command = line.add("bake", "Bake a mesh into an SQ-Map model");
    command.option("mesh", options->mesh, "OFF, OBJ, STL, PLY, glTF or GLB; with the program assimp also DAE, 3MF, FBX")
        .required()
        .existing_file();
    command.option("-o,--output", options->model, "Model to write (.sqmap)").required();
    command.option("--threads", options->bake.bake.threads, "Threads, 0 for one a core; the model does not depend on it");
    command.option("--report", options->report, "Write what happened, a part and a stage at a time, as JSON");
    add_load_options(command, options->load);
    add_bake_options(command, options->bake);
    command.footer(
        "Exit code: 0 written (it says so first where the target error was not reached or layer 3 errs), 2 mesh refused or model "
        "not written, 64 wrong "
        "usage, 70 internal error.");
    command.run<io::ModelFileError>([options, command] {
        for (const std::string& option : command.given_but({"--output", "--threads", "--report"}))
            options->given += (options->given.empty() ? "" : " ") + option;
        return run(*options);
    });
}

}  // namespace sqmap::app
