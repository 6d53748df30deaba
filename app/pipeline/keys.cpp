#include "app/pipeline/keys.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>
#include <variant>

#include "app/pipeline/options.h"
#include "io/tie_points.h"

namespace gpvc::pipeline {
namespace {

void add_mesh(io::WorkHash& hash, const Mesh& mesh) {
  hash.add(mesh.positions);
  hash.add(mesh.faces);
}

void add_layout(io::WorkHash& hash, const io::UvLayout& layout) {
  hash.add(layout.texcoords);
  hash.add(layout.face_texcoords);
  hash.add(layout.face_page);
  for (const io::UvPage& page : layout.pages) {
    hash.add(page.width);
    hash.add(page.height);
  }
}

// What the view's name and files are called does not matter.
void add_view(io::WorkHash& hash, const View& view) {
  hash.add(view.pose);
  hash.add(view.camera);
}

// The keys of the views' photos; nullopt for those of unknown bytes.
std::vector<std::optional<io::WorkKey>> photo_keys(const Run& run) {
  std::vector<std::optional<io::WorkKey>> keys(run.input.views.size());
  tbb::parallel_for(std::size_t{0}, keys.size(), [&](std::size_t n) {
    run.observer.check_cancelled();
    keys[n] = run.photos.key(run.input.views[n]);
  });
  return keys;
}

// The file that this code was loaded from, if that is a shared library of somebody else's program.
std::optional<std::string> shared_library() {
  const auto here = reinterpret_cast<std::uintptr_t>(&add_mesh);
  std::error_code none;
  const std::string program = std::filesystem::read_symlink("/proc/self/exe", none);
  std::ifstream maps("/proc/self/maps");  // lines such as "55d0c000-55d0f000 r-xp 00002000 08:01 1234    /usr/bin/name"
  for (std::string line; std::getline(maps, line);) {
    const std::uintptr_t begin = std::stoull(line, nullptr, 16),
                         end = std::stoull(line.substr(line.find('-') + 1), nullptr, 16);
    const std::size_t path = line.find('/');
    if (here >= begin && here < end && path != std::string::npos && line.substr(path) != program)
      return line.substr(path);
  }
  return std::nullopt;
}

// Of what all parts come from. nullopt if this program cannot be read.
std::optional<io::WorkKey> common_key(const Run& run) {
  io::WorkHash hash;
  try {
    hash.add_file("/proc/self/exe");
    if (const auto library = shared_library()) hash.add_file(*library);
  } catch (const InputError&) {
    return std::nullopt;
  }
  if (const auto tie_points = io::tie_points_file(run.input.scene)) try {
      hash.add_file(*tie_points);
    } catch (const InputError&) {
      hash.add(std::string_view("unreadable"));  // of which a run that needs them warns
    }
  add_mesh(hash, run.input.mesh);
  add_options(hash, run.settings, Affects::views);
  return hash.key();
}

// The names of views that another list has not.
std::vector<std::string> missing_in(const std::vector<ViewKeys>& others, const std::vector<ViewKeys>& views) {
  std::vector<std::string> names;
  for (const ViewKeys& each : views)
    if (std::ranges::find(others, each.view, &ViewKeys::view) == others.end()) names.push_back(each.name);
  return names;
}

std::string difference(const std::vector<ViewKeys>& result, const std::vector<ViewKeys>& now) {
  constexpr std::size_t kMost = 3;
  if (!std::ranges::equal(result, now, {}, &ViewKeys::view, &ViewKeys::view)) {
    if (const auto names = missing_in(now, result); !names.empty())
      return fmt::format("was textured with photos that are not among those given: {}",
                         results::readable_list(names, kMost));
    return fmt::format("was textured without photos that are given now: {}",
                       results::readable_list(missing_in(result, now), kMost));
  }
  std::vector<std::string> photos, cameras;
  for (std::size_t n = 0; n < now.size(); ++n) {
    if (result[n].photo != now[n].photo) photos.push_back(now[n].name);
    if (result[n].camera != now[n].camera) cameras.push_back(now[n].name);
  }
  if (!cameras.empty())
    return fmt::format("was textured with other cameras or poses of {}", results::readable_list(cameras, kMost));
  if (!photos.empty())
    return fmt::format("was textured with other bytes of photos or masks: {}", results::readable_list(photos, kMost));
  return {};
}

template <typename Value>
std::string option_text(const Value& value) {
  if constexpr (IsNamed<Value>)
    return name_of(names_of(value), value);
  else if constexpr (std::same_as<Value, visibility::Method>)
    return visibility::visibility_mode_name(value);
  else if constexpr (std::is_arithmetic_v<Value>)
    return fmt::format("{}", value);
  else
    return fmt::format("{}", fmt::join(value, ","));
}

std::vector<OptionText> option_texts(const Settings& settings, Affects result) {
  std::vector<OptionText> texts;
  for_each_option(settings, [&](const auto& value, const OptionInfo& info) {
    if constexpr (!std::same_as<std::remove_cvref_t<decltype(value)>, std::vector<ViewRule>>)
      if (info.affects <= result) texts.push_back({info.name, option_text(value)});
  });
  return texts;
}

}  // namespace

std::optional<StepKeys> step_keys(const Run& run) {
  const std::optional<io::WorkKey> common = common_key(run);
  if (!common) return std::nullopt;
  StepKeys keys;
  io::WorkHash labels;
  for (std::size_t n = 0; const std::optional<io::WorkKey>& photo : photo_keys(run)) {
    if (!photo) return std::nullopt;
    const ViewId id = run.input.views[n++];
    io::WorkHash hash;
    hash.add(*common);
    hash.add(*photo);
    add_view(hash, run.input.scene.views[index(id)]);
    keys.views[id] = hash.key();
    labels.add(id);
    labels.add(hash.key());
  }
  add_options(labels, run.settings, Affects::labels);
  labels.add(run.settings.allow_misfit);  // where labels are kept, the mesh was found right or this was given
  for (const ViewRule& rule : run.settings.view_rules) {  // whatever they are called
    labels.add(rule.region);
    labels.add(rule.allow);
    labels.add(rule.views);
  }
  keys.labels = labels.key();
  io::WorkHash pages;
  pages.add(keys.labels);
  add_options(pages, run.settings, Affects::pages);
  if (run.input.layout != nullptr) add_layout(pages, *run.input.layout);
  keys.pages = pages.key();
  return keys;
}

ResultKeys result_keys(const Run& run) {
  Settings settings = run.settings;
  if (std::holds_alternative<visibility::Gpvc>(settings.visibility.method))
    settings.device = Settings{}.device;  // classes are the same on all of them
  io::WorkHash mesh, options;
  add_mesh(mesh, run.input.mesh);
  std::vector<ViewKeys> views;
  for (std::size_t n = 0; const std::optional<io::WorkKey>& photo : photo_keys(run)) {
    const ViewId id = run.input.views[n++];
    const View& view = run.input.scene.views[index(id)];
    io::WorkHash camera;
    add_view(camera, view);
    views.push_back({id, view.name, photo.value_or(io::WorkKey{}), camera.key()});
  }
  add_options(options, settings, Affects::page_files);
  if (run.input.layout != nullptr) add_layout(options, *run.input.layout);
  return {mesh.key(), std::move(views), options.key(), option_texts(settings, Affects::page_files)};
}

std::string difference(const ResultKeys& result, const ResultKeys& now) {
  if (result.mesh != now.mesh) return "was textured from another mesh";
  const std::string views = difference(result.views, now.views);
  if (!views.empty() || result.options == now.options) return views;
  for (std::size_t n = 0; n < std::min(result.option_texts.size(), now.option_texts.size()); ++n)
    if (const OptionText& before = result.option_texts[n], &after = now.option_texts[n]; before.text != after.text)
      return fmt::format("was textured with {} {}, and {} is asked for now", before.name, before.text, after.text);
  return "was textured with other steps of visibility, or on other texture coordinates";
}

}  // namespace gpvc::pipeline
