#include "commands.h"
#include "common/layer_name.h"
#include "common/reports.h"
#include "load_options.h"
#include "model_mesh.h"
#include "sqmap/bake/evaluate.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/paper/bake.h"
#include "sqmap/paper/model_file.h"

#include <cstdio>
#include <memory>
#include <optional>
#include <string>

namespace sqmap::app {
namespace {

void print_distribution(const char* name, const bake::Distribution& d, const char* unit)
{
    std::printf("  %-12s mean %.4f  median %.4f  p95 %.4f  p99 %.3f  max %.2f %s (%u)\n", name, d.mean, d.median, d.p95, d.p99,
                d.max, unit, d.count);
}

void print(const char* layer, const bake::Evaluation& e)
{
    std::printf("layer %s on %u points, %u inside: %u missed, %u false beyond the band (%u and %u at any distance)\n", layer,
                e.points, e.inside, e.missed, e.false_contacts, e.missed_any, e.false_any);
    std::printf("  certain %u, of them wrong %u, contradicted by layers 2 or 3 %u; layer 1 missed %u\n", e.certain,
                e.certain_wrong, e.contradictions, e.layer1_missed);
    print_distribution("eq. 35", e.eq35, "% of R_max");
    std::printf(
        "               left out %.2f %% (no crossing of map and mesh both on the ray), %.2f %% because only one has one\n",
        e.eq35_left_out, e.eq35_one_sided);
    print_distribution("depth", e.depth, "% of R_max");
    if (e.no_surface > 0)
        std::printf("               none of %.2f %% of the contacts: no map shows the surface above\n", e.no_surface);
    print_distribution("normal", e.normal, "degrees");
}

struct EvalArguments {
    std::string model, mesh, layer = "all";
    bake::EvaluateOptions evaluate;
    MeshOptions load;
    bool json = false;
};

/// mesh: model space.
void measure(const model::ModelView& m, const mesh::Mesh& mesh, const EvalArguments& o)
{
    const mesh::Solid solid(mesh, mesh::find_self_intersections(mesh).crossed);
    nlohmann::ordered_json out;
    for (const query::Layer layer : {query::Layer::Two, query::Layer::Three, query::Layer::Exact}) {
        const std::string name(layer_name(layer));
        if (o.layer != "all" && o.layer != name) continue;
        if (layer == query::Layer::Exact && !model::has_exact(m)) continue;
        bake::EvaluateOptions evaluate = o.evaluate;
        evaluate.layer = layer;
        if (layer == query::Layer::Exact) evaluate.verdict_band = 1e-5;
        const bake::Evaluation e = paper::evaluate(m, solid, evaluate);
        if (o.json)
            out["layer"][name] = evaluation_json(e);
        else
            print(name.c_str(), e);
    }
    const bake::Containment containment = bake::check_containment(m, mesh);
    if (o.json) {
        out["containment"] = {
            {"certified_parts", containment.certified}, {"parts", m.parts.size()}, {"triangles_outside", containment.outside}};
        std::printf("%s\n", out.dump(2).c_str());
    } else {
        std::printf(
            "containment: %u of %zu parts certified (every triangle and cap within its superquadric), %u triangles outside\n",
            containment.certified, m.parts.size(), containment.outside);
    }
}

int run(const EvalArguments& o)
{
    const paper::MappedModel file(o.model);
    const std::optional<AdmittedMesh> mesh = mesh_of_model(file.view(), o.model, o.mesh, o.load);
    if (!mesh) return 2;
    measure(file.view(), bake::model_space(mesh->mesh), o);
    return 0;
}

}  // namespace

void add_eval(CommandLine& line)
{
    const auto options = std::make_shared<EvalArguments>();
    Command command = line.add("eval", "Measure a model against its mesh with an exact oracle");
    command.option("model", options->model, "Model (.sqmap)").required().existing_file();
    command.option("mesh", options->mesh, "The mesh it was baked from").required().existing_file();
    command.option("--layer", options->layer, "2, 3, exact, or all").one_of({"2", "3", "exact", "all"});
    command.option("--points", options->evaluate.points, "Sample points: 3/4 within 4 % of R_max of the surface, 1/4 in the box")
        .in_range(1, 100000000);
    command.option("--seed", options->evaluate.seed, "Seed of the sample");
    command.flag("--json", options->json, "Answer as JSON");
    add_load_options(command, options->load);
    command.footer("Exit code: 0 measured, 2 bad model or mesh, 64 wrong usage, 70 internal error.");
    command.run<io::ModelFileError>([options] { return run(*options); });
}

}  // namespace sqmap::app
