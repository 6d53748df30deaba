#include "app/ortho/ortho.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <optional>

#include "app/ortho/tile.h"
#include "io/grouping.h"
#include "io/output_file.h"
#include "io/raster.h"

namespace gpvc::ortho {
namespace {

constexpr int kRows = 256;  // that are written at a time

// Tiles are squares of the picture, a whole number of which is as high as the rows.
struct Tiles {
  int edge, columns, rows;

  Tiles(const Grid& grid, int samples) {
    edge = static_cast<int>(std::bit_floor(static_cast<unsigned>(std::clamp(samples / grid.samples, 1, kRows))));
    columns = (grid.width + edge - 1) / edge;
    rows = (grid.height + edge - 1) / edge;
  }
  std::size_t count() const { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }
  std::size_t number(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column);
  }
};

// The faces that may lie in each tile.
Grouped<std::uint32_t> faces_of_tiles(const Drawing& of, const Tiles& tiles) {
  const int unit = kPlanUnit * of.grid.samples * tiles.edge;
  return group_items<std::uint32_t>(tiles.count(), [&](const auto& add) {
    const auto& faces = of.surface.mesh.faces;
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
      if (of.surface.kind[f] == FaceKind::absent) continue;
      const PlanPoint &a = of.plan[faces[f][0]], &b = of.plan[faces[f][1]], &c = of.plan[faces[f][2]];
      const std::int32_t left = std::min({a.x, b.x, c.x}), right = std::max({a.x, b.x, c.x});
      const std::int32_t top = std::min({a.y, b.y, c.y}), bottom = std::max({a.y, b.y, c.y});
      if (right < 0 || bottom < 0) continue;
      const int x1 = std::min(right / unit, tiles.columns - 1), y1 = std::min(bottom / unit, tiles.rows - 1);
      for (int y = std::max(top, 0) / unit; y <= y1; ++y)
        for (int x = std::max(left, 0) / unit; x <= x1; ++x) add(tiles.number(x, y), f);
    }
  });
}

io::RasterInfo raster_info(const Grid& grid, const Frame& frame) {
  io::RasterInfo info;
  info.width = grid.width;
  info.height = grid.height;
  info.west = grid.west;
  info.north = grid.north;
  info.pixel_size = grid.gsd;
  info.wkt = frame.wkt;
  info.threads = static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
  info.metadata = {{"TIFFTAG_SOFTWARE", "gpvc " GPVC_VERSION}, {"AREA_OR_POINT", "Area"}, {"COORDINATES", frame.name}};
  return info;
}

// The files, which take rows and are complete after finish().
class OrthoFiles {
 public:
  OrthoFiles(const Surface& surface, const std::optional<BandSet>& bands, const Grid& grid, const Frame& frame,
             const OrthoSettings& settings, pipeline::OutputFolder& folder) {
    io::RasterInfo colors = raster_info(grid, frame);
    colors.bands = {"red", "green", "blue"};
    colors.mask = true;
    colors.compression = settings.compress;
    colors.quality = settings.quality;
    colors_.emplace(folder.file(kOrthoFile), colors);
    const bool lossless = io::is_lossless(settings.compress);
    io::RasterInfo heights = raster_info(grid, frame);
    heights.bands = {"height"};
    heights.type = SampleType::f32;
    heights.nodata = kNoHeight;
    heights.compression = lossless ? settings.compress : io::RasterCompression::deflate;
    heights_.emplace(folder.file(kHeightFile), heights);
    if (bands) {
      io::RasterInfo samples = raster_info(grid, frame);
      for (const Band& band : bands->bands) {
        samples.bands.push_back(band.name);
        if (band.wavelength_nm)
          samples.metadata.emplace_back("WAVELENGTH_NM_" + band.name, fmt::to_string(*band.wavelength_nm));
        if (!band.unit.empty()) samples.metadata.emplace_back("UNIT_" + band.name, band.unit);
      }
      samples.type = bands->type;
      samples.mask = true;
      samples.compression = heights.compression;
      bands_.emplace(folder.file(kBandsFile), samples);
    }
    if (surface.photo.empty()) return;
    io::RasterInfo photos = heights;
    photos.bands = {"photo"};
    photos.metadata.emplace_back("PHOTOS", kPhotoListFile);
    photos.mean_overviews = false;
    // kNoPhoto is clamped to the largest value of either type.
    const auto is_small = [](std::uint32_t number) { return number == kNoPhoto || number < 0xFFFFU; };
    const bool few = std::ranges::all_of(surface.photo, is_small);
    photos.type = few ? SampleType::u16 : SampleType::u32;
    photos.nodata = few ? 0xFFFFU : kNoPhoto;
    photos_.emplace(folder.file(kPhotoFile), photos);
  }
  void write(const Rows& rows) {
    const int count = static_cast<int>(rows.mask.size() / static_cast<std::size_t>(rows.width));
    colors_->write_rows(rows.first, count, rows.rgb.data(), rows.mask.data());
    heights_->write_rows(rows.first, count, rows.height.data());
    if (bands_) bands_->write_rows(rows.first, count, rows.samples.data(), rows.mask.data());
    if (photos_) photos_->write_rows(rows.first, count, rows.photo.data());
  }
  void finish(const Progress& progress) {
    const std::array files{&colors_, &heights_, &bands_, &photos_};
    const auto count =
        static_cast<std::size_t>(std::ranges::count_if(files, [](const auto* file) { return file->has_value(); }));
    std::size_t done = 0;
    for (std::optional<io::RasterWriter>* file : files) {
      if (!*file) continue;
      (*file)->finish(results::part_of(progress, 100 * done++, 100 * count));
      file->reset();
    }
  }

