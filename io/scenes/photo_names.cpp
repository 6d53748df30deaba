// Names of views out of the paths that scenes state.
#include <algorithm>

#include "io/files/text_scan.h"
#include "io/scenes/photo_files.h"
#include "io/scenes/photo_index.h"

namespace gpvc::io {

namespace {

bool is_drive(const std::string& part) { return part.size() == 2 && part[1] == ':'; }

/// True for a name that can be joined to a folder and can name outputs.
bool is_plain(const std::string& name) {
  const std::vector<std::string> parts = parts_of(name);
  return !parts.empty() && name.front() != '/' && !is_drive(parts.front()) && parts.front() != ".." &&
         name.find("/..") == std::string::npos;
}

/// Paths without their common folders and without parts that lead out of a folder; empty where nothing is left.
std::vector<std::string> below_shared_folder(const std::vector<std::vector<std::string>>& paths, bool with_drives) {
  std::size_t shared = paths.front().empty() ? 0 : paths.front().size() - 1;
  for (const auto& path : paths) {
    std::size_t same = 0;
    while (same < shared && same + 1 < path.size() && path[same] == paths.front()[same]) ++same;
    shared = same;
  }
  std::vector<std::string> below;
  for (const auto& path : paths) {
    std::string joined;
    for (std::size_t p = shared; p < path.size(); ++p) {
      if (path[p] == ".." || path[p] == "/" || (is_drive(path[p]) && !with_drives)) continue;
      joined += (joined.empty() ? "" : "/") + (is_drive(path[p]) ? path[p].substr(0, 1) : path[p]);
    }
    below.push_back(joined);
  }
  return below;
}

bool repeated(std::vector<std::string> names) {
  std::ranges::sort(names);
  return std::ranges::adjacent_find(names) != names.end();
}

}  // namespace

void normalize_names(SceneFile& scene) {
  if (!std::ranges::all_of(scene.views, is_plain, &View::name)) {
    std::vector<std::vector<std::string>> names;
    for (const View& view : scene.views) names.push_back(parts_of(view.name));
    // Drive letters distinguish photos only where their folders do not.
    std::vector<std::string> below = below_shared_folder(names, false);
    if (repeated(below)) below = below_shared_folder(names, true);
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (below[i].empty())
        throw InputError(scene.listing, "", "the image '" + scene.views[i].name + "' has no file name");
      View& view = scene.views[i];
      if (view.photo.empty() && (names[i].front() == "/" || is_drive(names[i].front()))) view.photo = view.name;
      view.name = below[i];
    }
  }
  std::ranges::sort(scene.views, {}, &View::name);
  const auto twice = std::ranges::adjacent_find(scene.views, {}, &View::name);
  if (twice != scene.views.end()) throw InputError(scene.listing, "", "lists the image '" + twice->name + "' twice");
}

}  // namespace gpvc::io
