#include "commands.h"

#include <csignal>
#include <cstdio>
#include <exception>

int main(int argc, char** argv)
{
    // A file that may grow no further is a failed write, which removes what was written, not a reason to die halfway.
    std::signal(SIGXFSZ, SIG_IGN);
    CLI::App app{"sqmap: certified contact between complex shapes"};
    app.set_version_flag("--version", "sqmap " SQMAP_VERSION);
    app.require_subcommand(1);
    int exit_code = 0;
    sqmap::app::add_check(app, exit_code);
    sqmap::app::add_bake(app, exit_code);
    sqmap::app::add_info(app, exit_code);
    sqmap::app::add_query(app, exit_code);
    sqmap::app::add_eval(app, exit_code);
    sqmap::app::add_render(app, exit_code);
    sqmap::app::add_rtcheck(app, exit_code);
    sqmap::app::add_shapes(app, exit_code);
    sqmap::app::add_touch(app, exit_code);
    sqmap::app::add_replay(app, exit_code);
    sqmap::app::add_devices(app, exit_code);
#ifdef SQMAP_WITH_SIM
    sqmap::app::add_dress(app, exit_code);
#endif
    sqmap::app::add_view(app, exit_code);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? 0 : 64;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "sqmap: internal error: %s\n", e.what());
        return 70;
    }
    return exit_code;
}
