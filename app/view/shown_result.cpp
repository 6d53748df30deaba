#include "app/view/shown_result.h"

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>

#include "app/view/face_values.h"
#include "app/view/paths.h"
#include "io/vector.h"

namespace gpvc::view {
namespace {

// The mesh as it is drawn: the scene's faces where the result is of the scene's mesh, so that cameras fit it.
Mesh mesh_to_draw(const Result& result, const Asking* asking) {
  Mesh mesh;
  if (asking != nullptr) {
    const Mesh& all = asking->side().run->input.mesh;
    const bool same =
        result.face.size() <= all.faces.size() && (!result.labels.empty() || result.face.size() == all.faces.size());
    if (same && std::ranges::all_of(result.face, [&](std::uint32_t f) { return f < all.faces.size(); })) {
      mesh.positions = all.positions;
      for (const std::uint32_t f : result.face) mesh.faces.push_back(all.faces[f]);
      return mesh;
    }
  }
  mesh.faces = result.mesh.faces;
  for (const WorldPoint& p : result.mesh.positions) mesh.positions.push_back(p + result.offset);
  return mesh;
}

Reply file_reply(const std::filesystem::path& file) {
  Reply reply;
  reply.type = media_type(file);
  reply.file = file;
  return reply;
}

}  // namespace

ShownResult::ShownResult(const std::filesystem::path& folder, const ScratchFolder& scratch,
                         std::shared_ptr<const Asking> asking)
    : result_(read_result(folder, scratch)), asking_(std::move(asking)) {
  drawn_ = drawn_model(mesh_to_draw(result_, asking_.get()), result_.model, result_.labels);
  // The page names faces by their numbers in the mesh that was textured.
  DrawnModel sent = drawn_;
  for (std::uint32_t& face : sent.faces) face = result_.face[face];
  geometry_ = std::make_shared<const std::string>(bytes_of(sent));
  for (auto* part : {&drawn_.positions, &drawn_.wide_uv}) *part = {};
  drawn_.uv = {};
}

std::vector<std::int32_t> ShownResult::labels_of_mesh() const {
  std::vector<std::int32_t> labels(asking_->side().run->input.mesh.faces.size(), -1);
  for (std::size_t f = 0; f < result_.labels.size(); ++f) labels[result_.face[f]] = result_.labels[f];
  return labels;
}

std::vector<std::string> ShownResult::paths() const {
  std::vector<std::string> paths{"model.json", "geometry"};
  for (std::size_t n = 0; n < result_.pages.size(); ++n)
    for (const char* folder : {"pages/", "quarters/"}) paths.push_back(folder + std::to_string(n));
  for (const std::string& name : value_names(result_, asking_.get())) paths.push_back("values/" + name);
  return paths;
}

Reply ShownResult::answer(const std::string& path) {
  if (path == "model.json") return model_json();
  if (path == "geometry") return {200, "application/octet-stream", geometry_, {}, {}};
  const auto& pages = result_.pages;
  if (const auto page = number_behind(path, "pages/", pages.size())) return file_reply(pages[*page].file);
  if (const auto page = number_behind(path, "quarters/", pages.size())) return quarter(pages[*page]);
  constexpr std::string_view kValues = "values/";
  if (path.starts_with(kValues)) return values(path.substr(kValues.size()));
  return text_reply(404, "not found");
}

Reply ShownResult::quarter(const ResultPage& page) {
  const std::lock_guard lock(quarters_);
  make_quarter(page);
  return file_reply(page.quarter);
}

Reply ShownResult::model_json() const {
  evaluate::Json json = {{"faces", result_.face.size()},
                         {"values", value_names(result_, asking_.get())},
                         {"pages", evaluate::Json::array()}};
  for (const ResultPage& page : result_.pages)
    json["pages"].push_back({{"width", page.width}, {"height", page.height}, {"key", page.key}});
  return bytes_reply("application/json", evaluate::json_text(json));
}

Reply ShownResult::values(const std::string& name) {
  const std::vector<std::string> known = value_names(result_, asking_.get());
  if (std::ranges::find(known, name) == known.end()) return text_reply(404, "not found");
  const std::lock_guard lock(mutex_);
  auto& kept = values_[name];
  if (!kept) {
    const std::vector<float> values = in_drawing_order(drawn_, face_values(name, result_, asking_.get()));
    std::string bytes(values.size() * sizeof(float), '\0');
    if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
    kept = std::make_shared<const std::string>(std::move(bytes));
  }
  return {200, "application/octet-stream", kept, {}, {}};
}

}  // namespace gpvc::view
