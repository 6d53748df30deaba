// Pictures in memory.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace gpvc {

/// Of pixel (x, y) in a row-major raster.
inline std::size_t pixel_index(int x, int y, int width) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
}

/// The bytes of a picture: its own, as of a vector, or somebody else's, which are never written to. Whoever changes them, or
/// may by what it is given, works on a copy from then on.
class Pixels {
 public:
  using value_type = std::uint8_t;

  Pixels() = default;
  Pixels(std::vector<std::uint8_t> bytes) : owned_(std::move(bytes)) { show_owned(); }
  Pixels(std::initializer_list<std::uint8_t> bytes) : Pixels(std::vector<std::uint8_t>(bytes)) {}
  /// Bytes that stay where they are, and as they are, as long as `keeper` lives. \pre keeper is not null
  static Pixels borrowed(std::span<const std::uint8_t> bytes, std::shared_ptr<const void> keeper) {
    Pixels pixels;
    pixels.data_ = bytes.data();
    pixels.size_ = bytes.size();
    pixels.keeper_ = std::move(keeper);
    return pixels;
  }
  Pixels(const Pixels& other) : data_(other.data_), size_(other.size_), owned_(other.owned_), keeper_(other.keeper_) {
    if (!keeper_) show_owned();
  }
  Pixels(Pixels&& other) noexcept { swap(other); }
  Pixels& operator=(Pixels other) noexcept {
    swap(other);
    return *this;
  }
  ~Pixels() = default;
  void swap(Pixels& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    owned_.swap(other.owned_);
    keeper_.swap(other.keeper_);
  }

  bool is_borrowed() const { return keeper_ != nullptr; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const std::uint8_t* data() const { return data_; }
  const std::uint8_t* begin() const { return data_; }
  const std::uint8_t* end() const { return data_ + size_; }
  const std::uint8_t& operator[](std::size_t i) const { return data_[i]; }
  const std::uint8_t& front() const { return data_[0]; }
  const std::uint8_t& back() const { return data_[size_ - 1]; }
  operator std::span<const std::uint8_t>() const { return {data_, size_}; }
  bool operator==(const Pixels& other) const { return std::equal(begin(), end(), other.begin(), other.end()); }

  std::uint8_t* data() { return own().data(); }
  std::uint8_t* begin() { return own().data(); }
  std::uint8_t* end() { return own().data() + size_; }
  std::uint8_t& operator[](std::size_t i) { return own()[i]; }

  // As of a vector.
  void reserve(std::size_t count) {
    own().reserve(count);
    show_owned();
  }
  void push_back(std::uint8_t byte) {
    own().push_back(byte);
    show_owned();
  }
  void resize(std::size_t count, std::uint8_t value = 0) {
    own().resize(count, value);
    show_owned();
  }
  void assign(std::size_t count, std::uint8_t value) {
    if (keeper_) *this = {};
    owned_.assign(count, value);
    show_owned();
  }
  template <std::input_iterator Iterator>
  void assign(Iterator first, Iterator last) {
    *this = std::vector<std::uint8_t>(first, last);
  }
  void insert(const std::uint8_t* at, std::size_t count, std::uint8_t value) {
    const auto place = at - data_;  // own() may move the bytes
    own().insert(owned_.begin() + place, count, value);
    show_owned();
  }
  template <std::input_iterator Iterator>
  void insert(const std::uint8_t* at, Iterator first, Iterator last) {
    const auto place = at - data_;
    own().insert(owned_.begin() + place, first, last);
    show_owned();
  }
  void insert(const std::uint8_t* at, std::initializer_list<std::uint8_t> bytes) {
    insert(at, bytes.begin(), bytes.end());
  }

  /// The bytes as a vector, a copy of borrowed ones; none are left here.
  std::vector<std::uint8_t> release() {
    std::vector<std::uint8_t> bytes = std::move(own());
    *this = {};
    return bytes;
  }

 private:
  std::vector<std::uint8_t>& own() {
    if (keeper_) *this = std::vector<std::uint8_t>(data_, data_ + size_);
    return owned_;
  }
  void show_owned() {
    data_ = owned_.data();
    size_ = owned_.size();
  }

  const std::uint8_t* data_ = nullptr;
  std::size_t size_ = 0;
  std::vector<std::uint8_t> owned_;     ///< where data_ points to, unless somebody else's
  std::shared_ptr<const void> keeper_;  ///< of somebody else's; null: they are our own
};

/// 8 bits a channel, row-major from the top-left, interleaved.
struct Image {
  int width = 0, height = 0, channels = 3;
  Pixels pixels;  ///< width * height * channels

  const std::uint8_t* at(int x, int y) const {
    return pixels.data() + pixel_index(x, y, width) * static_cast<std::size_t>(channels);
  }
  std::uint8_t* at(int x, int y) {
    return pixels.data() + pixel_index(x, y, width) * static_cast<std::size_t>(channels);
  }
};

}  // namespace gpvc
