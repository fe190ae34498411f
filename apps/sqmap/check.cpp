#include "commands.h"
#include "common/program_words.h"
#include "io/files.h"
#include "load_options.h"
#include "sqmap/collider/shape.h"

#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <map>
#include <memory>
#include <new>
#include <string>
#include <system_error>
#include <vector>

namespace sqmap::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

ordered_json as_json(const Vec3d& v) { return {v.x, v.y, v.z}; }
ordered_json as_json(const mesh::Distances& d) { return {{"mean", d.mean}, {"p99", d.p99}, {"max", d.max}}; }

/// The file's name may hold any bytes; JSON is UTF-8. indent: -1 for a single line.
std::string dumped(const ordered_json& j, int indent)
{
    return j.dump(indent, ' ', false, ordered_json::error_handler_t::replace);
}

ordered_json as_json(const std::string& file, const AdmittedMesh& loaded)
{
    const bool refused = loaded.refused();
    const auto text_or_null = [&](const std::string& text) { return refused ? ordered_json(text) : ordered_json(nullptr); };
    ordered_json out{{"file", file},
                     {"format", loaded.format.empty() ? ordered_json(nullptr) : ordered_json(loaded.format)},
                     {"verdict", mesh::name_of(loaded.admission)},
                     {"code", text_or_null(mesh::name_of(loaded.diagnosis.code))},
                     {"element", text_or_null(loaded.diagnosis.element)},
                     {"message", text_or_null(loaded.diagnosis.message)},
                     {"cure", text_or_null(loaded.diagnosis.cure.text(k_program_settings))},
                     {"repairs", ordered_json::array()},
                     {"warnings", ordered_json::array()}};
    for (const mesh::RepairNote& r : loaded.repairs)
        out["repairs"].push_back({{"kind", mesh::name_of(r.kind)}, {"count", r.count}});
    for (const mesh::Warning& w : loaded.warnings)
        out["warnings"].push_back(
            {{"code", mesh::name_of(w.kind)}, {"count", w.count}, {"message", mesh::words(w, k_program_settings)}});
    if (loaded.deviation) {
        out["moved"] = {{"input_to_result", as_json(loaded.deviation->input_to_result)},
                        {"result_to_input", as_json(loaded.deviation->result_to_input)},
                        {"made_up_share", loaded.deviation->made_up_share},
                        {"r_max", mesh::largest_vertex_distance(loaded.mesh)}};
        if (loaded.deviation->bounding_to_result)
            out["moved"]["bounding_to_result"] = as_json(*loaded.deviation->bounding_to_result);
    }
    if (refused) return out;
    const mesh::MeshFacts& f = loaded.facts;
    out["facts"] = {{"vertices", f.vertex_count},
                    {"triangles", f.triangle_count},
                    {"solid", loaded.solid},
                    {"components", f.component_count},
                    {"genus", loaded.solid ? ordered_json(f.genus) : ordered_json(nullptr)},
                    {"boundary_edges", f.boundary_edge_count},
                    {"self_intersecting_pairs", f.self_intersecting_pairs},
                    {"box_min", as_json(f.box.lo)},
                    {"box_max", as_json(f.box.hi)},
                    {"area", f.area},
                    {"volume", loaded.solid ? ordered_json(f.volume) : ordered_json(nullptr)}};
    return out;
}

void print(const std::string& file, const AdmittedMesh& loaded)
{
    std::printf("%s: %s", file.c_str(), report(loaded).c_str());
    if (loaded.refused()) return;
    const mesh::MeshFacts& f = loaded.facts;
    const Vec3d size = sqmap::size(f.box);
    std::printf("  %s, %llu vertices, %llu triangles, %llu component%s\n", loaded.format.c_str(),
                static_cast<unsigned long long>(f.vertex_count), static_cast<unsigned long long>(f.triangle_count),
                static_cast<unsigned long long>(f.component_count), f.component_count == 1 ? "" : "s");
    if (loaded.solid)
        std::printf("  closed, genus %lld, volume %.6g, area %.6g\n", static_cast<long long>(f.genus), f.volume, f.area);
    else
        std::printf("  open, %llu boundary edges, area %.6g\n", static_cast<unsigned long long>(f.boundary_edge_count), f.area);
    std::printf("  box %.6g x %.6g x %.6g\n", size.x, size.y, size.z);
}

