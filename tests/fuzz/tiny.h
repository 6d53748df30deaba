// A scene of some 300 faces and three photos, and the files that runs leave of it: for targets that read what the program
// itself has stored. Such files have hashes; a target repairs them, since a right hash makes no value right.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "app/checks/input.h"
#include "app/pipeline/settings.h"
#include "fuzz.h"
#include "io/work_store.h"

namespace gpvc::fuzz {

struct Tiny {
  Scene scene;  ///< its photos are files in folder()
  Mesh mesh;
  std::vector<ViewId> views;
  checks::Input input() const { return {scene, mesh, views}; }
};
/// Made once.
const Tiny& tiny();
/// That texture it, though it is too small for any check.
pipeline::Settings tiny_settings();

std::string read(const std::filesystem::path& file);

/// What lies between head and hash of a file of io::WorkStore.
std::string stored(const std::filesystem::path& file);
/// Replaces that, and makes the hash right, also in `list`, if there is one.
void store(const std::filesystem::path& file, std::string_view body, const char* list = "");

/// The files below a folder as they are, to be had again.
class Snapshot {
 public:
  explicit Snapshot(std::filesystem::path folder);
  void restore() const;

 private:
  std::filesystem::path folder_;
  std::map<std::filesystem::path, std::string> files_;
};

/// Which of several files an input is for, by its first byte, and what that one is to hold.
struct Choice {
  std::size_t number;
  std::string_view body;
};
inline Choice choice_of(std::string_view input, std::size_t files) {
  if (input.empty()) return {0, {}};
  return {static_cast<unsigned char>(input[0]) % files, input.substr(1)};
}
inline std::string input_for(std::size_t number, const std::string& body) { return static_cast<char>(number) + body; }

}  // namespace gpvc::fuzz
