// Checks of a JPEG's markers and tables against its bytes. Tables and figures cited are those of ITU-T T.81.
#include <algorithm>
#include <array>
#include <optional>

#include "io/error.h"
#include "io/images/image_bounds.h"

namespace gpvc::io {
namespace {

constexpr unsigned kHuffmanTables = 0xC4, kReserved = 0xC8, kArithmetic = 0xC9, kArithmeticTables = 0xCC;
constexpr unsigned kBaseline = 0xC0, kExtended = 0xC1, kScan = 0xDA, kEnd = 0xD9;

/// Bytes of zeros that no scan holds in which zero bits are coefficients. There they are codes of at most kMostCode bits
/// with at most kMostBits more, 63 to a block, behind a DC code of at most 16 + 15 bits: 31 + 63 * 7 = 472 bits a block.
/// Other blocks end at once, behind at most 31 + 16 bits, and a data unit has at most 10 blocks (T.81, B.2.3). A run may
/// begin within a code, of which up to 31 bits are left, and a block: then 31 + 472 + 9 * 47 + 472 bits suffice for a
/// whole block of coefficients.
constexpr std::size_t kDamage = 175, kMostCode = 4, kMostBits = 3;

bool is_frame(unsigned marker) {
  return marker >= 0xC0 && marker <= 0xCF && marker != kHuffmanTables && marker != kReserved &&
         marker != kArithmeticTables;
}

struct Segment {
  unsigned marker = 0;
  std::size_t at = 0;       ///< of the marker
  std::string_view header;  ///< behind marker and length, as far as there are bytes
  std::size_t next = 0;     ///< where it ends; no less than the file's size where that cuts it
};

/// The first marker at `at` or later, with its segment; nullopt when there is none. Entropy-coded data and stray bytes
/// lie between markers. A marker is 0xFF followed by anything but 0x00 (a data byte), 0xFF (fill), a restart D0 .. D7,
/// the start D8 or 01. Every marker but the end of the image is followed by its length.
std::optional<Segment> next_segment(std::string_view view, std::size_t at) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(view[i]); };
  while ((at = view.find('\xFF', at)) != std::string_view::npos && at + 1 < view.size()) {
    const unsigned marker = byte(at + 1);
    if (marker == 0xFF) {
      ++at;
    } else if (marker <= 1 || (marker >= 0xD0 && marker <= 0xD8)) {
      at += 2;
    } else if (marker == kEnd || at + 3 >= view.size()) {
      return Segment{marker, at, {}, view.size()};
    } else {
      const std::size_t length = std::size_t{byte(at + 2)} << 8 | byte(at + 3);
      return Segment{marker, at, length > 2 ? view.substr(at + 4, length - 2) : std::string_view(), at + 2 + length};
    }
  }
  return std::nullopt;
}

/// Checks the size in a frame header; unknown kinds of frames pass.
void check_jpeg_claim(const ImageBytes& image, const Segment& frame) {
  if (frame.header.size() < 6) return;
  const auto field = [&](std::size_t at, std::size_t count) { return image.big_endian(frame.at + 4 + at, count); };
  const std::int64_t height = field(1, 2), width = field(3, 2);  // behind the bits a sample, before the components
  check_size(image.file, image.part, width, height, std::max<std::int64_t>(field(5, 1), 1));
  // Every block of 8 x 8 samples takes a Huffman code of at least one bit. Components of 4 x 1 and 1 x 4 sampling have
  // the fewest blocks together, half a block for each block of pixels: 8 * 64 * 2 pixels from a byte. Arithmetic coding
  // has no such bound.
  constexpr std::size_t kMostFromByte = 1024;
  const bool huffman = frame.marker < kArithmetic;
  if (huffman && static_cast<std::size_t>(width * height) > kMostFromByte * image.view.size())
    refuse_claim(image.file, image.part, width, height, image.view.size());
}

// Data that was overwritten with zeros, which libjpeg may decode without a warning. Zero bits decode to the first code
// of each Huffman table (T.81, C.2). In the AC tables of T.81, K.3, which nearly all cameras use, that is 0x01 for
// luminance, a coefficient of one bit without a run of zeros before it: a block of zero bits then has all its 63
// coefficients, of the same negative value, which no picture has. For chrominance it ends the block. With tables whose
// first code ends the block throughout, zeros are a flat picture, so such scans are not checked, nor are scans with
// other tables, progressive and arithmetic coding.

