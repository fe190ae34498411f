#include "load_options.h"

#include <map>
#include <string>

namespace sqmap::app {

void add_load_options(Command& command, MeshOptions& options)
{
    const std::map<std::string, mesh::Repair> repairs{{"auto", mesh::Repair::Wrap},
                                                      {"none", mesh::Repair::None},
                                                      {"safe", mesh::Repair::Safe},
                                                      {"close", mesh::Repair::Close},
                                                      {"wrap", mesh::Repair::Wrap}};
    command.choice("--repair", options.admit.repair, repairs,
                   "The last rung that may be tried: nothing, what leaves no doubt, closing, wrapping; auto: all",
                   "auto|none|safe|close|wrap");
    command.choice(
        "--solid", options.admit.solid,
        std::map<std::string, mesh::SolidKind>{{"as-is", mesh::SolidKind::AsIs}, {"outer", mesh::SolidKind::Outer}},
        "What the surface bounds, or a body about all of it: what cannot be reached from outside, proven to hold every "
        "triangle",
        "as-is|outer");
    command.option("--gap", options.admit.gap, "Gaps of an outer solid that are narrower are closed, share of R_max")
        .in_range(0, 0.2);
    command.option("--max-filled", options.admit.max_filled, "Share of the area that fillings may have where a mesh is closed")
        .in_range(0, 1);
    command
        .option("--wrap-tolerance", options.admit.wrap.tolerance,
                "How far a wrapped mesh may be from the file, share of R_max, while --max-wrapped-faces allow it")
        .in_range(1.6e-3, 0.1);
    command.flag("--surface", options.admit.accept_surface, "Take an open mesh as a surface without inside");
    command
        .option("--thickness", options.admit.thickness,
                "Make open meshes and flat ones, also closed, plates this thick, in units of the result")
        .above_zero()
        .shows_default("");
    // The result is in metres, so that "--unit mm" divides by a thousand.
    command.unit(
        "--unit", [&options](double metres) { options.admit.unit = metres; },
        "The file's unit of length: um, mm, cm, dm, m, km, in, ft or metres per unit; the result is in metres");
    Command limits = command.titled("Limits (beyond them: E_LIMIT)");
    limits.size("--max-bytes", options.limits.max_bytes, "Largest file; also as 500MB or 4GB, of 1024 each");
    limits.option("--max-faces", options.limits.max_faces, "Most faces in the file").above_zero();
    command
        .option("--max-wrapped-faces", options.admit.wrap.max_triangles,
                "Most triangles of a wrapped mesh; wins over the tolerance")
        .in_range(100, 1e9);
    limits.option("--max-cells", options.admit.wrap.max_cells, "Most cells of the grid for wrapping; about 400 bytes each")
        .in_range(10000, 1e9);
    limits.option("--max-cured-faces", options.admit.max_cured_faces, "Most triangles of a mesh that is closed or wrapped")
        .above_zero();
    limits.option("--max-components", options.admit.max_components, "Most connected pieces of the surface").above_zero();
}

}  // namespace sqmap::app
