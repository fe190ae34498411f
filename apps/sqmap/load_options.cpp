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
    const auto number = [&](const char* name, const char* words) {
        return command.number(option_named(mesh::k_admission_numbers, name), options.admit, words);
    };
    const auto of_wraps = [&](Command to, const char* name, const char* words) {
        to.number(option_named(mesh::k_wrap_numbers, name), options.admit.wrap, words);
    };
    number("gap", "Gaps of an outer solid that are narrower are closed, share of R_max");
    number("max_filled", "Share of the area that fillings may have where a mesh is closed");
    of_wraps(command, "wrap_tolerance",
             "How far a wrapped mesh may be from the file, share of R_max, while --max-wrapped-faces allow it");
    command.flag("--surface", options.admit.accept_surface, "Take an open mesh as a surface without inside");
    number("thickness", "Make open meshes and flat ones, also closed, plates this thick, in units of the result; 0: none");
    // The result is in metres, so that "--unit mm" divides by a thousand.
    command.unit(
        "--unit", [&options](double metres) { options.admit.unit = metres; },
        "The file's unit of length: um, mm, cm, dm, m, km, in, ft or metres per unit; the result is in metres");
    Command limits = command.titled("Limits (beyond them: E_LIMIT)");
    limits.size("--max-bytes", options.limits.max_bytes, "Largest file; also as 500MB or 4GB, of 1024 each");
    limits.option("--max-faces", options.limits.max_faces, "Most faces in the file").above_zero();
    of_wraps(command, "max_wrapped_faces", "Most triangles of a wrapped mesh; wins over the tolerance");
    of_wraps(limits, "max_cells", "Most cells of the grid for wrapping; about 400 bytes each");
    limits.option("--max-cured-faces", options.admit.max_cured_faces, "Most triangles of a mesh that is closed or wrapped")
        .above_zero();
    limits.option("--max-components", options.admit.max_components, "Most connected pieces of the surface").above_zero();
}

}  // namespace sqmap::app
