// Times one visibility mode on one scene.
#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <map>
#include <memory>
#include <stdexcept>

#include "benchmarks/efficiency.h"
#include "io/clock.h"
#include "visibility/visibility.h"

namespace gpvc::efficiency {
namespace {

using Classes = std::vector<std::vector<visibility::FaceClass>>;  // per view

/// Adds the wall and CPU time of its lifetime.
class Watch {
 public:
  explicit Watch(Measured& into) : into_(into), start_(Clock::now()), cpu_(cpu_seconds()) {}
  ~Watch() {
    into_.total_s += seconds_since(start_);
    into_.cpu_s += cpu_seconds() - cpu_;
  }

 private:
  Measured& into_;
  Clock::time_point start_;
  double cpu_;
};

std::size_t unlike(const std::vector<visibility::FaceClass>& a, const std::vector<visibility::FaceClass>& b) {
  std::size_t count = 0;
  for (std::size_t f = 0; f < a.size(); ++f) count += a[f] != b[f];
  return count;
}

std::string first_word(const std::string& note) { return note.substr(0, note.find(':')); }

/// A key that rows share if their classes must agree on every face: HIVERS and dense sampling with the same correction, on
/// either processor and with either way of drawing. Empty for rows that need not agree with any.
std::string agreement(const visibility::VisibilityOptions& options) {
  const GpvcRow row = gpvc_row(options.method);
  if (row.correction == nullptr || row.sampling == visibility::Sampling::ves) return {};
  return row.correction;
}

/// Sets what `word` names; false if it names nothing that the method has.
bool set(const std::string& word, visibility::Method& method) {
  const auto find = [&](const auto& names, auto& value) {
    for (const auto& known : names)
      if (word == known.name) {
        value = known.value;
        return true;
      }
    return false;
  };
  auto* gpvc = std::get_if<visibility::Gpvc>(&method);
  auto* paper = std::get_if<visibility::PaperGpvc>(&method);
  if (gpvc != nullptr && (word == "off" || word == "paper")) {
    paper = &method.emplace<visibility::PaperGpvc>(visibility::PaperGpvc{
        gpvc->sampling, visibility::Projection::apc, visibility::CoverageCorrection::paper, gpvc->classifier});
    gpvc = nullptr;
  }
  if (gpvc != nullptr)
    return word == "exact" || find(visibility::kClassifierNames, gpvc->classifier) ||
           find(visibility::kDrawingNames, gpvc->drawing);
  return paper != nullptr && (find(visibility::kCoverageCorrectionNames, paper->correction) ||
                              find(visibility::kClassifierNames, paper->classifier) || word == "opengl");
}

}  // namespace

GpvcRow gpvc_row(const visibility::Method& method) {
  if (const auto* gpvc = std::get_if<visibility::Gpvc>(&method)) return {gpvc->sampling, "exact"};
  if (const auto* paper = std::get_if<visibility::PaperGpvc>(&method))
    return {paper->sampling, name_of(visibility::kCoverageCorrectionNames, paper->correction)};
  return {};
}

Row parse_row(const std::string& name) {
  std::size_t at = name.find('/');
  Row row{name, {visibility::parse_visibility_mode(std::string_view(name).substr(0, at))}};
  while (at != std::string::npos) {
    const std::size_t next = name.find('/', at + 1);
    const std::string word = name.substr(at + 1, next == std::string::npos ? next : next - at - 1);
    if (!set(word, row.options.method))
      throw std::invalid_argument("'" + word + "' in '" + name + "' is none of off, paper, exact, cpu, gpu, opengl, " +
                                  "native, or does not go with the rest");
    at = next;
  }
  row.options.draw_ivm = false;  // unless the method needs it
  return row;
}

std::vector<Measured> measure(visibility::GraphicsDevice& device, const BenchScene& scene, const std::vector<Row>& rows,
                              std::size_t& differing) {
  std::vector<Measured> measured;
  Classes first;
  std::map<std::string, Classes> must_agree;
  visibility::ViewVisibility seen;
  const bool terminal = isatty(STDERR_FILENO) != 0;
  for (const Row& row : rows) {
    Measured result{row, {}, {}, {}, 0, 0, 0, 0};
    const auto stage = [&] {
      const Watch watch(result);
      return std::make_unique<visibility::VisibilityStage>(scene.mesh, row.options, &device);
    }();
    result.start_s = result.total_s;
    result.processor = stage->classifier_note().substr(0, 3);
    result.drawing = first_word(stage->drawing_note());
    const std::string key = agreement(row.options);
    Classes* others = key.empty() ? nullptr : &must_agree[key];
    for (std::size_t v = 0; v < scene.views.size(); ++v) {
      {
        const Watch watch(result);
        stage->classify(scene.views[v], ViewId{static_cast<std::uint32_t>(v)}, nullptr, seen);
      }
      result.sum += seen.statistics;
      if (terminal || v + 1 == scene.views.size())
        std::fprintf(stderr, "%s%s: %zu of %zu views, %.2f s", terminal ? "\r" : "", row.name.c_str(), v + 1,
                     scene.views.size(), result.total_s);
      if (measured.empty()) first.push_back(seen.classes);
      result.unlike_first += unlike(seen.classes, first[v]);
      if (others == nullptr) continue;
      if (others->size() <= v) {
        others->push_back(seen.classes);
      } else {
        differing += unlike(seen.classes, (*others)[v]);
      }
    }
    std::fputc('\n', stderr);
    measured.push_back(result);
  }
  return measured;
}

}  // namespace gpvc::efficiency
