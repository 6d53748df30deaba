#include "app/evaluate/oracle_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "io/clock.h"
#include "visibility/oracle.h"

namespace gpvc::evaluate {
namespace {

constexpr std::uint32_t kSeed = 2018;
constexpr std::size_t kListed = 10;
constexpr const char* kClassNames[] = {"hidden", "partial", "full", "unresolved"};

const char* name_of(visibility::FaceClass c) { return kClassNames[static_cast<std::size_t>(c)]; }

PixelPoint centroid_px(const Mesh& mesh, const View& view, std::size_t face) {
  CameraPoint sum;
  for (const std::uint32_t v : mesh.faces[face]) {
    const CameraPoint p = camera_from_world(view.pose, mesh.positions[v]);
    sum = {sum.x + p.x, sum.y + p.y, sum.z + p.z};
  }
  constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();
  return sum.z > 0 ? pixel_from_camera(view.camera, sum) : PixelPoint{kNowhere, kNowhere};
}

}  // namespace

OracleCheck::OracleCheck(const std::vector<ViewId>& used, std::size_t count) : drawn_(used) {
  // The first places of a shuffle, spelled out: what std::shuffle does is the library's own affair.
  count = std::min(count, drawn_.size());
  std::mt19937 random(kSeed);
  for (std::size_t i = 0; i < count; ++i) std::swap(drawn_[i], drawn_[i + random() % (drawn_.size() - i)]);
  drawn_.resize(count);
  std::sort(drawn_.begin(), drawn_.end());
}

bool OracleCheck::wants(ViewId view) const { return std::binary_search(drawn_.begin(), drawn_.end(), view); }

void OracleCheck::compare(const Mesh& mesh, const View& view, std::span<const visibility::FaceClass> classes) {
  const auto start = Clock::now();
  const visibility::OracleView truth = visibility::oracle_visibility(mesh, view);
  const double seconds = seconds_since(start);
  Matrix matrix{};
  std::size_t tied = 0, wrong = 0;
  for (std::size_t f = 0; f < classes.size(); ++f) {
    // A face left open on request is not wrong.
    const bool differs = classes[f] != truth.classes[f] && classes[f] != visibility::FaceClass::unresolved;
    if (truth.tied[f] != 0) {
      ++tied;
      tied_differing_ += differs ? 1 : 0;
      continue;
    }
    ++matrix[static_cast<std::size_t>(classes[f])][static_cast<std::size_t>(truth.classes[f])];
    if (!differs) continue;
    ++wrong;
    if (first_.size() == kListed) continue;
    const PixelPoint at = centroid_px(mesh, view, f);
    first_.push_back({view.name, f, classes[f], truth.classes[f], at.x, at.y});
  }
  for (std::size_t i = 0; i < matrix.size(); ++i)
    for (std::size_t k = 0; k < matrix[i].size(); ++k) matrix_[i][k] += matrix[i][k];
  views_.push_back({{"name", view.name},
                    {"tied", tied},
                    {"disagreements", wrong},
                    {"confusion", matrix},
                    {"samples", truth.samples},
                    {"oracle_s", seconds}});
  faces_ += classes.size();
  tied_ += tied;
  disagreements_ += wrong;
  samples_ += truth.samples;
  seconds_ += seconds;
}

bool OracleCheck::any_unresolved() const {
  const auto& row = matrix_[static_cast<std::size_t>(visibility::FaceClass::unresolved)];
  return std::any_of(row.begin(), row.end(), [](std::size_t count) { return count != 0; });
}

std::string OracleCheck::report() const {
  std::string text = fmt::format(
      "oracle: {} views (seed {}), {} faces and views, {} samples, {:.2f} s\n"
      "{:22} {:>12} {:>12} {:>12}\n",
      views_.size(), kSeed, pipeline::readable_count(faces_), pipeline::readable_count(samples_), seconds_,
      "found \\ oracle", kClassNames[0], kClassNames[1], kClassNames[2]);
  const std::size_t rows = any_unresolved() ? 4 : 3;
  for (std::size_t i = 0; i < rows; ++i)
    text += fmt::format("{:22} {:>12} {:>12} {:>12}\n", kClassNames[i], matrix_[i][0], matrix_[i][1], matrix_[i][2]);
  text += fmt::format("{} disagreements; {} tied apart, {} of them classed otherwise", disagreements_, tied_,
                      tied_differing_);
  for (const Disagreement& d : first_)
    text += fmt::format("\n  {} face {}: {} for {}, centroid at ({:.2f}, {:.2f}) px", d.view, d.face, name_of(d.found),
                        name_of(d.truth), d.x, d.y);
  if (disagreements_ > first_.size()) text += fmt::format("\n  and {} more", disagreements_ - first_.size());
  return text;
}

Json OracleCheck::json() const {
  Json first = Json::array();
  for (const Disagreement& d : first_)
    first.push_back({{"view", d.view},
                     {"face", d.face},
                     {"found", name_of(d.found)},
                     {"oracle", name_of(d.truth)},
                     {"centroid_px", std::isfinite(d.x) ? Json::array({d.x, d.y}) : Json(nullptr)}});
  return {{"seed", kSeed},
          {"classes", {kClassNames[0], kClassNames[1], kClassNames[2], kClassNames[3]}},
          {"confusion", matrix_},  // rows found, columns the oracle's
          {"rows", "found"},
          {"columns", "oracle"},
          {"faces", faces_},
          {"tied", tied_},
          {"tied_differing", tied_differing_},
          {"disagreements", disagreements_},
          {"first_disagreements", first},
          {"samples", samples_},
          {"oracle_s", seconds_},
          {"views", views_}};
}

}  // namespace gpvc::evaluate
