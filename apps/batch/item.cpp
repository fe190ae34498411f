#include "batch/item.h"

#include "batch/child.h"
#include "batch/manifest.h"
#include "batch/text.h"
#include "common/program_words.h"
#include "common/render/pictures.h"
#include "sqmap/io/model_file.h"
#include "sqmap/io/read.h"
#include "sqmap/model/model.h"
#include "sqmap/paper/model_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>
#include <vector>

namespace sqmap::batch {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

std::string_view text_of(std::span<const std::byte> bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

/// Reads a regular file; returns the fault where that is not possible. Never waits, as opening a pipe would.
std::optional<Fault> read_file(const fs::path& path, std::uint64_t max_bytes, std::vector<std::byte>& out)
{
    const auto fault = [](const char* code, const std::string& why, const char* cure) { return Fault{code, "file", why, cure}; };
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    if (!file) return fault("E_FILE", errno == ENOENT ? io::k_no_file : std::strerror(errno), "mend the path, or leave it out");
    struct stat info {};
    if (::fstat(file.get(), &info) != 0 || !S_ISREG(info.st_mode))
        return fault("E_FILE", "it is not a file", "name a mesh, or a folder as the manifest");
    const auto size = static_cast<std::uint64_t>(info.st_size);
    if (size > max_bytes)
        return fault("E_LIMIT", "it has " + std::to_string(size) + " bytes, at most " + std::to_string(max_bytes) + " are read",
                     "raise --max-bytes");
    out.resize(size);
    for (std::size_t at = 0; at < size;) {
        const ssize_t n = ::pread(file.get(), out.data() + at, size - at, static_cast<off_t>(at));
        if (n <= 0 && !(n < 0 && errno == EINTR)) return fault("E_FILE", "it cannot be read to its end", "get the whole file");
        at += static_cast<std::size_t>(std::max<ssize_t>(n, 0));
    }
    return std::nullopt;
}

void say(int channel, const std::string& line)
{
    if (!write_all(channel, line + "\n")) ::_exit(1);
}

/// Draws the model that output holds, as a PNG; empty where there is nothing to draw.
std::string drawn(const mesh::Mesh& mesh, int output)
try {
    paper::MappedModel model("/proc/self/fd/" + std::to_string(output));
    const bool has_triangles = model::has_exact(model.view());
    const app::Subject subject = app::subject_of_model(std::move(model), has_triangles ? nullptr : &mesh);
    // One thread, because the driver starts a process for each core. Few sky rays, because 96 rays a vertex take a quarter of the
    // time in which a large mesh is baked.
    app::View view{.width = 160, .height = 120, .samples = 2, .sky_rays = 16, .threads = 1};
    view.azimuth = app::broad_azimuth(subject.mesh, view.up);
    return app::png_bytes(app::parts_picture(subject, view));
} catch (const std::invalid_argument&) {
    return {};
}

/// The outcome of a bake, and the picture that follows the model in the output.
struct Baked {
    ordered_json outcome;
    std::size_t model_size = 0;
    std::string sha256, picture;
};

ordered_json baked_outcome(const BakedModel& baked, std::size_t bytes)
{
    ordered_json out;
    out["verdict"] = lower(mesh::name_of(baked.mesh.admission));
    out["format"] = baked.mesh.format;
    out["notes"] = words(baked.notes, app::k_program_settings);
    out["moved"] = ordered_json::parse(io::cure_json(baked.model.common.cure));
    out["triangles"] = baked.model.common.header.triangle_count;
    out["r_max"] = baked.model.common.header.r_max * baked.model.common.header.unit;
    out["parts"] = baked.report.parts.size();
    out["bytes"] = bytes;
    out["target_met"] = baked.report.target_met;
    out["doubtful"] = model::is_doubtful(baked.model.common.measured);
    out["measured"] = ordered_json::parse(io::measured_json(baked.model.common.measured));
    return out;
}

Baked refused(const Fault& fault)
{
    return {.outcome = ordered_json::parse(batch::outcome_of("refused", fault).text), .sha256 = sha256(""), .picture = ""};
}

Baked baked(const Source& source, const Settings& settings, int output)
{
    const MeshInput input = source.bytes ? MeshInput(MeshBytes{*source.bytes, source.file.string()}) : MeshInput(source.file);
    const BakedModel result = bake_mesh(input, settings.bake);
    const std::vector<std::byte> model = result.bytes();
    if (!write_all(output, text_of(model))) end_for_output();
    return {baked_outcome(result, model.size()), model.size(), sha256(text_of(model)),
            settings.pictures ? drawn(result.mesh.mesh, output) : ""};
}

Baked baked_or_refused(const Source& source, const Settings& settings, int output)
{
    try {
        return baked(source, settings, output);
    } catch (const mesh::RefusedMesh& e) {
        const mesh::Diagnosis& d = e.diagnosis();
        return refused({mesh::name_of(d.code), d.element, d.message, d.cure.text(app::k_program_settings)});
    } catch (const mesh::Error& e) {
        return refused({"E_BAKE", "mesh", e.what(), "report it, with the file"});
    }
}

}  // namespace

std::string key_of(std::span<const std::byte> bytes, const Source& source, const Settings& settings)
{
    const std::string ending = lower(source.file.extension().string());
    std::string all = "sqmap batch 1\n" + settings.bake.provenance.made_by + "\n" + settings.options + "\n" + ending + "\n";
    all += sha256(text_of(bytes));
    if (ending == ".gltf" && !source.bytes) {
        for (const fs::path& beside : io::buffers_beside(bytes, source.file.parent_path())) {
            std::vector<std::byte> buffer;
            if (!read_file(beside, settings.bake.mesh.limits.max_bytes, buffer)) all += sha256(text_of(buffer));
        }
    }
    return sha256(all);
}

void bake_item(const Source& source, const Settings& settings, int channel, int output)
{
    std::vector<std::byte> read;
    if (!source.bytes) {
        if (const auto fault = read_file(source.file, settings.bake.mesh.limits.max_bytes, read)) {
            say(channel, k_unreadable + batch::outcome_of("unreadable", *fault).text);
            return;
        }
    }
    say(channel, k_key + key_of(source.bytes ? *source.bytes : read, source, settings));
    read = {};
    char answer = k_skip;
    if (::read(channel, &answer, 1) != 1 || answer != k_go) return;

    const Baked made = baked_or_refused(source, settings, output);
    const std::string outcome = dumped(made.outcome);
    if (!write_all(output, made.picture) || !write_all(output, outcome)) end_for_output();
    say(channel, k_done + std::to_string(made.model_size) + " " + std::to_string(made.picture.size()) + " " +
                     std::to_string(outcome.size()) + " " + made.sha256);
}

}  // namespace sqmap::batch
