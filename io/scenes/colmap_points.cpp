// COLMAP's sparse points, binary and text: https://colmap.github.io/format.html
#include "io/scenes/colmap_points.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "io/error.h"
#include "io/file_bytes.h"
#include "io/files/text_scan.h"
#include "io/scene_files.h"
#include "io/tie_points.h"
#include "io/vector.h"

namespace gpvc::io {
namespace {

void parse_binary(const std::filesystem::path& file, std::string_view bytes, const TakeColmapPoint& take) {
  constexpr const char* kWhat = "the point list";
  ByteReader reader(file, bytes);
  std::vector<std::uint32_t> track;
  for (auto left = reader.read<std::uint64_t>(kWhat); left > 0; --left) {
    const auto number = reader.read<std::uint64_t>(kWhat);
    WorldPoint p;
    for (double* value : {&p.x, &p.y, &p.z}) *value = reader.read<double>(kWhat);
    reader.take(3 + 8, kWhat);  // colour and error
    const auto length = reader.read<std::uint64_t>(kWhat);
    constexpr std::uint64_t kEntryBytes = 8;  // number of the image, number of its point
    if (length > reader.remaining() / kEntryBytes) reader.fail("the file ends inside the track of a point");
    track.resize(static_cast<std::size_t>(length));
    for (std::uint32_t& image : track) {
      image = reader.read<std::uint32_t>(kWhat);
      reader.take(4, kWhat);
    }
    take(number, p, track);
  }
}

void parse_text(const std::filesystem::path& file, std::string_view text, const TakeColmapPoint& take) {
  std::string_view rest = without_byte_order_mark(text);
  std::vector<std::uint32_t> track;
  for (std::size_t number = 1; !rest.empty(); ++number) {
    std::string_view line = trimmed(next_line(rest));
    if (line.empty() || line.front() == '#') continue;
    const auto fail = [&](std::string_view word) {
      throw InputError(file, "line " + std::to_string(number),
                       "expected POINT3D_ID X Y Z R G B ERROR and pairs of IMAGE_ID POINT2D_IDX, found " + quote(word));
    };
    const auto value = [&] {
      const std::string_view word = next_word(line);
      const std::optional<double> v = number_from(word);
      if (!v) fail(word);
      return *v;
    };
    const std::string_view number_word = next_word(line);
    if (!number_from(number_word)) fail(number_word);
    const std::uint64_t id = integer_from<std::uint64_t>(number_word).value_or(~std::uint64_t{0});
    WorldPoint p;
    for (double* coordinate : {&p.x, &p.y, &p.z}) *coordinate = value();
    for (int i = 0; i < 4; ++i) value();
    track.clear();
    while (!line.empty()) {
      const std::string_view word = next_word(line);
      const std::optional<std::uint32_t> image = integer_from<std::uint32_t>(word);
      if (!image) fail(word);
      track.push_back(*image);
      value();
      line = trimmed(line);
    }
    take(id, p, track);
  }
}

void parse_binary_sightings(const std::filesystem::path& file, std::string_view bytes, const TakeColmapSighting& take) {
  constexpr const char* kWhat = "the image list";
  constexpr std::uint64_t kNone = ~std::uint64_t{0};
  ByteReader reader(file, bytes);
  for (auto left = reader.read<std::uint64_t>(kWhat); left > 0; --left) {
    const auto image = reader.read<std::uint32_t>(kWhat);
    reader.take(7 * sizeof(double) + sizeof(std::uint32_t), kWhat);  // pose and camera
    reader.take_text(kWhat);
    for (auto points = reader.read<std::uint64_t>(kWhat); points > 0; --points) {
      PhotoPoint at;
      at.x = reader.read<double>(kWhat);
      at.y = reader.read<double>(kWhat);
      if (const auto point = reader.read<std::uint64_t>(kWhat); point != kNone) take(image, point, at);
    }
  }
}

void parse_text_sightings(std::string_view text, const TakeColmapSighting& take) {
  std::string_view rest = without_byte_order_mark(text);
  while (!rest.empty()) {
    std::string_view line = trimmed(next_line(rest));
    if (line.empty() || line.front() == '#') continue;
    const auto image = integer_from<std::uint32_t>(next_word(line));
    line = next_line(rest);
    // The reader of the cameras has judged the file; what is no triple here is not looked at.
    while (image && !line.empty()) {
      const auto x = number_from(next_word(line)), y = number_from(next_word(line));
      if (const auto point = integer_from<std::uint64_t>(next_word(line)); x && y && point)
        take(*image, *point, {*x, *y});
      line = trimmed(line);
    }
  }
}

/// Keeps at most twice `most` of the points that it is given, evenly.
class Sample {
 public:
  explicit Sample(std::size_t most) : most_(most) {}
  bool takes_next() { return given_++ % step_ == 0; }
  void add(const TiePoint& point) {
    points_.push_back(point);
    if (points_.size() < 2 * most_) return;
    thin(most_);
    step_ *= 2;
  }
  std::vector<TiePoint> points() && {
    if (points_.size() > most_) thin(most_);
    return std::move(points_);
  }

