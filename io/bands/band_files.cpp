#include "io/bands/band_files.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string_view>

#include "io/files/text_scan.h"
#include "io/images/image_file.h"
#include "io/scenes/bad_photos.h"
#include "io/scenes/layers.h"
#include "io/scenes/photo_index.h"

namespace gpvc::io {
namespace {

struct Suffix {
  std::string_view text;  ///< small letters
  int order;
  const char* band;
};
constexpr Suffix kSuffixes[] = {{"_ms_g", 2, "Green"},   {"_ms_re", 4, "Red edge"}, {"_ms_r", 3, "Red"},
                                {"_ms_nir", 5, "NIR"},   {"_gre", 2, "Green"},      {"_red", 3, "Red"},
                                {"_reg", 4, "Red edge"}, {"_nir", 5, "NIR"}};
constexpr Suffix kFolders[] = {
    {"blue", 1, "Blue"}, {"green", 2, "Green"}, {"rededge", 4, "Red edge"}, {"red", 3, "Red"}, {"nir", 5, "NIR"}};

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool ends_in_digits(std::string_view text, std::size_t count) {
  return text.size() >= count && std::ranges::all_of(text.substr(text.size() - count), is_digit);
}

/// MicaSense's number behind the last underscore, with the photo's number of four digits before it.
std::optional<int> number_of_band(std::string_view stem) {
  const std::size_t bar = stem.rfind('_');
  if (bar == std::string_view::npos || !ends_in_digits(stem.substr(0, bar), 4)) return std::nullopt;
  const auto number = integer_from<int>(stem.substr(bar + 1));
  constexpr int kMost = 10;
  return number && *number >= 1 && *number <= kMost ? number : std::nullopt;
}

/// DJI's Phantom 4 Multispectral counts all files: DJI_0010.JPG is in colour, DJI_0011.TIF to DJI_0015.TIF are the bands.
constexpr const char* kPhantomBands[] = {"Blue", "Green", "Red", "Red edge", "NIR"};
std::optional<int> phantom_band(std::string_view stem) {
  constexpr std::string_view kBefore = "dji_";
  constexpr std::size_t kDigits = 4;
  if (stem.size() != kBefore.size() + kDigits || !stem.starts_with(kBefore) || !ends_in_digits(stem, kDigits))
    return std::nullopt;
  const int last = stem.back() - '0';
  return last >= 1 && last <= 5 ? std::optional(last) : std::nullopt;
}

/// The band that a folder is named after: letters alone count.
const Suffix* band_of_folder(const fs::path& folder) {
  std::string letters;
  for (const char c : lower_case(folder.filename().string()))
    if (c >= 'a' && c <= 'z') letters += c;
  const auto* found = std::ranges::find(kFolders, letters, &Suffix::text);
  return found == std::end(kFolders) ? nullptr : found;
}

bool is_tiff(const fs::path& file) {
  const std::string extension = lower_case(file.extension().string());
  return extension == ".tif" || extension == ".tiff";
}

std::vector<fs::path> folders_beside(const fs::path& folder) {
  std::vector<fs::path> all;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder_of(folder), ignored))
    if (is_folder(entry.path()) && band_of_folder(entry.path()) != nullptr) all.push_back(entry.path());
  std::ranges::sort(all);
  return all;
}

void forget_without(SceneFile& scene, std::size_t view, bool needed, const std::string& band, const fs::path& folder) {
  forget_photo(scene, view, needed, BadPhoto::Problem::unreadable,
               "there is no file of its band " + quote(band) + " in " + folder.string());
}

/// True if a file of a group is the photo of another view: its bands are views of their own.
bool are_views(const SceneFile& scene, const std::vector<std::map<int, BandMember>>& groups) {
  std::set<fs::path> photos;
  for (const View& view : scene.views)
    if (!view.photo.empty()) photos.insert(real_path(view.photo));
  for (std::size_t i = 0; i < scene.views.size(); ++i)
    for (const auto& [order, member] : groups[i])
      if (member.file != scene.views[i].photo && photos.contains(real_path(member.file))) return true;
  return false;
}

void find_by_name(SceneFile& scene, const std::vector<bool>& needed) {
  BandGroups groups;
  std::vector<std::map<int, BandMember>> found(scene.views.size());
  std::size_t wanting = 0, grouped = 0;
  std::map<int, BandMember> all;  // bands of any view
  std::set<int> primaries;        // orders of the views' own files
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    if (scene.views[i].photo.empty()) continue;
    wanting += needed[i] ? 1 : 0;
    found[i] = groups.of(scene.views[i].photo);
    if (!needed[i] || found[i].size() < 2) continue;
    ++grouped;
    primaries.insert(band_file_name(scene.views[i].photo)->order);
    all.insert(found[i].begin(), found[i].end());
  }
  if (primaries.size() != 1 || 2 * grouped < wanting || are_views(scene, found)) return;
  std::erase_if(all, [&](const auto& band) {
    const BandMember& member = band.second;
    for (std::size_t i = 0; i < scene.views.size(); ++i) {
      const auto here = found[i].find(band.first);
      if (here == found[i].end() || here->second.file != member.file) continue;
      const std::string why = misfit_of_band(member.file, scene.views[i].photo);
      if (!why.empty())
        scene.warnings.push_back("the band " + quote(member.band()) + " is left out: " + member.file.string() + " " +
                                 why);
      return !why.empty();
    }
    return false;
  });
  if (all.size() < 2) return;
  for (const auto& [order, member] : all) scene.band_names.push_back(member.name.band);
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    View& view = scene.views[i];
    if (view.photo.empty()) continue;
    std::vector<fs::path> files;
    for (const auto& [order, member] : all)
      if (const auto here = found[i].find(order); here != found[i].end())
        files.push_back(here->second.file);
      else
        forget_without(scene, i, needed[i], member.band(), folder_of(view.photo));
    if (files.size() == all.size()) view.band_files = std::move(files);
  }
}

