// The visibility modes a comparison runs through.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "visibility/visibility.h"

namespace gpvc::compare {

struct ComparedMode {
  std::string name;               ///< as the user writes it, with its epsilon
  std::string family;             ///< without the epsilon
  std::optional<double> epsilon;  ///< of the biased ones
  visibility::VisibilityOptions visibility;
};

/// What `gpvc compare` runs without --modes.
const std::string& default_modes();
/// The biases of figures 21 to 24.
std::vector<double> default_epsilons();

/// The modes of a list separated by commas, in its order, each once: those of visibility::parse_visibility_mode(),
/// `gpvc:uncorrected`, `gpvc:uncorrected:spc` (figure 15's depth) and `gpvc:paper` (coverage correction off and LPCC
/// alone), and biased ones without their epsilon, which stand for one mode per epsilon. `base` gives what a mode does
/// not say. Throws UsageError.
std::vector<ComparedMode> compared_modes(const std::string& list, std::span<const double> epsilons,
                                         const visibility::VisibilityOptions& base);

}  // namespace gpvc::compare
