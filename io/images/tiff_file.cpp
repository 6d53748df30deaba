// TIFF by libtiff. What it is asked for here are photos as cameras and mapping programs write them: grey or RGB, further samples, whole
// numbers of 8 or 16 bits or floats of 32 or 64, strips or tiles, planes together or apart, in every coding that libtiff knows. Other
// files, of palettes or inks or sensors' samples for example, are left to other_formats.h.
#include <tiffio.h>

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "io/bands/band_tags.h"
#include "io/file_bytes.h"
#include "io/files/frees.h"
#include "io/files/text_scan.h"
#include "io/images/codec.h"
#include "io/images/image_file.h"

namespace gpvc::io {
namespace {

/// The bytes of a file as libtiff reads them, in memory or in parts, and the first thing that it complains of.
class Source {
 public:
  explicit Source(std::string_view bytes) : bytes_(bytes) {}
  explicit Source(const FileParts& parts) : parts_(&parts) {}
  const std::string& complaint() const { return complaint_; }

  static tmsize_t read(thandle_t handle, void* to, tmsize_t count) {
    Source& self = of(handle);
    if (self.parts_ != nullptr) {
      const auto read = self.parts_->read(self.at_, {static_cast<char*>(to), static_cast<std::size_t>(count)});
      if (!read) return -1;
      self.at_ += *read;
      return static_cast<tmsize_t>(*read);
    }
    const std::size_t left = self.bytes_.size() - std::min<std::size_t>(self.at_, self.bytes_.size());
    const std::size_t taken = std::min(static_cast<std::size_t>(count), left);
    if (taken > 0) std::memcpy(to, self.bytes_.data() + self.at_, taken);
    self.at_ += taken;
    return static_cast<tmsize_t>(taken);
  }
  static tmsize_t write(thandle_t, void*, tmsize_t) { return 0; }
  static toff_t seek(thandle_t handle, toff_t offset, int whence) {
    Source& self = of(handle);
    self.at_ = offset + (whence == SEEK_CUR ? self.at_ : whence == SEEK_END ? size(handle) : 0);
    return self.at_;
  }
  static int close(thandle_t) { return 0; }
  static toff_t size(thandle_t handle) {
    const Source& self = of(handle);
    return self.parts_ != nullptr ? self.parts_->size() : self.bytes_.size();
  }
  static int map(thandle_t handle, void** base, toff_t* bytes) {
    if (of(handle).parts_ != nullptr) return 0;
    *base = const_cast<char*>(of(handle).bytes_.data());
    *bytes = of(handle).bytes_.size();
    return 1;
  }
  static void unmap(thandle_t, void*, toff_t) {}

  static int note(TIFF*, void* user, const char*, const char* format, va_list arguments) {
    Source& self = *static_cast<Source*>(user);
    char text[400];
    std::vsnprintf(text, sizeof text, format, arguments);
    if (self.complaint_.empty()) self.complaint_ = text;
    return 1;
  }
  static int ignore(TIFF*, void*, const char*, const char*, va_list) { return 1; }

 private:
  static Source& of(thandle_t handle) { return *static_cast<Source*>(handle); }
  std::string_view bytes_;
  const FileParts* parts_ = nullptr;  ///< instead of these
  std::uint64_t at_ = 0;
  std::string complaint_;
};

using Tiff = std::unique_ptr<TIFF, Frees<TIFFClose>>;

Tiff open(Source& source) {
  const std::unique_ptr<TIFFOpenOptions, Frees<TIFFOpenOptionsFree>> options(TIFFOpenOptionsAlloc());
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), Source::note, &source);
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), Source::ignore, &source);
  return Tiff(TIFFClientOpenExt("photo", "r", &source, Source::read, Source::write, Source::seek, Source::close,
                                Source::size, Source::map, Source::unmap, options.get()));
}

/// What a file of ours says of its samples.
struct Layout {
  std::uint32_t width = 0, height = 0;
  std::uint16_t channels = 1, bits = 1, format = SAMPLEFORMAT_UINT, photometric = 0, coding = COMPRESSION_NONE,
                planes = PLANARCONFIG_CONTIG;
  std::vector<std::uint16_t> extra;  ///< what samples beyond grey or RGB mean
  bool is_tiled = false;