/// What zero bits are under an AC table: the end of a block, or coefficients without end, or neither for certain.
enum class ZeroBits { unknown, end_of_block, coefficients };
using ZeroBitsOfTables = std::array<ZeroBits, 4>;

void read_tables(std::string_view header, ZeroBitsOfTables& ac) {
  constexpr std::size_t kLengths = 16;  // codes of each length of 1 to 16 bits, behind the table's class and number
  while (header.size() > kLengths + 1) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(header[i]); };
    std::size_t symbols = 0, first_bits = 0;
    for (std::size_t length = 1; length <= kLengths; ++length) {
      if (symbols == 0) first_bits = length;
      symbols += byte(length);
    }
    if (symbols == 0 || symbols > header.size() - kLengths - 1) return;
    const unsigned table = byte(0), symbol = byte(kLengths + 1);  // a symbol: 16 * run + bits of the coefficient
    if (table / 16 == 1 && table % 16 < ac.size())
      ac[table % 16] = symbol == 0                                      ? ZeroBits::end_of_block
                       : symbol <= kMostBits && first_bits <= kMostCode ? ZeroBits::coefficients
                                                                        : ZeroBits::unknown;
    header.remove_prefix(kLengths + 1 + symbols);
  }
}

/// True if a scan of sequential Huffman coding cannot hold kDamage bytes of zeros.
bool refutes_zeros(std::string_view header, const ZeroBitsOfTables& ac) {
  const std::size_t components = header.empty() ? 0 : static_cast<unsigned char>(header[0]);
  if (header.size() < 1 + 2 * components) return false;
  bool refuted = false;
  for (std::size_t i = 0; i < components; ++i) {
    const unsigned table = static_cast<unsigned char>(header[2 + 2 * i]) % 16;
    if (table >= ac.size() || ac[table] == ZeroBits::unknown) return false;
    refuted = refuted || ac[table] == ZeroBits::coefficients;
  }
  return refuted;
}

/// Throws where `data`, which begins at byte `start` of the file, holds kDamage bytes of zeros.
void check_zero_runs(const ImageBytes& image, std::string_view data, std::size_t start) {
  for (std::size_t at = kDamage - 1; at < data.size(); at += kDamage) {  // a run this long covers one of these
    if (data[at] != '\0') continue;
    const std::size_t begin = data.find_last_not_of('\0', at) + 1;  // npos + 1 is 0
    const std::size_t end = std::min(data.find_first_not_of('\0', at), data.size());
    // Zeros before a marker may be an encoder's padding.
    const bool padding = end == data.size() || (data[end] == '\xFF' && end + 1 < data.size() && data[end + 1] != '\0');
    if (end - begin >= kDamage && !padding)
      image.fail(start + begin, "cannot be decoded whole: " + std::to_string(end - begin) +
                                    " bytes of the JPEG's picture have been overwritten with zeros");
    at = end - 1;  // what lies before has been looked at: O(size)
  }
}

}  // namespace

void check_jpeg(const ImageBytes& image) {
  if (!image.is_jpeg()) return;
  ZeroBitsOfTables ac{};
  bool sequential = false, refuted = false;
  std::size_t data = 0;  // of the scan, once there is one
  for (auto segment = next_segment(image.view, 2); segment; segment = next_segment(image.view, segment->next)) {
    if (refuted) check_zero_runs(image, image.view.substr(data, segment->at - data), data);
    refuted = false;
    if (segment->marker == kEnd) return;
    if (is_frame(segment->marker)) {
      check_jpeg_claim(image, *segment);
      sequential = segment->marker == kBaseline || segment->marker == kExtended;
    }
    if (segment->next >= image.view.size()) break;
    if (segment->marker == kHuffmanTables) read_tables(segment->header, ac);
    if (segment->marker == kScan) {
      refuted = sequential && refutes_zeros(segment->header, ac);
      data = segment->next;
    }
  }
  image.fail(image.view.size(), "cannot be decoded whole: the JPEG ends too early");
}

}  // namespace gpvc::io
