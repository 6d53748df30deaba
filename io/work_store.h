// Results of parts of a long run, kept on disk, so that a run that was cut off can be continued.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "error.h"
#include "members.h"

namespace gpvc::io {

/// Stands for everything that a result was computed from: a 128-bit hash (XXH3) of it.
struct WorkKey {
  std::array<std::uint64_t, 2> bits{};
  bool operator==(const WorkKey&) const = default;
};
GPVC_MEMBERS(WorkKey, bits)

/// Hashes what a key is to stand for. Texts and lists count with their lengths.
class WorkHash {
 public:
  WorkHash();
  ~WorkHash();
  void add_bytes(const void* data, std::size_t bytes);
  /// As WorkStore::Writer::add().
  template <typename T>
  void add(const T& value) {
    put_value(*this, value);
  }
  void write(const void* data, std::size_t bytes) { add_bytes(data, bytes); }
  /// The bytes of a file. Throws InputError.
  void add_file(const std::filesystem::path& file);
  WorkKey key() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A folder of results. Each is kept under a name, with the key of what it came from and a hash of its bytes, so that a
/// file that a power cut left incomplete counts as none. The values are those of this machine and this program. Several
/// threads may keep and read results of different names.
class WorkStore {
 public:
  class Writer;
  class Reader;
  /// The folder is made when the first result is kept. `list`: the name of a file there that has the hashes of all results once
  /// more, so that a result that was changed together with its own hash counts as none, too. Only one process at a time may then
  /// keep results.
  explicit WorkStore(std::filesystem::path folder, std::string list = {});

  /// True if a result of that name and key seems to be there.
  bool has(const std::string& name, const WorkKey& key) const;
  /// Calls fill(reader) on the result of that name and key. False if there is none or it is damaged: then what was read
  /// means nothing.
  bool read(const std::string& name, const WorkKey& key, const std::function<void(Reader&)>& fill) const;
  /// Keeps what write(writer) writes, instead of any result of that name. If that fails (disk full), nothing more is kept.
  void keep(const std::string& name, const WorkKey& key, const std::function<void(Writer&)>& write);
  /// Removes all results with their list, those in its folders, too, and the folder unless it holds anything else.
  void clear() noexcept;
  /// Why nothing more is kept; nullopt while all is well.
  std::optional<OutputError> failure() const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

/// Takes the parts of a result, one after another.
class WorkStore::Writer {
 public:
  virtual ~Writer() = default;
  virtual void write(const void* data, std::size_t bytes) = 0;
  /// Numbers, enums, texts, paths, lists, optional and alternative values, and structs with a list of members (members.h).
  template <typename T>
  void add(const T& value) {
    put_value(*this, value);
  }
};

/// Gives the parts back in the same order. All functions throw an exception that WorkStore::read() catches where the
/// file ends early.
class WorkStore::Reader {
 public:
  virtual ~Reader() = default;
  virtual void read(void* data, std::size_t bytes) = 0;
  /// Bytes that are left.
  virtual std::size_t left() const = 0;
  /// What was read cannot be a result of this run.
  [[noreturn]] void refuse() const;
  template <typename T>
  T get() {
    T value{};
    get_value(*this, value);
    return value;
  }
};

}  // namespace gpvc::io