/// The files of one band in a folder that is given.
class BandIndex {
 public:
  explicit BandIndex(const BandFolder& band) : band_(band), index_(band.folder, true) {
    std::set<fs::path> seen;  // a link may lead to a file a second time
    for (const fs::path& file : index_.files())
      if (const auto name = band_file_name(file); name && seen.insert(real_path(file)).second)
        groups_.emplace(name->group, file);
  }

  /// Empty: there is none, or several.
  fs::path of(const View& view, const fs::path& listing) const {
    const fs::path name = view.name;
    for (const fs::path& wanted : {name, name.parent_path() / name.stem()}) try {
        if (fs::path file = index_.match(listing, wanted.string(), band_.folder / view.name); !file.empty())
          return file;
      } catch (const InputError&) {  // several
      }
    const auto own = band_file_name(view.photo);
    const std::string group = own ? own->group : lower_case(view.photo.stem().string());
    return groups_.count(group) == 1 ? groups_.find(group)->second : fs::path();
  }

 private:
  const BandFolder& band_;
  PhotoIndex index_;
  std::multimap<std::string, fs::path> groups_;
};

void find_in_folders(SceneFile& scene, const std::vector<bool>& needed, const std::vector<BandFolder>& bands) {
  std::vector<BandIndex> indices;
  std::set<std::string> names;
  for (const BandFolder& band : bands) {
    if (!names.insert(lower_case(band.name)).second)
      throw InputError(band.folder, "",
                       "is given for the band " + quote(band.name) + ", which another folder is given for");
    if (!is_folder(band.folder))
      throw InputError(band.folder, "", "is not a folder; it was given as that of the band " + quote(band.name));
    indices.emplace_back(band);
  }
  bool own = true;  // the photos are none of the bands' files
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    View& view = scene.views[i];
    if (view.photo.empty()) continue;
    std::vector<fs::path> files;
    for (std::size_t band = 0; band < bands.size(); ++band) {
      fs::path file = indices[band].of(view, scene.listing);
      if (file.empty()) {
        forget_without(scene, i, needed[i], bands[band].name, bands[band].folder);
        break;
      }
      if (real_path(file) == real_path(view.photo)) {
        file = view.photo;
        own = false;
      }
      files.push_back(std::move(file));
    }
    if (files.size() == bands.size()) view.band_files = std::move(files);
  }
  if (own) scene.band_names.emplace_back();
  for (const BandFolder& band : bands) scene.band_names.push_back(band.name);
  for (View& view : scene.views)
    if (own && !view.band_files.empty()) view.band_files.insert(view.band_files.begin(), view.photo);
}

}  // namespace

std::optional<BandFileName> band_file_name(const fs::path& file) {
  if (!is_tiff(file)) return std::nullopt;
  const std::string stem = lower_case(file.stem().string());
  for (const Suffix& suffix : kSuffixes)
    if (stem.size() > suffix.text.size() && stem.ends_with(suffix.text))
      return BandFileName{stem.substr(0, stem.size() - suffix.text.size()), suffix.order, suffix.band, false};
  if (const auto number = number_of_band(stem); number)
    return BandFileName{stem.substr(0, stem.rfind('_')), *number, {}, false};
  if (const auto band = phantom_band(stem); band)
    return BandFileName{stem.substr(0, stem.size() - 1), *band, kPhantomBands[*band - 1], false};
  if (const Suffix* folder = band_of_folder(folder_of(file)))
    return BandFileName{stem, folder->order, folder->band, true};
  return std::nullopt;
}

std::map<int, BandMember> BandGroups::of(const fs::path& photo) {
  const std::optional<BandFileName> own = band_file_name(photo);
  std::map<int, BandMember> members;
  if (!own) return members;
  for (const fs::path& folder : own->by_folder ? folders_beside(folder_of(photo)) : std::vector{folder_of(photo)}) {
    const auto [first, end] = in_folder(folder).equal_range(own->group);
    for (auto it = first; it != end; ++it)
      if (it->second.file.extension() == photo.extension()) members.emplace(it->second.name.order, it->second);
  }
  members.insert_or_assign(own->order, BandMember{*own, photo});
  return members;
}

const std::multimap<std::string, BandMember>& BandGroups::in_folder(const fs::path& folder) {
  const auto [found, added] = folders_.try_emplace(folder);
  std::error_code ignored;
  std::set<fs::path> files;
  if (added)
    for (const auto& entry : fs::directory_iterator(folder, ignored)) files.insert(entry.path());
  for (const fs::path& file : files)
    if (const auto name = band_file_name(file)) found->second.emplace(name->group, BandMember{*name, file});
  return found->second;
}

std::string misfit_of_band(const fs::path& file, const fs::path& photo) {
  const PhotoHeader a = read_photo_header(file), b = read_photo_header(photo);
  if (a.size.width != b.size.width || a.size.height != b.size.height)
    return "is " + size_text(a.size.width, a.size.height) + " pixels, not " + size_text(b.size.width, b.size.height);
  if (a.type != b.type) return "is of another type of samples";
  if (a.channels - (a.alpha_channel >= 0 ? 1 : 0) != 1) return "holds more than one band";
  return {};
}

void find_band_files(SceneFile& scene, const std::vector<bool>& needed, const SceneOptions& options) {
  if (!options.bands.empty())
    find_in_folders(scene, needed, options.bands);
  else if (options.bands_by_name)
    find_by_name(scene, needed);
}

}  // namespace gpvc::io
