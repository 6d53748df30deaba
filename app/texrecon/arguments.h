// The command line of mvs-texturing's texrecon, as its users' scripts and other programs give it: apps/texrecon/arguments.cpp of
// github.com/nmoehrle/mvs-texturing, of OpenDroneMap's fork, and libs/util/arguments.cc of the Multi-View Environment.
#pragma once

#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>

#include "app/pipeline/settings.h"
#include "io/names.h"

namespace gpvc::texrecon {

/// What makes a photo good for a face.
enum class DataTerm { area, gmi };
inline constexpr Named<DataTerm> kDataTermNames[] = {{"area", DataTerm::area}, {"gmi", DataTerm::gmi}};
enum class SmoothnessTerm { potts };
inline constexpr Named<SmoothnessTerm> kSmoothnessTermNames[] = {{"potts", SmoothnessTerm::potts}};
inline constexpr Named<labeling::Outliers> kOutlierNames[] = {{"none", labeling::Outliers::none},
                                                              {"gauss_damping", labeling::Outliers::damp},
                                                              {"gauss_clamping", labeling::Outliers::clamp}};
enum class ToneMapping { none, gamma };
inline constexpr Named<ToneMapping> kToneMappingNames[] = {{"none", ToneMapping::none}, {"gamma", ToneMapping::gamma}};

struct Arguments {
  std::filesystem::path scene;       ///< a folder, an NVM file, or an MVE scene and its embedding, SCENE::EMBEDDING
  std::filesystem::path mesh;        ///< PLY, or what else io::read_mesh() reads
  std::filesystem::path prefix;      ///< of the files to write
  std::filesystem::path data_costs;  ///< empty: costs are computed
  std::filesystem::path labels;      ///< of another run; empty: they are chosen
  DataTerm data_term = DataTerm::gmi;
  SmoothnessTerm smoothness = SmoothnessTerm::potts;
  labeling::Outliers outliers = labeling::Outliers::none;
  ToneMapping tone_mapping = ToneMapping::none;
  bool view_selection_model = false;  ///< write PREFIX_view_selection.obj
  bool visibility_test = true;
  bool global_leveling = true, local_leveling = true;
  bool hole_filling = true;
  bool keep_unseen = false;
  bool nadir = false;
  double nadir_weight = 65535;
  bool timings = false;  ///< write PREFIX_timings.csv
  bool intermediate_results = true;
  int threads = 0;  ///< 0: all
  int max_texture_size = 8192;
};

/// The words are not a command line of texrecon.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What the words ask for.
enum class Request { run, help, version };

/// Reads the words after the program's name: IN_SCENE IN_MESH OUT_PREFIX and options in any order; --name and --name=VALUE, also
/// with only the first letters of a name; -x, -x VALUE and -xVALUE; -xy for -x -y; words after -- are no options; empty words are
/// left out. Throws UsageError.
Request read_arguments(std::span<const std::string> words, Arguments& arguments);

std::string help_text();
/// What texrecon writes into PREFIX.conf.
std::string conf_text(const Arguments& arguments);

/// What the arguments mean for a run.
pipeline::Settings settings_of(const Arguments& arguments);

}  // namespace gpvc::texrecon
