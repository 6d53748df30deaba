#include "io/scenes/layers.h"

#include "io/files/paths.h"
#include "io/files/text_scan.h"

namespace gpvc::io {

std::span<const char* const> layer_endings() {
  static constexpr const char* kEndings[] = {".png", ".jpg", ".jpeg", ".tif", ".tiff"};
  return kEndings;
}

const FolderNames::Names& FolderNames::names_in(const fs::path& folder) {
  const auto [found, added] = folders_.try_emplace(folder);
  Names& names = found->second;
  std::error_code error;
  if (added)
    for (fs::directory_iterator it(folder.empty() ? "." : folder, error); !error && it != fs::directory_iterator();
         it.increment(error))
      names.exact.emplace(it->path().filename().string(), folder / it->path().filename());
  if (added)
    for (const auto& [name, path] : names.exact) names.folded.emplace(lower_case(name), path);
  return names;
}

fs::path FolderNames::find(const fs::path& wanted) {
  const Names& names = names_in(wanted.parent_path());
  const std::string name = wanted.filename().string();
  if (const auto exact = names.exact.find(name); exact != names.exact.end())
    return is_file(exact->second) ? exact->second : fs::path();
  const auto folded = names.folded.find(lower_case(name));
  return folded != names.folded.end() && is_file(folded->second) ? folded->second : fs::path();
}

fs::path FolderNames::find_layer(const fs::path& photo, const std::string& layer) {
  const fs::path inside = photo.parent_path() / ("." + layer) / photo.filename();
  if (fs::path found = find(inside); !found.empty()) return found;
  for (const std::string ending : layer_endings())
    for (const fs::path& candidate : {fs::path(inside.string() + ending), fs::path(inside).replace_extension(ending),
                                      fs::path(photo.string() + "." + layer + ending)})
      if (fs::path found = find(candidate); !found.empty()) return found;
  return {};
}

}  // namespace gpvc::io