/// The loss when a convex shape stands for the mesh in contacts.
struct ColliderRow {
    collider::Kind kind;
    collider::Figures figures;
};

std::vector<ColliderRow> collider_rows(const AdmittedMesh& loaded)
{
    std::vector<ColliderRow> rows;
    for (const collider::Kind kind : {collider::Kind::Hull, collider::Kind::Box, collider::Kind::Capsule}) {
        const collider::Shape shape = collider::enclosing(kind, loaded.mesh.vertices);
        rows.push_back({kind, collider::figures_of({&shape, 1}, {.points = loaded.mesh.vertices,
                                                                 .volume = loaded.solid ? loaded.facts.volume : 0,
                                                                 .solid = loaded.solid ? &loaded.mesh : nullptr,
                                                                 .crossed = loaded.crossed})});
    }
    return rows;
}

/// Shells inside others, which every convex shape fills.
std::uint64_t cavities_of(const AdmittedMesh& loaded)
{
    for (const mesh::Warning& w : loaded.warnings)
        if (w.kind == mesh::WarningKind::Cavities) return w.count;
    return 0;
}

ordered_json colliders_json(const AdmittedMesh& loaded)
{
    ordered_json out;
    for (const ColliderRow& row : collider_rows(loaded))
        out[collider::name_of(row.kind)] = {
            {"volume", row.figures.volume},
            {"volume_ratio", loaded.solid ? ordered_json(row.figures.volume_ratio) : ordered_json(nullptr)},
            {"support_excess", row.figures.support_excess},
            {"protrusion", loaded.solid ? ordered_json(row.figures.protrusion) : ordered_json(nullptr)},
            {"cavities_filled", cavities_of(loaded)},
            {"handles_filled", loaded.solid ? ordered_json(loaded.facts.genus) : ordered_json(nullptr)}};
    return out;
}

void print_losses(const AdmittedMesh& loaded)
{
    std::printf("  as a collider, certified to hold the mesh as it was taken; each fills %llu cavities and %lld handles\n",
                static_cast<unsigned long long>(cavities_of(loaded)),
                static_cast<long long>(loaded.solid ? loaded.facts.genus : 0));
    std::printf("    %-8s %14s %15s %15s\n", "shape", "volume / solid", "support excess", "protrusion");
    for (const ColliderRow& row : collider_rows(loaded))
        std::printf("    %-8s %14.4g %15.5g %15.5g\n", collider::name_of(row.kind), row.figures.volume_ratio,
                    row.figures.support_excess, row.figures.protrusion);
}

// --- a folder -----------------------------------------------------------------------------------------------------

std::vector<fs::path> meshes_below(const fs::path& folder)
{
    std::vector<fs::path> out;
    std::error_code ignored;  // a folder that may not be read has no files
    for (fs::recursive_directory_iterator it(folder, fs::directory_options::skip_permission_denied, ignored), end; it != end;
         it.increment(ignored))
        if (it->is_regular_file(ignored) && io::format_of_name(it->path())) out.push_back(it->path());
    std::sort(out.begin(), out.end());
    return out;
}

/// As admit_mesh, but whatever is thrown becomes the file's own refusal.
AdmittedMesh admitted_anyhow(const fs::path& path, const MeshOptions& options)
{
    AdmittedMesh out;
    try {
        return admit_mesh(path, options);
    } catch (const std::bad_alloc&) {
        out.diagnosis = {mesh::Refusal::Limit, "file", "it does not fit into memory", "lower --max-bytes or --max-faces"};
    } catch (const std::exception& e) {
        out.diagnosis = {mesh::Refusal::Internal, "file", e.what(), "report it, with the file"};
    }
    return out;
}

std::string done_to(const AdmittedMesh& loaded)
{
    if (loaded.refused())
        return mesh::name_of(loaded.diagnosis.code) + (" at " + loaded.diagnosis.element + ": " + loaded.diagnosis.message);
    std::string out;
    for (const mesh::RepairNote& r : loaded.repairs)
        out += (out.empty() ? "" : ", ") + std::string(mesh::name_of(r.kind)) + " " + std::to_string(r.count);
    return out;
}

