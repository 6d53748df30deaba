// gpvc photos: which photos show a point, and why the others do not.
#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/cli/interrupt.h"
#include "app/cli/scene_input.h"
#include "app/pipeline/judgement.h"
#include "app/query/index.h"
#include "app/query/photos_json.h"
#include "app/query/places.h"
#include "io/geojson_points.h"
#include "io/images.h"
#include "io/output_file.h"
#include "io/photos.h"

namespace gpvc::cli {
namespace {

namespace fs = std::filesystem;

struct Asked {
  query::Place place;
  std::optional<FaceId> face{};  ///< asked for instead of a place
};

std::vector<Asked> read_points(const PhotosOptions& options, std::size_t faces) {
  std::vector<Asked> asked;
  for (const WorldPoint& at : options.points)
    asked.push_back({{at, true, options.crs, fmt::format("point {}", asked.size() + 1)}});
  for (const std::uint32_t face : options.faces) {
    if (face >= faces)
      throw InputError(options.input.mesh, "", fmt::format("has no face {}: faces are 0 to {}", face, faces - 1));
    asked.push_back({{{}, true, "", fmt::format("face {}", face)}, FaceId{face}});
  }
  if (options.geojson.empty()) return asked;
  const io::GeoPoints read = io::read_geojson_points(options.geojson);
  for (const io::GeoPoint& point : read.points) asked.push_back({{point.at, point.has_height, read.srs, point.name}});
  return asked;
}

std::string number(double value) { return fmt::format("{:.4g}", value); }

void print_photo(const Scene& scene, const query::PhotoOfPoint& photo, std::size_t width, Console& console) {
  const std::string& name = scene.views[index(photo.view)].name;
  if (photo.reason != query::Reason::shown) {
    console.result(fmt::format("    {:{}}  {}", name, width, query::reason_words(photo)));
    return;
  }
  const char* of_class = photo.found == visibility::FaceClass::full      ? "whole"
                         : photo.found == visibility::FaceClass::partial ? "partly"
                                                                         : "hardly";
  console.result(fmt::format(
      "  {} {:{}}  {:>8.1f} {:>8.1f}  {:>9}  {:>5.1f}  {:6}  {}", photo.textures_face ? "*" : " ", name, width,
      photo.pixel->x, photo.pixel->y, number(photo.sharpness.gsd), photo.sharpness.angle, of_class,
      photo.cost ? fmt::format("{:.3f}: {}", photo.cost->total(), query::cost_words(photo)) : "no candidate"));
}

std::string point_text(const WorldPoint& p) { return fmt::format("({:.3f}, {:.3f}, {:.3f})", p.x, p.y, p.z); }

void print_answer(const Scene& scene, const Asked& asked, const query::PointAnswer& answer, const WorldPoint& at,
                  Console& console) {
  std::size_t width = 5;
  for (const query::PhotoOfPoint& photo : answer.photos)
    width = std::max(width, scene.views[index(photo.view)].name.size());
  console.result(
      fmt::format("{}: {} on face {}{}, shown by {} of {} photos", asked.place.name, point_text(at),
                  index(answer.point.faces.front()),
                  asked.face ? "" : fmt::format(", {} from the place asked for", number(answer.point.distance)),
                  answer.shown, answer.photos.size()));
  if (answer.shown > 0)
    console.result(fmt::format("    {:{}}  {:>8} {:>8}  {:>9}  {:>5}  {:6}  {}", "photo", width, "x", "y", "gsd",
                               "angle", "face", "cost: for"));
  for (const query::PhotoOfPoint& photo : answer.photos) print_photo(scene, photo, width, console);
}

// A cross around the pixel that leaves it free.
void mark(query::Cutout& cut) {
  const int x = static_cast<int>(cut.pixel.x), y = static_cast<int>(cut.pixel.y);
  const auto paint = [&](int px, int py) {
    if (px < 0 || py < 0 || px >= cut.image.width || py >= cut.image.height) return;
    std::uint8_t* to = cut.image.at(px, py);
    to[0] = 255;
    to[1] = 0;
    to[2] = 255;
  };
  constexpr int kFree = 4, kEnd = 12;
  for (int step = kFree; step < kEnd; ++step)
    for (const int sign : {-1, 1}) {
      paint(x + sign * step, y);
      paint(x, y + sign * step);
    }
}

using Answers = std::vector<std::pair<const Asked*, query::PointAnswer>>;

// Photo by photo, so that each is decoded once.
void write_crops(const PhotosOptions& options, const Scene& scene, const Answers& answers, RunRecord& record) {
  struct Crop {
    fs::path file;
    PhotoPoint pixel;
  };
  std::map<ViewId, std::vector<Crop>> crops;
  for (std::size_t n = 0; n < answers.size(); ++n)
    for (const query::PhotoOfPoint& photo : answers[n].second.photos)
      if (photo.reason == query::Reason::shown)
        crops[photo.view].push_back({options.crops / std::to_string(n + 1) /
                                         results::contained_path(scene.views[index(photo.view)].name + ".png"),
                                     *photo.pixel});
  record.begin({"crops", "photos"});
  std::size_t done = 0, written = 0;
  for (const auto& [view, of_view] : crops) {
    record.progress(done++, crops.size());
    const Image photo = io::read_image(scene.views[index(view)].photo);
    for (const Crop& crop : of_view) {
      query::Cutout cut = query::cut_out(photo, crop.pixel, options.crop_size);
      mark(cut);
      std::error_code failed;
      fs::create_directories(crop.file.parent_path(), failed);
      if (failed) throw OutputError(crop.file, "cannot be written: " + failed.message());
      io::write_image(crop.file, cut.image, io::ImageFormat::png, 0);
      ++written;
    }
  }
  record.end(fmt::format("{} written", written));
}

Json answers_json(const PhotosOptions& options, const Scene& scene, const query::PlaceFinder& places,
                  const Answers& answers, bool judged) {
  Json json = {{"program", "gpvc"}, {"command", "photos"}, {"version", program_version()}};
  json["scene"] = options.input.scene.string();
  json["mesh"] = options.input.mesh.string();
  json["from"] = options.from.empty() ? Json(nullptr) : Json(options.from.string());
  json["judged"] = judged;
  json["srs"] = scene.srs.empty() ? Json(nullptr) : Json(scene.srs);
  json["points"] = Json::array();
  for (const auto& [asked, answer] : answers) {
    Json point = {{"name", asked->place.name}};
    const WorldPoint& at = asked->place.at;
    point["asked"] =
        asked->face ? Json(nullptr) : Json{at.x, at.y, asked->place.has_height ? Json(at.z) : Json(nullptr)};
    point["at"] = evaluate::point_json(places.in_file(answer.point));
    const std::optional<WorldPoint> in_system = places.in_system(answer.point);
    point["at_srs"] = in_system ? evaluate::point_json(*in_system) : Json(nullptr);
    point.update(query::photos_json(scene, answer, judged));
    json["points"].push_back(std::move(point));
  }
  return json;
}

}  // namespace

void run_photos(const PhotosOptions& options, Console& console) {
  const EndsSoonAfterSignal ends([&] { console.interrupted(); });
  const bool asks_for_points = !options.points.empty() || !options.faces.empty() || !options.geojson.empty();
  if (!asks_for_points && options.index.empty()) throw UsageError("--at, --face or --geojson is missing: which point?");
  RunRecord record(console);
  const SceneInputData in = read_scene_input(options.input, record);
  const std::vector<Asked> asked = read_points(options, in.mesh.faces.size());
  pipeline::Settings settings = options.settings;
  std::set<fs::path> read = input_files(in);
  settings.view_rules = rules_of(options.allow, in, read);
  settings.device = options.common.device;
  io::PhotoCache photos(in.scene);
  const checks::Input input = in.input();
  const pipeline::Run run{input, settings, photos, record};
  std::optional<pipeline::Judgement> judgement;
  if (!options.from.empty()) {
    record.begin({"earlier result"});
    results::OutputFolder::finish_interrupted(options.from);
    judgement = pipeline::read_judgement(options.from, run);
    record.end(fmt::format("{} photos judged", judgement->agreement.size()));
  } else if (options.judge) {
    judgement = pipeline::judge(run);
  }
  if (!judgement)
    console.note(
        "outliers and silhouettes are not known, and costs without them: --from takes them from an editable result, "
        "--judge "
        "compares all photos");
  if (judgement && !options.allow.empty()) judgement->rules = settings.view_rules;
  const auto allowed = pipeline::allowed_views(judgement ? judgement->rules : settings.view_rules, in.mesh,
                                               in.scene.views.size(), record);
  const query::PhotoFinder finder(input, photos, judgement ? &*judgement : nullptr, settings.costs, allowed);
  const query::PlaceFinder places(input, finder);
  Answers answers;
  for (const Asked& each : asked) {
    throw_if_interrupted();
    const visibility::SurfacePoint point = each.face ? finder.middle(*each.face) : places.find(each.place);
    answers.emplace_back(&each, finder.photos_of(point));
  }
  const bool to_stdout = options.json == "-";
  if (!to_stdout)
    for (const auto& [each, answer] : answers)
      print_answer(in.scene, *each, answer, places.in_file(answer.point), console);
  if (!options.index.empty())
    query::write_index(options.index, query::index_faces(run, judgement ? &*judgement : nullptr), in.scene);
  if (!options.crops.empty()) write_crops(options, in.scene, answers, record);
  if (options.json.empty() || !asks_for_points) return;
  const Json json = answers_json(options, in.scene, places, answers, judgement.has_value());
  if (to_stdout)
    console.result(evaluate::json_text(json));
  else
    evaluate::write_json(options.json, json);
}

}  // namespace gpvc::cli
