// Errors as values: the sentence that says what was found, what was measured, and what a caller may do about it.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace gpvc {

/// What a caller may do about an error or a warning, in terms of these libraries. How it is done from a command line, only
/// the command line knows.
enum class Cure {
  keep_odd_views,  ///< set labeling::CostOptions::keep_odd_views: photos that agree with no others are used
  allow_misfit,    ///< set pipeline::Settings::allow_misfit: photos, poses and mesh that contradict each other are used
  allow_unseen,    ///< set pipeline::Settings::allow_unseen: a mesh that photos hardly see is textured
  look_at_fit,     ///< look at evaluate::agreement_picture(), which shows photos side by side at places of the mesh
  name_mesh_crs,   ///< give checks::match_frames() the mesh's reference system
  more_memory,     ///< free memory, or raise pipeline::Settings::memory_bytes
  limit_memory,    ///< set pipeline::Settings::memory_bytes to an amount that the run stays below
  skip_bad_photos,   ///< set io::SceneOptions::skip_bad_photos: photos that cannot be used are left out
  keep_background,   ///< set labeling::CostOptions::background to none: sky and backdrops count as the surface
  photos_folder,     ///< set io::SceneOptions::images_dir: where the photos are
  smaller_photos,    ///< raise io::SceneOptions::downscale
  fewer_views,       ///< name fewer of the scene's views in checks::Input::views
  fewer_faces,       ///< give a mesh of fewer faces
  more_bytes,        ///< raise pipeline::OutputSettings::max_bytes
  other_folder,      ///< give results::OutputFolder another folder
  replace_result,    ///< construct results::OutputFolder with `force`: the new result replaces the one that is there
  bands_as_tiff,     ///< set pipeline::OutputSettings::band_format to tif
  make_editable,     ///< texture again, with pipeline::Settings::editable
  make_job,          ///< make the job, again where there is one: tiles::make_job()
  smaller_tiles,     ///< make the job with a lower tileset::TilesetSettings::faces_per_tile
  fewer_unit_views,  ///< make the job with a lower tiles::JobSettings::views_per_unit
  synthesize,        ///< give the folder of a synthetic scene
};

/// A sentence that is no error, with what may be done about it. Names no option of a command line.
struct Remark {
  std::string text;  ///< empty: there is nothing to remark
  std::vector<Cure> cures{};
};

/// A number that an error is based on: {"seen_share", 0.02}. Named as the figure that a run reports of it, if it does.
struct Measure {
  std::string name;
  double value;
};

/// The base of every error of ours that is no mistake of the calling program. what() is one sentence that says what was
/// found and names no option of a command line.
class Error : public std::runtime_error {
 public:
  explicit Error(const std::string& sentence, std::vector<Cure> cures = {}, std::vector<Measure> measures = {})
      : std::runtime_error(sentence), cures_(std::move(cures)), measures_(std::move(measures)) {}

  /// Ways out, each of them enough by itself; empty: none is known beside what the sentence says.
  const std::vector<Cure>& cures() const { return cures_; }
  const std::vector<Measure>& measures() const { return measures_; }

 private:
  std::vector<Cure> cures_;
  std::vector<Measure> measures_;
};

/// Input that cannot be used. what() is one sentence: "FILE: PLACE: REASON" (PLACE may be empty).
class InputError : public Error {
 public:
  /// A sentence that names its files itself.
  explicit InputError(const std::string& sentence, std::vector<Cure> cures) : Error(sentence, std::move(cures)) {}

  /// `place` is "line 12", "byte 340", "face 7" or empty; `reason` says what was expected and what was found.
  InputError(const std::filesystem::path& file, const std::string& place, const std::string& reason,
             std::vector<Cure> cures = {}, std::vector<Measure> measures = {})
      : Error(file.string() + ": " + (place.empty() ? "" : place + ": ") + reason, std::move(cures),
              std::move(measures)) {}
};

/// A promised file that cannot be written (no permission, disk full). what() is "FILE: REASON".
class OutputError : public Error {
 public:
  OutputError(const std::filesystem::path& file, const std::string& reason, std::vector<Cure> cures = {},
              std::vector<Measure> measures = {})
      : Error(file.string() + ": " + reason, std::move(cures), std::move(measures)) {}
};

/// The user asked to stop (Ctrl-C); unwinds to main, which exits with 130.
class Cancelled : public Error {
 public:
  Cancelled() : Error("cancelled") {}
};

}  // namespace gpvc
