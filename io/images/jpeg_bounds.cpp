// Checks of a JPEG's markers and tables against its bytes. Tables and figures cited are those of ITU-T T.81.
#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "io/error.h"
#include "io/images/image_bounds.h"

namespace gpvc::io {
namespace {

constexpr unsigned kHuffmanTables = 0xC4, kReserved = 0xC8, kArithmetic = 0xC9, kArithmeticTables = 0xCC;
constexpr unsigned kBaseline = 0xC0, kExtended = 0xC1, kScan = 0xDA, kEnd = 0xD9;

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

/// Checks the size in the frame header of marker 0xC0 .. 0xCF at `at`; unknown kinds of frames pass.
void check_jpeg_claim(const ImageBytes& bytes, std::uint64_t at, unsigned marker) {
  std::array<unsigned char, 6> frame{};  // bits a sample, height, width, components
  if (!bytes.read(at + 4, frame)) return;
  const int height = frame[1] << 8 | frame[2], width = frame[3] << 8 | frame[4];
  check_size(bytes.file, bytes.part, width, height, std::max<unsigned char>(frame[5], 1));
  // Every block of 8 x 8 samples takes a Huffman code of at least one bit. Components of 4 x 1 and 1 x 4 sampling have
  // the fewest blocks together, half a block for each block of pixels: 8 * 64 * 2 pixels from a byte. Arithmetic coding
  // has no such bound.
  constexpr std::uint64_t kMostFromByte = 1024;
  const std::uint64_t pixels = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
  if (marker < kArithmetic && pixels > kMostFromByte * bytes.size)
    throw InputError(bytes.file, bytes.part,
                     "claims " + std::to_string(width) + " x " + std::to_string(height) + " pixels, more than its " +
                         std::to_string(bytes.size) + " bytes can hold");
}

/// The first code of a Huffman table, which consists of zero bits alone (T.81, C.2), and its symbol.
struct ZeroCode {
  unsigned bits = 0, symbol = 0;
};

/// Finds data that was overwritten with zeros, which libjpeg may decode without a warning. Zero bits decode to the
/// first code of each table. In the AC tables of T.81, K.3, which nearly all cameras use, that is 0x01, a coefficient
/// without a run of zeros before it: a block of zero bits then has all its 63 coefficients, of the same negative value,
/// which no picture has. With tables whose first code ends the block, zeros are a flat picture, so such files are not
/// checked, nor are progressive and arithmetic coding.
class ZeroRuns {
 public:
  void frame(std::string_view header, unsigned marker) {
    components_.clear();
    if ((marker != kBaseline && marker != kExtended) || header.size() < 6) return;
    for (std::size_t at = 6; at + 2 < header.size(); at += 3)
      components_.push_back({byte(header, at), (byte(header, at + 1) >> 4) * (byte(header, at + 1) & 15u)});
  }

  void tables(std::string_view header) {
    constexpr std::size_t kLengths = 16;
    while (header.size() > kLengths + 1) {
      std::size_t symbols = 0;
      ZeroCode code;
      for (unsigned length = 1; length <= kLengths; ++length) {
        if (symbols == 0 && byte(header, length) > 0) code.bits = length;
        symbols += byte(header, length);
      }
      if (symbols == 0 || symbols > header.size() - kLengths - 1) return;
      code.symbol = byte(header, kLengths + 1);
      const unsigned place = byte(header, 0);
      if (place / 16 < 2 && place % 16 < 4) codes_[place / 16][place % 16] = code;
      header.remove_prefix(kLengths + 1 + symbols);
    }
  }

  /// Bits that a data unit of the scan takes in zeros; 0 where zeros could be picture data.
  std::size_t unit_bits(std::string_view header) const {
    if (header.empty()) return 0;
    const std::size_t count = byte(header, 0);
    if (count == 0 || header.size() < 1 + 2 * count) return 0;
    std::size_t bits = 0;
    bool impossible = false;
    for (std::size_t i = 0; i < count; ++i) {
      const auto component = std::find_if(components_.begin(), components_.end(),
                                          [&](const Component& c) { return c.id == byte(header, 1 + 2 * i); });
      const unsigned places = byte(header, 2 + 2 * i);
      if (component == components_.end() || places / 16 > 3 || places % 16 > 3) return 0;
      const ZeroCode dc = codes_[0][places / 16], ac = codes_[1][places % 16];
      if (dc.bits == 0 || ac.bits == 0 || dc.symbol > 15) return 0;
      const unsigned run = ac.symbol / 16, size = ac.symbol % 16;
      constexpr unsigned kCoefficients = 63, kEndOfBlock = 0;
      if (size == 0 && ac.symbol != kEndOfBlock) return 0;
      const std::size_t codes = size == 0 ? 1 : kCoefficients / (run + 1);
      const std::size_t block = dc.bits + dc.symbol + codes * (ac.bits + size);
      impossible = impossible || (size > 0 && run == 0);
      bits += block * (count == 1 ? 1 : component->blocks);  // a scan of one component has no units (A.2.2)
    }
    return impossible ? bits : 0;
  }

