// What all steps of a run work with.
#pragma once

#include "../../io/photos.h"
#include "../checks/input.h"
#include "../results/observer.h"
#include "../results/output_folder.h"
#include "../results/store.h"
#include "settings.h"

namespace gpvc::pipeline {

using checks::all_views;
using checks::Input;
using results::Observer;
using results::OutputFolder;

/// Borrows everything.
struct Run {
  const Input& input;
  const Settings& settings;
  io::PhotoSource& photos;
  Observer& observer;
  results::Store* kept = nullptr;  ///< parts that an earlier run has left, and where to leave them; null: nowhere
};

}  // namespace gpvc::pipeline
