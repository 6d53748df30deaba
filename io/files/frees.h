// What C libraries make, in std::unique_ptr.
#pragma once

namespace gpvc::io {

/// A deleter: std::unique_ptr<zip_t, Frees<zip_discard>>.
template <auto kFree>
struct Frees {
  void operator()(auto* object) const { kFree(object); }
};

}  // namespace gpvc::io