 private:
  struct Component {
    unsigned id, blocks;  ///< blocks in a data unit
  };
  static unsigned byte(std::string_view bytes, std::size_t i) { return static_cast<unsigned char>(bytes[i]); }

  std::vector<Component> components_;
  std::array<std::array<ZeroCode, 4>, 2> codes_{};  ///< DC, AC
};

/// Throws where `data`, which begins at byte `start` of the file, holds a whole data unit of zero bits.
void check_zero_runs(const ImageBytes& bytes, std::string_view data, std::size_t start, std::size_t bits) {
  // A run may begin within a unit: the code begun there takes at most 16 + 15 more bits, the rest of that unit at most
  // a unit of zeros, and the next unit is all zeros.
  const std::size_t run = (2 * bits + 32) / 8 + 1;
  for (std::size_t at = run - 1; at < data.size(); at += run) {  // a run this long covers one of these
    if (data[at] != '\0') continue;
    const std::size_t before = data.find_last_not_of('\0', at), begin = before + 1;  // npos + 1 is 0
    const std::size_t end = std::min(data.find_first_not_of('\0', at), data.size());
    // Zeros before a marker may be an encoder's padding.
    const bool padding = end == data.size() || (data[end] == '\xFF' && end + 1 < data.size() && data[end + 1] != '\0');
    if (end - begin >= run && !padding)
      bytes.fail(start + begin, "cannot be decoded whole: " + std::to_string(end - begin) +
                                    " bytes of the JPEG's picture have been overwritten with zeros");
    at = end - 1;  // what lies before has been looked at: O(size)
  }
}

/// An APP13 segment as OpenImageIO reads it: IPTC records in Photoshop's first resource.
void check_iptc(const ImageBytes& bytes, std::size_t at, std::string_view segment) {
  constexpr std::string_view kPhotoshop("Photoshop 3.0\0", 14), kIptc("8BIM\x04\x04", 6);
  if (!segment.starts_with(kPhotoshop.substr(0, 13))) return;
  const auto fail = [&] {
    bytes.fail(at,
               "the IPTC metadata in segment APP13 of the JPEG reaches beyond its end; metadata tools can "
               "remove it");
  };
  if (segment.size() < kPhotoshop.size()) fail();
  segment.remove_prefix(kPhotoshop.size());
  if (!segment.starts_with(kIptc)) return;
  segment.remove_prefix(kIptc.size());
  // An empty name, then the size, whose upper half OpenImageIO ignores.
  const auto word = [&](std::size_t i) {
    return std::size_t{static_cast<unsigned char>(segment[i])} << 8 | static_cast<unsigned char>(segment[i + 1]);
  };
  if (segment.size() < 6 || word(4) > segment.size() - 6) fail();
  segment = segment.substr(6, word(4));
  constexpr std::size_t kRecord = 5;  // a mark, record, number and size
  for (std::size_t i = 0; i < segment.size() && segment[i] == '\x1C';) {
    if (segment.size() - i < kRecord || word(i + 3) > segment.size() - i - kRecord) fail();
    i += kRecord + word(i + 3);
  }
}

}  // namespace

void check_jpeg_metadata(const std::filesystem::path& file, const std::string& part, std::string_view view) {
  if (!view.starts_with("\xFF\xD8\xFF")) return;
  const ImageBytes bytes = bytes_in_memory(file, part, view);
  constexpr unsigned kApp13 = 0xED;
  for (auto segment = next_segment(view, 2); segment; segment = next_segment(view, segment->next)) {
    if (segment->marker == kScan || segment->marker == kEnd) return;
    if (segment->marker == kApp13) check_iptc(bytes, segment->at, segment->header);
  }
}

void check_jpeg(const std::filesystem::path& file, const std::string& part, std::string_view view) {
  if (!view.starts_with("\xFF\xD8\xFF")) return;
  const ImageBytes bytes = bytes_in_memory(file, part, view);
  ZeroRuns zeros;
  std::size_t data = 0, unit_bits = 0;  // of the scan, once there is one
  for (auto segment = next_segment(view, 2); segment; segment = next_segment(view, segment->next)) {
    if (unit_bits > 0) check_zero_runs(bytes, view.substr(data, segment->at - data), data, unit_bits);
    unit_bits = 0;
    if (segment->marker == kEnd) return;
    if (is_frame(segment->marker)) check_jpeg_claim(bytes, segment->at, segment->marker);
    if (segment->next >= view.size()) break;
    if (is_frame(segment->marker)) zeros.frame(segment->header, segment->marker);
    if (segment->marker == kHuffmanTables) zeros.tables(segment->header);
    if (segment->marker == kScan) {
      unit_bits = zeros.unit_bits(segment->header);
      data = segment->next;
    }
  }
  bytes.fail(view.size(), "cannot be decoded whole: the JPEG ends too early");
}

}  // namespace gpvc::io