 private:
  std::optional<io::RasterWriter> colors_, heights_, bands_, photos_;
};

std::string quoted(const std::string& name) {
  if (name.find_first_of(",\"\r\n") == std::string::npos) return name;
  std::string text = "\"";
  for (const char c : name) text += c == '"' ? "\"\"" : std::string(1, c);
  return text + "\"";
}

void write_photo_list(const std::vector<std::string>& names, const std::filesystem::path& file) {
  std::string text = "number,photo\n";
  for (std::size_t n = 0; n < names.size(); ++n) text += fmt::format("{},{}\n", n, quoted(names[n]));
  io::write_file(file, text);
}

// Bytes of the rows before they are compressed.
double raw_bytes(const Grid& grid, const std::optional<BandSet>& bands, bool with_photos) {
  const double of_bands = bands ? static_cast<double>(bands->pixel_bytes()) : 0;
  return (3 + 4 + of_bands + (with_photos ? 2.0 : 0.0)) * grid.width * grid.height;
}

}  // namespace

void write_ortho(const Surface& surface, const PageStore& pages, const Frame& frame, const OrthoSettings& settings,
                 pipeline::OutputFolder& folder, pipeline::Observer& observer) {
  const Grid grid = grid_of(surface, pages, settings);
  observer.note(fmt::format("an orthophoto of {} x {} pixels of {} units, {} samples each; {}", grid.width, grid.height,
                            grid.gsd, grid.samples * grid.samples, frame.name));
  const bool with_photos = !surface.photo.empty();
  const double raw = raw_bytes(grid, pages.bands(), with_photos);
  folder.expect_space(0.1 * raw, 1.5 * raw, observer);
  const std::vector<PlanPoint> plan = plan_points(surface, grid);
  const Drawing drawing{surface, pages, grid, plan};
  const Tiles tiles(grid, settings.tile_samples);
  const Grouped<std::uint32_t> faces = faces_of_tiles(drawing, tiles);
  OrthoFiles files(surface, pages.bands(), grid, frame, settings, folder);
  if (with_photos && !surface.photos.empty()) write_photo_list(surface.photos, folder.file(kPhotoListFile));

  observer.begin({"draw", "rows"});
  tbb::enumerable_thread_specific<TileRenderer> renderers([&] { return TileRenderer(drawing); });
  Rows rows;
  std::size_t shown = 0;
  for (int first = 0; first < grid.height; first += kRows) {
    const int end = std::min(first + kRows, grid.height);
    rows.reset(first, end - first, grid.width, pages.bands() ? pages.bands()->bands.size() : 0);
    const std::size_t begin_tile = tiles.number(0, first / tiles.edge);
    const std::size_t end_tile = tiles.number(0, (end + tiles.edge - 1) / tiles.edge);
    tbb::parallel_for(begin_tile, end_tile, [&](std::size_t tile) {
      observer.check_cancelled();
      const int x = static_cast<int>(tile % static_cast<std::size_t>(tiles.columns)) * tiles.edge;
      const int y = static_cast<int>(tile / static_cast<std::size_t>(tiles.columns)) * tiles.edge;
      renderers.local().draw({x, y, std::min(x + tiles.edge, grid.width), std::min(y + tiles.edge, end)}, faces[tile],
                             rows);
    });
    files.write(rows);
    shown += static_cast<std::size_t>(std::ranges::count(rows.mask, 255));
    observer.progress(static_cast<std::size_t>(end), static_cast<std::size_t>(grid.height));
  }
  const double share = static_cast<double>(shown) / grid.width / grid.height;
  observer.figure("width", static_cast<std::size_t>(grid.width));
  observer.figure("height", static_cast<std::size_t>(grid.height));
  observer.figure("gsd", grid.gsd);
  observer.figure("samples_per_pixel", static_cast<std::size_t>(grid.samples * grid.samples));
  observer.figure("shown_share", share);
  observer.figure("coordinates", frame.name);
  observer.end(fmt::format("{:.0f} % of the pixels show something", 100 * share));

  observer.begin({"write", "steps"});
  files.finish(observer.reporter());
  observer.end("");
}

}  // namespace gpvc::ortho
