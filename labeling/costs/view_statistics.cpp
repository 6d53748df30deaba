#include "labeling/costs/view_statistics.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "labeling/costs/photo_lookup.h"
#include "labeling/costs/silhouettes.h"
#include "labeling/view_choice.h"

namespace gpvc::labeling {
namespace {

// --- gradient

constexpr int kGradientUnit = 8;

/// Rec. 601 luma in grey levels, with the first and the last pixel repeated.
void luma_row(const Image& photo, int y, std::vector<std::int16_t>& out) {
  const auto width = static_cast<std::size_t>(photo.width);
  const std::uint8_t* in = photo.at(0, std::clamp(y, 0, photo.height - 1));
  for (std::size_t x = 0; x < width; ++x)
    out[x + 1] = static_cast<std::int16_t>((77 * in[3 * x] + 150 * in[3 * x + 1] + 29 * in[3 * x + 2] + 128) >> 8);
  out[0] = out[1];
  out[width + 1] = out[width];
}

void gradient_row(const std::int16_t* above, const std::int16_t* here, const std::int16_t* below, std::uint16_t* out,
                  std::size_t width) {
  for (std::size_t x = 0; x < width; ++x) {
    const int dx = above[x + 2] - above[x] + 2 * (here[x + 2] - here[x]) + below[x + 2] - below[x];
    const int dy = below[x] - above[x] + 2 * (below[x + 1] - above[x + 1]) + below[x + 2] - above[x + 2];
    out[x] = static_cast<std::uint16_t>(static_cast<int>(std::sqrt(static_cast<float>(dx * dx + dy * dy)) + 0.5f));
  }
}

/// Fills `gradient`, per pixel, row-major: gradient magnitude of luma in 1/kGradientUnit grey levels a pixel, rounded
/// (Sobel's kernel, whose weights sum to 8; the outermost pixels are repeated beyond the border). O(pixels), TBB inside.
void gradient_magnitude(const Image& photo, std::vector<std::uint16_t>& gradient) {
  const auto width = static_cast<std::size_t>(photo.width);
  gradient.resize(width * static_cast<std::size_t>(photo.height));
  tbb::parallel_for(tbb::blocked_range<int>(0, photo.height, 32), [&](const tbb::blocked_range<int>& rows) {
    std::array<std::vector<std::int16_t>, 3> luma;
    for (auto& row : luma) row.resize(width + 2);
    const auto slot = [](int y) { return static_cast<std::size_t>(y + 3) % 3; };
    luma_row(photo, rows.begin() - 1, luma[slot(rows.begin() - 1)]);
    luma_row(photo, rows.begin(), luma[slot(rows.begin())]);
    for (int y = rows.begin(); y != rows.end(); ++y) {
      luma_row(photo, y + 1, luma[slot(y + 1)]);
      gradient_row(luma[slot(y - 1)].data(), luma[slot(y)].data(), luma[slot(y + 1)].data(),
                   gradient.data() + static_cast<std::size_t>(y) * width, width);
    }
  });
}

// --- statistics

constexpr std::uint32_t kNoSlot = 0xFFFFFFFFu;

/// Four times the brightness.
std::uint32_t brightness_of(const std::uint8_t* rgb) { return rgb[0] + 2U * rgb[1] + rgb[2]; }

/// Of whatever sign: unsigned differences wrap around, and their squares do not tell. Which is the larger cannot be predicted.
std::uint32_t square_of_step(std::uint32_t a, std::uint32_t b) { return (a - b) * (a - b); }

/// Sums over pixels of a face.
struct PixelSums {
  std::uint32_t pixels = 0, margin = 0;
  std::uint64_t gradient = 0;
  std::array<std::uint64_t, 3> color{};
  std::uint64_t squares = 0;  ///< of brightness, R + 2 G + B
  std::uint64_t steps = 0;    ///< squared differences of brightness to the pixel before in the row

  PixelSums& operator+=(const PixelSums& other) {
    pixels += other.pixels;
    margin += other.margin;
    gradient += other.gradient;
    for (std::size_t c = 0; c < 3; ++c) color[c] += other.color[c];
    squares += other.squares;
    steps += other.steps;
    return *this;
  }

