#include "touch/page_replay.h"

#include "common/hash_text.h"
#include "io/files.h"
#include "touch/options.h"

#ifdef SQMAP_HAVE_VIEWER
#include "viewer/server/scene/load.h"
#include "viewer/server/touch/recording_file.h"
#endif

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace sqmap::app {

bool is_of_page(const device::TraceHeader& header) { return header.find("page").has_value(); }

#ifdef SQMAP_HAVE_VIEWER
namespace {

using viewer::RecordingFile;

std::vector<std::filesystem::path> model_files(const ReplayArguments& arguments)
{
    std::vector<std::filesystem::path> out(arguments.models.begin(), arguments.models.end());
    if (!out.empty()) return out;
    const std::filesystem::path folder = std::filesystem::absolute(arguments.trace).parent_path();
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (entry.path().extension() == ".sqmap") out.push_back(entry.path());
    std::sort(out.begin(), out.end());  // the order of a folder is chance
    return out;
}

/// @throw BadTouch, io::ModelFileError
std::shared_ptr<viewer::Object> object_of(const std::filesystem::path& file)
{
    const paper::MappedModel model(file);
    try {
        return viewer::object_from_model({model.bytes().begin(), model.bytes().end()}, file.string(), 1);
    } catch (const std::runtime_error& e) {
        throw BadTouch(e.what());
    }
}

/// The file whose model has that content; empty where none has it.
std::filesystem::path file_of(const RecordingFile::NamedObject& object, const std::vector<std::filesystem::path>& files,
                              bool named)
{
    for (const std::filesystem::path& file : files) {
        try {
            if (paper::content_hash(paper::MappedModel(file).view()) == object.hash) return file;
        } catch (const io::ModelFileError&) {
            if (named) throw;  // beside a recording any file may lie
        }
    }
    return {};
}

std::vector<viewer::ObjectPtr> objects_of(const RecordingFile& recording, const ReplayArguments& arguments)
{
    const std::vector<std::filesystem::path> files = model_files(arguments);
    std::vector<viewer::ObjectPtr> out;
    for (const RecordingFile::NamedObject& named : recording.objects) {
        // Another model takes the first object's position at its scale.
        const bool other = out.empty() && !arguments.against.empty();
        const std::filesystem::path file =
            other ? std::filesystem::path(arguments.against) : file_of(named, files, !arguments.models.empty());
        if (file.empty())
            throw BadTouch(arguments.trace + ": it is a recording of " + named.name + " (model " + hash_text(named.hash) +
                           "), which is not " +
                           (arguments.models.empty() ? "among the .sqmap files beside it" : "among the files of --model") +
                           "\n  cure: save " + named.name +
                           ".sqmap by Export in the page, or bake its mesh as then, and name it: --model " + named.name +
                           ".sqmap");
        const std::shared_ptr<viewer::Object> object = object_of(file);
        object->put_at(named.metres_per_unit, named.position, named.up);
        out.push_back(object);
    }
    return out;
}

}  // namespace

Replayed replay_page(const ReplayArguments& arguments, bool rows, Comparison* computed)
{
    const RecordingFile file = viewer::read_recording(io::text_of_file(arguments.trace).value_or(""), arguments.trace);
    const std::vector<viewer::ObjectPtr> objects = objects_of(file, arguments);
    Replayed out;
    viewer::Recording recording;
    for (std::size_t i = 0; i < file.takes.size(); ++i) {
        viewer::Take& take = *file.takes[i];
        for (const std::uint32_t number : file.objects_of[i])
            take.objects.push_back(number == viewer::k_hidden_object ? nullptr : objects[number]);
        out.dropped += take.lost;
        recording.push_back(file.takes[i]);
    }
    device::TraceReader reader(arguments.trace);  // for the lines and times of the rows
    device::TraceRow row;
    if (rows) print_difference_head();
    (void)viewer::compute_again(
        recording, {}, {}, [&](const viewer::Take::Tick& tick, const haptic::Wrench& wrench, double depth) {
            (void)reader.next(row);
            ++out.ticks;
            const double was = norm(tick.commanded.force), is = norm(wrench.force), torque = norm(wrench.torque);
            if (computed != nullptr) {
                computed->depth.push_back(depth);
                computed->force.push_back(is);
                computed->torque.push_back(torque);
            }
            for (int i = 0; i < 3; ++i) {
                out.mix(wrench.force[i]);
                out.mix(wrench.torque[i]);
            }
            device::TraceRow again = row;
            again.computed[0] = wrench;
            again.depth = depth;
            if (device::same_bits(row, again, 1)) return;
            add_difference(out,
                           {.line = reader.line(),
                            .time = row.time,
                            .columns = device::differences(row, again, 1),
                            .depth = {tick.depth, depth},
                            .force = {was, is},
                            .force_apart = norm(wrench.force - tick.commanded.force),
                            .torque_apart = norm(wrench.torque - tick.commanded.torque)},
                           rows);
        });
    out.complete = !reader.next(row) && reader.complete();
    return out;
}
#else
Replayed replay_page(const ReplayArguments& arguments, bool, Comparison*)
{
    throw BadTouch(arguments.trace +
                   " is a recording of the page, which this program was built without (no Boost.Beast)\n  cure: "
                   "apt-get install libboost-dev, build again");
}
#endif

}  // namespace sqmap::app
