#include "io/scenes/bad_photos.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "io/images.h"
#include "io/photos.h"
#include "io/scene_files.h"

namespace gpvc::io {
namespace {

using Problem = BadPhoto::Problem;

std::string clause_of(Problem problem, const fs::path& folder) {
  switch (problem) {
    case Problem::missing:
      return "are not in " + folder.string();
    case Problem::ambiguous:
      return "could be any of several files";
    case Problem::unreadable:
      return "cannot be read";
    case Problem::truncated:
      return "end too early";
    case Problem::damaged:
      return "are damaged";
    case Problem::turned:
      return "have been turned by a quarter";
    case Problem::other_shape:
      return "are of another shape than their cameras";
  }
  return {};
}

/// "3 of 15 photos are damaged: A (WHY), B (WHY), C (WHY); 1 of 15 photos ..."
std::string all_of_them(const SceneFile& scene, const fs::path& folder) {
  constexpr std::size_t kMostNames = 50;  // of a kind; a wrong folder lacks all photos of a flight
  std::string text;
  for (const auto& [name, problem] : kPhotoProblemNames) {
    std::size_t count = 0;
    std::string named;
    for (const BadPhoto& photo : scene.bad_photos) {
      if (photo.problem != problem || ++count > kMostNames) continue;
      named += (named.empty() ? "" : ", ") + photo.view;
      if (!photo.reason.empty()) named += " (" + photo.reason + ")";
    }
    if (count == 0) continue;
    if (count > kMostNames) named += ", and " + std::to_string(count - kMostNames) + " more";
    text += (text.empty() ? "" : "; ") + std::to_string(count) + " of " + std::to_string(scene.views.size()) +
            " photos " + clause_of(problem, folder) + ": " + named;
  }
  return text;
}

void forget_where(SceneFile& scene, const std::vector<bool>& needed, Problem problem,
                  void (*check)(const fs::path& file)) {
  const std::vector<std::exception_ptr> errors = for_each_photo(scene.views, [&](std::size_t i) {
    if (!needed[i]) return;
    check(scene.views[i].photo);
    for (const fs::path& file : scene.views[i].band_files)
      if (file != scene.views[i].photo) check(file);
  });
  for (std::size_t i = 0; i < errors.size(); ++i) try {
      if (errors[i]) std::rethrow_exception(errors[i]);
    } catch (const InputError& error) {
      forget_photo(scene, i, true, problem, reason_of(error, scene.views[i].photo));
    }
}

}  // namespace

void forget_photo(SceneFile& scene, std::size_t view, bool needed, Problem problem, const std::string& reason) {
  scene.views[view].photo.clear();
  if (needed) scene.bad_photos.push_back({scene.views[view].name, problem, reason});
}

std::string reason_of(const InputError& error, const fs::path& file) {
  const std::string text = error.what(), before = file.string() + ": ";
  return text.starts_with(before) ? text.substr(before.size()) : text;
}

void forget_truncated_photos(SceneFile& scene, const std::vector<bool>& needed) {
  forget_where(scene, needed, Problem::truncated, check_photo_end);
}

void forget_damaged_photos(SceneFile& scene, const std::vector<bool>& needed) {
  forget_where(scene, needed, Problem::damaged, [](const fs::path& file) { read_image(file); });
}

std::vector<std::exception_ptr> for_each_photo(std::span<const View> views,
                                               const std::function<void(std::size_t)>& work) {
  std::vector<std::exception_ptr> errors(views.size());
  tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t i) {
    try {
      if (!views[i].photo.empty()) work(i);
    } catch (const InputError&) {
      errors[i] = std::current_exception();
    }
  });
  return errors;
}

void throw_together(std::span<const std::exception_ptr> errors, const std::string& what,
                    const std::vector<Cure>& cures) {
  std::vector<std::string> sentences;
  for (const std::exception_ptr& each : errors) try {
      if (each) std::rethrow_exception(each);
    } catch (const InputError& error) {  // of one file for several views: once
      if (std::ranges::find(sentences, error.what()) == sentences.end()) sentences.emplace_back(error.what());
    }
  if (sentences.empty()) return;
  std::string all;
  for (const std::string& sentence : sentences) all += (all.empty() ? "" : "; ") + sentence;
  throw InputError(sentences.size() == 1 ? all : std::to_string(sentences.size()) + " " + what + ": " + all, cures);
}

void refuse_bad_photos(SceneFile& scene, std::vector<bool>& needed, const fs::path& folder, bool skip) {
  if (scene.bad_photos.empty()) return;
  const auto all = static_cast<std::size_t>(std::ranges::count(needed, true));
  const std::string text = all_of_them(scene, folder);
  std::vector<Cure> cures;
  if (scene.bad_photos.size() < all && !skip) cures.push_back(Cure::skip_bad_photos);
  if (std::ranges::count(scene.bad_photos, Problem::missing, &BadPhoto::problem) > 0)
    cures.push_back(Cure::photos_folder);
  if (!skip || scene.bad_photos.size() >= all) throw InputError(scene.listing, "", text, cures);
  scene.warnings.push_back("left out: " + text);
  for (const BadPhoto& photo : scene.bad_photos)
    for (std::size_t i = 0; i < scene.views.size(); ++i)
      if (scene.views[i].name == photo.view) needed[i] = false;
}

}  // namespace gpvc::io
