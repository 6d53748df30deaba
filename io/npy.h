// NumPy's .npy: version 1.0, little endian, C order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "error.h"

namespace gpvc::io {

template <typename T>
struct NpyArray {
  std::vector<std::size_t> shape;
  std::vector<T> values;
};

/// Reads an array of exactly this type, for T = uint8_t, int32_t, uint32_t, float, double. Throws InputError on another
/// type or order and on a truncated file.
template <typename T>
NpyArray<T> read_npy(const std::filesystem::path& file);

/// Writes an array of one of the types that read_npy reads. The product of `shape` must equal values.size(). Throws
/// OutputError.
template <typename T>
void write_npy(const std::filesystem::path& file, std::span<const T> values, std::span<const std::size_t> shape);

/// The same for a vector or an array of such values.
template <typename Values>
void write_npy(const std::filesystem::path& file, const Values& values, std::span<const std::size_t> shape) {
  write_npy<typename Values::value_type>(file, std::span(values), shape);
}

/// Writes an array of one dimension, each value converted to T: of an enum, its number. Throws OutputError.
template <typename T, typename Values>
void write_npy_as(const std::filesystem::path& file, const Values& values) {
  std::vector<T> converted;
  converted.reserve(values.size());
  for (const auto& value : values) converted.push_back(static_cast<T>(value));
  const std::size_t shape = converted.size();
  write_npy(file, converted, std::span(&shape, 1));
}

}  // namespace gpvc::io
