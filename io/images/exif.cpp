#include "io/images/exif.h"

#include <libexif/exif-data.h>

#include <cmath>
#include <memory>

#include "io/files/frees.h"

namespace gpvc::io {
namespace {

/// The first number of an entry; 0 where there is none.
double number_of(const ExifData& data, ExifTag tag) {
  const ExifEntry* entry = exif_content_get_entry(data.ifd[EXIF_IFD_EXIF], tag);
  if (entry == nullptr || entry->components == 0) return 0;
  const ExifByteOrder order = exif_data_get_byte_order(const_cast<ExifData*>(&data));
  if (entry->size < exif_format_get_size(entry->format)) return 0;
  if (entry->format == EXIF_FORMAT_RATIONAL) {
    const ExifRational ratio = exif_get_rational(entry->data, order);
    return ratio.denominator == 0 ? 0 : static_cast<double>(ratio.numerator) / ratio.denominator;
  }
  if (entry->format == EXIF_FORMAT_SHORT) return exif_get_short(entry->data, order);
  return entry->format == EXIF_FORMAT_LONG ? exif_get_long(entry->data, order) : 0;
}

}  // namespace

std::optional<float> exposure_value(double seconds, double f_number, double sensitivity) {
  const double ratio = 100 * f_number * f_number / (seconds * sensitivity);
  if (!(seconds > 0 && f_number > 0 && sensitivity > 0 && std::isfinite(ratio) && ratio > 0)) return std::nullopt;
  return static_cast<float>(std::log2(ratio));
}

std::optional<float> exposure_value(std::span<const std::uint8_t> exif) {
  const std::unique_ptr<ExifData, Frees<exif_data_unref>> data(exif_data_new());
  if (!data) return std::nullopt;
  exif_data_unset_option(data.get(), EXIF_DATA_OPTION_FOLLOW_SPECIFICATION);  // it would add entries that are not there
  exif_data_load_data(data.get(), exif.data(), static_cast<unsigned>(exif.size()));
  return exposure_value(number_of(*data, EXIF_TAG_EXPOSURE_TIME), number_of(*data, EXIF_TAG_FNUMBER),
                        number_of(*data, EXIF_TAG_ISO_SPEED_RATINGS));
}

std::string exif_data(double seconds, double f_number, std::uint32_t sensitivity) {
  std::string data("Exif\0\0", 6), tiff("II*\0", 4);  // little-endian
  const auto number = [](std::uint32_t value, int bytes) {
    std::string text;
    for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i) & 0xFF);
    return text;
  };
  const auto entry = [&](ExifTag tag, ExifFormat format, std::uint32_t value) {
    return number(tag, 2) + number(format, 2) + number(1, 4) + number(value, 4);
  };
  const auto ratio = [&](double value, std::uint32_t below) {
    return number(static_cast<std::uint32_t>(std::lround(value * below)), 4) + number(below, 4);
  };
  // A directory of one entry, which leads to that of the exposure, behind which its ratios lie.
  constexpr std::uint32_t kDirectory = 8, kSub = kDirectory + 2 + 12 + 4, kRatios = kSub + 2 + 3 * 12 + 4;
  tiff +=
      number(kDirectory, 4) + number(1, 2) + entry(EXIF_TAG_EXIF_IFD_POINTER, EXIF_FORMAT_LONG, kSub) + number(0, 4);
  tiff += number(3, 2) + entry(EXIF_TAG_EXPOSURE_TIME, EXIF_FORMAT_RATIONAL, kRatios) +
          entry(EXIF_TAG_FNUMBER, EXIF_FORMAT_RATIONAL, kRatios + 8) +
          entry(EXIF_TAG_ISO_SPEED_RATINGS, EXIF_FORMAT_SHORT, sensitivity) + number(0, 4);
  return data + tiff + ratio(seconds, 1000000) + ratio(f_number, 100);
}

}  // namespace gpvc::io
