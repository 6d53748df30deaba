#include "app/cli/view_lists.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <sstream>

#include "app/pipeline/rule_regions.h"
#include "io/near_words.h"
#include "io/paths.h"
#include "io/scene_files.h"
#include "io/view_rules.h"

namespace gpvc::cli {
namespace {

// The entries of a list: separated by commas, or the lines of the file after an @.
std::vector<std::string> listed(const std::string& list) {
  const bool in_file = list.starts_with("@");
  if (in_file) io::refuse_special_file(list.substr(1));
  std::ifstream file(in_file ? list.substr(1) : "");
  if (in_file && (!file || !io::is_file(list.substr(1))))
    throw InputError(list.substr(1), "", "cannot be read as a list of views");
  std::istringstream text(list);
  std::istream& in = in_file ? static_cast<std::istream&>(file) : text;
  std::vector<std::string> names;
  for (std::string name; std::getline(in, name, in_file ? '\n' : ',');) {
    if (in_file && name.ends_with('\r')) name.pop_back();
    if (!name.empty()) names.push_back(name);
  }
  return names;
}

std::string near_names(std::span<const View> views, const std::string& name) {
  std::vector<std::string> names;
  for (const View& view : views) names.push_back(view.name);
  return results::readable_list(io::near_words(name, names, 3), 3);
}

// How a list's entry may be read; the first reading that matches a view counts.
enum class Reading { name, glob, stem, file_name, file_stem };

// True if such an entry means one view alone.
bool is_single(Reading reading) { return reading != Reading::name && reading != Reading::glob; }

// `name`: a view's, or that of the photo it shows.
bool fits(const std::string& entry, const std::string& name, Reading reading) {
  if (reading == Reading::name) return name == entry;
  if (reading == Reading::glob) return fnmatch(entry.c_str(), name.c_str(), 0) == 0;
  const std::filesystem::path path(name);
  if (reading == Reading::stem) return std::filesystem::path(path).replace_extension() == entry;
  return (reading == Reading::file_name ? path.filename() : path.stem()) == entry;
}

// The views that an entry means, or why it means none.
struct Match {
  std::vector<std::size_t> found;
  std::string complaint;
};

Match match(std::span<const View> views, const std::string& entry) {
  Match match;
  for (const Reading reading : {Reading::name, Reading::glob, Reading::stem, Reading::file_name, Reading::file_stem}) {
    for (std::size_t v = 0; v < views.size(); ++v)
      if (fits(entry, views[v].name, reading) || fits(entry, io::photo_name(views[v]), reading))
        match.found.push_back(v);
    if (match.found.empty()) continue;
    const std::string photo = io::photo_name(views[match.found[0]]);
    for (const std::size_t v : match.found)
      if (const std::string other = io::photo_name(views[v]); is_single(reading) && other != photo)
        match.complaint = fmt::format("'{}' may be {} or {}; give the whole name", entry, photo, other);
    return match;
  }
  match.complaint = fmt::format("the scene has no view '{}'; near are {}", entry, near_names(views, entry));
  return match;
}

std::vector<bool> matched(std::span<const View> views, const std::string& option, const std::string& list) {
  std::vector<bool> hit(views.size(), false);
  for (const std::string& entry : listed(list)) {
    const Match found = match(views, entry);
    if (!found.complaint.empty()) throw UsageError(fmt::format("{}: {}", option, found.complaint));
    for (const std::size_t v : found.found) hit[v] = true;
  }
  return hit;
}

// The part of the mesh that a listed rule is about.
struct RegionReader {
  const std::filesystem::path& file;
  const io::ListedViewRule& listed;
  const checks::Input& input;

