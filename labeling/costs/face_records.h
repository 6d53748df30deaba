// The records of all views, and a way to walk them face by face without a table of everything.
#pragma once

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "io/grouping.h"
#include "labeling/costs/view_statistics.h"

namespace gpvc::labeling {

/// Per view (index(ViewId)), its records in face order.
using RecordsByView = std::map<std::uint32_t, std::vector<FaceRecord>>;

struct ViewRecord {
  std::uint32_t view = 0;
  FaceRecord* record = nullptr;
};

/// The records of a range of faces, grouped by face, views ascending.
class FaceChunk {
 public:
  /// O(records of these faces + views * log(records of a view)).
  FaceChunk(RecordsByView& by_view, std::size_t begin_face, std::size_t end_face);

  std::span<const ViewRecord> of(std::size_t face) const { return records_[face - begin_face_]; }

 private:
  std::size_t begin_face_;
  Grouped<ViewRecord> records_;
};

inline constexpr std::size_t kChunkFaces = 16384;

inline std::size_t chunk_count(std::size_t faces) { return (faces + kChunkFaces - 1) / kChunkFaces; }

/// Calls body(chunk, first face, one past the last face) for all chunks of `faces`, in parallel.
template <class Body>
void for_each_chunk(std::size_t faces, Body body) {
  tbb::parallel_for(std::size_t{0}, chunk_count(faces), [&](std::size_t chunk) {
    body(chunk, chunk * kChunkFaces, std::min(faces, (chunk + 1) * kChunkFaces));
  });
}

}  // namespace gpvc::labeling
