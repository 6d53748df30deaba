// The records of all views, and a way to walk them face by face without a table of everything.
#pragma once

#include <tbb/enumerable_thread_specific.h>
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

/// One more than the highest number of a view.
inline std::size_t view_count(const RecordsByView& by_view) {
  return by_view.empty() ? 0 : std::size_t{by_view.rbegin()->first} + 1;
}

struct ViewRecord {
  std::uint32_t view = 0;
  FaceRecord* record = nullptr;
};

/// The records of the faces [begin, end), grouped by face, views ascending. Uses the memory that `result` has. O(records of
/// these faces + views * log(records of a view)).
inline void records_of_faces(RecordsByView& by_view, std::size_t begin, std::size_t end, Grouped<ViewRecord>& result) {
  std::vector<std::pair<std::uint32_t, std::span<FaceRecord>>> parts;
  for (auto& [view, records] : by_view) {
    const auto first = std::ranges::lower_bound(records, begin, {}, &FaceRecord::face);
    const auto last = std::ranges::lower_bound(first, records.end(), end, {}, &FaceRecord::face);
    if (first != last) parts.emplace_back(view, std::span<FaceRecord>(first, last));
  }
  group_items_into(result, end - begin, [&](const auto& add) {
    for (const auto& [view, records] : parts)
      for (FaceRecord& record : records) add(record.face - begin, {view, &record});
  });
}

inline constexpr std::size_t kChunkFaces = 16384;

inline std::size_t chunk_count(std::size_t faces) { return (faces + kChunkFaces - 1) / kChunkFaces; }

/// Calls body(chunk, records of its faces, grouped by face) for every `stride`-th chunk of `faces`, in parallel. The body
/// must not wait for tasks.
template <class Body>
void for_each_chunk(RecordsByView& by_view, std::size_t faces, std::size_t stride, Body body) {
  // Megabytes, which would be cleared by the system anew for every chunk.
  tbb::enumerable_thread_specific<Grouped<ViewRecord>> of_threads;
  tbb::parallel_for(std::size_t{0}, chunk_count(faces), stride, [&](std::size_t chunk) {
    const std::size_t begin = chunk * kChunkFaces;
    Grouped<ViewRecord>& records = of_threads.local();
    records_of_faces(by_view, begin, std::min(faces, begin + kChunkFaces), records);
    body(chunk, std::as_const(records));
  });
}

}  // namespace gpvc::labeling
