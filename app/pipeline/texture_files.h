// The files of a textured model, each written as soon as its content is known.
#pragma once

#include <array>
#include <atomic>
#include <filesystem>
#include <future>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "page_sink.h"
#include "run.h"
#include "viewpoint.h"

namespace gpvc::pipeline {

/// The file of a page of a result.
std::string page_name(std::size_t number, io::ImageFormat format);

/// Whose coordinates a result's files have, where a mesh was taken from other ones to the scene's: those of models are the
/// mesh's own; tilesets are placed on the globe, for which the scene's are metres and their heights are known.
enum class Coordinates { of_mesh_file, of_scene };

/// The file of its samples, where photos have bands: NAME.tif or NAME_bands.png. Those of a page that a layout names are called like
/// the page.
std::filesystem::path samples_of(const std::filesystem::path& page, io::SampleFormat format);

/// Throws InputError for bands that the format cannot hold.
void check_band_format(const Input& input, const OutputSettings& settings);

/// The file of a page of a model that was read. Of one in the model's own file what it is called beside model.obj.
std::filesystem::path page_file_of(const std::filesystem::path& model, const io::LoadedModel& loaded, std::size_t page);

/// Samples of a page, and the file that holds them.
struct FoundSamples {
  std::filesystem::path file;
  Samples samples;
};
/// Those in a result's folder, of either format; nullopt where there are none, or not of the page's size: then they are another
/// program's. Throws InputError.
std::optional<FoundSamples> samples_beside(const std::filesystem::path& page, int width, int height);

/// How the result's files write coordinates.
io::ModelOptions model_options(const Input& input, std::span<const ViewId> labels, const OutputSettings& settings,
                               Coordinates coordinates = Coordinates::of_mesh_file);

/// The model with the faces taken off their pages that are in no glTF and no preview (atlas::is_dropped()).
io::TexturedModel without_dropped(io::TexturedModel model, std::span<const labeling::FaceTag> tags,
                                  atlas::UnseenFaces unseen);

/// Beside a model whose coordinates are not the scene's own, or whose reference system is known: what to add to them.
inline constexpr const char* kOffsetFile = "offset.txt";
bool has_offset(const io::ModelOptions& model);
/// Throws OutputError.
void write_offset(const io::ModelOptions& model, const std::filesystem::path& file);

/// The reference system that offset.txt beside a model states, with its offset, into `model`; none where there is no such file. The
/// model's own offset is io::read_offset(). Throws InputError.
void read_reference_system(const std::filesystem::path& model_file, io::ModelOptions& model);

/// Beside an OBJ whose reference system is known: the same as ContextCapture states it, by which other programs place the OBJ.
inline constexpr const char* kMetadataFile = "metadata.xml";
/// Throws OutputError. \pre the model has a reference system
void write_metadata(const io::ModelOptions& model, const std::filesystem::path& file);

/// The color profile of a view's photo file; empty where it has none or there is no file. Throws InputError, also where
/// the file is not what it was when `photos`, a source with keys, first read it.
io::ColorProfile profile_of_photo(const Scene& scene, ViewId view, io::PhotoSource& photos);

/// The color profile for the pages, that of the first view's photo. Warns of photos with another profile, of which it
/// reads the headers alone, because colors are not converted. Throws InputError.
io::ColorProfile profile_of_photos(const Run& run);

/// By how much pages with so many texels are reduced for a preview, which needs no more of them.
int preview_reduction(std::size_t page_texels);
struct Preview {
  Viewpoint from;
  Image image;  ///< RGB
};
/// Draws preview.png, a picture of a model from where all of it is seen. \param pages reduced \param up of the scene. Throws
/// OutputError.
Preview write_preview(const Input& input, const io::TexturedModel& model, const std::vector<Image>& pages,
                      std::span<const ViewId> labels, io::UpAxis up, const io::ColorProfile& profile,
                      const std::filesystem::path& file);

/// Bytes of all files of a result, before anything is known of it but the texels that are expected.
struct FileSizes {
  double least = 0, likely = 0;
};
FileSizes predicted_sizes(const Input& input, const Settings& settings, double texels);

/// The files of a textured model: call the functions in their order. Borrows what it is given.
class ModelFiles final : public PageSink {
 public:
  /// Reads the photos' color profiles. \param labels, tags per face. Throws InputError.
  ModelFiles(const Run& run, OutputFolder& folder, std::span<const ViewId> labels,
             std::span<const labeling::FaceTag> tags);

  /// Promises the files of a model with so many pages and texels, and writes the smallest ones. Throws OutputError, as all
  /// that follow.
  void begin(const atlas::AtlasEstimate& size) override;
  /// Writes model.obj, labels.npy and tags.npy, beside what follows.
  std::future<void> take_model(const io::TexturedModel& model) override;
  /// Writes a page and keeps what the preview needs of it. The last one is written while finish() draws the preview.
  void take_page(std::size_t number, Image page) override;
  /// Writes model_N.tif or model_N_bands.png.
  void take_samples(std::size_t number, atlas::PageSamples page, const BandSet& bands) override;
  /// Takes over the file of a page of another result, byte for byte, instead of take_page().
  void keep_page(std::size_t number, const std::filesystem::path& from, const Image& page);
  /// Likewise the file of its samples, instead of take_samples().
  void keep_samples(std::size_t number, const std::filesystem::path& from);
  /// Of the pages, by number.
  const std::vector<std::array<int, 2>>& page_sizes() const { return page_sizes_; }
  /// Draws the preview and, where cuts were measured, misfit.png; writes the glTF. \pre all pages were taken or kept
  WrittenModel finish(const io::TexturedModel& model, const atlas::CutMisfit& cuts);

 private:
  const Run& run_;
  OutputFolder& folder_;
  io::ColorProfile profile_;
  std::span<const ViewId> labels_;
  std::span<const labeling::FaceTag> tags_;
  io::ModelOptions options_;
  std::filesystem::path obj_file_, preview_file_, labels_file_, tags_file_, faces_file_;
  std::vector<io::PageFile> pages_;
  std::vector<std::filesystem::path> samples_;  ///< per page, where photos have bands
  std::vector<std::array<int, 2>> page_sizes_;
  int reduction_ = 1;                  ///< of the pages that the preview is drawn with
  std::vector<Image> preview_pages_;   ///< by number, as they are written
  std::atomic<std::size_t> left_ = 0;  ///< pages to be given
  std::future<void> last_page_;
};

}  // namespace gpvc::pipeline
