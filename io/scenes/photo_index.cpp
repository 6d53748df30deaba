#include "io/scenes/photo_index.h"

#include <utf8proc.h>

#include <algorithm>
#include <cstdlib>
#include <memory>

#include "io/error.h"
#include "io/files/paths.h"
#include "io/files/text_scan.h"
#include "io/images.h"
#include "io/near_words.h"

namespace gpvc::io {

namespace {

/// For comparing names: in small letters, and accents in one piece with their letters (Unicode's NFC; macOS takes them
/// apart).
std::string folded(const std::string& name) {
  std::unique_ptr<utf8proc_uint8_t, decltype(&std::free)> composed(
      utf8proc_NFC(reinterpret_cast<const utf8proc_uint8_t*>(name.c_str())), &std::free);
  return lower_case(composed ? reinterpret_cast<const char*>(composed.get()) : name.c_str());  // null: no UTF-8
}

/// \pre both are real paths
bool lies_in(const fs::path& inner, const fs::path& outer) {
  const fs::path relative = inner.lexically_relative(outer);
  return !relative.empty() && *relative.begin() != "..";
}

bool has_extension(const fs::path& name, std::initializer_list<std::string_view> extensions) {
  return std::ranges::find(extensions, lower_case(name.extension().string())) != extensions.end();
}

/// Raw formats, which cameras write beside the photos that they develop themselves.
bool is_raw(const fs::path& name) {
  return has_extension(name, {".dng", ".arw", ".cr2", ".cr3", ".nef", ".orf", ".pef", ".raf", ".rw2"});
}

}  // namespace

bool has_image_extension(const fs::path& name) {
  return is_raw(name) || has_extension(name, {".jpg",  ".jpeg", ".jpe",  ".png",  ".tif", ".tiff", ".exr",
                                              ".webp", ".bmp",  ".jp2",  ".j2k",  ".pgm", ".ppm",  ".pnm",
                                              ".hdr",  ".heic", ".heif", ".avif", ".psd", ".dpx",  ".tga"});
}

std::vector<std::string> parts_of(const std::string& path) {
  std::vector<std::string> parts;
  for (const fs::path& part : fs::path(path).lexically_normal())
    if (!part.empty() && part != ".") parts.push_back(part.string());
  return parts;
}

fs::path real_path(const fs::path& path) {
  std::error_code failed;
  const fs::path real = fs::canonical(path, failed);
  return failed ? path.lexically_normal() : real;
}

std::size_t common_tail(const std::vector<std::string>& a, const std::vector<std::string>& b, bool exact,
                        bool by_stem) {
  const auto same = [&](const std::string& x, const std::string& y) {
    return exact ? x == y : folded(x) == folded(y) || (by_stem && &x == &a.back());
  };
  const auto end = std::mismatch(a.rbegin(), a.rend(), b.rbegin(), b.rend(), same).first;
  return static_cast<std::size_t>(end - a.rbegin());
}

/// Files are added, links to folders collected.
template <class Iterator>
void PhotoIndex::add_below(const fs::path& folder, std::set<fs::path>& links) {
  std::error_code error, ignored;
  for (Iterator it(folder, fs::directory_options::skip_permission_denied, error); !error && it != Iterator();
       it.increment(error)) {
    if (it->is_symlink(ignored) && is_folder(it->path())) {
      links.insert(it->path());
    } else if (it->path().filename() == ".texture" || it->path().filename() == ".mask" ||
               it->path().filename() == ".geometry") {
      // RealityCapture's layers have the names of their photos.
      if constexpr (requires { it.disable_recursion_pending(); }) it.disable_recursion_pending();
    } else {
      add(it->path());
    }
  }
}

/// Links to folders are followed in the order of their paths. A folder that several lead to is entered under each of
/// their names, since names are what `match` goes by, but once under each, and by none that lies in it: that ends all
/// loops.
void PhotoIndex::follow(std::set<fs::path>& links) {
  std::set<std::pair<fs::path, fs::path>> entered;
  while (!links.empty()) {
    const fs::path link = links.extract(links.begin()).value(), target = real_path(link);
    if (lies_in(real_path(link.parent_path()), target)) continue;
    if (entered.emplace(target, link.filename()).second) add_below<fs::recursive_directory_iterator>(link, links);
  }
}

PhotoIndex::PhotoIndex(const fs::path& folder, bool deep) : folder_(folder) {
  std::set<fs::path> links;
  if (deep) {
    add_below<fs::recursive_directory_iterator>(folder, links);
    follow(links);
  } else {
    add_below<fs::directory_iterator>(folder, links);
  }
}

void PhotoIndex::add(const fs::path& path) {
  if (!is_file(path)) return;
  const File file{path, parts_of(path.string())};
  by_name_[folded(path.filename().string())].push_back(file);
  if (has_image_extension(path)) by_stem_[folded(path.stem().string())].push_back(file);
}

std::vector<fs::path> PhotoIndex::files() const {
  std::vector<fs::path> all;
  for (const auto& [name, files] : by_name_)
    for (const File& file : files) all.push_back(file.path);
  return all;
}

std::vector<fs::path> PhotoIndex::best(const std::vector<std::string>& tail, const Index& index, const std::string& key,
                                       bool exact, bool by_stem) {
  const auto candidates = index.find(key);
  if (candidates == index.end()) return {};
  std::size_t longest = 0;
  std::vector<fs::path> found;
  for (const File& file : candidates->second) {
    const std::size_t common = common_tail(tail, file.parts, exact, by_stem);
    if (common == 0 || common < longest) continue;
    if (common > longest) found.clear();
    longest = common;
    found.push_back(file.path);
  }
  return found;
}

fs::path PhotoIndex::only(std::vector<fs::path> found, const fs::path& listing, const std::string& wanted,
                          const fs::path& preferred) const {
  if (found.size() == 1) return found.front();
  if (std::find(found.begin(), found.end(), preferred) != found.end()) return preferred;
  std::sort(found.begin(), found.end());
  std::set<fs::path> files;
  std::erase_if(found, [&](const fs::path& path) { return !files.insert(real_path(path)).second; });
  if (found.size() == 1) return found.front();
  std::string names;
  for (std::size_t i = 0; i < found.size() && i < 5; ++i)
    names += (i == 0 ? "" : ", ") + found[i].lexically_relative(folder_).string();
  throw InputError(listing, "",
                   "the photo '" + wanted + "' could be any of " + std::to_string(found.size()) + " files in " +
                       folder_.string() + ": " + names + (found.size() > 5 ? ", ..." : ""));
}

fs::path PhotoIndex::match(const fs::path& listing, const std::string& wanted, const fs::path& preferred) const {
  const std::vector<std::string> tail = parts_of(wanted);
  const std::string key = folded(tail.back());
  for (const bool exact : {true, false})
    if (const auto found = best(tail, by_name_, key, exact, false); !found.empty())
      return only(found, listing, wanted, preferred);
  auto found = best(tail, by_stem_, key, false, true);
  // OpenSfM names undistorted photos NAME.jpg.jpg. NAME.jpg.png would be a mask.
  if (has_image_extension(tail.back()))
    std::erase_if(found, [&](const fs::path& path) {
      return lower_case(path.extension().string()) != lower_case(fs::path(key).extension().string());
    });
  if (!std::all_of(found.begin(), found.end(), is_raw)) std::erase_if(found, is_raw);
  return found.empty() ? fs::path() : only(found, listing, wanted, preferred);
}

std::string PhotoIndex::near(const std::string& wanted, const std::set<fs::path>& taken) const {
  std::vector<std::string> names;
  for (const auto& [name, files] : by_name_)
    for (const File& file : files)
      if (has_image_extension(file.path) && !taken.contains(file.path)) names.push_back(file.parts.back());
  const std::string name = parts_of(wanted).back();
  const std::vector<std::string> nearest = near_words(name, names, 1, 1 + name.size() / 4);
  return nearest.empty() ? std::string() : nearest.front();
}

}  // namespace gpvc::io