  std::size_t sample_bytes() const { return bits / 8u; }
  std::uint16_t colors() const { return photometric == PHOTOMETRIC_MINISBLACK ? 1 : 3; }
};

Layout layout_of(TIFF& tiff) {
  Layout l;
  TIFFGetField(&tiff, TIFFTAG_IMAGEWIDTH, &l.width);
  TIFFGetField(&tiff, TIFFTAG_IMAGELENGTH, &l.height);
  TIFFGetFieldDefaulted(&tiff, TIFFTAG_SAMPLESPERPIXEL, &l.channels);
  TIFFGetFieldDefaulted(&tiff, TIFFTAG_BITSPERSAMPLE, &l.bits);
  TIFFGetFieldDefaulted(&tiff, TIFFTAG_SAMPLEFORMAT, &l.format);
  TIFFGetFieldDefaulted(&tiff, TIFFTAG_COMPRESSION, &l.coding);
  TIFFGetFieldDefaulted(&tiff, TIFFTAG_PLANARCONFIG, &l.planes);
  if (TIFFGetField(&tiff, TIFFTAG_PHOTOMETRIC, &l.photometric) == 0)
    l.photometric = std::numeric_limits<std::uint16_t>::max();
  std::uint16_t count = 0;
  const std::uint16_t* meanings = nullptr;
  if (TIFFGetField(&tiff, TIFFTAG_EXTRASAMPLES, &count, &meanings) != 0) l.extra.assign(meanings, meanings + count);
  l.is_tiled = TIFFIsTiled(&tiff) != 0;
  return l;
}

/// A digital negative: its first picture is a small one, and the photo lies elsewhere in the file.
bool is_dng(TIFF& tiff) {
  const std::uint8_t* version = nullptr;
  return TIFFGetField(&tiff, TIFFTAG_DNGVERSION, &version) != 0;
}

/// JPEG data in YCbCr come as RGB.
bool is_jpeg_in_ycbcr(const Layout& l) {
  return l.coding == COMPRESSION_JPEG && l.photometric == PHOTOMETRIC_YCBCR && l.bits == 8 && l.channels == 3;
}

bool is_ours(TIFF& tiff, const Layout& l) {
  const bool whole = l.format == SAMPLEFORMAT_UINT && (l.bits == 8 || l.bits == 16);
  const bool real = l.format == SAMPLEFORMAT_IEEEFP && (l.bits == 32 || l.bits == 64);
  if (!(whole || real) || TIFFIsCODECConfigured(l.coding) == 0 || is_dng(tiff)) return false;
  if (is_jpeg_in_ycbcr(l)) return true;
  if (l.photometric != PHOTOMETRIC_MINISBLACK && l.photometric != PHOTOMETRIC_RGB) return false;
  return l.channels >= l.colors() + l.extra.size();
}

/// The place of the alpha among the channels; -1: none. Files that do not say what their samples mean are taken to have one where
/// they have one more than colours, as OpenImageIO takes them.
int alpha_of(const Layout& l) {
  for (std::size_t i = 0; i < l.extra.size(); ++i)
    if (l.extra[i] == EXTRASAMPLE_ASSOCALPHA || l.extra[i] == EXTRASAMPLE_UNASSALPHA)
      return l.colors() + static_cast<int>(i);
  return l.extra.empty() && l.channels == l.colors() + 1 ? l.colors() : -1;
}

/// A text that GDAL or a camera has put into the file; libtiff knows no such tag.
std::string text_of(TIFF& tiff, std::uint32_t tag) {
  std::uint32_t count = 0;
  const char* text = nullptr;
  if (TIFFGetField(&tiff, tag, &count, &text) == 0 || text == nullptr) return {};
  return std::string(text, std::find(text, text + count, '\0'));
}

/// https://gdal.org/drivers/raster/gtiff.html, and XMP's.
void read_band_tags(TIFF& tiff, OtherHeader& header) {
  constexpr std::uint32_t kXmp = 700, kMetadata = 42112, kNodata = 42113;
  header.bands =
      bands_of_tags(text_of(tiff, kMetadata), text_of(tiff, kXmp), static_cast<std::size_t>(header.channels));
  header.nodata = number_from(trimmed(text_of(tiff, kNodata)));
}