  /// Standard deviation of the brightness, in grey levels.
  double contrast() const {
    const auto count = static_cast<double>(pixels), sum = static_cast<double>(color[0] + 2 * color[1] + color[2]);
    return std::sqrt(std::max(0.0, static_cast<double>(squares) - sum * sum / count) / count) / 4;
  }

  /// Their root mean square, in grey levels.
  double step() const { return std::sqrt(static_cast<double>(steps) / static_cast<double>(pixels)) / 4; }

  /// Stores itself in a total that several threads may try to be the first to fill; false if another one was. \pre pixels > 0
  bool fill(PixelSums& total) const {
    std::uint32_t none = 0;
    if (!std::atomic_ref(total.pixels).compare_exchange_strong(none, pixels, std::memory_order_relaxed)) return false;
    total.margin = margin;
    total.gradient = gradient;
    total.color = color;
    total.squares = squares;
    total.steps = steps;
    return true;
  }
};

/// The sums over a block of rows, which one thread collects. Most faces lie in one block.
class BlockSums {
 public:
  void start(std::size_t slots) {
    if (place_.size() < slots) place_.resize(slots, kNoSlot);
    sums_.clear();
    slots_.clear();
  }
  /// The number of the slot's sums in this block.
  std::uint32_t place_of(std::uint32_t slot) {
    if (place_[slot] == kNoSlot) {
      place_[slot] = static_cast<std::uint32_t>(sums_.size());
      slots_.push_back(slot);
      sums_.emplace_back();
    }
    return place_[slot];
  }
  PixelSums& sums(std::uint32_t place) { return sums_[place]; }
  /// Fills the totals of slots that no other block has filled, and keeps the sums of others for add_rest().
  void fill(std::vector<PixelSums>& totals) {
    constexpr std::size_t kAhead = 8;
    for (std::size_t i = 0; i < slots_.size(); ++i) {
      if (i + kAhead < slots_.size()) __builtin_prefetch(&totals[slots_[i + kAhead]], 1);
      if (sums_[i].pixels > 0 && !sums_[i].fill(totals[slots_[i]])) rest_.emplace_back(slots_[i], sums_[i]);
      place_[slots_[i]] = kNoSlot;
    }
  }
  /// When all blocks of a view are done.
  void add_rest(std::vector<PixelSums>& totals) {
    for (const auto& [slot, sums] : rest_) totals[slot] += sums;
    rest_.clear();
  }

 private:
  std::vector<std::uint32_t> place_;  ///< per slot, its place in sums_; kNoSlot between blocks
  std::vector<std::uint32_t> slots_;
  std::vector<PixelSums> sums_;
  std::vector<std::pair<std::uint32_t, PixelSums>> rest_;
};

double length(const CameraPoint& a) { return std::sqrt(a.x * a.x + a.y * a.y + a.z * a.z); }

/// What costs need of a face's projection.
struct FaceShape {
  InverseDepth plane;
  float area_px = 0;  ///< of the projection, unclipped by the image; 0 if a vertex lies far outside the image
  float cosine = 0;   ///< of the angle between normal and line of sight to the centroid
  float nadir = 0;    ///< how far the view looks straight down at the centroid, 0..1
};

/// True within the region that FaceCoverage::visible_share refers to. The projection of a face that ends close to the
/// camera plane grows without bound beyond it.
bool is_near(const Camera& camera, const PixelPoint& p) {
  const double w = camera.width, h = camera.height;
  return p.x >= -w && p.x <= 2 * w && p.y >= -h && p.y <= 2 * h;
}

/// Area of the projection in pixels; 0 unless all corners lie in front of the camera and near the image.
double projected_area(const Camera& camera, const CameraTriangle& p) {
  std::array<PixelPoint, 3> q;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(p[i].z > 0)) return 0;
    q[i] = pixel_from_camera(camera, p[i]);
    if (!is_near(camera, q[i])) return 0;
  }
  const auto& [a, b, c] = q;
  return std::abs((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y)) / 2;
}

CameraPoint centroid_of(const CameraTriangle& p) {
  return {(p[0].x + p[1].x + p[2].x) / 3, (p[0].y + p[1].y + p[2].y) / 3, (p[0].z + p[1].z + p[2].z) / 3};
}

/// Between normal and line of sight to the centroid.
float cos_angle(const CameraTriangle& p) {
  const CameraPoint centroid = centroid_of(p), n = area_normal(p);
  const double norm = length(n) * length(centroid);
  if (!(norm > 0)) return 0;
  return static_cast<float>(std::abs(n.x * centroid.x + n.y * centroid.y + n.z * centroid.z) / norm);
}

