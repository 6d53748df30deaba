// Where finished parts of a run are kept, so that this run or another one goes on from them.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "../../io/work_store.h"

namespace gpvc::results {

/// Parts by name, each under a key of what it came from, which the store knows: a folder that a run goes on from after it was
/// cut off, a job's folder, an editable result. A part that came from something else counts as none. Thread-safe for
/// different parts.
class Store {
 public:
  using Writer = io::WorkStore::Writer;
  using Reader = io::WorkStore::Reader;
  virtual ~Store() = default;

  /// nullopt where the part has to be made.
  template <typename Part>
  std::optional<Part> get(const std::string& name) const {
    std::optional<Part> part;
    const bool found = read(name, [&](Reader& in) { part = in.get<Part>(); });
    return found ? std::move(part) : std::nullopt;
  }
  template <typename Part>
  void put(const std::string& name, const Part& part) {
    write(name, [&](Writer& out) { out.add(part); });
  }
  /// For parts that are read or written piece by piece.
  virtual bool read(const std::string& name, const std::function<void(Reader&)>& fill) const = 0;
  virtual void write(const std::string& name, const std::function<void(Writer&)>& fill) = 0;
};

}  // namespace gpvc::results
