// What classification needs to know of a method.
#pragma once

#include "visibility/visibility.h"

namespace gpvc::visibility {

struct ClassifyOptions {
  Sampling sampling = Sampling::hivers;
  CoverageCorrection correction = CoverageCorrection::exact;
  bool subpixel = true;
};

}  // namespace gpvc::visibility
