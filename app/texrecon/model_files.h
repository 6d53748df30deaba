// The files that texrecon leaves of a model, under its names and by the rules of those who read them (io::ObjStyle).
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "app/pipeline/page_sink.h"
#include "io/textured_model.h"

namespace gpvc::texrecon {

/// Files beside each other whose names begin alike. They are written into a hidden folder beside their places, and move there
/// together: nothing is half-written.
class PrefixedFiles {
 public:
  /// Throws OutputError where the prefix's folder is not there or cannot be written to.
  explicit PrefixedFiles(std::filesystem::path prefix);
  /// Removes files that were not published.
  ~PrefixedFiles();
  PrefixedFiles(const PrefixedFiles&) = delete;
  PrefixedFiles& operator=(const PrefixedFiles&) = delete;

  /// Where to write what will be PREFIX + `ending`.
  std::filesystem::path file(const std::string& ending);
  /// For what is written and removed meanwhile.
  const std::filesystem::path& folder() const { return unfinished_; }
  /// Moves the files to their places, over files that are there, and removes pages of an earlier, larger model. Throws OutputError.
  void publish();
  /// Removes what was written. Nothing else may be called afterwards; threads that still write files get errors.
  void discard() noexcept;

 private:
  std::filesystem::path prefix_, unfinished_;
  std::vector<std::filesystem::path> names_;
};

/// The number of a page, or of anything, as mvs-texturing's file names have it: 0012.
std::string four_digits(std::size_t number);

struct PageOptions {
  bool samples = false;  ///< the photos' own bands and depth, as TIFF, instead of colours of 8 bits
  bool grey = false;     ///< one channel, as the photos
  bool gamma = false;    ///< colours to the power of 1 / 2.2
};

/// Writes the pages that faces use, and the OBJ of those faces.
class ModelFiles final : public pipeline::PageSink {
 public:
  /// \param ending what follows the prefix in the names \param written per face, 0: left out. Borrows all.
  ModelFiles(PrefixedFiles& files, std::string ending, std::span<const std::uint8_t> written,
             const PageOptions& options)
      : files_(files), ending_(std::move(ending)), written_(written), options_(options) {}

  void begin(const atlas::AtlasEstimate&) override {}
  /// Numbers the pages that written faces use, and begins to write the OBJ. Throws InputError where there is no such face.
  std::future<void> take_model(const io::TexturedModel& model) override;
  void take_page(std::size_t number, Image page) override;
  void take_samples(std::size_t number, atlas::PageSamples page, const BandSet& bands) override;

 private:
  PrefixedFiles& files_;
  std::string ending_;
  std::span<const std::uint8_t> written_;
  PageOptions options_;
  std::vector<std::filesystem::path> page_files_;  ///< by the atlas's number; empty: no face uses it
};

}  // namespace gpvc::texrecon
