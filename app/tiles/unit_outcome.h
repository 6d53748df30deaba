// What a unit notes while it runs: the files that it leaves, and figures.
#pragma once

#include <filesystem>

#include "app/tiles/done.h"
#include "app/tiles/units.h"

namespace gpvc::tiles {

struct UnitRunner::Outcome {
  Done done;
  void add(const JobFolder& folder, const std::filesystem::path& file) {
    done.outputs.push_back({std::filesystem::relative(file, folder.path()).string(), std::filesystem::file_size(file)});
  }
};

}  // namespace gpvc::tiles
