#include "app/view/face_values.h"

#include <cmath>
#include <limits>

#include "app/query/coverage.h"
#include "app/query/sharpness.h"

namespace gpvc::view {
namespace {

constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();

std::vector<float> sharpness_values(bool angle, const Result& result, const Asking& asking) {
  const Mesh& mesh = asking.side().run->input.mesh;
  std::vector<float> values(result.labels.size(), kNothing);
  for (std::size_t f = 0; f < values.size(); ++f) {
    if (result.labels[f] < 0) continue;
    const FaceId face{result.face[f]};
    const View& view = asking.scene().views[index(asking.view(static_cast<std::size_t>(result.labels[f])))];
    const query::Sharpness found =
        query::sharpness_of(view, query::middle_of(mesh, face), query::normal_of(mesh, face));
    values[f] = static_cast<float>(angle ? found.angle : found.gsd);
  }
  return values;
}

std::vector<float> photo_counts(const Result& result, const Asking& asking) {
  const query::FaceCoverage coverage = query::cover_faces(*asking.side().run, asking.side().judgement.get());
  std::vector<float> values(result.face.size());
  for (std::size_t f = 0; f < values.size(); ++f) values[f] = static_cast<float>(coverage.photos[result.face[f]]);
  return values;
}

}  // namespace

std::vector<std::string> value_names(const Result& result, const Asking* asking) {
  std::vector<std::string> names;
  if (result.labels.empty()) return names;
  names = {"photo", "tag"};
  if (asking != nullptr) names.insert(names.end(), {"gsd", "angle", "photos"});
  return names;
}

std::vector<float> face_values(const std::string& name, const Result& result, const Asking* asking) {
  if (name == "gsd" || name == "angle") return sharpness_values(name == "angle", result, *asking);
  if (name == "photos") return photo_counts(result, *asking);
  std::vector<float> values;
  if (name == "tag")
    for (const std::uint8_t tag : result.tags) values.push_back(static_cast<float>(tag));
  else
    for (const std::int32_t label : result.labels) values.push_back(label < 0 ? kNothing : static_cast<float>(label));
  return values;
}

}  // namespace gpvc::view
