// Views that a scene's reader leaves out for their lens.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "io/error.h"
#include "io/files/text_scan.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {

/// A lens that no LensModel is (a panorama's) takes its views out of a scene that has others; a scene of nothing else
/// is refused.
class OmittedLenses {
 public:
  /// One view of the lens; `refusal` says what is wrong with it, and where.
  void add(const std::string& lens, const InputError& refusal) {
    if (!first_) first_ = refusal;
    ++counts_[lens];
  }

  /// To be called when the scene has all its other views. Throws the first refusal where there are none.
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
