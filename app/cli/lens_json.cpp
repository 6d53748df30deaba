#include "app/cli/lens_json.h"

#include <fmt/format.h>

#include <array>
#include <string_view>

namespace gpvc::cli {
namespace {

struct Term {
  const char* name;
  double value;
};

std::array<Term, 5> first_terms(const Distortion& d) {
  return {{{"k1", d.k1}, {"k2", d.k2}, {"p1", d.p1}, {"p2", d.p2}, {"k3", d.k3}}};
}

std::array<Term, 16> further_terms(const Distortion& d) {
  return {{{"k4", d.k4},
           {"d1", d.d1},
           {"d2", d.d2},
           {"d3", d.d3},
           {"p3", d.p3},
           {"p4", d.p4},
           {"s1", d.s1},
           {"s2", d.s2},
           {"skew", d.skew},
           {"omega", d.omega},
           {"k5", d.k5},
           {"k6", d.k6},
           {"s3", d.s3},
           {"s4", d.s4},
           {"alpha", d.alpha},
           {"beta", d.beta}}};
}

}  // namespace

const char* lens_model_name(LensModel model) {
  constexpr std::array<const char*, 9> kNames{"opencv",         "perspective", "equidistant", "equisolid",  "fov",
                                              "inverse_radial", "division",    "unified",     "fisheye_624"};
  return kNames[static_cast<std::size_t>(model)];
}

nlohmann::ordered_json lens_json(const Distortion& lens) {
  nlohmann::ordered_json json = {{"model", lens_model_name(lens.model)}};
  for (const Term& term : first_terms(lens)) json[term.name] = term.value;
  if (lens.model != LensModel::brown)
    for (const Term& term : further_terms(lens)) json[term.name] = term.value;
  return json;
}

std::string lens_text(const Distortion& lens) {
  std::string text;
  const auto add = [&](const Term& term) {
    if (term.value != 0) text += fmt::format("{}{} {:.5g}", text.empty() ? "" : " ", term.name, term.value);
  };
  for (const Term& term : first_terms(lens)) add(term);
  if (lens.model != LensModel::brown)
    for (const Term& term : further_terms(lens)) add(term);
  return text;
}

}  // namespace gpvc::cli
