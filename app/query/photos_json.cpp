#include "app/query/photos_json.h"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>
#include <utility>

namespace gpvc::query {
namespace {

using evaluate::Json;  // which writes what is not finite as null

constexpr Named<visibility::FaceClass> kClassNames[] = {{"hidden", visibility::FaceClass::hidden},
                                                        {"partial", visibility::FaceClass::partial},
                                                        {"full", visibility::FaceClass::full}};

Json cost_json(const labeling::CostParts& cost, bool judged) {
  return {{"total", cost.total()},
          {"quality", cost.quality},
          {"silhouette", judged ? Json(cost.silhouette) : Json(nullptr)},
          {"hidden", cost.hidden},
          {"coarse", cost.coarse}};
}

}  // namespace

std::string cost_words(const PhotoOfPoint& photo) {
  if (!photo.cost) return "";
  constexpr double kLeast = 0.0005;  // less is shown as 0
  std::string words;
  for (const auto& [name, part] : {std::pair{"lower quality", photo.cost->quality},
                                   {"along a silhouette", photo.cost->silhouette},
                                   {"partly hidden", photo.cost->hidden},
                                   {"much coarser", photo.cost->coarse}})
    if (part >= kLeast) words += fmt::format("{}{} {:.3f}", words.empty() ? "" : ", ", name, part);
  if (photo.doubtful) words += std::string(words.empty() ? "" : ", ") + "an outlier, as all photos here are";
  return words.empty() ? "nothing" : words;
}

std::string reason_words(const PhotoOfPoint& photo) {
  if (photo.reason == Reason::hidden) return fmt::format("hidden by face {}", index(photo.hidden_by));
  return words_of(photo.reason);
}

Json photo_json(const Scene& scene, const PhotoOfPoint& photo, bool judged) {
  const bool shows = photo.reason == Reason::shown, ahead = photo.reason != Reason::behind;
  Json json = {{"view", index(photo.view)},
               {"name", scene.views[index(photo.view)].name},
               {"shows", shows},
               {"reason", name_of(kReasonNames, photo.reason)},
               {"words", shows ? cost_words(photo) : reason_words(photo)},
               {"face", index(photo.face)}};
  json["pixel"] = photo.pixel ? Json{photo.pixel->x, photo.pixel->y} : Json(nullptr);
  json["gsd"] = ahead ? Json(photo.sharpness.gsd) : Json(nullptr);
  json["angle"] = ahead ? Json(photo.sharpness.angle) : Json(nullptr);
  json["distance"] = ahead ? Json(photo.sharpness.distance) : Json(nullptr);
  json["class"] = name_of(kClassNames, photo.found);
  json["visible_share"] = photo.visible_share;
  json["candidate"] = photo.cost.has_value();
  json["cost"] = photo.cost ? cost_json(*photo.cost, judged) : Json(nullptr);
  json["textures_face"] = photo.textures_face;
  if (photo.reason == Reason::hidden) json["hidden_by"] = index(photo.hidden_by);
  return json;
}

Json photos_json(const Scene& scene, const PointAnswer& answer, bool judged) {
  Json photos = Json::array();
  for (const PhotoOfPoint& photo : answer.photos) photos.push_back(photo_json(scene, photo, judged));
  Json faces = Json::array();
  for (const FaceId face : answer.point.faces) faces.push_back(index(face));
  return {{"faces", faces}, {"distance", answer.point.distance}, {"shown", answer.shown}, {"photos", photos}};
}

}  // namespace gpvc::query
