// Contents of a model as JSON text, for reports and other programs.
// Pure functions: any number of threads.
#pragma once

#include "sqmap/model/model.h"

#include <cstddef>
#include <string>

namespace sqmap::io {

/// Format, hashes, parts with superquadric and certificate, bytes by section, cure, measured error; two spaces a level. As
/// `sqmap info --json` prints it. total: bytes of the model's file. @throw std::bad_alloc
[[nodiscard]] std::string model_json(const model::ModelView& view, std::size_t total);

/// The figures that bake measured, one object. @throw std::bad_alloc
[[nodiscard]] std::string measured_json(const model::Measured& measured);

/// How the mesh was made a solid, one object; "null" if it was taken unchanged. @throw std::bad_alloc
[[nodiscard]] std::string cure_json(const model::Cure& cure);

}  // namespace sqmap::io
