#include "io/bands/band_set.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "io/bands/band_cameras.h"
#include "io/bands/band_names.h"
#include "io/bands/band_photo.h"
#include "io/bands/band_range.h"
#include "io/bands/band_registration.h"
#include "io/files/text_scan.h"
#include "io/images/image_bounds.h"
#include "io/images/image_file.h"
#include "io/names.h"
#include "io/photos.h"

namespace gpvc::io {
namespace {

/// What the files of a photo hold, one after the other.
struct Holding {
  std::vector<PhotoHeader> files;
  std::vector<std::size_t> bands;  ///< of each file, without alphas
  std::size_t count() const {
    std::size_t all = 0;
    for (const std::size_t of_file : bands) all += of_file;
    return all;
  }
  bool is_colors() const {
    return files.size() == 1 && (count() == 1 || count() == 3) && files[0].type != SampleType::f32;
  }
  std::string text() const {
    return std::to_string(count()) + (count() == 1 ? " band" : " bands") + " of " +
           std::string(name_of(kSampleTypeNames, files[0].type));
  }
};

std::vector<fs::path> band_files_of(const View& view) {
  return view.band_files.empty() ? std::vector{view.photo} : view.band_files;
}

/// By its bytes, as all readers of photos go: of most scenes that is all that has to be looked at.
bool is_jpeg(const fs::path& file) {
  const FileBytes bytes = image_bytes(file, FileBytes::Use::in_places);
  return ImageBytes{file, "", bytes.view()}.is_jpeg();
}

bool is_tiff_name(const fs::path& file) {
  const std::string extension = lower_case(file.extension().string());
  return extension == ".tif" || extension == ".tiff";
}

/// Some of a list, from all of it, and always the same.
std::vector<std::size_t> some_of(const std::vector<std::size_t>& all) {
  constexpr std::size_t kMost = 8;
  std::vector<std::size_t> some;
  const std::size_t count = std::min(all.size(), kMost);
  for (std::size_t n = 0; n < count; ++n) some.push_back(all[n * all.size() / count]);
  return some;
}

class BandFinder {
 public:
  BandFinder(SceneFile& scene, const std::vector<bool>& needed, const SceneOptions& options)
      : scene_(scene), options_(options), holdings_(scene.views.size()) {
    for (std::size_t i = 0; i < scene.views.size(); ++i)
      if (needed[i] && !scene.views[i].photo.empty()) views_.push_back(i);
  }

  void find() {
    const auto may_be_more = [&](std::size_t i) {
      const View& view = scene_.views[i];
      return !view.band_files.empty() || !is_jpeg(view.photo);
    };
    std::vector<char> more(scene_.views.size(), 0);
    throw_together(for_each_photo(scene_.views,
                                  [&](std::size_t i) {
                                    if (std::ranges::binary_search(views_, i)) more[i] = may_be_more(i) ? 1 : 0;
                                  }),
                   "photos cannot be used");
    if (std::ranges::none_of(more, [](char any) { return any != 0; })) return;
    read_headers();
    if (!holds_more()) return;
    if (!all_alike()) return;
    BandSet set;
    set.type = first().files[0].type;
    set.bands = named_bands();
    set.composite = options_.composite.empty() ? usual_composite(set.bands)
                                               : composite_of_names(scene_.listing, options_.composite, set.bands);
    set.radiometric = holds_quantities(set);
    look_at_photos(set);
    scene_.bands = std::move(set);
  }

 private:
  const View& view(std::size_t i) const { return scene_.views[i]; }
  const Holding& first() const { return holdings_[views_.front()]; }

  void read_headers() {
    std::vector<std::exception_ptr> errors = for_each_photo(scene_.views, [&](std::size_t i) {
      if (!std::ranges::binary_search(views_, i)) return;
      Holding& holding = holdings_[i];
      for (const fs::path& file : band_files_of(view(i))) {
        const PhotoHeader& header = holding.files.emplace_back(read_photo_header(file));
        const bool alpha = header.alpha_channel >= 0 && header.channels > 1;
        holding.bands.push_back(static_cast<std::size_t>(header.channels - (alpha ? 1 : 0)));
      }
    });
    throw_together(errors, "photos cannot be used");
    take_alphas_for_bands();
  }

