// gpvc synth: a synthetic scene as files.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <array>
#include <cmath>

#include "app/cli/interrupt.h"
#include "app/cli/scene_input.h"
#include "app/cli/synth_bands.h"
#include "app/evaluate/truth.h"
#include "app/synth/terrain.h"
#include "io/npy.h"

namespace gpvc::cli {
namespace {

// Bounds of the photos' gains, and of the lens's loss of brightness in the corners.
constexpr double kLeastGain = 0.7, kMostGain = 1.4, kLeastVignetting = 0.15, kMostVignetting = 0.3;

/// The gains of two successive photos have the product kLeastGain * kMostGain, about 1. Photos do not show how bright the
/// scene is as a whole, so levelled colours are expected at the mean of the gains.
synth::Exposure exposure_of(const SynthOptions& options, std::size_t view) {
  synth::Exposure result;
  const std::uint32_t seed = options.flight.seed, number = static_cast<std::uint32_t>(view);
  if (options.exposure) {
    const double t = synth::synth_chance(seed, number / 2, 8101);
    const double first = kLeastGain + (kMostGain - kLeastGain) * t;
    result.gain.fill(number % 2 == 0 ? first : kLeastGain * kMostGain / first);
    result.vignetting = kLeastVignetting + (kMostVignetting - kLeastVignetting) * synth::synth_chance(seed, 0, 8102);
  }
  // Every gain is made from the one before: half of a step is common to all channels. It turns back at the bounds.
  std::array<double, 3> walk{1, 1, 1};
  for (std::uint32_t n = 0; n < number && options.wander > 0; ++n) {
    const auto chance = [&](std::uint32_t what) { return 2 * synth::synth_chance(seed, n, 8104 + what) - 1; };
    for (std::uint32_t c = 0; c < 3; ++c) {
      const double step = 1 + options.wander * (chance(0) + chance(1 + c)) / 2;
      const double next = walk[c] * step;
      walk[c] = next < kLeastGain || next > kMostGain ? walk[c] / step : next;
    }
  }
  for (std::size_t c = 0; c < 3; ++c) result.gain[c] *= walk[c];
  return result;
}

// As a camera that changes its exposure time alone, and whose values rise with the 2.2th root of the light.
void state_exposure(const std::filesystem::path& jpeg, const synth::Exposure& exposure) {
  const double gain = (exposure.gain[0] + exposure.gain[1] + exposure.gain[2]) / 3;
  io::state_exposure(jpeg, std::pow(gain, 2.2) / 500, 2.8, 100);
}

// How far the middle of a photo moves over its exposure, in pixels: evenly spread over a disc.
PixelPoint shake_of(const SynthOptions& options, std::size_t view) {
  if (options.shake_px == 0) return {};
  const auto number = static_cast<std::uint32_t>(view);
  for (std::uint32_t n = 0;; n += 2) {
    const auto chance = [&](std::uint32_t what) {
      return 2 * synth::synth_chance(options.flight.seed, number, 8200 + n + what) - 1;
    };
    const double x = chance(0), y = chance(1);
    if (x * x + y * y <= 1) return {options.shake_px * x, options.shake_px * y};
  }
}

double travel_of(const SynthOptions& options, std::size_t view) {
  return options.travel_m * synth::synth_chance(options.flight.seed, static_cast<std::uint32_t>(view), 8103);
}

double focus_of(const SynthOptions& options) {
  return options.focus_m.value_or(options.flight.size_m * options.flight.range);
}

synth::Shot shot_of(const SynthOptions& options, const Camera& camera, std::size_t view) {
  synth::Shot shot;
  shot.exposure = exposure_of(options, view);
  shot.lens = {options.aperture_m, focus_of(options)};
  // A camera that turns about its y axis by the small angle w moves what is in its middle by -fx * w to the right.
  const PixelPoint shake = shake_of(options, view);
  shot.shake.turn_rad = {shake.y / camera.fy, -shake.x / camera.fx, 0};
  shot.shake.travel_m = {travel_of(options, view), 0, 0};
  shot.visibility_m = options.visibility_m;
  shot.backscatter = options.backscatter;
  shot.rays = options.rays;
  shot.reflections = options.reflections;
  return shot;
}

// True if clean photos would be others.
bool imperfect(const SynthOptions& o) {
  return o.exposure || o.wander > 0 || o.backscatter != 0 || o.unmodelled.any() || o.reflections || o.aperture_m > 0 ||
         o.shake_px > 0 || o.travel_m > 0 || o.visibility_m > 0;
}

Json options_json(const SynthOptions& o) {
  return {{"faces", o.faces},
          {"photos", o.flight.photos},
          {"nadir", o.flight.all_nadir},
          {"width", o.flight.width},
          {"height", o.flight.height},
          {"size_m", o.flight.size_m},
          {"range", o.flight.range},
          {"gap_m", o.gap_m},
          {"seed", o.flight.seed},
          {"distorted", o.flight.distorted},
          {"mesh_noise_m", o.mesh_noise_m},
          {"pose_error_px", o.errors.pose_px},
          {"lens_error_px", o.errors.lens_px},
          {"exposure", o.exposure},
          {"wander", o.wander},
          {"exif", o.exif},
          {"backscatter", o.backscatter},
          {"cars", o.unmodelled.cars},
          {"people", o.unmodelled.people},
          {"fences", o.unmodelled.fences},
          {"trees", o.unmodelled.trees},
          {"wires", o.unmodelled.wires},
          {"reflections", o.reflections},
          {"aperture_m", o.aperture_m},
          {"focus_m", focus_of(o)},
          {"shake_px", o.shake_px},
          {"travel_m", o.travel_m},
          {"visibility_m", o.visibility_m},
          {"rays", o.rays},
          {"ids", o.ids},
          {"bands", o.bands.count},
          {"depth", name_of(kSampleTypeNames, o.bands.type)},
          {"band_files", o.bands.apart},
          {"offset", Json::array({o.offset.x, o.offset.y, o.offset.z})},
          {"quality", o.quality}};
}

synth::SynthScene make_scene(const SynthOptions& options) {
  if (options.kind == SynthKind::city) return synth::make_city({options.flight, options.faces});
  const synth::LayerOptions layers{options.faces, options.flight.size_m, options.gap_m, options.flight.seed};
  return options.kind == SynthKind::terrain ? synth::make_terrain(layers) : synth::make_slits(layers);
}

// Moves every coordinate by up to `noise_m` and rounds it to 2^-20 m.
Mesh noisy(Mesh mesh, double noise_m, std::uint32_t seed) {
  constexpr double kGrid = 1048576;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    WorldPoint& p = mesh.positions[v];
    const auto n = static_cast<std::uint32_t>(v);
    const auto moved = [&](double at, std::uint32_t axis) {
      return std::round((at + noise_m * (2 * synth::synth_chance(seed, n, axis + 70) - 1)) * kGrid) / kGrid;
    };
    p = {moved(p.x, 0), moved(p.y, 1), moved(p.z, 2)};
  }
  return mesh;
}

Image id_picture(const std::vector<std::uint32_t>& surfaces, int width, int height) {
  Image picture{width, height, 3, {}};
  picture.pixels.reserve(surfaces.size() * 3);
  for (const std::uint32_t surface : surfaces)
    for (const std::uint8_t c : evaluate::id_color(surface)) picture.pixels.push_back(c);
  return picture;
}

// The share in each of the three channels, since photos have three.
Image share_picture(const std::vector<std::uint8_t>& shares, int width, int height) {
  Image picture{width, height, 3, {}};
  picture.pixels.reserve(shares.size() * 3);
  for (const std::uint8_t share : shares) picture.pixels.insert(picture.pixels.end(), 3, share);
  return picture;
}

synth::SynthScene unmodelled_of(const SynthOptions& options, std::size_t view) {
  return options.unmodelled.any()
             ? synth::make_unmodelled({options.flight, 0}, static_cast<std::uint32_t>(view), options.unmodelled)
             : synth::SynthScene{};
}

synth::SynthPhoto take_photo(synth::SynthRenderer& renderer, const View& view, const synth::Shot& shot,
                             const synth::SynthScene* unmodelled, const SynthOptions& options,
                             const std::string& subfolder, results::OutputFolder& folder) {
  if (!options.bands.any()) {
    synth::SynthPhoto photo = renderer.photo(view.camera, view.pose, shot, unmodelled);
    io::write_image(folder.file(subfolder + view.name), photo.image, io::ImageFormat::jpg, options.quality);
    return photo;
  }
  synth::SynthPhoto photo;
  const Samples samples = synth::band_photo(renderer, view.camera, view.pose, shot, unmodelled, options.bands, photo);
  write_bands(samples, subfolder, view.name, options.bands, folder);
  return photo;
}

void take_photos(synth::SynthRenderer& renderer, const std::vector<View>& views, const SynthOptions& options,
                 RunRecord& record, results::OutputFolder& folder) {
  record.begin({"photos", "photos"});
  for (std::size_t v = 0; v < views.size(); ++v) {
    record.progress(v, views.size());
    const View& view = views[v];
    const synth::SynthScene unmodelled = unmodelled_of(options, v);
    const synth::SynthPhoto photo =
        take_photo(renderer, view, shot_of(options, view.camera, v), &unmodelled, options, "images/", folder);
    if (options.exif) state_exposure(folder.file("images/" + view.name), exposure_of(options, v));
    if (!options.ids) continue;
    io::write_image(folder.file("ids/" + view.name + ".png"),
                    id_picture(photo.surfaces, view.camera.width, view.camera.height), io::ImageFormat::png, 0);
    if (options.unmodelled.any())
      io::write_image(folder.file("unmodelled/" + view.name + ".png"),
                      share_picture(photo.unmodelled, view.camera.width, view.camera.height), io::ImageFormat::png, 0);
    if (imperfect(options)) take_photo(renderer, view, {}, nullptr, options, "clean/", folder);
  }
  record.end(fmt::format("{} of {} x {}", views.size(), options.flight.width, options.flight.height));
}

void write_truth(const SynthOptions& options, const synth::SynthScene& scene, const std::vector<View>& views,
                 results::OutputFolder& folder) {
  io::write_npy_as<std::uint32_t>(folder.file("surfaces.npy"), scene.face_surface);
  synth::write_synth_surfaces(folder.file("surfaces.json"), scene);
  double least = 1, most = 1;
  Json photos = Json::object();
  for (std::size_t v = 0; v < views.size(); ++v) {
    const synth::Exposure e = exposure_of(options, v);
    const PixelPoint shake = shake_of(options, v);
    photos[views[v].name] = {{"gain", e.gain},
                             {"vignetting", e.vignetting},
                             {"shake_px", Json::array({shake.x, shake.y})},
                             {"travel_m", travel_of(options, v)}};
    for (std::size_t c = 0; c < 3; ++c) {
      least = std::min(least, e.at(c, 1));
      most = std::max(most, e.gain[c]);
    }
  }
  const Json truth = {{"surfaces", scene.surfaces.size()},
                      {"moving_surfaces", unmodelled_of(options, 0).surfaces.size()},
                      {"least_gain", least},
                      {"most_gain", most},
                      {"photos", photos},
                      {"bands", synth_bands_json(options.bands)}};
  evaluate::write_json(folder.file("truth.json"), truth);
  if (options.mesh_noise_m > 0) synth::write_synth_mesh(folder.file("true_mesh.ply"), scene.mesh, options.offset);
}

RunFacts synthesize(const SynthOptions& options, RunRecord& record, results::OutputFolder& folder) {
  record.begin({synth_name(options.kind)});
  const synth::SynthScene scene = make_scene(options);
  std::vector<View> views = synth::synth_flight(options.flight);
  if (options.bands.any()) name_band_photos(views, options.bands);
  synth::SynthRenderer renderer(scene);
  record.counts = {{"faces", scene.mesh.faces.size()},
                   {"vertices", scene.mesh.positions.size()},
                   {"surfaces", scene.surfaces.size()},
                   {"views", views.size()}};
  const bool exact = options.mesh_noise_m == 0;
  synth::write_synth_mesh(folder.file("mesh.ply"),
                          exact ? scene.mesh : noisy(scene.mesh, options.mesh_noise_m, options.flight.seed),
                          options.offset);
  const auto write_cameras = [&](const std::string& model, const std::vector<View>& written) {
    for (const char* name : {"/cameras.txt", "/images.txt"}) folder.file(model + name);
    synth::write_synth_cameras(folder.file(model + "/points3D.txt").parent_path(), scene, views, written, renderer,
                               options.offset);
  };
  write_cameras("colmap", synth::with_errors(views, options.errors, options.flight.seed));
  if (options.errors.any()) write_cameras("true_colmap", views);
  write_truth(options, scene, views, folder);
  record.end(
      fmt::format("{} faces of {} surfaces", results::readable_count(scene.mesh.faces.size()), scene.surfaces.size()));
  take_photos(renderer, views, options, record, folder);
  return {.options = options_json(options),
          .result = fmt::format("scene   {}\nmesh    {}\nphotos  {}", (options.out / "colmap").string(),
                                (options.out / "mesh.ply").string(), (options.out / "images").string())};
}

}  // namespace

SynthOptions synth_defaults(SynthKind kind) {
  SynthOptions options;
  options.kind = kind;
  if (kind == SynthKind::terrain) {
    options.faces = 40000;
    options.flight.size_m = 4000;
    options.flight.range = 1.5;
    options.flight.target_m = 160;
  }
  if (kind == SynthKind::slits) {
    options.faces = 60000;
    options.flight.size_m = 1;
    options.flight.range = 0.9;
    options.flight.width = 1600;
    options.flight.height = 1200;
  }
  return options;
}

const char* synth_name(SynthKind kind) {
  constexpr const char* kNames[] = {"city", "terrain", "slits"};
  return kNames[static_cast<std::size_t>(kind)];
}

void run_synth(const SynthOptions& options, Console& console) {
  if (options.exif && options.bands.any()) throw UsageError("--exif is of JPEGs, which bands are not");
  if (options.bands.apart && !options.bands.any()) throw UsageError("--band-files belongs to --bands or --depth");
  run_command(fmt::format("synth {}", synth_name(options.kind)), options, console,
              [&](RunRecord& record, results::OutputFolder& folder) { return synthesize(options, record, folder); });
}

}  // namespace gpvc::cli
