// Small synthetic cities, written as gpvc synth writes them.
#pragma once

#include <filesystem>

#include "app/cli/options.h"

namespace gpvc::test {

/// Five photos of this width; two thirds as high.
inline cli::SynthOptions small_city(const std::filesystem::path& out, int width) {
  cli::SynthOptions options = cli::synth_defaults(cli::SynthKind::city);
  options.faces = 3000;
  options.flight.size_m = 40;
  options.flight.photos = 5;
  options.flight.width = width;
  options.flight.height = width / 3 * 2;
  options.out = out;
  return options;
}

inline void synthesize(const cli::SynthOptions& options) {
  cli::Console console(cli::Loudness::quiet, {});
  cli::run_synth(options, console);
}

}  // namespace gpvc::test
