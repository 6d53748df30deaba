#include "app/cli/lens_json.h"

#include <fmt/format.h>

#include "io/lens_terms.h"

namespace gpvc::cli {

const char* lens_model_name(LensModel model) { return name_of(kLensModelNames, model); }

nlohmann::ordered_json lens_json(const Distortion& lens) {
  nlohmann::ordered_json json = {{"model", lens_model_name(lens.model)}};
  for (const LensTerm& term : terms_of(lens.model)) json[term.name] = lens.*term.term;
  return json;
}

std::string lens_text(const Distortion& lens) {
  std::string text;
  for (const LensTerm& term : terms_of(lens.model))
    if (const double value = lens.*term.term; value != 0)
      text += fmt::format("{}{} {:.5g}", text.empty() ? "" : " ", term.name, value);
  return text;
}

}  // namespace gpvc::cli
