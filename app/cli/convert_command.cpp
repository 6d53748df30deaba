// gpvc convert: a scene in another program's format, with or without undistorted photos.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <set>

#include "app/checks/frame_check.h"
#include "app/checks/mesh_frame.h"
#include "app/checks/nearness.h"
#include "app/cli/scene_input.h"
#include "app/pipeline/texture_files.h"
#include "app/pipeline/undistort.h"
#include "io/mesh.h"
#include "io/output_file.h"

namespace gpvc::cli {
namespace {

namespace fs = std::filesystem;

bool is_jpeg(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return extension == ".jpg" || extension == ".jpeg";
}

/// The name of a photo that is encoded anew: JPEGs stay JPEGs, others become PNGs. Only the extensions of image formats are
/// replaced; other dots belong to the name.
std::string resampled_name(fs::path name) {
  if (is_jpeg(name)) return name.string();
  return io::has_image_extension(name) ? name.replace_extension(".png").string() : name.string() + ".png";
}

// Refuses the first view whose camera the format cannot express, before a photo is read.
void refuse_lost_terms(const Scene& scene, const std::vector<ViewId>& used, io::SceneTarget target) {
  for (const ViewId id : used)
    if (const auto lost = io::lost_term(target, scene.views[index(id)].camera))
      throw InputError(
          scene.source, scene.views[index(id)].name,
          fmt::format("its camera has {}, which the format '{}' cannot express; --undistort writes photos "
                      "and cameras without distortion{}",
                      *lost, name_of(io::kSceneTargetNames, target),
                      io::scene_writer(target).more.square_and_centred ? ", with square pixels about the middle" : ""));
}

/// Refuses, before photos are converted, to replace files of the scene or foreign files, and to put a listing into the
/// folder of the scene, which is read as a whole.
void refuse_overwriting(const ConvertOptions& options, const Scene& scene, const results::OutputFolder& folder,
                        const std::vector<fs::path>& places, const std::vector<fs::path>& masks) {
  const std::vector<fs::path> listings = io::listing_files(options.target, places);
  const std::string advice = "; choose another folder than " + options.out.string();
  const fs::path source = fs::weakly_canonical(scene.read_from);
  for (const fs::path& listing : listings)
    if (fs::weakly_canonical(options.out / listing).parent_path() == source)
      throw OutputError(options.out / listing,
                        "would be written into the folder of the scene that is converted" + advice);
  std::vector<fs::path> made = listings;
  made.insert(made.end(), places.begin(), places.end());
  made.insert(made.end(), masks.begin(), masks.end());
  const std::set<fs::path> sources = input_files(scene);
  made.insert(made.end(), folder.listed().begin(), folder.listed().end());  // removed with the earlier result
  for (const fs::path& place : made) {
    const fs::path file = options.out / place;
    std::error_code ignored;
    if (!fs::exists(file, ignored)) continue;
    if (sources.contains(fs::weakly_canonical(file)))
      throw OutputError(file, "belongs to the scene that is converted" + advice);
    folder.refuse_foreign_file(place.generic_string());
  }
}

struct Frame {
  pipeline::FrameWindow window;
  bool blank = false;  ///< some pixels show nothing of the photo
};

const View& view_of(const Scene& scene, ViewId id) { return scene.views[index(id)]; }

/// The conversion of a scene, its photos and their masks.
class Conversion {
 public:
  Conversion(const ConvertOptions& options, RunRecord& record, results::OutputFolder& folder)
      : options_(options), record_(record), folder_(folder) {}