void print_row(const std::string& file, const AdmittedMesh& loaded, double seconds)
{
    char moved[32] = "-", made_up[32] = "-";
    if (loaded.deviation) {
        const double r_max = mesh::largest_vertex_distance(loaded.mesh);
        std::snprintf(moved, sizeof moved, "%.3f", 100 * loaded.deviation->input_to_result.p99 / r_max);
        std::snprintf(made_up, sizeof made_up, "%.1f", 100 * loaded.deviation->made_up_share);
    }
    std::printf("%-8s %9llu %8s %8s %7.2f  %s%s%s\n", mesh::name_of(loaded.admission),
                static_cast<unsigned long long>(loaded.facts.triangle_count), moved, made_up, seconds, file.c_str(),
                done_to(loaded).empty() ? "" : ": ", done_to(loaded).c_str());
    std::fflush(stdout);
}

int check_folder(const fs::path& folder, const MeshOptions& options, bool json)
{
    const std::vector<fs::path> files = meshes_below(folder);
    const bool shows_progress = ::isatty(STDERR_FILENO) != 0;
    if (!json) std::printf("%-8s %9s %8s %8s %7s  %s\n", "verdict", "faces", "moved %", "made up", "s", "file: what was done");
    std::map<std::string, int> counts;
    for (std::size_t i = 0; i < files.size(); ++i) {
        const std::string file = fs::relative(files[i], folder).string();
        if (shows_progress) std::fprintf(stderr, "\r%zu of %zu %-40.40s\r", i + 1, files.size(), file.c_str());
        const auto start = std::chrono::steady_clock::now();
        const AdmittedMesh loaded = admitted_anyhow(files[i], options);
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        ++counts[mesh::name_of(loaded.admission)];
        if (json) {
            ordered_json line = as_json(file, loaded);
            line["seconds"] = seconds;
            std::printf("%s\n", dumped(line, -1).c_str());
            std::fflush(stdout);
        } else {
            print_row(file, loaded, seconds);
        }
    }
    if (!json) {
        std::printf("%zu files:", files.size());
        for (const auto& [verdict, count] : counts) std::printf(" %s %d", verdict.c_str(), count);
        std::printf("\n");
    }
    return counts["REFUSED"] > 0 || files.empty() ? 2 : 0;
}

}  // namespace

void add_check(CommandLine& line)
{
    struct Options {
        std::string file;
        MeshOptions load;
        bool json = false, collider = false;
    };
    const auto options = std::make_shared<Options>();
    Command command = line.add("check", "Say whether a mesh can be used, what would be repaired, or why not");
    command
        .option("mesh", options->file,
                "OFF, OBJ, STL, PLY, glTF or GLB; with the program assimp also DAE, 3MF, FBX; or a folder of these")
        .required()
        .existing_path();
    command.flag("--json", options->json, "Answer as JSON; of a folder a line for each file");
    command.flag(
        "--collider", options->collider,
        "Say what a hull, a box and a capsule of the mesh would lose as its collider: volume, excess, cavities; of a file");
    add_load_options(command, options->load);
    command.footer("Exit code: 0 usable, 2 refused (of a folder: some file), 64 wrong usage, 70 internal error.");
    command.run([options] {
        if (fs::is_directory(options->file)) {
            if (options->collider) throw WrongUsage("--collider", "is of one mesh: name a file, not a folder");
            return check_folder(options->file, options->load, options->json);
        }
        const AdmittedMesh loaded = admit_mesh(options->file, options->load);
        const bool collides = options->collider && !loaded.refused();
        if (options->json) {
            ordered_json out = as_json(options->file, loaded);
            if (collides) out["colliders"] = colliders_json(loaded);
            std::printf("%s\n", dumped(out, 2).c_str());
        } else {
            print(options->file, loaded);
            if (collides) print_losses(loaded);
        }
        return loaded.refused() ? 2 : 0;
    });
}

}  // namespace sqmap::app