/// Goes on to the mask of the first picture, as GDAL writes it
/// (https://gdal.org/drivers/raster/gtiff.html#internal-nodata-masks); false: there is none.
bool go_to_mask(TIFF& tiff, std::uint32_t width, std::uint32_t height) {
  constexpr int kMost = 100;  // pictures, smaller ones and their masks among them
  for (int n = 0; n < kMost && TIFFReadDirectory(&tiff) != 0; ++n) {
    std::uint32_t kind = 0;
    TIFFGetFieldDefaulted(&tiff, TIFFTAG_SUBFILETYPE, &kind);
    const Layout l = layout_of(tiff);
    if ((kind & FILETYPE_MASK) != 0 && l.width == width && l.height == height && l.channels == 1 &&
        (l.bits == 1 || l.bits == 8))
      return true;
  }
  return false;
}

bool is_named_tiff(const std::filesystem::path& file) {
  const std::string extension = lower_case(file.extension().string());
  return extension == ".tif" || extension == ".tiff";
}

/// Null for a file that is left to others.
Tiff open_ours(const std::filesystem::path& file, Source& source, Layout& layout) {
  if (!is_named_tiff(file)) return nullptr;
  Tiff tiff = open(source);
  if (!tiff) return nullptr;
  layout = layout_of(*tiff);
  return is_ours(*tiff, layout) ? std::move(tiff) : nullptr;
}

Tiff open_ours(const ImageBytes& image, Source& source, Layout& layout) {
  return image.part.empty() ? open_ours(image.file, source, layout) : nullptr;
}

double exif_number(TIFF& tiff, std::uint32_t tag) {
  const TIFFField* field = TIFFFieldWithTag(&tiff, tag);
  if (field == nullptr) return 0;
  double value = 0;
  if (TIFFFieldSetGetSize(field) == sizeof value) return TIFFGetField(&tiff, tag, &value) != 0 ? value : 0;
  float single = 0;
  return TIFFGetField(&tiff, tag, &single) != 0 ? static_cast<double>(single) : 0;
}

/// After all else: the file stands at another directory then.
void read_exif(TIFF& tiff, OtherHeader& header) {
  toff_t place = 0;
  if (TIFFGetField(&tiff, TIFFTAG_EXIFIFD, &place) == 0 || TIFFReadEXIFDirectory(&tiff, place) == 0) return;
  header.exposure_seconds = exif_number(tiff, EXIFTAG_EXPOSURETIME);
  header.f_number = exif_number(tiff, EXIFTAG_FNUMBER);
  std::uint16_t count = 0;
  const std::uint16_t* speeds = nullptr;
  if (TIFFGetField(&tiff, EXIFTAG_ISOSPEEDRATINGS, &count, &speeds) != 0 && count > 0) header.sensitivity = speeds[0];
}

/// Writes one sample, of any depth, in the form that is asked for.
class Store {
 public:
  Store(const Layout& layout, const SampleRoom& room) : layout_(layout), room_(room) {}

  /// `count` pixels from (x, y) on. \param from their first sample \param stride bytes from pixel to pixel \param channel that of
  /// the first sample \param channels how many follow it in each pixel
  void row(std::uint32_t x, std::uint32_t y, std::uint32_t count, const std::byte* from, std::size_t stride,
           std::size_t channel, std::size_t channels) const {
    const auto wanted = static_cast<std::size_t>(room_.channels);
    if (channel >= wanted) return;
    const std::size_t each = std::min(channels, wanted - channel);
    std::size_t to = (std::size_t{y} * static_cast<std::size_t>(room_.width) + x) * wanted + channel;
    for (std::uint32_t i = 0; i < count; ++i, to += wanted, from += stride)
      for (std::size_t c = 0; c < each; ++c) put(to + c, from + c * layout_.sample_bytes());
  }

