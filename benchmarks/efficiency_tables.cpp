// The efficiency tables of the paper as text.
#include <fmt/format.h>

#include "benchmarks/efficiency.h"
#include "benchmarks/table.h"

namespace gpvc::efficiency {
namespace {

using Cells = std::vector<std::string>;

std::string seconds(double s) { return fmt::format("{:.3f}", s); }

/// The paper's columns, then the parts of the time, then the comparison with the first row of the run.
const Cells kTimes{"Processed face number",
                   "Sampling count",
                   "Rays",
                   "Time consumption (s)",
                   "Start (s)",
                   "IVM (s)",
                   "Upload (s)",
                   "Read back (s)",
                   "Build (s)",
                   "Classification (s)",
                   "Shaders (s)",
                   "Claims (s)",
                   "Per view (s)",
                   "CPU time (s)",
                   "x GPVC",
                   "CPU x GPVC",
                   "Faces unlike GPVC"};

Cells times(const Measured& m, const Measured& gpvc, std::size_t views) {
  const visibility::VisibilityStatistics& s = m.sum;
  return {std::to_string(s.processed_faces),
          std::to_string(s.samples),
          std::to_string(s.rays),
          seconds(m.total_s),
          seconds(m.start_s),
          seconds(s.render_s),
          seconds(s.upload_s),
          seconds(s.readback_s),
          seconds(s.build_s),
          seconds(s.classify_s),
          seconds(s.shader_s),
          seconds(s.claims_s),
          seconds(m.total_s / static_cast<double>(views)),
          seconds(m.cpu_s),
          fmt::format("{:.2f}", m.total_s / gpvc.total_s),
          fmt::format("{:.2f}", m.cpu_s / gpvc.cpu_s),
          std::to_string(m.unlike_first)};
}

Cells shadow_map_head(const Measured& m) {
  const auto& method = std::get<visibility::ShadowMap>(m.row.options.method);
  return {method.projection == visibility::Projection::spc ? "SPC" : "APC", fmt::format("{}", method.epsilon)};
}

Cells ray_head(const Measured& m) {
  const auto& method = std::get<visibility::RayTracing>(m.row.options.method);
  return {method.sampling == visibility::RaySampling::sparse ? "Sparse Sampling" : "Dense Sampling",
          fmt::format("{}", method.epsilon)};
}

Cells gpvc_head(const Measured& m) {
  constexpr const char* kSamplings[] = {"HIVERS", "VES", "Dense Sampling"};
  const GpvcRow row = gpvc_row(m.row.options.method);
  return {kSamplings[static_cast<std::size_t>(row.sampling)], row.correction, m.drawing, m.processor};
}

Cells no_test_head(const Measured&) { return {"none"}; }

template <class... Methods>
bool is_one_of(const visibility::Method& method) {
  return (std::holds_alternative<Methods>(method) || ...);
}

struct Layout {
  bool (*contains)(const visibility::Method&);
  const char* name;
  const char* title;
  Cells head;
  Cells (*cells)(const Measured&);
};

}  // namespace

void print_tables(const BenchScene& scene, const std::vector<Measured>& measured, const std::filesystem::path& folder) {
  const Layout layouts[] = {{is_one_of<visibility::ShadowMap>,
                             "table7",
                             "Table 7. Efficiency statistics of the shadow-mapping algorithm.",
                             {"Projection Configuration", "Epsilon"},
                             shadow_map_head},
                            {is_one_of<visibility::RayTracing>,
                             "table8",
                             "Table 8. Efficiency statistics of the ray-tracing algorithm.",
                             {"Sampling Type", "Epsilon"},
                             ray_head},
                            {is_one_of<visibility::Gpvc, visibility::PaperGpvc>,
                             "table9",
                             "Table 9. Efficiency statistics of GPVC.",
                             {"Sampling Type", "Correction", "Drawing", "Classifier"},
                             gpvc_head},
                            {is_one_of<visibility::NoTest>, "none", "No visibility test.", {"Mode"}, no_test_head}};
  for (const Layout& layout : layouts) {
    Cells head = layout.head;
    head.insert(head.end(), kTimes.begin(), kTimes.end());
    Table table(head);
    for (const Measured& m : measured) {
      if (!layout.contains(m.row.options.method)) continue;
      Cells cells = layout.cells(m);
      const Cells rest = times(m, measured.front(), scene.views.size());
      cells.insert(cells.end(), rest.begin(), rest.end());
      table.add(cells);
    }
    if (table.empty()) continue;
    fmt::print("\n{}\n\n{}", layout.title, table.markdown());
    if (!folder.empty()) table.write_csv(folder / (std::string(layout.name) + ".csv"));
  }
}

}  // namespace gpvc::efficiency