  io::Region region() const { return std::visit(*this, listed.region); }
  io::Region operator()(const io::BoxRegion& box) const { return pipeline::region_of(box, input.mesh); }
  io::Region operator()(const io::GroundRegion& ground) const {
    if (listed.srs.empty()) return pipeline::region_of(ground, input.mesh);
    try {
      return pipeline::region_of(ground, listed.srs, input);
    } catch (const pipeline::RegionError& error) {
      throw InputError(file, listed.place, error.what());
    }
  }
  io::Region operator()(const io::FaceRegion& faces) const {
    const std::size_t count = input.mesh.faces.size();
    for (const auto& [first, last] : faces.ranges)
      if (last >= count)
        throw InputError(file, listed.place, fmt::format("expected faces of 0 to {}, found {}", count - 1, last));
    return faces;
  }
  io::Region operator()(const io::PhotoRegion& shown) const {
    const Match found = match(input.scene.views, shown.photo);
    if (!found.complaint.empty()) throw InputError(file, listed.place, found.complaint);
    const std::span<const View> views = input.scene.views;
    std::vector<ViewId> of_photo;
    for (const std::size_t v : found.found) {
      if (io::photo_name(views[v]) != io::photo_name(views[found.found[0]]))
        throw InputError(file, listed.place,
                         fmt::format("'{}' means {} and {}; a rectangle is one of a single photo", shown.photo,
                                     io::photo_name(views[found.found[0]]), io::photo_name(views[v])));
      of_photo.push_back(ViewId{static_cast<std::uint32_t>(v)});
    }
    return pipeline::faces_shown(input, of_photo, shown.low, shown.high);
  }
};

// Visits the views of the views.json beside a model that have a name.
void for_each_view_in_json(const std::filesystem::path& model,
                           const std::function<void(const nlohmann::json&)>& visit) {
  const std::filesystem::path file = model.parent_path() / "views.json";
  io::refuse_special_file(file);
  std::ifstream in(file);
  const nlohmann::json json = nlohmann::json::parse(in, nullptr, false);
  if (!json.is_object() || !json.contains("views") || !json["views"].is_array()) return;
  for (const nlohmann::json& view : json["views"])
    if (view.is_object() && view.contains("name") && view["name"].is_string()) visit(view);
}

bool has_mark(const nlohmann::json& view, const std::string& mark) { return view.contains(mark) && view[mark] == true; }

// nullopt where the JSON is none.
std::optional<Pose> pose_from(const nlohmann::json& view) {
  const auto numbers = [](const nlohmann::json& list, double* to) {
    if (!list.is_array() || list.size() != 3) return false;
    for (std::size_t i = 0; i < 3; ++i) {
      if (!list[i].is_number()) return false;
      to[i] = list[i].get<double>();
    }
    return true;
  };
  Pose pose;
  std::array<double, 3> centre{};
  const auto rows = view.find("rotation"), place = view.find("centre");
  if (rows == view.end() || place == view.end() || !rows->is_array() || rows->size() != 3) return std::nullopt;
  for (std::size_t i = 0; i < 3; ++i)
    if (!numbers((*rows)[i], &pose.rotation[3 * i])) return std::nullopt;
  if (!numbers(*place, centre.data())) return std::nullopt;
  pose.centre = {centre[0], centre[1], centre[2]};
  return pose;
}

}  // namespace

std::vector<ViewId> used_views(std::span<const View> all, const std::string& views, const std::string& exclude_views) {
  std::vector<bool> wanted(all.size(), true), excluded(all.size(), false);
  if (!views.empty()) wanted = matched(all, "--views", views);
  if (!exclude_views.empty()) excluded = matched(all, "--exclude-views", exclude_views);
  std::vector<ViewId> used;
  for (std::size_t v = 0; v < all.size(); ++v)
    if (wanted[v] && !excluded[v]) used.push_back(ViewId{static_cast<std::uint32_t>(v)});
  if (used.empty()) throw UsageError("--views and --exclude-views leave no view");
  return used;
}

std::vector<bool> marked(std::span<const ViewId> views, std::size_t count) {
  std::vector<bool> marks(count, false);
  for (const ViewId id : views) marks[index(id)] = true;
  return marks;
}

std::vector<ViewId> held_out_views(const Scene& scene, std::span<const ViewId> used, const std::string& hold_out) {
  std::vector<ViewId> held;
  if (hold_out.empty()) return held;
  const bool named =
      std::any_of(scene.views.begin(), scene.views.end(), [&](const View& view) { return view.name == hold_out; });
  std::size_t every = 0;
  const char* end = hold_out.data() + hold_out.size();
  const auto [parsed, failed] = std::from_chars(hold_out.data(), end, every);
  if (!named && failed == std::errc{} && parsed == end) {
    if (every < 2)
      throw UsageError(fmt::format("--hold-out {}: every K-th photo is held out, and K is 2 or more", hold_out));
    // A panorama's views follow each other, and leave together.
    std::size_t photos = 0;
    std::string last;
    for (const ViewId id : used) {
      const std::string photo = io::photo_name(scene.views[index(id)]);
      if (photos == 0 || photo != last) ++photos;
      last = photo;
      if (photos % every == 0) held.push_back(id);
    }
    if (held.empty()) throw UsageError(fmt::format("--hold-out {}: there are only {} photos", hold_out, photos));
    return held;
  }
  const std::vector<bool> hit = matched(scene.views, "--hold-out", hold_out);
  std::copy_if(used.begin(), used.end(), std::back_inserter(held), [&](ViewId id) { return hit[index(id)]; });
  if (held.empty()) throw UsageError("--hold-out names only views that --views and --exclude-views leave out");
  if (held.size() == used.size()) throw UsageError("--hold-out leaves no view to texture from");
  return held;
}

std::vector<pipeline::ViewRule> read_rules(const std::filesystem::path& file, const checks::Input& input) {
  const std::span<const View> views = input.scene.views;
  std::vector<pipeline::ViewRule> rules;
  for (const io::ListedViewRule& listed : io::read_view_rules(file)) {
    std::vector<bool> hit(views.size(), false);
    for (const std::string& entry : listed.photos) {
      const Match found = match(views, entry);
      if (!found.complaint.empty()) throw InputError(file, listed.place, found.complaint);
      for (const std::size_t v : found.found) hit[v] = true;
    }
    pipeline::ViewRule rule{RegionReader{file, listed, input}.region(),
                            listed.allow,
                            {},
                            fmt::format("{}: {}", file.string(), listed.place)};
    for (std::uint32_t v = 0; v < views.size(); ++v)
      if (hit[v]) rule.views.push_back(ViewId{v});
    rules.push_back(std::move(rule));
  }
  return rules;
}

std::vector<std::string> marked_views(const std::filesystem::path& model, const std::string& mark) {
  std::vector<std::string> names;
  for_each_view_in_json(model, [&](const nlohmann::json& view) {
    if (has_mark(view, mark)) names.push_back(view["name"].get<std::string>());
  });
  return names;
}

std::vector<std::string> listed_views(const std::filesystem::path& model) {
  std::vector<std::string> names;
  for_each_view_in_json(model, [&](const nlohmann::json& view) { names.push_back(view["name"].get<std::string>()); });
  return names;
}

std::vector<Pose> used_poses(const std::filesystem::path& model) {
  std::vector<Pose> poses;
  for_each_view_in_json(model, [&](const nlohmann::json& view) {
    const std::optional<Pose> pose = has_mark(view, "used") ? pose_from(view) : std::nullopt;
    if (pose) poses.push_back(*pose);
  });
  return poses;
}

}  // namespace gpvc::cli
