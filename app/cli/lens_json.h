// A camera's lens for views.json.
#pragma once

#include <nlohmann/json.hpp>

#include "io/scene.h"

namespace gpvc::cli {

/// "opencv" for the five terms alone, else the model's name in scene.h.
const char* lens_model_name(LensModel model);

/// The model and its terms: the five of OpenCV always, the others where the model has them.
nlohmann::ordered_json lens_json(const Distortion& lens);

/// "k1 -0.1 p2 0.003": the terms that are not zero; "" for none.
std::string lens_text(const Distortion& lens);

}  // namespace gpvc::cli