 private:
  void thin(std::size_t count) {
    const std::size_t size = points_.size();
    for (std::size_t i = 0; i < count; ++i) points_[i] = points_[i * size / count];
    points_.resize(count);
  }
  std::size_t most_, given_ = 0, step_ = 1;
  std::vector<TiePoint> points_;
};

/// The view of `track` that is farthest from the first in direction; nullopt where it is the only one.
std::optional<TiePoint> tie_point(const Scene& scene, const WorldPoint& p, std::span<const ViewId> track) {
  if (track.size() < 2 || !std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) return std::nullopt;
  const auto towards = [&](ViewId view) { return unit(scene.views[index(view)].pose.centre - p); };
  const WorldPoint to_a = towards(track[0]);
  const auto b = std::ranges::min_element(track, {}, [&](ViewId view) { return dot(to_a, towards(view)); });
  return *b == track[0] ? std::nullopt : std::optional(TiePoint{p, track[0], *b});
}

/// Of a panorama's views, nothing says which shows a point; of a fisheye's, the first may.
std::unordered_map<std::uint32_t, ViewId> views_by_number(const Scene& scene) {
  std::unordered_map<std::uint32_t, ViewId> views;
  for (std::uint32_t v = 0; v < scene.views.size(); ++v)
    if (photo_name(scene.views[v]) == scene.views[v].name) views.emplace(scene.views[v].number, ViewId{v});
  return views;
}

}  // namespace

void parse_colmap_points(bool binary, const std::filesystem::path& file, std::string_view bytes,
                         const TakeColmapPoint& take) {
  binary ? parse_binary(file, bytes, take) : parse_text(file, bytes, take);
}

void parse_colmap_sightings(bool binary, const std::filesystem::path& file, std::string_view bytes,
                            const TakeColmapSighting& take) {
  binary ? parse_binary_sightings(file, bytes, take) : parse_text_sightings(bytes, take);
}

std::optional<std::filesystem::path> tie_points_file(const Scene& scene) {
  const auto file = std::ranges::find_if(scene.files, [](const auto& each) { return each.stem() == "points3D"; });
  return scene.format == "COLMAP" && file != scene.files.end() ? std::optional(*file) : std::nullopt;
}

std::vector<TiePoint> read_tie_points(const Scene& scene, std::size_t most) {
  const std::optional<std::filesystem::path> file = tie_points_file(scene);
  if (!file || most == 0) return {};
  const auto views = views_by_number(scene);
  Sample sample(most);
  std::vector<ViewId> track;
  const auto take = [&](std::uint64_t, const WorldPoint& p, std::span<const std::uint32_t> images) {
    if (!sample.takes_next()) return;
    track.clear();
    for (const std::uint32_t image : images)
      if (const auto view = views.find(image); view != views.end()) track.push_back(view->second);
    if (const std::optional<TiePoint> point = tie_point(scene, p, track)) sample.add(*point);
  };
  parse_colmap_points(file->extension() == ".bin", *file, FileBytes(*file).view(), take);
  return std::move(sample).points();
}

std::vector<Sighting> read_sightings(const Scene& scene, std::size_t most) {
  const std::optional<std::filesystem::path> file = tie_points_file(scene);
  const auto images = std::ranges::find_if(scene.files, [](const auto& each) { return each.stem() == "images"; });
  if (!file || images == scene.files.end() || scene.views.empty()) return {};
  const auto views = views_by_number(scene);
  struct Numbered {
    std::uint64_t point;
    Sighting sighting;
  };
  // The same number for each view, evenly from its list.
  const std::size_t of_each = std::max<std::size_t>(1, most / scene.views.size());
  std::vector<Numbered> some, of_image;
  std::uint32_t current = 0;
  const auto flush = [&] {
    const std::size_t count = std::min(of_each, of_image.size());
    for (std::size_t i = 0; i < count; ++i) some.push_back(of_image[i * of_image.size() / count]);
    of_image.clear();
  };
  parse_colmap_sightings(images->extension() == ".bin", *images, FileBytes(*images).view(),
                         [&](std::uint32_t image, std::uint64_t point, const PhotoPoint& at) {
                           if (image != current) flush();
                           current = image;
                           const auto view = views.find(image);
                           if (view == views.end()) return;
                           const double reduction = scene.views[index(view->second)].reduction;
                           of_image.push_back({point, {view->second, {at.x / reduction, at.y / reduction}, {}}});
                         });
  flush();
  std::unordered_map<std::uint64_t, WorldPoint> positions;
  for (const Numbered& each : some) positions.emplace(each.point, WorldPoint{});
  std::size_t found = 0;
  parse_colmap_points(file->extension() == ".bin", *file, FileBytes(*file).view(),
                      [&](std::uint64_t point, const WorldPoint& p, std::span<const std::uint32_t>) {
                        const auto at = positions.find(point);
                        if (at == positions.end()) return;
                        at->second = p;
                        ++found;
                      });
  if (found < positions.size()) return {};  // lists of two models
  std::vector<Sighting> sightings;
  for (Numbered& each : some) {
    each.sighting.point = positions.at(each.point);
    sightings.push_back(each.sighting);
  }
  return sightings;
}

}  // namespace gpvc::io
