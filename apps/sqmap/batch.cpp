// sqmap batch: libraries of models.
#include "bake_options.h"
#include "batch/manifest.h"
#include "batch/operations.h"
#include "batch/run.h"
#include "commands.h"
#include "load_options.h"
#include "sqmap/io/model_file.h"

#include <sched.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace sqmap::app {
namespace {

using batch::Shard;

struct BatchArguments {
    std::string manifest, output, root, shard, rank, world_size;
    std::vector<std::string> retry;
    int jobs = 0;
    batch::Caps caps;
    batch::ProgressMode progress = batch::ProgressMode::Auto;
    bool no_pictures = false;
    MeshOptions load;
    BakeSettings bake;
};

/// Options of the driver, which do not change a model.
const std::vector<std::string> k_of_the_driver{"--output", "--shard",       "--rank",     "--world-size", "--jobs", "--time",
                                               "--memory", "--output-size", "--progress", "--root",       "--help", "--retry"};

std::optional<std::uint32_t> whole(std::string_view text)
{
    std::uint32_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

std::optional<std::uint32_t> environment(const char* name)
{
    const char* const text = std::getenv(name);
    return text != nullptr ? whole(text) : std::nullopt;
}

Shard shard_of_text(const std::string& text)
{
    const std::size_t slash = text.find('/');
    const auto index = whole(std::string_view(text).substr(0, slash));
    const auto count = slash == std::string::npos ? std::nullopt : whole(std::string_view(text).substr(slash + 1));
    if (!index || !count || *index >= *count || *count > 99999)
        throw WrongUsage("--shard", "'" + text + "' is not I/N with I from 0 to N - 1, as in 0/10");
    return {*index, *count};
}

/// The shard of a task of a whole Slurm job array; tasks of a part of an array must be given their shards.
std::optional<Shard> shard_of_slurm()
{
    const auto id = environment("SLURM_ARRAY_TASK_ID"), first = environment("SLURM_ARRAY_TASK_MIN"),
               last = environment("SLURM_ARRAY_TASK_MAX"), count = environment("SLURM_ARRAY_TASK_COUNT");
    if (!id || !first || !last || !count) return std::nullopt;
    const std::uint32_t step = environment("SLURM_ARRAY_TASK_STEP").value_or(1);
    if (step == 0 || (*last - *first) / step + 1 != *count)
        throw WrongUsage("--shard", "this Slurm array has gaps: give --shard \"$SLURM_ARRAY_TASK_ID/N\"");
    return Shard{(*id - *first) / step, *count};
}

Shard shard_of(const BatchArguments& o, const Command& command)
{
    if (command.given("--shard")) return shard_of_text(o.shard);
    if (command.given("--rank")) return shard_of_text(o.rank + "/" + o.world_size);
    return shard_of_slurm().value_or(Shard{});
}

/// Cores that this process may use, or the tasks's own under Slurm.
unsigned cores()
{
    cpu_set_t set;
    const int count = ::sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
    return std::min<unsigned>(static_cast<unsigned>(std::max(count, 1)), environment("SLURM_CPUS_PER_TASK").value_or(100000));
}

/// Says on standard error which shards wait for a run.
void warn_of_unfinished(const batch::Library& library)
{
    std::fflush(stdout);
    if (const std::string words = batch::words_of(library.unfinished()); !words.empty())
        std::fprintf(stderr, "%s\n", words.c_str());
}

batch::Plan plan_of(const BatchArguments& o, const Command& command)
{
    batch::Plan plan;
    plan.manifest = o.manifest;
    plan.root = o.root;
    plan.output = o.output;
    plan.shard = shard_of(o, command);
    plan.jobs = o.jobs > 0 ? static_cast<unsigned>(o.jobs) : cores();
    plan.caps = o.caps;
    plan.retry = {o.retry.begin(), o.retry.end()};
    plan.progress = o.progress;
    plan.arguments = command.given_but(k_of_the_driver);
    BakeMeshOptions& bake = plan.settings.bake = bake_options(o.bake);
    bake.mesh = o.load;
    bake.bake.threads = 1;
    bake.provenance = {.made_by = "sqmap " SQMAP_VERSION, .source = ""};
    // Programs that convert a mesh have no more time than its process.
    bake.mesh.limits.max_seconds = std::min(bake.mesh.limits.max_seconds, o.caps.seconds);
    plan.settings.pictures = !o.no_pictures;
    for (const std::string& argument : plan.arguments)
        plan.settings.options += (plan.settings.options.empty() ? "" : " ") + argument;
    return plan;
}

void add_driver_options(Command& command, BatchArguments& options)
{
    Command work = command.titled("Work");
    Option shard = work.option("--shard", options.shard,
                               "I/N: every Nth item from the Ith on, 0 to N - 1; default: Slurm's array task, or all")
                       .type_name("I/N");
    Option rank = work.option("--rank", options.rank, "I of --shard").type_name("I").excludes(shard);
    Option world_size = work.option("--world-size", options.world_size, "N of --shard").type_name("N");
    rank.needs(world_size.excludes(shard).needs(rank));
    work.option("--jobs", options.jobs, "Meshes at once; 0: one a core").in_range(0, 4096);
    work.choice<batch::ProgressMode>(
        "--progress", options.progress,
        {{"auto", batch::ProgressMode::Auto}, {"json", batch::ProgressMode::Json}, {"none", batch::ProgressMode::None}},
        "auto: rate and time left on standard error; json: a line an item on standard output", "auto|json|none");
    Command caps = command.titled("Limits of each mesh's process (beyond them: a row)");
    caps.option("--time", options.caps.seconds, "Seconds of CPU time; three times that, and 10 s, by the clock").in_range(1, 1e6);
    caps.size("--memory", options.caps.memory, "Memory; also as 500MB or 4GB, of 1024 each");
    caps.size("--output-size", options.caps.output, "Largest file that it may write");
}

/// Adds a subcommand that takes a library's folder, and options by `more`.
template <class Subcommand>
void add_over_library(Command& batch, const char* name, const char* words)
{
    struct State {
        std::string folder;
        Subcommand work;
    };
    const auto state = std::make_shared<State>();
    Command command = batch.add(name, words);
    command.option("library", state->folder, "Folder of the library").required().existing_path().type_name("OUT");
    state->work.add(command);
    command.run<batch::ManifestError, io::ModelFileError>([state] { return state->work.run(batch::Library(state->folder)); });
}

struct List {
    bool json = false;
    void add(Command& command) { command.flag("--json", json, "A JSON line an item"); }
    [[nodiscard]] int run(const batch::Library& library) const
    {
        batch::list(library, json);
        warn_of_unfinished(library);
        return 0;
    }
};

struct Merge {
    std::uint64_t size = std::uint64_t{4} << 30;
    bool partial = false;
    void add(Command& command)
    {
        command.flag("--partial", partial, "Also while shards are not finished");
        command.size("--size", size, "Bytes of an archive, about; also as 500MB or 4GB, of 1024 each");
    }
    [[nodiscard]] int run(const batch::Library& library) const
    {
        batch::merge(library, size, partial ? batch::Missing::Allowed : batch::Missing::Refused);
        for (const std::filesystem::path& archive : library.merged()) std::printf("%s\n", archive.c_str());
        return 0;
    }
};

struct Verify {
    bool index = false;
    void add(Command& command)
    {
        command.flag("--index", index, "Index and rows alone; models are not read");
        command.footer("Exit code: 0 all is well, 2 something is not, 64 wrong usage, 70 internal error.");
    }
    [[nodiscard]] int run(const batch::Library& library) const
    {
        const batch::Verification found = batch::verify(library, index ? batch::Depth::Index : batch::Depth::Models);
        std::printf("%zu archives, %zu models, %zu rows, faults: %zu\n", found.archives, found.models, found.rows, found.faults);
        warn_of_unfinished(library);
        return found.faults == 0 ? 0 : 2;
    }
};

struct Extract {
    std::string item, output;
    void add(Command& command)
    {
        command.option("item", item, "Key of the model or its first digits, path of the mesh, or the name of its file")
            .required();
        command.option("-o,--output", output, "Model to write (.sqmap)").required();
    }
    [[nodiscard]] int run(const batch::Library& library) const { return batch::extract(library, item, output), 0; }
};

struct Garbage {
    void add(Command& command) { command.footer("Run it when nothing is baked into the library."); }
    [[nodiscard]] int run(const batch::Library& library) const
    {
        const batch::Freed freed = batch::collect_garbage(library);
        std::printf("%zu files, %.1f MB\n", freed.files, static_cast<double>(freed.bytes) / 1e6);
        return 0;
    }
};

struct Report {
    void add(Command& command) { command.footer("OUT/report/index.html needs no server; OUT/report/rows.csv has all rows."); }
    [[nodiscard]] int run(const batch::Library& library) const
    {
        batch::write_report(library);
        std::printf("%s\n", (library.report_folder() / "index.html").c_str());
        warn_of_unfinished(library);
        return 0;
    }
};

/// Runs a library's shards again, by the command line that began it.
struct Retry {
    std::vector<std::string> verdicts;
    std::string manifest, time, memory, output_size, shard, jobs, progress;
    void add(Command& command)
    {
        command.option("--verdict", verdicts, "Verdicts that are not final: timeout, memory, output, crash; several by commas")
            .required()
            .delimiter(',')
            .one_of({"timeout", "memory", "output", "crash"});
        command.option("--manifest", manifest, "Where the library's manifest is now; default: where it was")
            .type_name("MANIFEST");
        command.option("--time", time, "As of sqmap batch");
        command.option("--memory", memory, "As of sqmap batch");
        command.option("--output-size", output_size, "As of sqmap batch");
        command.option("--shard", shard, "Of this shard alone; default: of all, one after another").type_name("I/N");
        command.option("--jobs", jobs, "As of sqmap batch");
        command.option("--progress", progress, "As of sqmap batch");
    }
    [[nodiscard]] int run(const batch::Library& library) const
    {
        batch::Recipe recipe = library.recipe();
        if (!manifest.empty()) recipe.manifest = manifest;
        if (std::error_code ignored; !std::filesystem::exists(recipe.manifest, ignored))
            throw batch::ManifestError(recipe.manifest +
                                       ": the library's manifest is not there any more\n"
                                       "  cure: if it has another name now, give that: --manifest MANIFEST");
        std::vector<std::string> shards{shard};
        if (shard.empty()) {
            shards.clear();
            for (std::uint32_t i = 0; i < recipe.shards; ++i)
                shards.push_back(std::to_string(i) + "/" + std::to_string(recipe.shards));
        }
        for (const std::string& one : shards)
            if (const int code = run_shard(library, recipe, one); code != 0) return code;
        return 0;
    }

private:
    [[nodiscard]] int run_shard(const batch::Library& library, const batch::Recipe& recipe, const std::string& one) const
    {
        std::vector<std::string> arguments{"sqmap", "batch", recipe.manifest, "-o", library.folder().string(), "--shard", one};
        const auto pass_on = [&](const char* name, const std::string& value) {
            if (!value.empty()) arguments.insert(arguments.end(), {name, value});
        };
        pass_on("--root", recipe.root);
        pass_on("--time", time);
        pass_on("--memory", memory);
        pass_on("--output-size", output_size);
        pass_on("--jobs", jobs);
        pass_on("--progress", progress);
        for (const std::string& verdict : verdicts) pass_on("--retry", verdict);
        arguments.insert(arguments.end(), recipe.arguments.begin(), recipe.arguments.end());
        std::vector<char*> pointers;
        for (std::string& argument : arguments) pointers.push_back(argument.data());
        CommandLine line("", "sqmap");
        add_batch(line);
        return line.run(static_cast<int>(pointers.size()), pointers.data());
    }
};

void add_subcommands(Command& command)
{
    add_over_library<List>(command, "list", "Print the items of a library");
    add_over_library<Merge>(command, "merge", "Join finished shards into archives in order of keys");
    add_over_library<Verify>(command, "verify", "Check every model and every row");
    add_over_library<Retry>(command, "retry", "Bake again what ended by one of these verdicts, within other limits");
    add_over_library<Report>(command, "report", "Write a page of all items: counts, distributions, pictures, reasons");
    add_over_library<Extract>(command, "extract", "Write one model as a file");
    add_over_library<Garbage>(command, "gc", "Remove what killed runs left and shards that are merged");
}

}  // namespace

void add_batch(CommandLine& line)
{
    const auto options = std::make_shared<BatchArguments>();
    Command command = line.add("batch", "Bake a library of meshes: resumable, in shards, a row for every item");
    command
        .option("items", options->manifest,
                "A folder, a mesh, an archive, or a list: .csv with a column path, .jsonl with \"path\", .txt")
        .type_name("MANIFEST");
    command.option("-o,--output", options->output, "Folder of the library; whatever is finished there is not baked again")
        .type_name("OUT");
    command.option("--root", options->root, "Folder that relative paths count from; default: the manifest's").type_name("FOLDER");
    command.flag("--no-pictures", options->no_pictures, "Leave the small picture of each model out");
    add_driver_options(command, *options);
    command.option("--retry", options->retry, "Verdicts that are not taken as final, as of sqmap batch retry").delimiter(',');
    add_subcommands(command);
    add_load_options(command, options->load);
    add_bake_options(command, options->bake);
    command.footer(
        "Exit code: 0 every item has a row, 2 the manifest cannot be read or the folder not be written (run it again), "
        "64 wrong usage, 70 internal error.");
    command.run<batch::ManifestError, io::ModelFileError>([options, command] {
        if (options->manifest.empty() || options->output.empty())
            throw WrongUsage("batch", "give MANIFEST and -o OUT, or a subcommand: see sqmap batch --help");
        return batch::run(plan_of(*options, command)), 0;
    });
}

}  // namespace sqmap::app