/// DataTerm::nadir. 0 for a view from below.
float nadir_share(const Pose& pose, const CameraTriangle& p) {
  const CameraPoint centroid = centroid_of(p), up{pose.rotation[2], pose.rotation[5], pose.rotation[8]};
  const double norm = length(centroid);
  if (!(norm > 0)) return 0;
  const double down = -(up.x * centroid.x + up.y * centroid.y + up.z * centroid.z) / norm;
  const double square = std::max(0.0, down) * down;
  return static_cast<float>(square * square * up.z * up.z);
}

FaceShape shape_of(const View& view, const CameraTriangle& p) {
  return {inverse_depth(view.camera, p), static_cast<float>(projected_area(view.camera, p)), cos_angle(p),
          nadir_share(view.pose, p)};
}

bool needs_gradient(DataTerm term) { return term == DataTerm::gmi || term == DataTerm::gmi_angle; }
bool needs_angle(DataTerm term) { return term == DataTerm::area_angle || term == DataTerm::gmi_angle; }

/// The data term: how good the view is for a face. Another term belongs here, in DataTerm and in kDataTermNames.
double quality_of(DataTerm term, const FaceShape& shape, double visible_share, const PixelSums& sums) {
  const auto pixels = static_cast<double>(sums.pixels);
  if (term == DataTerm::nadir) return static_cast<double>(shape.nadir) * visible_share;
  double quality = shape.area_px > 0 ? static_cast<double>(shape.area_px) * visible_share : pixels;
  if (needs_gradient(term)) quality *= static_cast<double>(sums.gradient) / (kGradientUnit * pixels);
  if (needs_angle(term)) {
    const auto cosine = static_cast<double>(shape.cosine);
    quality *= cosine * cosine;
  }
  return quality;
}

/// A full view alone has the whole share.
Share16 visible_share_of(double share) {
  return share >= 1 ? kWholeShare : std::clamp<Share16>(share16(share), 1, kWholeShare - 1);
}

/// True where the photo shows no surface of a face that the view would see.
bool is_beside_surface(visibility::FaceClass found) {
  using enum visibility::FaceClass;
  return found == background || found == mixed;
}

/// True where a face of this class gets a record.
bool is_candidate(visibility::FaceClass found) {
  using enum visibility::FaceClass;
  return found == full || found == partial || is_beside_surface(found);
}

}  // namespace

/// Work space of one thread.
struct ViewScratch::Block {
  StripRows rows;
  BlockSums sums;
  std::vector<std::uint32_t> photo_pixels;  ///< of the current row
};

struct ViewScratch::Buffers {
  std::vector<std::uint32_t> slot_of_face;
  std::vector<std::uint32_t> faces;     ///< by slot, ascending
  std::vector<FaceShape> shapes;        ///< by slot
  std::vector<PixelSums> sums;          ///< by slot
  std::vector<std::uint64_t> strip;     ///< the strip along silhouettes, a bit for each pixel; empty: there is none
  std::vector<std::uint16_t> gradient;  ///< by pixel of the photo; empty: not asked for
  tbb::enumerable_thread_specific<Block> blocks;
};

ViewScratch::ViewScratch() : buffers(std::make_unique<Buffers>()) {}
ViewScratch::~ViewScratch() = default;

namespace {

/// One view's pass over its IVM.
class ViewPass {
 public:
  ViewPass(const Mesh& mesh, const View& view, const Image& photo, const visibility::ViewVisibility& visibility,
           const CostOptions& options, ViewScratch::Buffers& buffers)
      : mesh_(mesh),
        view_(view),
        photo_(photo),
        visibility_(visibility),
        options_(options),
        lookup_(view.camera),
        strip_words_(options.margin_px > 0 ? (static_cast<std::size_t>(visibility.ivm.width) + 63) / 64 : 0),
        of_(buffers) {}

  std::vector<FaceRecord> run(std::span<const std::uint8_t> wanted) {
    list_faces(wanted);
    tbb::parallel_for(std::size_t{0}, of_.faces.size(), [&](std::size_t slot) {
      of_.shapes[slot] = shape_of(view_, corners(of_.faces[slot]));
      of_.sums[slot] = {};
    });
    of_.strip.resize(strip_words_ * static_cast<std::size_t>(visibility_.ivm.height));
    if (wants_gradient()) gradient_magnitude(photo_, of_.gradient);
    add_rows();
    return records();
  }

