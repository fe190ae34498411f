// Shapes that stand for a mesh, as subcommands take and print them.
#pragma once

#include "command_line.h"
#include "sqmap/collider/export.h"

namespace sqmap::app {

/// Adds --shape; choice must outlive the parser.
void add_shape_option(Command& command, collider::ShapeChoice& choice);
/// A line for each shape, and one for all.
void print_colliders(const collider::Colliders& colliders);

}  // namespace sqmap::app