  RunFacts run() {
    record_.begin({"read"});
    check_places(options_.input, "SCENE alone is converted");
    SceneInput input = options_.input;
    input.whole_fisheyes = true;
    input.bands_as_listed = true;
    scene_ = read_views(input, used_);
    for (const std::string& warning : scene_.warnings) record_.warning(warning);
    choose_coordinates();
    record_.end(fmt::format("{} views", used_.size()));
    choose_frames();
    warn_of_motion();
    refuse_lost_terms(written_, used_, options_.target);
    choose_places();
    warn_of_lost_masks();
    expect_space();

    record_.begin({"photos", "photos"});
    // Without masks, the cache does not paint over excluded pixels.
    Scene whole = scene_;
    for (View& view : whole.views) {
      view.mask.clear();
      view.uses_alpha = false;
    }
    io::PhotoCache photos(whole, 0), excluding(scene_, 0);
    std::size_t left_behind = 0, masks = 0, unmasked = 0;
    for (std::size_t i = 0; i < used_.size(); ++i) {
      record_.progress(i, used_.size());
      write_photo(i, photos);
      masks += write_mask(i, excluding) ? 1 : 0;
      if (may_lack_data() && !masks_[i] && !has_mask(view_of(scene_, used_[i])))
        unmasked += excluding.exclusion(used_[i]) != nullptr ? 1 : 0;
      left_behind += copies_photos() ? copy_bands(i) : 0;
    }
    if (left_behind > 0)
      record_.warning(fmt::format(
          "{} files of bands lie in other folders than their photos, or these got other names: they are not "
          "copied",
          left_behind));
    if (masks > 0) record_.note(fmt::format("masks of {} photos are written", masks));
    if (unmasked > 0)
      record_.warning(
          fmt::format("{} photos have pixels without data, which no mask of the new scene excludes", unmasked));
    record_.counts["masks"] = masks;
    record_.end(options_.undistort ? "undistorted" : options_.input.downscale > 1 ? "reduced" : "copied");

    for (const fs::path& listing : io::listing_files(options_.target, places_)) folder_.file(listing);
    io::write_scene(options_.target, written_, used_, places_, folder_.in_making());
    folder_.promise_all();
    record_.counts["views"] = used_.size();
    const fs::path result = writer_.files.size() == 1 ? writer_.files.front() : fs::path();
    return {.options = options_json(), .result = (options_.out / result).string()};
  }

 private:
  /// Takes the cameras to where the mesh fits them, and tells what the new files cannot tell.
  void choose_coordinates() {
    if (!options_.input.mesh.empty()) {
      Mesh mesh = io::read_mesh(options_.input.mesh);
      for (const std::string& warning : mesh.warnings)
        record_.warning(fmt::format("{}: {}", options_.input.mesh.string(), warning));
      const bool has_frames = !scene_.other_frames.empty();
      const Remark assumed = checks::match_frames(scene_, mesh, used_, options_.input.mesh, options_.input.mesh_crs);
      if (!assumed.text.empty()) record_.warning(assumed.text, assumed.cures);
      checks::check_frames(mesh, options_.input.mesh, scene_, used_);
      checks::set_nearness(scene_, mesh);
      const bool cameras_moved = has_frames && scene_.other_frames.empty();
      if (!mesh.file_positions.empty() || (!assumed.text.empty() && !cameras_moved))
        record_.warning("only cameras are written: in their coordinates the mesh has to be moved as it was here");
    }
    if (options_.input.mesh.empty() && !scene_.other_frames.empty()) {
      std::vector<std::string> names;
      for (const SceneFrame& frame : scene_.other_frames) names.push_back(frame.name);
      record_.warning(fmt::format(
          "the cameras are written in their own coordinates, and a mesh may be in {}: --mesh writes them for a mesh",
          fmt::join(names, ", or in ")));
    }
    const bool tells = writer_.more.states_enu && scene_.srs.starts_with("ENU:");
    if (scene_.srs.empty() || tells) return;
    const WorldPoint& o = scene_.offset;
    record_.note(fmt::format("the new files do not tell their reference system: {}{}", scene_.srs,
                             o == WorldPoint{} ? "" : fmt::format(", less {} {} {}", o.x, o.y, o.z)));
  }

