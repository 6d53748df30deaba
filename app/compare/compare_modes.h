// The visibility modes a comparison runs through.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "visibility/method.h"

namespace gpvc::compare {

struct ComparedMode {
  std::string name;               ///< as --visibility takes it, with its epsilon
  std::string family;             ///< without the epsilon
  std::optional<double> epsilon;  ///< of biased modes
  visibility::VisibilityOptions visibility;
};

/// What `gpvc compare` runs without --modes.
const std::string& default_modes();

/// The epsilons to run a family of biased modes with.
using EpsilonsOf = std::function<std::vector<double>(const std::string& family)>;

/// The modes of a list separated by commas, in its order, each once: those of visibility::parse_visibility_mode(),
/// `gpvc:uncorrected`, `gpvc:uncorrected:spc` (figure 15's depth) and `gpvc:paper` (coverage correction off and LPCC
/// alone), and biased ones without their epsilon, which stand for one mode per epsilon. Throws std::invalid_argument.
std::vector<ComparedMode> compared_modes(const std::string& list, const EpsilonsOf& epsilons);

}  // namespace gpvc::compare
