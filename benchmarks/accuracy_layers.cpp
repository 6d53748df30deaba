// Two layers at gaps, distances and places beyond the paper's: the accuracy of each method with its best bias.
#include <fmt/format.h>

#include <array>
#include <map>

#include "benchmarks/accuracy.h"
#include "tests/visibility/visibility_scenes.h"

namespace gpvc::accuracy {
namespace {

struct Place {
  const char* name;
  WorldPoint centre;
};

// Metres: the origin, easting and northing of a UTM zone, a place on the ellipsoid.
constexpr std::array kPlaces{Place{"0", {0, 0, 0}}, Place{"UTM", {412345.678, 5321987.654, 731.25}},
                             Place{"ECEF", {4177654.321, 855123.456, 4728456.789}}};
constexpr std::array kBiased{"shadow-map:spc", "shadow-map:apc", "ray:sparse", "ray:dense"};

/// The layers of scenes::two_layers, scaled to a distance, turned and moved with the camera to a place of the world.
/// Coordinates round to 1e-9 m at worst there; the oracle works on the rounded ones.
TrueScene layers(double gap_m, double distance_m, const Place& place, bool quick) {
  const int size = quick ? 200 : 300;
  View view = scenes::view_of(size, size, 5.0 * size);
  const Mesh unit = scenes::layers(view.camera, distance_m, gap_m, quick ? 10 : 15);
  view.pose.rotation = scenes::rotation(0.4, -0.3, 0.8);
  view.pose.centre = place.centre;
  const auto& r = view.pose.rotation;
  Mesh mesh{{}, unit.faces};
  for (const WorldPoint& p : unit.positions)
    mesh.positions.push_back({r[0] * p.x + r[3] * p.y + r[6] * p.z + place.centre.x,
                              r[1] * p.x + r[4] * p.y + r[7] * p.z + place.centre.y,
                              r[2] * p.x + r[5] * p.y + r[8] * p.z + place.centre.z});
  return with_truth(fmt::format("{} m, {} m, {}", gap_m, distance_m, place.name), std::move(mesh), view);
}

struct Row {
  std::string gap, distance, place;
  std::size_t faces = 0, full = 0, tied = 0;
  Score exact, paper, none;
  std::array<std::vector<Score>, kBiased.size()> biased;  ///< per epsilon
};

Row measure(const Setup& setup, const TrueScene& scene, const std::vector<double>& tried) {
  Row row;
  row.faces = scene.mesh.faces.size();
  for (std::size_t f = 0; f < row.faces; ++f) {
    row.full += scene.truth.classes[f] == visibility::FaceClass::full;
    row.tied += scene.truth.tied[f];
  }
  row.exact = score(setup.device, scene, {});
  row.paper = score(setup.device, scene, {visibility::PaperGpvc{}});
  row.none = score(setup.device, scene, mode("none"));
  for (std::size_t m = 0; m < kBiased.size(); ++m)
    for (const double epsilon : tried)
      row.biased[m].push_back(score(setup.device, scene, mode(fmt::format("{}:{}", kBiased[m], epsilon))));
  return row;
}

std::size_t best_of(const std::vector<Score>& scores) {
  std::size_t best = 0;
  for (std::size_t e = 1; e < scores.size(); ++e)
    if (scores[e].right > scores[best].right) best = e;
  return best;
}

/// The one epsilon that is right about most faces of all rows together.
std::size_t best_for_all(const std::vector<Row>& rows, std::size_t biased, std::size_t epsilons) {
  std::vector<Score> sums(epsilons);
  for (const Row& row : rows)
    for (std::size_t e = 0; e < epsilons; ++e) sums[e].right += row.biased[biased][e].right;
  return best_of(sums);
}

Table table_of(const std::vector<Row>& rows, const std::vector<double>& tried,
               const std::array<std::size_t, kBiased.size()>& fixed) {
  std::vector<std::string> head{"gap m", "distance m", "offset",     "faces", "full",
                                "tied",  "gpvc exact", "gpvc paper", "none"};
  for (const char* name : kBiased)
    for (const char* what : {" best", " its epsilon", " fixed"}) head.push_back(std::string(name) + what);
  Table table(head);
  const auto percent = [](const Score& s) { return fmt::format("{:.2f}", s.percent()); };
  for (const Row& row : rows) {
    std::vector<std::string> cells{row.gap,
                                   row.distance,
                                   row.place,
                                   std::to_string(row.faces),
                                   std::to_string(row.full),
                                   std::to_string(row.tied),
                                   percent(row.exact),
                                   percent(row.paper),
                                   percent(row.none)};
    for (std::size_t m = 0; m < kBiased.size(); ++m) {
      const std::size_t best = best_of(row.biased[m]);
      cells.push_back(percent(row.biased[m][best]));
      cells.push_back(fmt::format("{:.2g}", tried[best]));
      cells.push_back(percent(row.biased[m][fixed[m]]));
    }
    table.add(cells);
  }
  return table;
}

}  // namespace

Part layer_table(const Setup& setup) {
  const std::vector<double> gaps =
      setup.quick ? std::vector<double>{1, 1e-3, 1e-5} : std::vector<double>{1, 0.1, 0.01, 1e-3, 1e-4, 1e-5};
  const std::vector<double> distances =
      setup.quick ? std::vector<double>{10, 10000} : std::vector<double>{10, 100, 1000, 10000};
  const std::vector<double> tried = epsilons(setup.quick ? 8 : 2);
  std::vector<Row> rows;
  Part part;
  for (const double gap : gaps)
    for (const double distance : distances)
      for (const Place& place : kPlaces) {
        Row row = measure(setup, layers(gap, distance, place, setup.quick), tried);
        row.gap = fmt::format("{}", gap);
        row.distance = fmt::format("{}", distance);
        row.place = place.name;
        part.as_expected = part.as_expected && row.exact.wrong_classes == 0;
        rows.push_back(std::move(row));
      }
  std::array<std::size_t, kBiased.size()> fixed{};
  std::string words;
  for (std::size_t m = 0; m < kBiased.size(); ++m) {
    fixed[m] = best_for_all(rows, m, tried.size());
    words += fmt::format("{}{}:{:.2g}", m == 0 ? "" : ", ", kBiased[m], tried[fixed[m]]);
  }
  const Table table = table_of(rows, tried, fixed);
  if (!setup.folder.empty()) table.write_csv(setup.folder / "layers.csv");
  part.markdown = fmt::format(
      "## Layers closer, nearer and further, at offsets of the world\n\n"
      "Two layers, the lower one partially occluded wherever the upper one is not; faces right in percent, "
      "by the oracle.\nEvery mode with a bias stands twice: at the epsilon that is best for the row, out of "
      "{} from {:.2g} to {:.2g},\nand at the one that is best for the whole table ({}).\n\n{}\n",
      tried.size(), tried.front(), tried.back(), words, table.markdown());
  return part;
}

}  // namespace gpvc::accuracy
