// Sources of a run's photos, and of the pixels in them that must not be used.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "error.h"
#include "file_hashes.h"
#include "image.h"
#include "samples.h"
#include "scene.h"
#include "work_store.h"

namespace gpvc::io {

/// Pixels of a photo that must not be used: one bit a pixel, `stride` words a row. What they show counts as outside the
/// photo.
struct PhotoExclusion {
  int width = 0, height = 0;
  std::size_t stride = 0;
  std::vector<std::uint64_t> words;
  bool excludes(int x, int y) const {
    const auto column = static_cast<std::size_t>(x);
    return (words[static_cast<std::size_t>(y) * stride + column / 64] >> (column % 64)) & 1u;
  }
};

/// How many photos have been decoded, and how many times in all.
struct PhotoDecodes {
  std::size_t photos = 0, times = 0;
};

/// A pixel of a coarse photo is the mean of a square of the photo with this edge, in pixels. Detail finer than twice the edge is
/// taken from one photo alone. With 4 the error on photos held out of three scenes is higher (benchmarks/README.md).
inline constexpr int kCoarsePixel = 2;

/// A photo without its fine detail: the means of its squares. O(pixels).
Image coarse_image(const Image& photo);

/// The photos of a scene by view: all that the stages know of where pictures come from. Implementations are thread-safe.
class PhotoSource {
 public:
  virtual ~PhotoSource() = default;
  /// 3 channels at the view's camera size, with excluded pixels painted over from their surroundings, so that no filter
  /// picks them up. Throws InputError.
  virtual std::shared_ptr<const Image> photo(ViewId view) = 0;
  /// Pixels that must not be used, at the view's camera size; null when all may be. Throws InputError.
  virtual std::shared_ptr<const PhotoExclusion> exclusion(ViewId view) = 0;
  /// The coarse_image() of the view's photo. Throws InputError.
  virtual std::shared_ptr<const Image> coarse(ViewId view);
  /// What photo() is the picture of: the same size, pixel by pixel, excluded pixels painted over alike. A source that decodes files gets both
  /// from one decoding. Throws InputError. \pre Scene::bands
  virtual std::shared_ptr<const Samples> samples(ViewId /*view*/) { return nullptr; }
  /// Stands for what photo() and exclusion() give for the view. nullopt: unknown, so that no result made from the view is
  /// kept for another run. Throws InputError.
  virtual std::optional<WorkKey> key(ViewId /*view*/) { return std::nullopt; }
  /// Bytes of photos that a source which keeps some for later may keep from now on.
  virtual void keep_at_most(std::size_t /*bytes*/) {}
  /// Gives back memory that is held for the next photos alone.
  virtual void free_buffers() {}
  /// So far, of a source that decodes files.
  virtual PhotoDecodes decodes() const { return {}; }
};

/// Decoded photos of a scene under a byte limit, least recently used out first. Thread-safe; a photo asked for by two
/// threads is decoded once, on one of them and without parallel loops. Photos come at their view's camera size, with
/// excluded pixels painted over from their surroundings, so that no filter picks them up. Photos handed out live on
/// outside the limit until released, and are handed out again until then: the views of one file, and its alphas, share a
/// decoding. `scene` must outlive the cache.
///
/// Photos and masks are read several times, and each time must be the files that they were first, byte for byte, which
/// for Scene::circle_photos was when the scene was read: all functions throw InputError for one that has changed since.
/// Each reading compares the file's size and times; its hash is taken once, before it is decoded for the first time.
class PhotoCache final : public PhotoSource {
 public:
  /// \param known what is known of the files already, which they must still be; borrowed
  explicit PhotoCache(const Scene& scene, std::size_t limit_bytes = 0, FileHashes* known = nullptr);
  ~PhotoCache() override;
  PhotoCache(const PhotoCache&) = delete;
  PhotoCache& operator=(const PhotoCache&) = delete;
  /// Throws InputError when the photo cannot be decoded whole.
  std::shared_ptr<const Image> photo(ViewId view) override;
  /// The result of read_exclusion, and pixels without data in a band. Where alphas count or there are bands it comes with the photo,
  /// which lives as long; else nothing is kept.
  std::shared_ptr<const PhotoExclusion> exclusion(ViewId view) override;
  /// To be asked for before photo() where both are wanted: a photo that was decoded for photo() alone is decoded again, since samples
  /// are kept only where they were asked for. They count towards the limit.
  std::shared_ptr<const Samples> samples(ViewId view) override;
  /// Of the bytes of the view's files.
  std::optional<WorkKey> key(ViewId view) override;
  void keep_at_most(std::size_t bytes) override;
  void free_buffers() override;
  PhotoDecodes decodes() const override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A picture that the caller holds, and the pixels of it that must not be used.
struct Picture {
  Image image;  ///< 3 channels, of the view's camera size; of a panorama's view what continue_around() gives
  std::optional<PhotoExclusion> exclusion{};
  std::optional<Samples> samples{};  ///< of a scene with bands; what is no number has to be excluded
};

/// Pictures in memory, one a view.
class PictureSource final : public PhotoSource {
 public:
  /// Throws std::invalid_argument when a picture is not of its camera's size or has not 3 channels, and for samples that are not of that
  /// size and of Scene::bands.
  PictureSource(const Scene& scene, std::vector<Picture> pictures);
  std::shared_ptr<const Image> photo(ViewId view) override;
  std::shared_ptr<const PhotoExclusion> exclusion(ViewId view) override;
  std::shared_ptr<const Samples> samples(ViewId view) override;