 private:
  /// Gives every wanted face that is full or partial a slot, in face order.
  void list_faces(std::span<const std::uint8_t> wanted) {
    const auto& classes = visibility_.classes;
    of_.slot_of_face.resize(classes.size());
    of_.faces.clear();
    for (std::uint32_t face = 0; face < classes.size(); ++face) {
      const bool listed = is_candidate(classes[face]) && (wanted.empty() || wanted[face] != 0);
      of_.slot_of_face[face] = listed ? static_cast<std::uint32_t>(of_.faces.size()) : kNoSlot;
      if (listed) of_.faces.push_back(face);
    }
    of_.sums.resize(of_.faces.size());
    of_.shapes.resize(of_.faces.size());
  }

  bool wants_gradient() const { return needs_gradient(options_.term); }

  CameraTriangle corners(std::size_t face) const { return camera_corners(mesh_, face, view_.pose); }

  /// Numbers are those of the block's sums, kNoSlot for faces that are not listed.
  void find_faces(BlockSums& sums, std::span<const FaceId> faces, std::span<RunFace> found) const {
    for (std::size_t i = 0; i < faces.size(); ++i) {
      found[i].number = kNoSlot;
      if (faces[i] == kNoFace) continue;
      const std::uint32_t slot = of_.slot_of_face[index(faces[i])];
      if (slot == kNoSlot) {
        if (strip_words_ > 0) found[i].plane = inverse_depth(view_.camera, corners(index(faces[i])));
      } else {
        found[i] = {of_.shapes[slot].plane, sums.place_of(slot)};
      }
    }
  }

  void add_rows() {
    const Silhouettes silhouettes(view_.camera, visibility_.ivm, options_.margin_px);
    tbb::parallel_for(tbb::blocked_range<int>(0, visibility_.ivm.height, 64), [&](const auto& range) {
      ViewScratch::Block& block = of_.blocks.local();
      block.sums.start(of_.faces.size());
      block.rows.start(silhouettes, range.begin(), range.end(),
                       [&](const auto& faces, const auto& found) { find_faces(block.sums, faces, found); });
      while (block.rows.next()) add_row(block);
      block.sums.fill(of_.sums);
    });
    for (ViewScratch::Block& block : of_.blocks) block.sums.add_rest(of_.sums);
  }

  /// Adds a row run by run: neighbouring pixels mostly show the same face.
  void add_row(ViewScratch::Block& block) const {
    const int y = block.rows.y();
    const std::span<const std::uint64_t> strip = block.rows.strip();
    std::copy(strip.begin(), strip.end(),
              of_.strip.begin() + static_cast<std::ptrdiff_t>(strip_words_ * static_cast<std::size_t>(y)));
    lookup_.find_row(y, block.photo_pixels);
    const FaceRuns& runs = block.rows.runs();
    const std::span<const RunFace> found = block.rows.found();
    for (std::size_t i = 0; i < found.size(); ++i)
      if (found[i].number != kNoSlot)
        block.sums.sums(found[i].number) += sums_of_run(block.photo_pixels, y, runs.begins[i], runs.begins[i + 1]);
  }

  PixelSums sums_of_run(const std::vector<std::uint32_t>& photo_pixels, int y, std::uint32_t begin,
                        std::uint32_t end) const {
    PixelSums sums;
    add_colors(photo_pixels, begin, end, sums);
    if (strip_words_ > 0)
      sums.margin =
          sums.pixels == end - begin ? strip_pixels(y, begin, end) : found_in_strip(photo_pixels, y, begin, end);
    if (wants_gradient())
      for (std::uint32_t x = begin; x < end; ++x)
        if (photo_pixels[x] != PhotoLookup::kNoPixel) sums.gradient += of_.gradient[photo_pixels[x]];
    return sums;
  }

