// sqmap view: models and meshes in the browser, to be looked at and touched.
#include "commands.h"
#include "common/program_words.h"

#ifdef SQMAP_HAVE_VIEWER
#include "sqmap/mesh/error.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/paper/model_file.h"
#include "viewer/server/http/kept_token.h"
#include "viewer/server/http/page.h"
#include "viewer/server/http/server.h"
#include "viewer/server/scene/load.h"
#include "viewer/server/viewer.h"
#endif

#include <csignal>
#include <cstdio>
#include <memory>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace sqmap::app {

#ifdef SQMAP_HAVE_VIEWER
namespace {

struct ViewArguments {
    std::vector<std::string> files;
    std::string projection = "central";
    std::uint16_t port = 0;
    bool open = false;
    viewer::SceneOptions viewer{};
};

std::shared_ptr<viewer::Object> open_file(const std::string& file, const viewer::SceneOptions& options)
{
    if (file.ends_with(".sqmap")) {
        const paper::MappedModel model(file);
        auto object = viewer::object_from_model({model.bytes().begin(), model.bytes().end()}, file, options.size,
                                                viewer::words_beside(file));
        object->names_file = viewer::names_file_of(file);
        return object;
    }
    AdmittedMesh loaded = admit_mesh(file);
    const mesh::Diagnosis& d = loaded.diagnosis;
    if (loaded.refused())
        throw mesh::InvalidInput(file + ": REFUSED " + mesh::name_of(d.code) + " at " + d.element + ": " + d.message +
                                 "\n  cure: " + d.cure.text(k_program_settings));
    std::printf("%s: %s, baking %zu triangles\n", file.c_str(), mesh::name_of(loaded.admission), loaded.mesh.triangles.size());
    std::fflush(stdout);
    return viewer::object_from_mesh(std::move(loaded), std::filesystem::path(file).filename().string(), options.size,
                                    options.bake);
}

/// Shapes to begin with, where no file is given.
std::vector<std::shared_ptr<viewer::Object>> first_shapes(const viewer::SceneOptions& options)
{
    std::vector<std::shared_ptr<viewer::Object>> out;
    const auto add = [&](const char* name, mesh::Mesh mesh) {
        out.push_back(viewer::object_from_mesh(admit_mesh(std::move(mesh)), name, options.size, options.bake));
    };
    add("dumbbell", mesh::dumbbell());
    add("torus", mesh::torus());
    return out;
}

/// Waits for Ctrl-C; whatever ends the server ends both workers and this before the server is gone.
class Ending {
public:
    Ending(viewer::Viewer& content, viewer::Server& server, const sigset_t& signals)
        : content_(content), waiter_([&server, signals] {
              int signal = 0;
              ::sigwait(&signals, &signal);
              server.stop();
          })
    {
    }
    ~Ending()
    {
        content_.finish();
        ::pthread_kill(waiter_.native_handle(), SIGUSR1);  // where no signal ended it
        waiter_.join();
    }
    Ending(const Ending&) = delete;
    Ending& operator=(const Ending&) = delete;

private:
    viewer::Viewer& content_;
    std::thread waiter_;
};

int view(const ViewArguments& arguments)
{
    std::vector<std::shared_ptr<viewer::Object>> objects;
    try {
        for (const std::string& file : arguments.files) objects.push_back(open_file(file, arguments.viewer));
    } catch (const std::runtime_error& e) {  // model files, meshes
        std::fprintf(stderr, "%s\n", e.what());
        return 2;
    }
    if (objects.empty()) objects = first_shapes(arguments.viewer);

    // Taken by this thread alone, before any other is made: the rest inherit the mask.
    sigset_t signals;
    ::sigemptyset(&signals);
    ::sigaddset(&signals, SIGINT);
    ::sigaddset(&signals, SIGTERM);
    ::sigaddset(&signals, SIGUSR1);
    ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    viewer::Viewer content(std::move(objects), arguments.viewer);
    try {
        viewer::Server server(content,
                              {.port = arguments.port, .token = viewer::kept_token(viewer::state_folder(), arguments.port)});
        content.attach(server);
        std::printf("open  %s\n", server.url().c_str());
        if (!viewer::has_page()) std::printf("  this program was built without the page: run ./dev view\n");
        std::printf("  for this machine alone; Ctrl-C ends it\n");
        std::fflush(stdout);
        if (arguments.open && !viewer::open_in_browser(viewer::state_folder(), server.url()))
            std::fprintf(stderr, "no browser was started\n  cure: open the address above by hand\n");
        const Ending ending(content, server, signals);
        server.run();
    } catch (const std::system_error& e) {
        std::fprintf(stderr, "cannot listen on %s\n  cure: another --port, or none for any that is free\n", e.what());
        return 2;
    }
    return 0;
}

}  // namespace
#endif

void add_view(CommandLine& line)
{
    Command command = line.add("view", "Look at models and meshes in the browser, and touch them");
#ifdef SQMAP_HAVE_VIEWER
    const auto arguments = std::make_shared<ViewArguments>();
    command.option("files", arguments->files, "Models (.sqmap) and meshes, which are baked first; none: two shapes to begin with")
        .existing_file();
    command.option("--port", arguments->port,
                   "Port on this machine; 0: any that is free. A named one keeps its address when the program is started anew");
    command.flag("--open", arguments->open, "Open the address in the browser, too");
    command
        .option("--projection", arguments->projection, "Maps of meshes that are baked here: central, or normal: the paper's own")
        .one_of({"central", "normal"});
    command.option("--size", arguments->viewer.size, "R_max, m, that every object is shown and felt at").in_range(0.01, 10.0);
    command.footer(
        "Serves this machine alone, and only the address that it prints. Exit code: 0 ended, 2 a file was refused or the port is "
        "taken, 64 "
        "wrong usage, 70 internal error.");
    command.run([arguments] {
        if (arguments->projection == "normal") arguments->viewer.bake.paper_maps.emplace();
        return view(*arguments);
    });
#else
    const auto files = std::make_shared<std::vector<std::string>>();
    command.option("files", *files, "Models and meshes");
    command.run([files] {
        std::fprintf(stderr, "this program was built without Boost.Beast, which serves the page\n  cure: ./dev view\n");
        return 2;
    });
#endif
}

}  // namespace sqmap::app