  /// Of the TIFFs with an alpha, see find_bands.
  void take_alphas_for_bands() {
    std::vector<std::size_t> with_alpha;
    for (const std::size_t i : views_)
      if (view(i).band_files.empty() && is_tiff_name(view(i).photo) && holdings_[i].files[0].alpha_channel >= 0)
        with_alpha.push_back(i);
    const std::vector<std::size_t> some = some_of(with_alpha);
    if (some.empty()) return;
    std::vector<double> opaque(some.size(), 1);
    tbb::parallel_for(std::size_t{0}, some.size(), [&](std::size_t n) {
      try {
        opaque[n] = opaque_share(view(some[n]).photo);
      } catch (const InputError&) {
        // told where the photo is used
      }
    });
    double mean = 0;
    for (const double share : opaque) mean += share / static_cast<double>(opaque.size());
    constexpr double kMost = 0.5;
    if (mean >= kMost) return;
    for (const std::size_t i : with_alpha) {
      ++holdings_[i].bands[0];
      scene_.views[i].uses_alpha = scene_.views[i].uses_alpha && holdings_[i].files[0].has_mask;
    }
    scene_.warn(with_alpha.size(),
                "photos have a channel in the place of an alpha whose values are spread as those of a picture: it is "
                "taken for a band, as in " +
                    view(some[0]).photo.string());
  }

  bool holds_more() const {
    return std::ranges::any_of(views_, [&](std::size_t i) {
      const Holding& h = holdings_[i];
      return !h.is_colors() || h.files[0].type != SampleType::u8;
    });
  }

  /// False for colours of different depths, which are looked at in 8 bits.
  bool all_alike() {
    for (const std::size_t i : views_) {
      check_files(i);
      const Holding& h = holdings_[i];
      if (h.count() == first().count() && h.files[0].type == first().files[0].type) continue;
      const std::string differs =
          "holds " + h.text() + ", " + view(views_.front()).photo.string() + " " + first().text();
      const auto is_colors = [&](std::size_t n) { return holdings_[n].is_colors(); };
      if (!std::ranges::all_of(views_, is_colors))
        throw InputError(view(i).photo, "", differs + ": expected the same in all photos");
      scene_.warnings.push_back("photos are worked on with 8 bits, since they are of different kinds: " +
                                view(i).photo.string() + " " + differs);
      return false;
    }
    return true;
  }

  void check_files(std::size_t i) const {
    const Holding& h = holdings_[i];
    const std::vector<fs::path> files = band_files_of(view(i));
    const PhotoHeader& first = h.files[0];
    for (std::size_t n = 0; n < files.size(); ++n) {
      const PhotoHeader& file = h.files[n];
      if (file.size.width != first.size.width || file.size.height != first.size.height)
        throw InputError(files[n], "",
                         "is " + size_text(file.size.width, file.size.height) + " pixels, " + files[0].string() +
                             " is " + size_text(first.size.width, first.size.height) + ": expected bands of one size");
      if (file.type != first.type)
        throw InputError(files[n], "",
                         "holds samples of " + std::string(name_of(kSampleTypeNames, file.type)) + ", " +
                             files[0].string() + " of " + std::string(name_of(kSampleTypeNames, first.type)) +
                             ": expected bands of one type");
      if (files[n] != view(i).photo && h.bands[n] != 1)
        throw InputError(files[n], "", "holds " + std::to_string(h.bands[n]) + " bands, expected one band a file");
    }
  }

  std::vector<Band> named_bands() const {
    std::vector<Band> all;
    for (std::size_t n = 0; n < first().files.size(); ++n) {
      std::vector<Band> of_file = bands_of_file(first().files[n], first().bands[n], all.size());
      const std::string name = n < scene_.band_names.size() ? scene_.band_names[n] : std::string();
      // A name that is given goes before tags, and these before what a file is called.
      if (of_file.size() == 1 && !name.empty() && (!options_.bands.empty() || first().files[n].bands.empty()))
        of_file[0].name = name;
      all.insert(all.end(), of_file.begin(), of_file.end());
    }
    if (!options_.bands.empty()) refuse_repeated(all);
    make_unique(all);
    return all;
  }

