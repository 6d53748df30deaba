// Keys of what a run makes: hashes of all that each part came from.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "../../io/work_store.h"
#include "run.h"

namespace gpvc::pipeline {

/// The parts of a run that are kept on disk.
struct StepKeys {
  std::map<ViewId, io::WorkKey> views;  ///< what a view sees
  io::WorkKey labels, pages;
};
/// nullopt where the photos have no keys, or this program cannot be read. O(bytes of mesh and photos), TBB. Throws InputError.
std::optional<StepKeys> step_keys(const Run& run);

struct ViewKeys {
  ViewId view{};
  std::string name;
  io::WorkKey photo, camera;  ///< with its mask; with the pose
};
GPVC_MEMBERS(ViewKeys, view, name, photo, camera)

/// The value of an option: "area-angle", "8", "true".
struct OptionText {
  std::string name, text;
};
GPVC_MEMBERS(OptionText, name, text)

/// What a result came from, part by part, so that it can be told which of them is another one.
struct ResultKeys {
  io::WorkKey mesh;
  std::vector<ViewKeys> views;
  io::WorkKey options;                   ///< all but view_rules and the form of the models
  std::vector<OptionText> option_texts;  ///< the same as texts, as far as these tell values apart
};
GPVC_MEMBERS(ResultKeys, mesh, views, options, option_texts)
/// O(bytes of mesh and photos), TBB. Photos without keys count as the same. Throws InputError.
ResultKeys result_keys(const Run& run);
/// What differs, as the end of a sentence about a result: "was textured with padding 8, and 4 is asked for now". Empty:
/// nothing does.
std::string difference(const ResultKeys& result, const ResultKeys& now);

}  // namespace gpvc::pipeline
