// NumPy's .npz: named arrays in one zip archive, packed with Deflate.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace gpvc::io {

/// An archive that is being written. numpy.load() opens it.
class NpzWriter {
 public:
  /// Throws OutputError.
  explicit NpzWriter(std::filesystem::path file);
  ~NpzWriter();
  /// T as in write_npy(), and uint64_t. The values are borrowed until commit(), which packs them. Throws OutputError.
  template <typename T>
  void add(const std::string& name, std::span<const T> values, std::span<const std::size_t> shape);
  /// Of one dimension.
  template <typename Values>
  void add(const std::string& name, const Values& values) {
    const std::size_t size = values.size();
    add<typename Values::value_type>(name, std::span(values), std::span(&size, 1));
  }
  /// The archive appears under its name. Without it nothing does. Throws OutputError.
  void commit();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace gpvc::io