 private:
  std::vector<std::shared_ptr<const Image>> images_;
  std::vector<std::shared_ptr<const PhotoExclusion>> exclusions_;
  std::vector<std::shared_ptr<const Samples>> samples_;
};

/// Pictures that a function makes when they are asked for, kept as by PhotoCache. It is called from several threads at a time,
/// but for one view by one of them, and again only when nobody holds that view's picture any more and it did not fit.
class CallbackSource final : public PhotoSource {
 public:
  using Load = std::function<Picture(ViewId view)>;
  /// Borrows the scene.
  CallbackSource(const Scene& scene, Load load);
  ~CallbackSource() override;
  /// Throws std::invalid_argument as PictureSource does, and what the function throws.
  std::shared_ptr<const Image> photo(ViewId view) override;
  /// Makes the picture, too.
  std::shared_ptr<const PhotoExclusion> exclusion(ViewId view) override;
  std::shared_ptr<const Samples> samples(ViewId view) override;
  void keep_at_most(std::size_t bytes) override;
  PhotoDecodes decodes() const override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// At the view's camera size: pixels that are black in the view's mask, or darker than half of white where it is grey
/// (NAME.mask.png with the photo's whole name or its name without extension, the former first, NAME_mask.png, or
/// RealityCapture's layer; in SceneOptions::masks_dir also NAME.png and NAME; JPEG and TIFF as well) or of alpha 0 in the
/// photo; of a reduced photo, blocks that contain one. nullopt when nothing is excluded. Throws InputError.
std::optional<PhotoExclusion> read_exclusion(const View& view);

/// True if the view's mask tells other programs all that read_exclusion knows: it is a PNG without alpha, in black and
/// white alone, and the photo's alpha does not count. Decodes it. Throws InputError.
bool has_plain_mask(const View& view);

/// The files that a view's photo is read from: the photo or the files of its bands, and the mask.
std::vector<std::filesystem::path> files_of(const View& view);

/// Per view the first that shows the same photo: the views of a panorama and of a wide fisheye are made from one file.
std::vector<std::uint32_t> photo_of_view(const Scene& scene);

/// Photos of another source, whose coarse ones are made when a photo is first fetched, on the thread that fetches it, and kept in
/// a file without a name: to read one takes a tenth of the time that decoding the photo takes. What does not fit is made of
/// the photo each time.
class CoarsePhotos final : public PhotoSource {
 public:
  /// Borrows the source.
  /// \param folder where the file may grow to `most` bytes; 3 / kCoarsePixel^2 for each pixel of the photos hold all
  CoarsePhotos(PhotoSource& photos, const Scene& scene, const std::filesystem::path& folder, std::size_t most);
  ~CoarsePhotos() override;
  std::shared_ptr<const Image> photo(ViewId view) override;
  std::shared_ptr<const PhotoExclusion> exclusion(ViewId view) override { return photos_.exclusion(view); }
  /// Throws OutputError as well, where what was kept cannot be read.
  std::shared_ptr<const Image> coarse(ViewId view) override;
  std::shared_ptr<const Samples> samples(ViewId view) override { return photos_.samples(view); }
  std::optional<WorkKey> key(ViewId view) override { return photos_.key(view); }
  void keep_at_most(std::size_t bytes) override { photos_.keep_at_most(bytes); }
  void free_buffers() override { photos_.free_buffers(); }
  PhotoDecodes decodes() const override { return photos_.decodes(); }

 private:
  struct Store;
  PhotoSource& photos_;
  std::unique_ptr<Store> store_;
};

/// Calls `work` with the number of every view that has a photo, on several threads. Returns the InputError of each view,
/// null for none, so that the first view's can be reported for any number of threads.
std::vector<std::exception_ptr> for_each_photo(std::span<const View> views,
                                               const std::function<void(std::size_t)>& work);

/// Throws one InputError that repeats all of `errors`, if there are any: "3 WHAT: FILE: REASON; FILE: REASON; FILE: REASON".
void throw_together(std::span<const std::exception_ptr> errors, const std::string& what,
                    const std::vector<Cure>& cures = {});

}  // namespace gpvc::io