 private:
  void put(std::size_t at, const std::byte* from) const {
    if (layout_.bits == 8) {
      const auto value = static_cast<std::uint8_t>(*from);
      if (room_.form == SampleForm::reals)
        reals()[at] = static_cast<float>(value) / 255;
      else
        bytes()[at] = value;
    } else if (layout_.bits == 16) {
      std::uint16_t value = 0;
      std::memcpy(&value, from, sizeof value);
      if (room_.form == SampleForm::stored)
        std::memcpy(bytes() + at * sizeof value, &value, sizeof value);
      else if (room_.form == SampleForm::reals)
        reals()[at] = static_cast<float>(value) / 65535;
      else
        bytes()[at] = static_cast<std::uint8_t>((value + 128u) / 257u);  // to the nearest
    } else {
      const float value = real(from);
      if (room_.form != SampleForm::bytes)
        reals()[at] = value;
      else
        bytes()[at] =
            std::isnan(value) ? std::uint8_t{0} : static_cast<std::uint8_t>(std::clamp(value, 0.0f, 1.0f) * 255 + 0.5f);
    }
  }
  float real(const std::byte* from) const {
    float single = 0;
    double value = 0;
    if (layout_.bits == 32) {
      std::memcpy(&single, from, sizeof single);
      return single;
    }
    std::memcpy(&value, from, sizeof value);
    return static_cast<float>(value);
  }
  std::uint8_t* bytes() const { return static_cast<std::uint8_t*>(room_.samples); }
  float* reals() const { return static_cast<float*>(room_.samples); }

  const Layout& layout_;
  const SampleRoom& room_;
};

/// Looks for damage of strips that libtiff takes, before it decodes them.
class StripCheck {
 public:
  StripCheck(TIFF& tiff, const Layout& l, std::size_t file_bytes)
      : tiff_(tiff), is_tiled_(l.is_tiled), file_bytes_(file_bytes) {
    std::uint16_t order = FILLORDER_MSB2LSB;
    TIFFGetFieldDefaulted(&tiff, TIFFTAG_FILLORDER, &order);
    checks_ = order == FILLORDER_MSB2LSB && (l.coding == COMPRESSION_ADOBE_DEFLATE || l.coding == COMPRESSION_DEFLATE);
  }
  /// Throws InputError, which names `file`.
  void look(const std::filesystem::path& file, std::uint32_t number) {
    if (!checks_) return;
    const std::uint64_t count = TIFFGetStrileByteCount(&tiff_, number);
    if (count > file_bytes_) return;  // libtiff finds it missing
    bytes_.resize(count);
    const auto size = static_cast<tmsize_t>(bytes_.size());
    const tmsize_t read = is_tiled_ ? TIFFReadRawTile(&tiff_, number, bytes_.data(), size)
                                    : TIFFReadRawStrip(&tiff_, number, bytes_.data(), size);
    if (read != size) return;
    if (const std::string damage = deflate_damage({bytes_.data(), bytes_.size()}); !damage.empty())
      refuse_damage(file, TIFFGetStrileOffset(&tiff_, number), damage);
  }

 private:
  TIFF& tiff_;
  bool is_tiled_, checks_ = false;
  std::size_t file_bytes_;
  std::vector<char> bytes_;
};

/// True if the file's bytes of a strip are what the room holds.
bool fits_as_it_is(const Layout& l, const SampleRoom& room) {
  const bool as_stored =
      (room.form == SampleForm::stored && l.bits <= 32) || (room.form == SampleForm::bytes && l.bits == 8);
  return as_stored && (l.planes == PLANARCONFIG_CONTIG || l.channels == 1) && room.channels == l.channels;
}

/// \param check what is called with the number of each strip first
template <typename Check>
bool read_strips(TIFF& tiff, const Layout& l, const SampleRoom& room, const Check& check) {
  std::uint32_t rows = 0;
  TIFFGetFieldDefaulted(&tiff, TIFFTAG_ROWSPERSTRIP, &rows);
  rows = std::clamp<std::uint32_t>(rows, 1, l.height);
  const bool apart = l.planes == PLANARCONFIG_SEPARATE;
  const std::size_t together = apart ? 1 : l.channels, stride = together * l.sample_bytes(),
                    row_bytes = stride * l.width;
  const Store store(l, room);
  std::vector<std::byte> strip(fits_as_it_is(l, room) ? 0 : row_bytes * rows);
  for (std::size_t plane = 0; plane < (apart ? std::size_t{l.channels} : 1); ++plane) {
    if (plane >= static_cast<std::size_t>(room.channels)) break;
    for (std::uint32_t y = 0; y < l.height; y += rows) {
      const std::uint32_t count = std::min(rows, l.height - y);
      const std::uint32_t number = TIFFComputeStrip(&tiff, y, static_cast<std::uint16_t>(plane));
      const std::size_t bytes = row_bytes * count;
      check(number);
      void* to = strip.empty() ? static_cast<std::byte*>(room.samples) + row_bytes * y : strip.data();
      if (TIFFReadEncodedStrip(&tiff, number, to, static_cast<tmsize_t>(bytes)) != static_cast<tmsize_t>(bytes))
        return false;
      for (std::uint32_t i = 0; i < count && !strip.empty(); ++i)
        store.row(0, y + i, l.width, strip.data() + row_bytes * i, stride, plane, together);
    }
  }
  return true;
}

