#include "labeling/costs/face_records.h"

namespace gpvc::labeling {

FaceChunk::FaceChunk(RecordsByView& by_view, std::size_t begin_face, std::size_t end_face) : begin_face_(begin_face) {
  std::vector<std::pair<std::uint32_t, std::span<FaceRecord>>> parts;
  const auto before = [](const FaceRecord& record, std::size_t face) { return record.face < face; };
  for (auto& [view, records] : by_view) {
    const auto begin = std::lower_bound(records.begin(), records.end(), begin_face, before);
    const auto end = std::lower_bound(begin, records.end(), end_face, before);
    if (begin != end) parts.emplace_back(view, std::span<FaceRecord>(begin, end));
  }
  records_ = group_items<ViewRecord>(end_face - begin_face, [&](const auto& add) {
    for (const auto& [view, records] : parts)
      for (FaceRecord& record : records) add(record.face - begin_face, {view, &record});
  });
}

}  // namespace gpvc::labeling
