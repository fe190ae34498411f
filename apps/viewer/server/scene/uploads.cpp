// Files that a browser sends: meshes to be baked, models, names of parts.
#include "sqmap/mesh/error.h"
#include "viewer/server/http/routes.h"
#include "viewer/server/scene/file_name.h"
#include "viewer/server/scene/page_words.h"
#include "viewer/server/scene/scene.h"

#include <algorithm>
#include <cstring>

namespace sqmap::viewer {
namespace {

using nlohmann::ordered_json;

/// The reason why a file is refused, as the page shows it.
struct Refusal {
    const char *code, *element;
    std::string message, cure;
};

HttpReply refused(const Refusal& refusal, int status = 200)
{
    return json_reply({{"accepted", false},
                       {"verdict", "REFUSED"},
                       {"code", refusal.code},
                       {"element", refusal.element},
                       {"message", refusal.message},
                       {"cure", refusal.cure}},
                      status);
}

/// Reads a number of the request; a setting that the request leaves empty stays. @throw Refusal outside the setting's range
template <class Options>
void take_setting(std::string_view target, const NumberOption<Options>& setting, Options& options)
{
    std::string_view text = query_value(target, setting.name);
    if (text.empty()) return;
    const std::optional<double> value = take_number(text);
    if (!value || !text.empty() || !setting.range.holds(*value))
        throw Refusal{"E_OPTION", setting.name, "the setting does not take what was given",
                      "give a number " + words(setting.range)};
    setting.set(options, *value);
}

/// The server's options with the choices of the page's dialog, by name in the request: repair (none, safe, close or surface),
/// thickness of sheets, unit (metres per unit of the file), projection (normal: the paper's maps), target_error and max_parts.
/// @throw Refusal at a wrong number
BakeMeshOptions chosen(std::string_view target, const SceneOptions& scene)
{
    BakeMeshOptions out = scene.bake_options(query_value(target, "projection") == "normal");
    out.mesh.limits = scene.limits;
    const std::string_view repair = query_value(target, "repair");
    mesh::AdmitOptions& admit = out.mesh.admit;
    if (repair == "surface") admit.accept_surface = true;
    if (repair == "none") admit.repair = mesh::Repair::None;
    if (repair == "safe") admit.repair = mesh::Repair::Safe;
    if (repair == "close") admit.repair = mesh::Repair::Close;
    for (const char* const name : {"thickness", "unit"})
        take_setting(target, option_named(mesh::k_admission_numbers, name), admit);
    for (const char* const name : {"target_error", "max_parts"})
        take_setting(target, option_named(bake::k_bake_numbers, name), out.bake);
    return out;
}

HttpReply accepted(const char* verdict)
{
    return json_reply({{"accepted", true}, {"verdict", verdict}, {"notes", ordered_json::array()}});
}

}  // namespace

void Scene::upload(HttpRequest request, const Answer& answer)
{
    if (entries_.size() >= options_.max_objects)
        return answer(
            refused({"E_LIMIT", "scene", "the scene holds " + std::to_string(options_.max_objects) + " objects, which is all",
                     "remove an object"},
                    503));
    if (bakes_.busy()) return answer(refused({"E_BUSY", "scene", "other files are being baked", "wait, and send it again"}, 503));
    const std::string name = harmless(query_value(request.target, "name"));
    if (name.ends_with(".names.json")) return answer(take_names(name, request.body));
    BakeMeshOptions options;
    try {
        options = chosen(request.target, options_);
    } catch (const Refusal& wrong) {
        return answer(refused(wrong));
    }
    const Job job{.name = name, .upload = number_of(query_value(request.target, "upload")).value_or(0)};
    bakes_.work([this, answer, job, options, body = std::move(request.body)] {
        if (cancelled_.has(job.upload)) return answer(refused({"E_CANCELLED", "file", "the page took it back", "send it again"}));
        const std::span<const std::byte> bytes = std::as_bytes(std::span(body));
        if (job.name.ends_with(".sqmap"))
            take_model(job, bytes, answer);
        else
            take_mesh(job, admit_mesh(MeshBytes{bytes, job.name}, options.mesh), options, answer);
    });
}

/// Names the parts of the object whose name the file has.
HttpReply Scene::take_names(const std::string& file, const std::string& text)
{
    const std::string stem = file.substr(0, file.size() - std::strlen(".names.json"));
    const auto at =
        std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return harmless(e.object->name) == stem; });
    const std::optional<Words> words = read_names(text);
    if (!words) return refused({"E_NAMES", "file", "this is no file of names", "save one from the page to see what it holds"});
    if (at == entries_.end() || at->object->mesh.triangles.empty())
        return refused({"E_NAMES", "file", "no open object with triangles is called " + stem, "open the object first"});
    set_words(*at, *words);
    return accepted("NAMES");
}

/// Runs on the worker's thread.
void Scene::take_model(const Job& job, std::span<const std::byte> bytes, const Answer& answer)
{
    try {
        // The copy is aligned; the request's body need not be.
        const auto object = object_from_model({bytes.begin(), bytes.end()}, job.name, options_.size);
        answer(accepted("MODEL"));
        audience_.post([this, object, upload = job.upload] { add(object, upload), send(), on_objects(); });
    } catch (const std::runtime_error& e) {
        answer(refused({"E_FORMAT", "file", e.what(), "bake the mesh again with this version"}));
    }
}

/// Runs on the worker's thread.
void Scene::take_mesh(const Job& job, AdmittedMesh loaded, const BakeMeshOptions& options, const Answer& answer)
{
    const mesh::Diagnosis& d = loaded.diagnosis;
    answer(json_reply({{"accepted", !loaded.refused()},
                       {"verdict", mesh::name_of(loaded.admission)},
                       {"code", mesh::name_of(d.code)},
                       {"element", d.element},
                       {"message", d.message},
                       {"cure", d.cure.text(k_page_settings)},
                       {"notes", words(loaded.notes(), k_page_settings)},
                       {"triangles", loaded.mesh.triangles.size()}}));
    if (loaded.refused()) return;
    try {
        const auto object = object_from_mesh(std::move(loaded), job.name, options_.size, watched(options, job));
        audience_.post([this, object, job] {
            if (cancelled_.has(job.upload)) return send_progress(job, "cancelled");
            send_progress(job, "done");
            add(object, job.upload);
            send();
            on_objects();
        });
    } catch (const mesh::Error& e) {
        send_failure(job, e.what());
    }
}

}  // namespace sqmap::viewer