  void refuse_repeated(const std::vector<Band>& bands) const {
    for (std::size_t i = 0; i < bands.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (lower_case(bands[i].name) == lower_case(bands[j].name))
          throw InputError(scene_.listing, "",
                           "has two bands " + quote(bands[i].name) + ": expected names that differ");
  }

  void look_at_photos(BandSet& set) {
    const std::vector<std::size_t> some = some_of(views_);
    const std::size_t files = first().files.size();
    std::vector<std::vector<float>> samples(some.size());
    std::vector<std::vector<std::vector<BandMatch>>> matches(some.size(), std::vector<std::vector<BandMatch>>(files));
    bool linear_light = first().files[0].linear_light;
    const auto look = [&](std::size_t n) {
      try {
        const View& v = view(some[n]);
        const BandPhoto photo = read_band_photo(v, set, {});
        samples[n] = some_samples(photo);
        if (files == 1) return;
        const std::vector<std::size_t> bands = first_bands();
        const std::size_t primary = primary_of(v);
        for (std::size_t file = 0; file < files; ++file)
          if (file != primary) matches[n][file] = match_bands(photo.samples, bands[primary], bands[file]);
      } catch (const InputError&) {
        // told where the photo is used
      }
    };
    // No memory is planned yet: as many together as are small beside what any run takes, files and samples counted.
    constexpr std::size_t kMostBytes = 200'000'000;
    const ImageSize pixels = first().files[0].size;
    const std::size_t photo_bytes = 2 * pixel_index(0, pixels.height, pixels.width) * set.pixel_bytes();
    const std::size_t together = std::max<std::size_t>(1, kMostBytes / std::max<std::size_t>(1, photo_bytes));
    for (std::size_t first_of = 0; first_of < some.size(); first_of += together)
      tbb::parallel_for(first_of, std::min(some.size(), first_of + together), look);
    std::vector<float> all;
    for (const std::vector<float>& of_photo : samples) all.insert(all.end(), of_photo.begin(), of_photo.end());
    set_range(set, std::move(all), linear_light);
    if (files == 1) return;
    for (std::size_t file = 0; file < files; ++file) scene_.band_places.push_back(place_of(file, some, matches));
    warn_of_unregistered(set);
  }

  /// Where a file lies, by its matches in some views.
  BandPlace place_of(std::size_t file, const std::vector<std::size_t>& some,
                     const std::vector<std::vector<std::vector<BandMatch>>>& matches) const {
    std::vector<BandMatch> of_file;
    std::vector<CameraMatch> by_camera;
    for (std::size_t n = 0; n < some.size(); ++n)
      for (const BandMatch& match : matches[n][file]) {
        of_file.push_back(match);
        if (!view(some[n]).band_cameras.empty()) by_camera.push_back({match, &view(some[n]).band_cameras[file]});
      }
    const ImageSize size = first().files[0].size;
    BandPlace place;
    if (view(views_.front()).band_cameras.empty()) {
      place = place_of_matches(of_file, size.width, size.height);
    } else {
      const NearnessFit fit = fit_nearness(by_camera);
      place.nearness = fit.nearness;
      place.error_px = fit.error_px;
    }
    if (file == primary_of(view(views_.front()))) place.error_px = 0;
    return place;
  }

  /// The number of each file's first band.
  std::vector<std::size_t> first_bands() const {
    std::vector<std::size_t> numbers;
    std::size_t next = 0;
    for (const std::size_t bands : first().bands) {
      numbers.push_back(next);
      next += bands;
    }
    return numbers;
  }

  static std::size_t primary_of(const View& v) {
    return static_cast<std::size_t>(std::ranges::find(v.band_files, v.photo) - v.band_files.begin());
  }

  void warn_of_unregistered(const BandSet& set) {
    const std::vector<std::size_t> bands = first_bands();
    std::string names;
    for (std::size_t file = 0; file < bands.size(); ++file)
      if (!scene_.band_places[file].error_px) names += (names.empty() ? "" : ", ") + set.bands[bands[file]].name;
    if (names.empty()) return;
    const bool by_camera = !view(views_.front()).band_cameras.empty();
    scene_.warnings.push_back(std::string("bands show too little in common with the photos to be ") +
                              (by_camera
                                   ? "compared with them, and are taken to lie where the scene's cameras have them: "
                                   : "registered to them, and are taken to lie where they are: ") +
                              names);
  }

  SceneFile& scene_;
  const SceneOptions& options_;
  std::vector<std::size_t> views_;  ///< that need their photo
  std::vector<Holding> holdings_;   ///< of these
};

}  // namespace

void find_bands(SceneFile& scene, const std::vector<bool>& needed, const SceneOptions& options) {
  BandFinder finder(scene, needed, options);
  finder.find();
  if (!scene.bands && !options.composite.empty())
    throw InputError(scene.listing, "", "has photos in grey or RGB of 8 bits alone, which need no composite");
}

BandSet band_set_of(std::vector<Band> bands, SampleType type, const std::vector<std::string>& composite,
                    std::vector<float> some) {
  BandSet set;
  set.type = type;
  set.bands = std::move(bands);
  make_unique(set.bands);
  set.composite =
      composite.empty() ? usual_composite(set.bands) : composite_of_names("composite", composite, set.bands);
  set.radiometric = holds_quantities(set);
  set_range(set, std::move(some), false);
  return set;
}

BandSet read_band_set(const std::filesystem::path& file) {
  const PhotoHeader header = read_photo_header(file);
  BandSet set;
  set.type = header.type;
  set.bands = bands_of_file(header, static_cast<std::size_t>(header.channels), 0);
  set.composite = usual_composite(set.bands);
  set.radiometric = holds_quantities(set);
  return set;
}

}  // namespace gpvc::io
