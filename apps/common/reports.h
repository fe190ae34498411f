// How figures are printed, the same for bake, info and eval.
#pragma once

#include "sqmap/bake/evaluate.h"
#include "sqmap/model/model_data.h"

#include <nlohmann/json.hpp>

namespace sqmap::app {

[[nodiscard]] nlohmann::ordered_json measured_json(const model::Measured& measured);
[[nodiscard]] nlohmann::ordered_json evaluation_json(const bake::Evaluation& evaluation);
void print_measured(const model::Measured& measured);

}  // namespace sqmap::app
