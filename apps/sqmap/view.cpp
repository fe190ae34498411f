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

#include <atomic>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <functional>
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

using Maker = std::function<std::shared_ptr<viewer::Object>(const BakeMeshOptions&)>;

/// @throw std::runtime_error where the file is refused
std::shared_ptr<viewer::Object> open_file(const std::string& file, double size, const BakeMeshOptions& options)
{
    if (file.ends_with(".sqmap")) {
        const paper::MappedModel model(file);
        auto object =
            viewer::object_from_model({model.bytes().begin(), model.bytes().end()}, file, size, viewer::words_beside(file));
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
    return viewer::object_from_mesh(std::move(loaded), std::filesystem::path(file).filename().string(), size, options);
}

/// The files, or shapes to begin with where there are none.
std::vector<Maker> makers_of(const ViewArguments& arguments)
{
    std::vector<Maker> out;
    const double size = arguments.viewer.size;
    for (const std::string& file : arguments.files)
        out.emplace_back([file, size](const BakeMeshOptions& options) { return open_file(file, size, options); });
    if (!out.empty()) return out;
    for (const bool is_torus : {false, true})
        out.emplace_back([is_torus, size](const BakeMeshOptions& options) {
            return viewer::object_from_mesh(admit_mesh(is_torus ? mesh::torus() : mesh::dumbbell()),
                                            is_torus ? "torus" : "dumbbell", size, options);
        });
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
    // Taken by this thread alone, before any other is made: the rest inherit the mask.
    sigset_t signals;
    ::sigemptyset(&signals);
    ::sigaddset(&signals, SIGINT);
    ::sigaddset(&signals, SIGTERM);
    ::sigaddset(&signals, SIGUSR1);
    ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    viewer::Viewer content({}, arguments.viewer);
    std::atomic<bool> refused = false;
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
        // Reading and baking may take minutes, so the address is printed first and the page shows the progress.
        content.load(makers_of(arguments), [&](const std::string& why) {
            std::fprintf(stderr, "%s\n", why.c_str());
            refused = true;
            server.stop();
        });
        server.run();
    } catch (const std::system_error& e) {
        std::fprintf(stderr, "cannot listen on %s\n  cure: another --port, or none for any that is free\n", e.what());
        return 2;
    }
    return refused ? 2 : 0;
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
    const auto files = std::make_shared<std::vector<std::string> >();
    command.option("files", *files, "Models and meshes");
    command.run([files] {
        std::fprintf(stderr, "this program was built without Boost.Beast, which serves the page\n  cure: ./dev view\n");
        return 2;
    });
#endif
}

}  // namespace sqmap::app
