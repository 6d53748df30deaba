#include "app/view/asking.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/evaluate/scene_json.h"
#include "app/query/photos_json.h"
#include "io/vector.h"
#include "labeling/view_choice.h"

namespace gpvc::view {
namespace {

constexpr std::size_t kTakenBytes = std::size_t{600} << 20;  // of photos that are kept decoded

// A photo that shows the point, against the one that costs least: "21 % coarser, 71 degrees off; along a silhouette 0.050".
std::string plain_words(const query::PhotoOfPoint& photo, const query::PhotoOfPoint& best) {
  if (photo.reason != query::Reason::shown) return query::reason_words(photo);
  if (!photo.cost) return "no candidate: it sees the face in part, or along a silhouette, where others see it better";
  if (photo.view == best.view) return "costs least";
  std::string words;
  const auto add = [&](const std::string& more) { words += (words.empty() ? "" : ", ") + more; };
  const double ratio = photo.sharpness.gsd / best.sharpness.gsd;
  if (ratio > 1.03) add(fmt::format("{:.0f} % coarser", 100 * (ratio - 1)));
  if (ratio < 0.97) add(fmt::format("{:.0f} % sharper", 100 * (1 - ratio)));
  const bool but = ratio < 0.97 && photo.sharpness.angle > best.sharpness.angle + 5;
  if (std::abs(photo.sharpness.angle - best.sharpness.angle) > 5)
    words += fmt::format("{}{:.0f}° off, not {:.0f}°",
                         words.empty() ? ""
                         : but         ? " but "
                                       : ", ",
                         photo.sharpness.angle, best.sharpness.angle);
  const std::string cost = query::cost_words(photo);
  if (words.empty()) return cost == "nothing" ? "as good" : cost;
  return cost == "nothing" ? words : words + "; " + cost;
}

}  // namespace

Asking::Asking(const SceneSide& scene)
    : scene_(scene),
      finder_(scene.run->input, scene.run->photos, scene.judgement.get(), scene.run->settings.costs, scene.allowed),
      places_(scene.run->input, finder_),
      taken_(kTakenBytes) {}

ViewId Asking::view(std::size_t number) const {
  if (number >= scene().views.size())
    throw InputError(scene().source, "",
                     fmt::format("has no view {}, expected 0 to {}", number, scene().views.size() - 1));
  return ViewId{static_cast<std::uint32_t>(number)};
}

evaluate::Json Asking::answer(const WorldPoint& place, std::optional<FaceId> face) const {
  const auto& input = scene_.run->input;
  auto point = finder_.nearest(place);
  if (!point || point->distance > places_.limit()) throw InputError(input.mesh_file, "", "is not where the page asks");
  if (face) {
    const auto found = std::ranges::find(point->faces, *face);
    if (found != point->faces.end()) std::rotate(point->faces.begin(), found, found + 1);
  }
  const query::PointAnswer answer = finder_.photos_of(*point);
  evaluate::Json json = query::photos_json(scene(), answer, scene_.judgement != nullptr);
  for (std::size_t i = 0; i < answer.photos.size(); ++i)
    json["photos"][i]["plain"] = plain_words(answer.photos[i], answer.photos.front());
  json["at"] = evaluate::point_json(point->at);
  json["at_file"] = evaluate::point_json(places_.in_file(*point));
  const auto in_system = places_.in_system(*point);
  json["at_srs"] = in_system ? evaluate::point_json(*in_system) : evaluate::Json(nullptr);
  json["srs"] = scene().srs.empty() ? evaluate::Json(nullptr) : evaluate::Json(scene().srs);
  json["judged"] = scene_.judgement != nullptr;
  return json;
}

Image Asking::cutout(ViewId view, const PhotoPoint& pixel, int size) {
  const query::Cutout cut = query::cut_out(*taken_.photo(scene().views[index(view)].photo), pixel, size);
  const int left = size / 2 - static_cast<int>(cut.pixel.x), top = size / 2 - static_cast<int>(cut.pixel.y);
  constexpr std::uint8_t kGrey = 128;
  Image square{size, size, 3, std::vector<std::uint8_t>(pixel_index(0, size, size) * 3, kGrey)};
  for (int y = 0; y < cut.image.height; ++y)
    for (int x = 0; x < cut.image.width; ++x)
      if (x + left >= 0 && x + left < size && y + top >= 0 && y + top < size)
        std::copy_n(std::as_const(cut.image).at(x, y), 3, square.at(x + left, y + top));
  return square;
}

Image Asking::undistorted(ViewId view, int edge) const {
  const Camera& camera = scene().views[index(view)].camera;
  const auto photo = scene_.run->photos.photo(view);
  std::vector<std::uint8_t> inside;
  return at_most(pipeline::undistort_photo(*photo, camera, frame_of(view), inside), edge);
}

pipeline::FrameWindow Asking::frame_of(ViewId view) const {
  return pipeline::frame_window(scene().views[index(view)].camera, pipeline::FrameRule::inside);
}

std::vector<std::uint32_t> Asking::unseen(ViewId view, std::span<const std::uint32_t> faces) const {
  std::vector<std::uint32_t> none;
  if (scene_.judgement == nullptr) return none;
  const auto& statistics = scene_.judgement->statistics[index(view)];
  for (const std::uint32_t face : faces)
    if (face >= scene_.run->input.mesh.faces.size() || !labeling::record_of(statistics, FaceId{face}))
      none.push_back(face);
  return none;
}

}  // namespace gpvc::view