  /// Adds the pixels, and their colours.
  void add_colors(const std::vector<std::uint32_t>& photo_pixels, std::uint32_t begin, std::uint32_t end,
                  PixelSums& sums) const {
    std::uint64_t red = 0, green = 0, blue = 0, squares = 0, steps = 0;
    std::uint32_t missing = 0;
    const std::uint8_t* const pixels = photo_.pixels.data();
    const auto level = [&](std::uint32_t pixel) { return brightness_of(pixels + 3 * std::size_t{pixel}); };
    std::uint32_t pixel_before = begin > 0 ? photo_pixels[begin - 1] : PhotoLookup::kNoPixel;
    std::uint32_t before = pixel_before == PhotoLookup::kNoPixel ? 0 : level(pixel_before);
    for (std::uint32_t x = begin; x < end; ++x) {
      const bool follows = pixel_before != PhotoLookup::kNoPixel;
      pixel_before = photo_pixels[x];
      if (photo_pixels[x] == PhotoLookup::kNoPixel) {
        ++missing;
        continue;
      }
      const std::uint8_t* rgb = pixels + 3 * std::size_t{photo_pixels[x]};
      red += rgb[0];
      green += rgb[1];
      blue += rgb[2];
      const std::uint32_t brightness = brightness_of(rgb);
      squares += brightness * brightness;
      if (follows) steps += square_of_step(brightness, before);
      before = brightness;
    }
    sums.pixels += end - begin - missing;
    sums.color = {red, green, blue};
    sums.squares = squares;
    sums.steps = steps;
  }

  /// Pixels begin .. end - 1 of the row that lie in the strip; few runs touch it.
  std::uint32_t strip_pixels(int y, std::uint32_t begin, std::uint32_t end) const {
    const std::uint64_t* row = of_.strip.data() + strip_words_ * static_cast<std::size_t>(y);
    std::uint32_t count = 0;
    for (std::uint32_t word = begin / 64; word <= (end - 1) / 64; ++word) {
      std::uint64_t bits = row[word];
      if (word == begin / 64) bits &= ~std::uint64_t{0} << (begin % 64);
      if (word == (end - 1) / 64) bits &= ~std::uint64_t{0} >> (63 - (end - 1) % 64);
      if (bits != 0) count += static_cast<std::uint32_t>(std::popcount(bits));
    }
    return count;
  }

  /// The same without pixels that the photo has no colour for.
  std::uint32_t found_in_strip(const std::vector<std::uint32_t>& photo_pixels, int y, std::uint32_t begin,
                               std::uint32_t end) const {
    std::uint32_t count = 0;
    for (std::uint32_t x = begin; x < end; ++x)
      count += in_strip(x, y) && photo_pixels[x] != PhotoLookup::kNoPixel ? 1 : 0;
    return count;
  }

  bool in_strip(std::uint32_t x, int y) const {
    return (of_.strip[strip_words_ * static_cast<std::size_t>(y) + x / 64] >> (x % 64) & 1U) != 0;
  }

  /// For a face that owns no pixel: the pixel that its centroid lies in, or the nearest one.
  PixelSums sums_at_centroid(const CameraTriangle& face) const {
    const visibility::Ivm& ivm = visibility_.ivm;
    const CameraPoint centroid = centroid_of(face);
    const PixelPoint at = centroid.z > 0 ? pixel_from_camera(view_.camera, centroid) : PixelPoint{};
    // Close to the camera plane, projections exceed the range of int.
    const auto pixel = [](double position, int size) {
      return static_cast<int>(std::clamp(static_cast<float>(position), 0.0F, static_cast<float>(size - 1)));
    };
    const int x = pixel(at.x, ivm.width), y = pixel(at.y, ivm.height);
    const std::optional<std::size_t> photo_pixel = lookup_.pixel(x, y);
    if (!photo_pixel) return {};
    const std::uint8_t* rgb = photo_.pixels.data() + 3 * *photo_pixel;
    const std::uint32_t brightness = brightness_of(rgb);
    const std::optional<std::size_t> before = x > 0 ? lookup_.pixel(x - 1, y) : std::nullopt;
    return {1,
            strip_words_ > 0 && in_strip(static_cast<std::uint32_t>(x), y) ? 1U : 0U,
            wants_gradient() ? of_.gradient[*photo_pixel] : std::uint64_t{0},
            {rgb[0], rgb[1], rgb[2]},
            std::uint64_t{brightness} * brightness,
            before ? square_of_step(brightness, brightness_of(photo_.pixels.data() + 3 * *before)) : std::uint64_t{0}};
  }

