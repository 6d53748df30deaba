// Tables 1 to 6 of the paper: how many of the 9604 faces of three models of two layers each mode gets right.
#include <fmt/format.h>

#include <array>
#include <stdexcept>

#include "benchmarks/accuracy.h"
#include "tests/visibility/visibility_scenes.h"

namespace gpvc::accuracy {
namespace {

constexpr std::size_t kLayer = 4802;
constexpr std::array kGaps{0.01, 1.0, 100.0};
constexpr std::array kModels{"A", "B", "C"};

/// Throws unless the upper layer is fully visible and every face of the lower one partially occluded, by the oracle.
void prove(const TrueScene& model) {
  for (std::size_t f = 0; f < 2 * kLayer; ++f) {
    const visibility::FaceClass expected = f < kLayer ? visibility::FaceClass::full : visibility::FaceClass::partial;
    if (model.truth.classes[f] != expected || model.truth.tied[f] != 0)
      throw std::logic_error(fmt::format("model {}: face {} is not what the paper says of it", model.name, f));
  }
}

std::vector<TrueScene> make_models() {
  std::vector<TrueScene> models;
  const View view = scenes::view_of(1000, 1000, 5000);
  for (std::size_t i = 0; i < kGaps.size(); ++i) {
    models.push_back(with_truth(kModels[i], scenes::two_layers(view.camera, kGaps[i]), view));
    prove(models.back());
  }
  return models;
}

std::vector<std::string> columns_of(const std::vector<TrueScene>& models, std::vector<std::string> columns) {
  for (const TrueScene& model : models)
    for (const char* name : {"V", "O", "Ac (%)"}) columns.push_back(fmt::format("{}: {}", model.name, name));
  return columns;
}

void append_score(std::vector<std::string>& row, const Score& s) {
  row.insert(row.end(), {std::to_string(s.visible), std::to_string(s.occluded), fmt::format("{:.2f}", s.percent())});
}

/// One row per epsilon: for each model V, O and Ac.
Table bias_table(const Setup& setup, const std::vector<TrueScene>& models, const std::string& mode_prefix) {
  Table table(columns_of(models, {"epsilon"}));
  for (const double epsilon : epsilons(setup.quick ? 6 : 1)) {
    std::vector<std::string> row{fmt::format("{:.3g}", epsilon)};
    for (const TrueScene& model : models)
      append_score(row, score(setup.device, model, mode(fmt::format("{}:{}", mode_prefix, epsilon))));
    table.add(row);
  }
  return table;
}

struct GpvcTable {
  Table table;
  bool all_right = true;
};

GpvcTable gpvc_table(const Setup& setup, const std::vector<TrueScene>& models,
                     const std::vector<visibility::CoverageCorrection>& corrections) {
  GpvcTable result{Table(columns_of(models, {"correction", "projection"})), true};
  for (const visibility::CoverageCorrection correction : corrections)
    for (const visibility::Projection projection : {visibility::Projection::spc, visibility::Projection::apc}) {
      std::vector<std::string> row{name_of(visibility::kCoverageCorrectionNames, correction),
                                   projection == visibility::Projection::spc ? "SPC" : "APC"};
      for (const TrueScene& model : models) {
        const visibility::PaperGpvc method{.projection = projection, .correction = correction};
        const Score s = score(setup.device, model, {method});
        append_score(row, s);
        result.all_right = result.all_right && s.right == 2 * kLayer && s.wrong_classes == 0;
      }
      result.table.add(row);
    }
  return result;
}

}  // namespace

Part paper_tables(const Setup& setup) {
  const std::vector<TrueScene> models = make_models();
  Part part;
  part.markdown =
      "## Tables 1 to 6 of the paper\n\n"
      "Models A, B, C: two uneven layers of 4802 faces, 0.01, 1 and 100 m apart, seen from 6100 m in 1000 x "
      "1000 pixels.\nThe oracle confirms that the upper layer is fully visible and every face of the lower "
      "one partially occluded,\nwithout a tie. V: faces called fully visible; O: the others; Ac: faces that "
      "are right.\n\n";
  const auto add = [&](int number, const std::string& title, const Table& table) {
    part.markdown += fmt::format("### Table {}. {}\n\n{}\n", number, title, table.markdown());
    if (!setup.folder.empty()) table.write_csv(setup.folder / fmt::format("table{}.csv", number));
  };
  if (!setup.folder.empty())
    write_layers(setup.folder / "figure18.png", drawn(setup.device, models[1], {}),
                 [](std::size_t face) { return face < kLayer; });
  add(1, "Shadow mapping with SPC", bias_table(setup, models, "shadow-map:spc"));
  add(2, "Shadow mapping with APC", bias_table(setup, models, "shadow-map:apc"));
  add(3, "Ray tracing with sparse sampling", bias_table(setup, models, "ray:sparse"));
  add(4, "Ray tracing with dense sampling", bias_table(setup, models, "ray:dense"));
  add(5, "GPVC before coverage correction", gpvc_table(setup, models, {visibility::CoverageCorrection::off}).table);
  const GpvcTable corrected =
      gpvc_table(setup, models, {visibility::CoverageCorrection::paper, visibility::CoverageCorrection::exact});
  add(6, "GPVC after coverage correction", corrected.table);
  part.as_expected = corrected.all_right;
  return part;
}

}  // namespace gpvc::accuracy
