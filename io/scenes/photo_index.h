// Files looked for by the tails of their paths.
#pragma once

#include <cstddef>
#include <filesystem>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

namespace gpvc::io {

/// "a/b/../c" as {a, c}; leading "..", "/" and "C:" stay as parts of their own.
std::vector<std::string> parts_of(const std::string& path);

/// The path with all links resolved; the path itself where that fails.
std::filesystem::path real_path(const std::filesystem::path& path);

/// Number of path parts equal from the end: exactly, or ignoring case; `by_stem` ignores the file name's extension.
std::size_t common_tail(const std::vector<std::string>& a, const std::vector<std::string>& b, bool exact, bool by_stem);

/// The files in and below a folder, by file name in small letters, and by that without extension.
class PhotoIndex {
 public:
  /// `deep`: with all folders below it, behind links too.
  PhotoIndex(const std::filesystem::path& folder, bool deep);
  void add(const std::filesystem::path& path);

  /// The file whose path has the longest tail in common with `wanted`, `preferred` where several have; empty when none
  /// fits. Throws when several fit equally well.
  std::filesystem::path match(const std::filesystem::path& listing, const std::string& wanted,
                              const std::filesystem::path& preferred) const;

  /// All of them, in any order.
  std::vector<std::filesystem::path> files() const;

  /// The name of a photo that is none of `taken` and differs from `wanted` as a slip of the pen does; empty: there is none.
  std::string near(const std::string& wanted, const std::set<std::filesystem::path>& taken) const;

 private:
  struct File {
    std::filesystem::path path;
    std::vector<std::string> parts;
  };
  using Index = std::unordered_map<std::string, std::vector<File>>;

  template <class Iterator>
  void add_below(const std::filesystem::path& folder, std::set<std::filesystem::path>& links);
  void follow(std::set<std::filesystem::path>& links);
  static std::vector<std::filesystem::path> best(const std::vector<std::string>& tail, const Index& index,
                                                 const std::string& key, bool exact, bool by_stem);
  std::filesystem::path only(std::vector<std::filesystem::path> found, const std::filesystem::path& listing,
                             const std::string& wanted, const std::filesystem::path& preferred) const;

  std::filesystem::path folder_;
  Index by_name_, by_stem_;
};

}  // namespace gpvc::io
