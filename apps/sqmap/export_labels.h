// sqmap export --labels: which part of a model each polygon of its mesh file belongs to.
#pragma once

#include "command_line.h"
#include "sqmap/bake_mesh.h"

#include <string>

namespace sqmap::app {

struct LabelOptions {
    bool wanted = false;
    std::string mesh;
    MeshOptions load;
};

/// Adds --labels, --mesh and the options of reading it; options must outlive the parser.
void add_label_options(Command& command, LabelOptions& options);

/// Writes a line for each polygon of the mesh file, in its order: the number of its named part, -1 where admission dropped the
/// polygon. Returns the program's exit code. @throw io::ModelFileError where the model is none or the file cannot be written
[[nodiscard]] int write_labels(const std::string& model, const std::string& output, const LabelOptions& options);

}  // namespace sqmap::app
