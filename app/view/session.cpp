#include "app/view/session.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/evaluate/scene_json.h"
#include "app/view/page_files.h"
#include "app/view/paths.h"
#include "app/view/tileset_files.h"

namespace gpvc::view {
namespace {

using evaluate::Json;

constexpr std::string_view kResults = "results/", kPhotos = "photos/", kTiles = "tileset/";
constexpr int kPhotoEdge = 2048, kMostCut = 1024;

Reply json_reply(const Json& json) {
  return bytes_reply("application/json", json.dump(-1, ' ', false, Json::error_handler_t::replace));
}

// Of a question's words, a finite number.
double number_in(const Request& request, const char* name) {
  const auto found = request.query.find(name);
  double value = 0;
  const std::string text = found == request.query.end() ? "" : found->second;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failed != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
    throw InputError(request.path, "", fmt::format("expected a number {}", name));
  return value;
}

std::size_t count_in(const Request& request, const char* name) {
  const double value = number_in(request, name);
  if (!(value >= 0 && value < 4294967296.0) || value != std::floor(value))
    throw InputError(request.path, "", fmt::format("expected a whole number {}", name));
  return static_cast<std::size_t>(value);
}

Json body_of(const Request& request) {
  Json json = Json::parse(request.body, nullptr, false);
  if (!json.is_object()) throw InputError(request.path, "", "expected a JSON object");
  return json;
}

template <typename T>
T member(const Json& json, const char* name) {
  try {
    return json.at(name).get<T>();
  } catch (const nlohmann::json::exception&) {
    throw InputError("the page's question", name, "is missing, or of another kind");
  }
}

// The page's camera as a view without distortion.
View screen_of(const Json& json) {
  constexpr int kMostEdge = 8192;
  View view{.name = "screen", .photo = {}, .camera = {}, .pose = {}};
  Camera& camera = view.camera;
  camera.width = member<int>(json, "width"), camera.height = member<int>(json, "height");
  if (camera.width < 1 || camera.height < 1 || camera.width > kMostEdge || camera.height > kMostEdge)
    throw InputError("the page's question", "width", "expected a screen of 1 to 8192 pixels");
  camera.fx = camera.fy = member<double>(json, "focal");
  camera.cx = camera.width / 2.0, camera.cy = camera.height / 2.0;
  view.pose.rotation = member<std::array<double, 9>>(json, "rotation");
  const auto centre = member<std::array<double, 3>>(json, "centre");
  view.pose.centre = {centre[0], centre[1], centre[2]};
  return view;
}

std::vector<PhotoPoint> polygon_of(const Json& json) {
  std::vector<PhotoPoint> polygon;
  for (const auto& [x, y] : member<std::vector<std::array<double, 2>>>(json, "polygon")) polygon.push_back({x, y});
  if (polygon.size() < 3) throw InputError("the page's question", "polygon", "expected three corners or more");
  return polygon;
}

Json view_json(const View& view, const pipeline::FrameWindow& frame) {
  const Camera& c = view.camera;
  return {{"name", view.name},
          {"frame", {frame.x, frame.y, frame.width, frame.height}},
          {"width", c.width},
          {"height", c.height},
          {"fx", c.fx},
          {"fy", c.fy},
          {"cx", c.cx},
          {"cy", c.cy},
          {"reduction", view.reduction},
          {"rotation", view.pose.rotation},
          {"centre", evaluate::point_json(view.pose.centre)}};
}

}  // namespace

Session::Session(SessionInput input, std::function<void(const std::string&, const std::string&)> tell)
    : input_(std::move(input)), tell_(std::move(tell)) {
  if (input_.scene) asking_ = std::make_shared<Asking>(*input_.scene);
  results_.resize(input_.results.size());
  if (input_.changing) rules_.emplace(input_.changing->rules, input_.changing->earlier_rules);
  job_ = std::make_unique<Job>([this](const std::string& line) { tell_("job", line); });
  if (input_.tileset.empty())
    result(0);
  else
    tiles_ = tileset_files(input_.tileset);
}

Session::~Session() = default;

std::shared_ptr<Asking> Session::asking() const {
  const std::lock_guard lock(mutex_);
  if (!asking_)
    throw InputError(input_.tileset.empty() ? input_.results.front().folder : input_.tileset, "",
                     "was opened without its scene and photos");
  return asking_;
}

std::shared_ptr<ShownResult> Session::result(std::size_t number) {
  const std::lock_guard lock(mutex_);
  auto& kept = results_.at(number);
  if (!kept) kept = std::make_shared<ShownResult>(input_.results[number].folder, scratch_, asking_);
  return kept;
}

Reply Session::answer(const Request& request) {
  if (request.posts) return posted(request);
  for (const PageFile& file : page_files())
    if (file.name == (request.path.empty() ? "index.html" : request.path))
      return bytes_reply(fmt::format("{}; charset=utf-8", file.type), std::string(file.content));
  if (request.path == "page.json") return page_json();
  if (request.path.starts_with(kTiles)) return tile(request.path.substr(kTiles.size()));
  if (request.path.starts_with(kResults)) return shown(request.path);
  return asked(request);
}

Reply Session::page_json() const {
  const std::lock_guard lock(mutex_);
  Json json = {{"results", Json::array()}, {"up", evaluate::point_json(input_.up)}, {"photos", input_.photos}};
  for (const NamedResult& named : input_.results) json["results"].push_back({{"name", named.name}});
  json["tileset"] = input_.tileset.empty() ? Json(nullptr) : Json(input_.tileset.lexically_normal().string());
  json["views"] = Json::array();
  if (asking_)
    for (const ViewId id : all_views(asking_->scene()))
      json["views"].push_back(view_json(asking_->scene().views[index(id)], asking_->frame_of(id)));
  json["used"] = Json::array();
  if (asking_)
    for (const ViewId view : asking_->side().run->input.views) json["used"].push_back(index(view));
  json["live"] = true;
  json["asks"] = asking_ != nullptr;
  json["judged"] = asking_ && asking_->side().judgement;
  json["changes"] = input_.changing && input_.changing->apply;
  json["rules"] = rules_ ? Json(rules_->path().string()) : Json(nullptr);
  return json_reply(json);
}

Reply Session::shown(const std::string& path) {
  const std::size_t slash = path.find('/', kResults.size());
  const auto number = number_behind(std::string_view(path).substr(0, slash), kResults, results_.size());
  if (slash == std::string::npos || !number) return text_reply(404, "not found");
  return result(*number)->answer(path.substr(slash + 1));
}

Reply Session::tile(const std::string& path) const {
  if (!tiles_.contains(path)) return text_reply(404, "not found");
  Reply reply;
  reply.type = path.ends_with(".json") ? "application/json" : "model/gltf-binary";
  reply.file = input_.tileset / path;
  return reply;
}

Reply Session::photo(std::size_t number) {
  const auto asks = asking();
  Reply reply = bytes_reply(
      "image/jpeg", encoded(scratch_, asks->undistorted(asks->view(number), kPhotoEdge), io::ImageFormat::jpg, 90));
  reply.fresh = std::chrono::hours(1);
  return reply;
}

Reply Session::asked(const Request& request) {
  if (const auto number = number_behind(request.path, kPhotos, input_.photos.size())) return photo(*number);
  if (request.path == "ask") {
    std::optional<FaceId> face;
    if (request.query.contains("face")) face = FaceId{static_cast<std::uint32_t>(count_in(request, "face"))};
    return json_reply(
        asking()->answer({number_in(request, "x"), number_in(request, "y"), number_in(request, "z")}, face));
  }
  if (request.path == "cut") {
    const auto asks = asking();
    const int size = static_cast<int>(std::clamp<std::size_t>(count_in(request, "size"), 16, kMostCut));
    const PhotoPoint pixel{number_in(request, "x"), number_in(request, "y")};
    const Image cut = asks->cutout(asks->view(count_in(request, "view")), pixel, size);
    Reply reply = bytes_reply("image/png", encoded(scratch_, cut, io::ImageFormat::png, 0));
    reply.fresh = std::chrono::hours(1);
    return reply;
  }
  if (request.path == "rules" && rules_) return json_reply({{"rules", rules_->read()}});
  return text_reply(404, "not found");
}

Reply Session::posted(const Request& request) {
  const auto asks = asking();
  const auto& input = asks->side().run->input;
  const std::size_t faces = input.mesh.faces.size();
  if (request.path == "faces-in") {
    const Json json = body_of(request);
    return json_reply({{"faces", faces_json(faces_in(input, screen_of(json), polygon_of(json)))}});
  }
  if (request.path == "chart" && !results_.empty()) {
    const auto face = member<std::uint32_t>(body_of(request), "face");
    if (face >= faces) throw InputError(request.path, "face", "is not one of the mesh");
    const auto first = result(0);
    if (first->result().labels.empty())
      throw InputError(first->result().folder, "", "does not say which photo shows a face");
    {
      const std::lock_guard lock(mutex_);
      if (!graph_) graph_ = std::make_shared<const labeling::FaceGraph>(labeling::face_graph(input.mesh));
    }
    return json_reply({{"faces", faces_json(chart_around(FaceId{face}, first->labels_of_mesh(), *graph_))}});
  }
  if (request.path == "unseen") {
    const Json json = body_of(request);
    const auto asked = faces_from(member<Json>(json, "faces"), faces, "the page's question");
    return json_reply({{"faces", faces_json(asks->unseen(asks->view(member<std::size_t>(json, "view")), asked))}});
  }
  if (!rules_) return text_reply(404, "not found");
  if (request.path == "rules") {
    rules_->write(member<Json>(body_of(request), "rules"));
    return json_reply({{"file", rules_->path().string()}});
  }
  if (request.path == "cancel") {
    job_->cancel();
    return json_reply(Json::object());
  }
  if (request.path == "apply" && input_.changing->apply) {
    const bool started = job_->start([this](results::Observer& observer) {
      input_.changing->apply(rules_->read().empty() ? std::filesystem::path() : rules_->path(), observer);
      apply();
    });
    return started ? json_reply(Json::object()) : text_reply(409, "rules are being applied already");
  }
  return text_reply(404, "not found");
}

void Session::apply() {
  auto asking = std::make_shared<Asking>(input_.changing->reopened());
  auto first = std::make_shared<ShownResult>(input_.results.front().folder, scratch_, asking);
  const std::lock_guard lock(mutex_);
  asking_ = std::move(asking);
  results_.front() = std::move(first);
}

}  // namespace gpvc::view
