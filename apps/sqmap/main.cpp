#include "commands.h"

#include <csignal>
#include <cstdio>
#include <exception>

int main(int argc, char** argv)
{
#ifdef SIGXFSZ
    // A file that may grow no further is a failed write, which removes what was written, not a reason to die halfway.
    std::signal(SIGXFSZ, SIG_IGN);
#endif
    sqmap::app::CommandLine line("sqmap: certified contact between complex shapes", "sqmap");
    line.footer(
#ifdef SQMAP_MODELS_ONLY
        "This program was built for ./dev demo; ./dev build adds batch, touch, dress, view and devices.\n"
#endif
        "To begin with: sqmap check MESH, sqmap bake MESH -o MODEL.sqmap, sqmap view MODEL.sqmap.\n"
        "Meshes: OFF, OBJ, STL, PLY, glTF, GLB; DAE, 3MF and FBX where the program assimp is installed (Debian: assimp-utils).\n"
        "Each subcommand explains itself: sqmap bake --help.");
    line.version("sqmap " SQMAP_VERSION);
    sqmap::app::add_check(line);
    sqmap::app::add_bake(line);
#ifdef SQMAP_WITH_BATCH
    sqmap::app::add_batch(line);
#endif
    sqmap::app::add_info(line);
    sqmap::app::add_export(line);
    sqmap::app::add_query(line);
    sqmap::app::add_eval(line);
#ifdef SQMAP_WITH_PICTURES
    sqmap::app::add_render(line);
#endif
#ifdef SQMAP_WITH_DEVICES
    sqmap::app::add_rtcheck(line);
#endif
    sqmap::app::add_shapes(line);
#ifdef SQMAP_WITH_DEVICES
    sqmap::app::add_touch(line);
    sqmap::app::add_replay(line);
    sqmap::app::add_devices(line);
#endif
#ifdef SQMAP_WITH_SIM
    sqmap::app::add_dress(line);
#endif
#ifdef SQMAP_WITH_ROBOTS
    sqmap::app::add_urdf(line);
#endif
#ifdef SQMAP_WITH_DEVICES
    sqmap::app::add_view(line);
#endif
    try {
        return line.run(argc, argv);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "sqmap: internal error: %s\n", e.what());
        return 70;
    }
}