template <typename Check>
bool read_tiles(TIFF& tiff, const Layout& l, const SampleRoom& room, const Check& check) {
  std::uint32_t width = 0, height = 0;
  TIFFGetField(&tiff, TIFFTAG_TILEWIDTH, &width);
  TIFFGetField(&tiff, TIFFTAG_TILELENGTH, &height);
  const bool apart = l.planes == PLANARCONFIG_SEPARATE;
  const std::size_t together = apart ? 1 : l.channels, stride = together * l.sample_bytes(), row_bytes = stride * width;
  // A tile may reach beyond the picture; one much larger than it is no picture's.
  constexpr std::size_t kMostBytes = std::size_t{1} << 31;
  if (width == 0 || height == 0 || row_bytes > kMostBytes / height) return false;
  const Store store(l, room);
  std::vector<std::byte> tile(row_bytes * height);
  for (std::size_t plane = 0; plane < (apart ? std::size_t{l.channels} : 1); ++plane) {
    if (plane >= static_cast<std::size_t>(room.channels)) break;
    for (std::uint32_t y = 0; y < l.height; y += height)
      for (std::uint32_t x = 0; x < l.width; x += width) {
        const std::uint32_t number = TIFFComputeTile(&tiff, x, y, 0, static_cast<std::uint16_t>(plane));
        check(number);
        if (TIFFReadEncodedTile(&tiff, number, tile.data(), static_cast<tmsize_t>(tile.size())) !=
            static_cast<tmsize_t>(tile.size()))
          return false;
        for (std::uint32_t i = 0; i < std::min(height, l.height - y); ++i)
          store.row(x, y + i, std::min(width, l.width - x), tile.data() + row_bytes * i, stride, plane, together);
      }
  }
  return true;
}

/// Excludes the pixels of a mask that are 0. \pre one channel of 1 or 8 bits
bool read_mask(TIFF& tiff, const Layout& l, PhotoExclusion& masked) {
  std::uint32_t width = l.width, height = 0;
  if (l.is_tiled) {
    TIFFGetField(&tiff, TIFFTAG_TILEWIDTH, &width);
    TIFFGetField(&tiff, TIFFTAG_TILELENGTH, &height);
  } else {
    TIFFGetFieldDefaulted(&tiff, TIFFTAG_ROWSPERSTRIP, &height);
    height = std::min(height, l.height);
  }
  const std::size_t row_bytes = l.bits == 8 ? width : (std::size_t{width} + 7) / 8;
  constexpr std::size_t kMostBytes = std::size_t{1} << 31;
  if (width == 0 || height == 0 || row_bytes > kMostBytes / height) return false;
  std::vector<std::uint8_t> part(row_bytes * height);
  const auto is_zero = [&](std::uint32_t x, std::uint32_t y) {
    const std::uint8_t* row = part.data() + row_bytes * y;
    return l.bits == 8 ? row[x] == 0 : (row[x / 8] & (0x80 >> x % 8)) == 0;
  };
  for (std::uint32_t top = 0; top < l.height; top += height)
    for (std::uint32_t left = 0; left < l.width; left += width) {
      const std::uint32_t rows = std::min(height, l.height - top), columns = std::min(width, l.width - left);
      const auto bytes = static_cast<tmsize_t>(row_bytes * (l.is_tiled ? height : rows));
      const tmsize_t read =
          l.is_tiled ? TIFFReadEncodedTile(&tiff, TIFFComputeTile(&tiff, left, top, 0, 0), part.data(), bytes)
                     : TIFFReadEncodedStrip(&tiff, TIFFComputeStrip(&tiff, top, 0), part.data(), bytes);
      if (read != bytes) return false;
      for (std::uint32_t y = 0; y < rows; ++y)
        for (std::uint32_t x = 0; x < columns; ++x)
          if (is_zero(x, y)) exclude(masked, std::size_t{left} + x, std::size_t{top} + y);
    }
  return true;
}

}  // namespace

