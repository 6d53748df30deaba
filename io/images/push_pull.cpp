#include "io/push_pull.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <vector>

#include "io/images/image_file.h"

namespace gpvc::io {
namespace {

/// A picture of which only some pixels are known.
struct Level {
  Image image;
  std::vector<std::uint8_t> known;
};

template <class Row>
void for_rows(int height, bool parallel, const Row& row) {
  if (parallel)
    tbb::parallel_for(tbb::blocked_range<int>(0, height, 16), [&](const tbb::blocked_range<int>& rows) {
      for (int y = rows.begin(); y < rows.end(); ++y) row(y);
    });
  else
    for (int y = 0; y < height; ++y) row(y);
}

/// Pixels that are looked at together.
constexpr int kWord = 8;
enum class Known { none, some, all };

Known known_word(const std::uint8_t* known) {
  constexpr std::uint64_t kOnes = 0x0101010101010101;
  std::uint64_t word = 0;
  std::memcpy(&word, known, kWord);
  if (word == 0) return Known::none;
  // A byte of 0, and above it of 1, borrows from the bit above it: Warren, Hacker's Delight, section 6-1.
  return ((word - kOnes) & ~word & kOnes << 7) == 0 ? Known::all : Known::some;
}

/// Halves a picture: blocks of 2 x 2 pixels, smaller at the right and lower edge, become the mean of their known pixels,
/// rounded to nearest.
class Halver {
 public:
  Halver(const Image& image, std::span<const std::uint8_t> known) : image_(image), known_(known) {
    half_.image = black_image((image.width + 1) / 2, (image.height + 1) / 2, 3);
    half_.known.resize(half_.image.pixels.size() / 3);
  }

  Level halved(bool parallel) {
    for_rows(half_.image.height, parallel, [&](int y) { take_row(y); });
    return std::move(half_);
  }

 private:
  static constexpr int kBlocks = kWord / 2;

  void take_row(int y) {
    const int width = half_.image.width;
    for (int x = 0, end = 0; x < width; x = end) {
      const Known known = known_blocks(x, y);
      end = std::min(x + kBlocks, width);
      if (known == Known::all) {
        while (known_blocks(end, y) == Known::all) end += kBlocks;
        halve_rows(image_.at(2 * x, 2 * y), image_.at(2 * x, 2 * y + 1), end - x, half_.image.at(x, y));
        std::fill_n(&half_.known[half_at(x, y)], end - x, std::uint8_t{1});
      }
      for (int block = x; known == Known::some && block < end; ++block) take_block(block, y);
    }
  }

  /// Of so many blocks from x on; `some` where there are fewer.
  Known known_blocks(int x, int y) const {
    if (2 * (x + kBlocks) > image_.width || 2 * y + 1 >= image_.height) return Known::some;
    const Known above = known_word(&known_[at(2 * x, 2 * y)]), below = known_word(&known_[at(2 * x, 2 * y + 1)]);
    return above == below ? above : Known::some;
  }

  void take_block(int x, int y) {
    constexpr std::array<unsigned, 5> kInverse{0, 65536, 32768, 21846, 16384};  // rounded up: exact for sums up to 1022
    std::array<unsigned, 3> sum{};
    unsigned count = 0;
    for (int fine_y = 2 * y; fine_y < std::min(2 * y + 2, image_.height); ++fine_y)
      for (int fine_x = 2 * x; fine_x < std::min(2 * x + 2, image_.width); ++fine_x) {
        if (known_[at(fine_x, fine_y)] == 0) continue;
        ++count;
        for (std::size_t c = 0; c < 3; ++c) sum[c] += image_.at(fine_x, fine_y)[c];
      }
    if (count == 0) return;
    half_.known[half_at(x, y)] = 1;
    for (std::size_t c = 0; c < 3; ++c)
      half_.image.at(x, y)[c] = static_cast<std::uint8_t>((sum[c] + count / 2) * kInverse[count] / 65536);
  }

  std::size_t at(int x, int y) const { return pixel_index(x, y, image_.width); }
  std::size_t half_at(int x, int y) const { return pixel_index(x, y, half_.image.width); }

  const Image& image_;
  std::span<const std::uint8_t> known_;
  Level half_;
};

}  // namespace

void fill_holes(Image& image, std::span<const std::uint8_t> known, bool parallel) {
  const auto is_known = [](std::uint8_t value) { return value != 0; };
  if (std::ranges::all_of(known, is_known) || std::ranges::none_of(known, is_known)) return;
  Level half = Halver(image, known).halved(parallel);
  fill_holes(half.image, half.known, parallel);
  for_rows(image.height, parallel, [&](int y) {
    const std::uint8_t* known_row = &known[pixel_index(0, y, image.width)];
    for (int x = 0; x < image.width; ++x) {
      if (x % kWord == 0 && x + kWord <= image.width && known_word(known_row + x) == Known::all)
        x += kWord - 1;
      else if (known_row[x] == 0)
        std::copy_n(half.image.at(x / 2, y / 2), 3, image.at(x, y));
    }
  });
}

void fill_holes(Samples& samples, std::span<const std::uint8_t> known) {
  const auto is_known = [](std::uint8_t value) { return value != 0; };
  if (std::ranges::all_of(known, is_known) || std::ranges::none_of(known, is_known)) return;
  const std::size_t size = bytes_of(samples.type);
  Samples half{(samples.width + 1) / 2, (samples.height + 1) / 2, samples.bands, SampleType::f32, {}};
  std::vector<std::uint8_t> half_known(pixel_index(0, half.height, half.width));
  half.bytes.resize(half_known.size() * half.pixel_bytes());
  std::vector<float> sums(samples.bands);
  for (int y = 0; y < half.height; ++y)
    for (int x = 0; x < half.width; ++x) {
      std::ranges::fill(sums, 0.0f);
      float count = 0;
      for (int fine_y = 2 * y; fine_y < std::min(2 * y + 2, samples.height); ++fine_y)
        for (int fine_x = 2 * x; fine_x < std::min(2 * x + 2, samples.width); ++fine_x) {
          if (known[pixel_index(fine_x, fine_y, samples.width)] == 0) continue;
          ++count;
          const std::byte* from = samples.at(fine_x, fine_y);
          for (std::size_t band = 0; band < sums.size(); ++band)
            sums[band] += load_sample(from + band * size, samples.type);
        }
      if (count == 0) continue;
      half_known[pixel_index(x, y, half.width)] = 1;
      std::byte* to = half.at(x, y);
      for (std::size_t band = 0; band < sums.size(); ++band)
        store_sample(to + band * sizeof(float), half.type, sums[band] / count);
    }
  fill_holes(half, half_known);
  for (int y = 0; y < samples.height; ++y)
    for (int x = 0; x < samples.width; ++x) {
      if (known[pixel_index(x, y, samples.width)] != 0) continue;
      for (std::size_t band = 0; band < samples.bands; ++band)
        store_sample(samples.at(x, y) + band * size, samples.type,
                     load_sample(half.at(x / 2, y / 2) + band * sizeof(float), half.type));
    }
}

}  // namespace gpvc::io
