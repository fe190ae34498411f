// A shape as an element of robot and simulator files.
#pragma once

#include "sqmap/collider/export.h"

#include <string>
#include <string_view>

namespace sqmap::collider {

/// True where URDF has the shape.
[[nodiscard]] constexpr bool is_in_urdf(Kind kind) { return kind == Kind::Box || kind == Kind::Cylinder || kind == Kind::Sphere; }
/// True where MuJoCo and SDFormat have it.
[[nodiscard]] constexpr bool is_primitive(Kind kind) { return kind != Kind::Hull && kind != Kind::Superquadric; }

/// &, <, >, " as entities, and characters that XML forbids as "_".
[[nodiscard]] std::string escaped(std::string_view text);
/// "support excess 0.0012, volume 1.31 of the solid's": for a comment.
[[nodiscard]] std::string words(const Figures& figures);
/// A mesh as OBJ text; coordinates keep every bit. first: of the vertices in the file, from 1.
[[nodiscard]] std::string obj_text(const mesh::Mesh& mesh, std::string_view name, std::size_t first = 1);
/// One object as JSON text: the shape's parameters, and the equation that holds within it.
[[nodiscard]] std::string parameters_json(const Shape& shape, std::string_view name);

}  // namespace sqmap::collider
