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

}  // namespace gpvc::io
