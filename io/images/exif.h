// What a camera's EXIF data say of a photo's exposure. https://www.cipa.jp/std/documents/e/DC-008-2012_E.pdf
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace gpvc::io {

/// The exposure value at ISO 100, log2(100 N^2 / (t S)); nullopt where a number is not positive. \param seconds t
/// \param f_number N \param sensitivity S, as an ISO speed
std::optional<float> exposure_value(double seconds, double f_number, double sensitivity);

/// That of EXIF data, "Exif\0\0" at their beginning; nullopt where they do not say it.
std::optional<float> exposure_value(std::span<const std::uint8_t> exif);

/// EXIF data that say so, "Exif\0\0" at their beginning: times and f-numbers in millionths and hundredths.
std::string exif_data(double seconds, double f_number, std::uint32_t sensitivity);

}  // namespace gpvc::io