bool read_tiff_header(const ImageBytes& image, OtherHeader& header) {
  Source source(image.view);
  Layout l;
  const Tiff tiff = open_ours(image, source, l);
  // Other readers would take a complex number for one or two of another kind.
  const bool is_complex = l.format == SAMPLEFORMAT_COMPLEXINT || l.format == SAMPLEFORMAT_COMPLEXIEEEFP;
  if (!tiff && !is_complex) return false;
  header.format = "tiff";
  header.width = static_cast<int>(std::min<std::uint32_t>(l.width, std::numeric_limits<int>::max()));
  header.height = static_cast<int>(std::min<std::uint32_t>(l.height, std::numeric_limits<int>::max()));
  header.channels = l.channels;
  if (is_complex) {
    header.type_name = "complex numbers";
    return true;
  }
  header.bits = l.format == SAMPLEFORMAT_IEEEFP ? 0 : l.bits;
  header.alpha_channel = alpha_of(l);
  header.type = l.format == SAMPLEFORMAT_IEEEFP ? SampleType::f32 : l.bits == 16 ? SampleType::u16 : SampleType::u8;
  header.colors = l.colors() == 3 || l.channels == 1 || (l.channels == 2 && header.alpha_channel >= 0);
  read_band_tags(*tiff, header);
  if (header.alpha_channel >= 0 && !header.bands.empty() &&
      names_band(header.bands[static_cast<std::size_t>(header.alpha_channel)]))
    header.alpha_channel = -1;
  std::uint32_t count = 0;
  const std::uint8_t* profile = nullptr;
  if (TIFFGetField(tiff.get(), TIFFTAG_ICCPROFILE, &count, &profile) != 0)
    header.profile.assign(profile, profile + count);
  header.has_mask = go_to_mask(*tiff, l.width, l.height);
  TIFFSetDirectory(tiff.get(), 0);
  read_exif(*tiff, header);
  return true;
}

std::string decode_tiff_mask(const ImageBytes& image, PhotoExclusion& masked) {
  Source source(image.view);
  Layout l;
  const Tiff tiff = open_ours(image, source, l);
  if (!tiff || l.width != static_cast<std::uint32_t>(masked.width) ||
      l.height != static_cast<std::uint32_t>(masked.height) || !go_to_mask(*tiff, l.width, l.height))
    return "it changes while it is read";
  if (!read_mask(*tiff, layout_of(*tiff), masked) || !source.complaint().empty())
    return source.complaint().empty() ? "it ends too early" : source.complaint();
  return {};
}

namespace {

/// What is wrong, or nothing.
template <typename Check>
std::string decode(TIFF& tiff, const Layout& l, const SampleRoom& room, const Source& source, const Check& check) {
  if (l.width != static_cast<std::uint32_t>(room.width) || l.height != static_cast<std::uint32_t>(room.height) ||
      l.channels < room.channels)
    return "it changes while it is read";
  if (is_jpeg_in_ycbcr(l)) TIFFSetField(&tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
  const bool whole = l.is_tiled ? read_tiles(tiff, l, room, check) : read_strips(tiff, l, room, check);
  if (whole && source.complaint().empty()) return {};
  return source.complaint().empty() ? "it ends too early" : source.complaint();
}

}  // namespace

bool decode_tiff(const ImageBytes& image, const SampleRoom& room, std::string& wrong) {
  Source source(image.view);
  Layout l;
  const Tiff tiff = open_ours(image, source, l);
  if (!tiff) return false;
  wrong = decode(*tiff, l, room, source, [](std::uint32_t) {});
  return true;
}

bool decode_tiff_in_parts(const std::filesystem::path& file, const SampleRoom& room, std::string& wrong) {
  if (!is_named_tiff(file)) return false;
  const FileParts parts(file);
  Source source(parts);
  Layout l;
  const Tiff tiff = open_ours(file, source, l);
  if (!tiff || l.coding == COMPRESSION_JPEG) return false;
  StripCheck check(*tiff, l, parts.size());
  wrong = decode(*tiff, l, room, source, [&](std::uint32_t number) { check.look(file, number); });
  return true;
}

}  // namespace gpvc::io