  /// Views with the same camera get the same frame.
  void choose_frames() {
    written_ = scene_;
    std::vector<std::pair<Camera, Frame>> known;
    for (const ViewId id : used_) {
      const Camera& camera = view_of(scene_, id).camera;
      Frame frame{{0, 0, camera.width, camera.height}, false};
      const auto same = std::find_if(known.begin(), known.end(), [&](const auto& k) { return k.first == camera; });
      if (same != known.end()) {
        frame = same->second;
      } else if (options_.undistort) {
        frame.window = pipeline::frame_window(camera, options_.frame, writer_.more.square_and_centred);
        frame.blank = pipeline::shows_blank(camera, frame.window);
        known.emplace_back(camera, frame);
        constexpr std::size_t kHandful = 5;
        if ((!camera.distortion.is_identity() || frame.window.centred) && known.size() <= kHandful)
          record_.note(fmt::format("frame: {} x {} pixels become {} x {}", camera.width, camera.height,
                                   frame.window.width, frame.window.height));
      }
      if (options_.undistort) written_.views[index(id)].camera = pipeline::camera_of_window(camera, frame.window);
      frames_.push_back(frame);
    }
  }

  void choose_places() {
    if (options_.undistort || options_.input.downscale > 1)
      for (const ViewId id : used_) {
        std::string& name = written_.views[index(id)].name;
        name = resampled_name(name);
      }
    places_ = io::photo_places(options_.target, written_, used_);
    std::set<fs::path> taken;
    std::vector<fs::path> masks;
    for (std::size_t i = 0; i < used_.size(); ++i) {
      const bool masked = has_mask(view_of(scene_, used_[i])) || frames_[i].blank || may_lack_data();
      masks_.push_back(masked && writer_.mask_place != nullptr ? std::optional(writer_.mask_place(places_[i]))
                                                               : std::nullopt);
      if (!masks_.back()) continue;
      masks.push_back(*masks_.back());
      if (!taken.insert(masks.back()).second)
        throw OutputError(masks.back(), "two photos that differ in their extension alone would need this mask");
    }
    refuse_overwriting(options_, scene_, folder_, places_, masks);
    folder_.protect(input_files(scene_));
  }

  void warn_of_motion() const {
    const auto moving = std::ranges::count_if(used_, [&](ViewId id) {
      const Motion& motion = view_of(scene_, id).camera.distortion.motion;
      return motion.step != Motion{}.step && motion.nearness == Motion{}.nearness;
    });
    if (options_.undistort && moving > 0)
      record_.warning(fmt::format(
          "{} cameras moved while their photos were read out (rolling shutter): their turns are undone, and not "
          "their travel, whose effect depends on distances; with --mesh both are where they show it",
          moving));
  }

  void warn_of_lost_masks() const {
    const char* const who = writer_.more.without_masks;
    if (who == nullptr) return;
    const auto masked =
        std::count_if(used_.begin(), used_.end(), [&](ViewId id) { return has_mask(view_of(scene_, id)); });
    if (masked > 0)
      record_.warning(fmt::format("{} will use the pixels that the masks of {} photos exclude", who, masked));
    if (std::any_of(frames_.begin(), frames_.end(), [](const Frame& frame) { return frame.blank; }))
      record_.warning(
          fmt::format("{} will use the blank parts of undistorted photos; --frame inside leaves nothing blank", who));
  }

  /// What is decoded loses what its file says of pixels without data.
  bool may_lack_data() const { return scene_.bands && !copies_photos(); }
  bool copies_photos() const { return !options_.undistort && options_.input.downscale == 1; }

  void expect_space() const {
    // Of photos of leaves and gravel, which compress badly.
    constexpr double kJpegBytesPerPixel = 0.7, kPngBytesPerPixel = 2.5;
    double copied = 0, encoded = 0;
    for (std::size_t i = 0; i < used_.size(); ++i) {
      if (copies_photos()) {
        copied += static_cast<double>(fs::file_size(view_of(scene_, used_[i]).photo));
      } else {
        const Camera& camera = view_of(written_, used_[i]).camera;
        encoded += (is_jpeg(places_[i]) ? kJpegBytesPerPixel : kPngBytesPerPixel) * camera.width * camera.height;
      }
    }
    folder_.expect_space(copied, copied + encoded, record_);
  }

