// Views that a scene's reader leaves out for their lens.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "io/error.h"
#include "io/files/text_scan.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {

/// Views with a lens that no LensModel describes (a panorama's) are left out of a scene that has others; a scene
/// without others is refused.
class OmittedLenses {
 public:
  /// One view of the lens; `refusal` says what is wrong with it, and where.
  void add(const std::string& lens, const InputError& refusal) {
    if (!first_) first_ = refusal;
    ++counts_[lens];
  }

  /// To be called after the last view was added. Throws the first refusal if the scene has no other views.
  void settle(SceneFile& scene, const char* views = "images") const {
    if (!first_) return;
    if (scene.views.empty()) throw *first_;
    std::size_t all = 0;
    std::string names;
    for (const auto& [lens, count] : counts_) {
      all += count;
      names += (names.empty() ? "" : ", ") + in_quotes(lens);
    }
    scene.warnings.push_back(std::to_string(all) + " " + views + " are left out: " +
                             (counts_.size() == 1 ? "their lens, " + names + ", is not supported"
                                                  : "their lenses, " + names + ", are not supported"));
  }

 private:
  std::map<std::string, std::size_t> counts_;
  std::optional<InputError> first_;
};

}  // namespace gpvc::io