  std::vector<FaceRecord> records() const {
    std::vector<FaceRecord> records(of_.faces.size());
    const auto& entries = visibility_.coverage.entries;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, records.size(), 1024), [&](const auto& slots) {
      // Both lists are in face order.
      auto entry = std::ranges::lower_bound(entries, of_.faces[slots.begin()], {},
                                            [](const visibility::FaceCoverage& e) { return index(e.face); });
      for (std::size_t slot = slots.begin(); slot != slots.end(); ++slot) {
        while (entry != entries.end() && index(entry->face) < of_.faces[slot]) ++entry;
        const visibility::FaceClass of_face = visibility_.classes[of_.faces[slot]];
        if (is_beside_surface(of_face)) {
          records[slot] = {.face = of_.faces[slot],
                           .margin = of_face == visibility::FaceClass::mixed ? kWholeShare : Share16{0}};
          continue;
        }
        const bool found = entry != entries.end() && index(entry->face) == of_.faces[slot];
        const float share = found ? std::min(entry->visible_share, kMaxPartialShare) : 0.5f;
        records[slot] = record(slot, of_face == visibility::FaceClass::full ? 1.0 : static_cast<double>(share));
      }
    });
    return records;
  }

  FaceRecord record(std::size_t slot, double visible_share) const {
    const std::uint32_t face = of_.faces[slot];
    PixelSums sums = of_.sums[slot];
    if (sums.pixels == 0) sums = sums_at_centroid(corners(face));
    FaceRecord result;
    result.face = face;
    result.visible = visible_share_of(visible_share);
    if (sums.pixels == 0) return result;
    result.quality = static_cast<float>(quality_of(options_.term, of_.shapes[slot], visible_share, sums));
    if (sums.margin != 0) result.margin = share16(static_cast<double>(sums.margin) / static_cast<double>(sums.pixels));
    for (std::size_t c = 0; c < 3; ++c)
      result.color[c] = static_cast<std::uint16_t>((sums.color[c] * 256 + sums.pixels / 2) / sums.pixels);
    result.contrast = static_cast<std::uint16_t>(std::lround(256 * sums.contrast()));
    result.pixels = static_cast<std::uint16_t>(std::min<std::uint32_t>(sums.pixels, 65535));
    result.disagreement = static_cast<std::uint16_t>(std::lround(256 * sums.step()));  // FaceRecord::steps()
    return result;
  }

  /// A face is partial although every in-image sample sees it if a vertex lies outside the image.
  static constexpr float kMaxPartialShare = 65534.0f / 65535.0f;

  const Mesh& mesh_;
  const View& view_;
  const Image& photo_;
  const visibility::ViewVisibility& visibility_;
  const CostOptions& options_;
  PhotoLookup lookup_;
  std::size_t strip_words_;  ///< a row; 0: no strip
  ViewScratch::Buffers& of_;
};

}  // namespace

Share16 share16(double share) { return static_cast<Share16>(std::lround(std::clamp(share, 0.0, 1.0) * kWholeShare)); }

FaceRecord geometric_record(const Mesh& mesh, const View& view, FaceId face, double visible_share, std::size_t pixels,
                            DataTerm term) {
  const FaceShape shape = shape_of(view, camera_corners(mesh, index(face), view.pose));
  if (term == DataTerm::gmi) term = DataTerm::area;
  if (term == DataTerm::gmi_angle) term = DataTerm::area_angle;
  PixelSums sums;
  sums.pixels = static_cast<std::uint32_t>(std::min<std::size_t>(pixels, std::numeric_limits<std::uint32_t>::max()));
  FaceRecord record;
  record.face = static_cast<std::uint32_t>(index(face));
  record.visible = visible_share_of(visible_share);
  record.quality = static_cast<float>(quality_of(term, shape, visible_share, sums));
  record.pixels = static_cast<std::uint16_t>(std::min<std::size_t>(pixels, 65535));
  return record;
}

std::vector<FaceRecord> view_statistics(const Mesh& mesh, const View& view, const Image& photo,
                                        const visibility::ViewVisibility& visibility, const CostOptions& options,
                                        ViewScratch& scratch, std::span<const std::uint8_t> wanted) {
  return ViewPass(mesh, view, photo, visibility, options, *scratch.buffers).run(wanted);
}

}  // namespace gpvc::labeling
