// Scores against the truth as a table and as JSON.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/evaluate/truth_score.h"

namespace gpvc::evaluate {
namespace {

std::string origin_table(const OriginScore& score) {
  std::string table = fmt::format("\n{:<24}{:^44}{:^30}{:^21}\n{:<24}{:>10}{:>10}{:>12}{:>12}{:>15}{:>15}{:>12}{:>9}\n",
                                  "by the photos' pixels", "of the area seen", "of the area hidden", "of both", "",
                                  "a photo's", "right", "wrong", "edge", "a photo's", "ghost", "foreign", "faithful");
  const auto line = [&](const char* name, const OriginShares& s) {
    table +=
        fmt::format("{:<24}{:>8.3f} %{:>8.3f} %{:>10.4f} %{:>10.3f} %{:>13.3f} %{:>13.4f} %{:>10.4f} %{:>7.3f} %\n",
                    name, 100 * s.photo, 100 * s.right, 100 * s.wrong, 100 * s.edge, 100 * s.hidden_photo,
                    100 * s.ghost, 100 * s.foreign, 100 * s.faithful);
  };
  line("all", score.all);
  line("seen whole by a view", score.full);
  line("seen only in parts", score.partial);
  line("seen by none", score.none);
  if (score.all.unmodelled > 0)
    table += fmt::format("{:.4f} % of the area seen shows what the mesh lacks\n", 100 * score.all.unmodelled);
  if (score.all.unknown > 0)
    table += fmt::format("{:.2f} % of the area seen comes from photos that are not known\n", 100 * score.all.unknown);
  return table;
}

}  // namespace

std::string truth_table(const TruthScore& score, const OriginScore* origins) {
  std::string table =
      "faces                     count  textured   of all area, seen   of that textured   wrong   unexplained   "
      "undetectable\n";
  const auto percent = [](double share) { return 100 * share; };
  const auto line = [&](const char* name, std::size_t faces, std::size_t textured, const TruthShares& s) {
    table += fmt::format("{:<22}{:>9}{:>10}{:>18.2f} %{:>16.2f} %{:>7.3f} %{:>11.3f} %{:>12.1f} %\n", name, faces,
                         textured, score.all.area > 0 ? percent(s.seen_area / score.all.area) : 0, percent(s.textured),
                         percent(s.wrong), percent(s.unexplained), percent(s.undetectable));
  };
  line("all", score.faces[0] + score.faces[1] + score.faces[2],
       score.textured[0] + score.textured[1] + score.textured[2], score.all);
  line("seen whole by a view", score.faces[0], score.textured[0], score.full);
  line("seen only in parts", score.faces[1], score.textured[1], score.partial);
  table += fmt::format("{:<22}{:>9}{:>10}\n", "seen by none", score.faces[2], score.textured[2]);
  const TruthLight& light = score.light;
  if (light.places > 0)
    table += fmt::format(
        "Off the true light, but for one gain of the whole: brightness by {:.1f} % at worst, {:.1f} % in 95 % of the "
        "places; tint "
        "{:.1f} %, {:.1f} %\n",
        percent(light.brightness_worst), percent(light.brightness_95), percent(light.tint_worst),
        percent(light.tint_95));
  return origins == nullptr ? table : table + origin_table(*origins);
}

Json shares_json(const TruthShares& s) {
  return {{"area", s.area},
          {"seen_area", s.seen_area},
          {"textured", s.textured},
          {"wrong", s.wrong},
          {"unexplained", s.unexplained},
          {"undetectable", s.undetectable},
          {"right", s.textured * (1 - s.wrong)}};
}

Json light_json(const TruthLight& light) {
  return {{"places", light.places},
          {"brightness_worst", light.brightness_worst},
          {"brightness_95", light.brightness_95},
          {"tint_worst", light.tint_worst},
          {"tint_95", light.tint_95}};
}

Json shares_json(const OriginShares& s) {
  return {{"seen_area", s.seen_area},
          {"photo", s.photo},
          {"filled", 1 - s.photo},
          {"right", s.right},
          {"wrong", s.wrong},
          {"edge", s.edge},
          {"unmodelled", s.unmodelled},
          {"unknown", s.unknown},
          {"hidden_area", s.hidden_area},
          {"hidden_photo", s.hidden_photo},
          {"ghost", s.ghost},
          {"foreign", s.foreign},
          {"faithful", s.faithful}};
}

}  // namespace gpvc::evaluate
