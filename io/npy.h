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

/// The product of `shape` must equal values.size(). Throws OutputError.
void write_npy(const std::filesystem::path& file, std::span<const std::uint8_t> values,
               std::span<const std::size_t> shape);
void write_npy(const std::filesystem::path& file, std::span<const std::int32_t> values,
               std::span<const std::size_t> shape);
void write_npy(const std::filesystem::path& file, std::span<const std::uint32_t> values,
               std::span<const std::size_t> shape);
void write_npy(const std::filesystem::path& file, std::span<const float> values, std::span<const std::size_t> shape);
void write_npy(const std::filesystem::path& file, std::span<const double> values, std::span<const std::size_t> shape);

}  // namespace gpvc::io
