// What a unit notes while it runs: the files that it leaves, and figures.
#pragma once

#include "app/tiles/done.h"
#include "app/tiles/units.h"

namespace gpvc::tiles {

struct UnitRunner::Outcome {
  Done done;
};

}  // namespace gpvc::tiles