  void write_photo(std::size_t i, io::PhotoSource& photos) {
    const View& view = view_of(scene_, used_[i]);
    const fs::path file = folder_.file(places_[i]);
    if (copies_photos()) return io::copy_file(view.photo, file);
    const io::ImageFormat format = is_jpeg(file) ? io::ImageFormat::jpg : io::ImageFormat::png;
    const io::ColorProfile profile = pipeline::profile_of_photo(scene_, used_[i], photos);
    const auto photo = photos.photo(used_[i]);
    std::vector<std::uint8_t> inside;
    if (options_.undistort)
      io::write_image(file, pipeline::undistort_photo(*photo, view.camera, frames_[i].window, inside), format,
                      options_.quality, profile);
    else
      io::write_image(file, *photo, format, options_.quality, profile);
  }

  /// The other bands of a photo, beside it under their own names, by which they are found again. Returns how many cannot be.
  std::size_t copy_bands(std::size_t i) {
    const View& view = view_of(scene_, used_[i]);
    const bool keeps_name = places_[i].filename() == view.photo.filename();
    std::size_t left = 0;
    for (const fs::path& band : view.band_files) {
      if (band == view.photo) continue;
      if (keeps_name && band.parent_path() == view.photo.parent_path())
        io::copy_file(band, folder_.file(places_[i].parent_path() / band.filename()));
      else
        ++left;
    }
    return left;
  }

  /// False where the photo needs none.
  bool write_mask(std::size_t i, io::PhotoSource& excluding) {
    const View& view = view_of(scene_, used_[i]);
    if (!masks_[i]) return false;
    // Masks are written as PNG without alpha, which other programs ignore.
    const bool unchanged = copies_photos() && io::has_plain_mask(view);
    if (unchanged) {
      io::copy_file(view.mask, folder_.file(*masks_[i]));
      return true;
    }
    const auto exclusion = excluding.exclusion(used_[i]);
    if (!exclusion && !options_.undistort) return false;
    const Image mask = options_.undistort
                           ? pipeline::undistort_mask(exclusion ? &*exclusion : nullptr, view.camera, frames_[i].window)
                           : pipeline::mask_image(*exclusion);
    const bool excludes = std::find(mask.pixels.begin(), mask.pixels.end(), 0) != mask.pixels.end();
    if (excludes) io::write_image(folder_.file(*masks_[i]), mask, io::ImageFormat::png, 0);
    return excludes;
  }

  Json options_json() const {
    Json json = scene_json(options_.input);
    json.erase("hold_out");
    json["format"] = name_of(io::kSceneTargetNames, options_.target);
    json["undistort"] = options_.undistort;
    json["frame"] = name_of(pipeline::kFrameRuleNames, options_.frame);
    json["quality"] = options_.quality;
    return json;
  }

  const ConvertOptions& options_;
  const io::SceneWriter& writer_ = io::scene_writer(options_.target);
  RunRecord& record_;
  results::OutputFolder& folder_;
  Scene scene_, written_;  ///< as read; with the cameras and names that are written
  std::vector<ViewId> used_;
  std::vector<Frame> frames_;     ///< per used view
  std::vector<fs::path> places_;  ///< per used view
  std::vector<std::optional<fs::path>>
      masks_;  ///< per used view; nullopt if it has none or the format has no place for it
};

}  // namespace

void run_convert(const ConvertOptions& options, Console& console) {
  run_command("convert", options, console, [&](RunRecord& record, results::OutputFolder& folder) {
    return Conversion(options, record, folder).run();
  });
}

}  // namespace gpvc::cli
