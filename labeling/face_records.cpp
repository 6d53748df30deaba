#include "labeling/face_records.h"

namespace gpvc::labeling {

FaceChunk::FaceChunk(RecordsByView& by_view, std::size_t begin_face, std::size_t end_face)
    : begin_face_(begin_face), first_(end_face - begin_face + 1, 0) {
  std::vector<std::pair<std::uint32_t, std::span<FaceRecord>>> parts;
  const auto before = [](const FaceRecord& record, std::size_t face) { return record.face < face; };
  for (auto& [view, records] : by_view) {
    const auto begin = std::lower_bound(records.begin(), records.end(), begin_face, before);
    const auto end = std::lower_bound(begin, records.end(), end_face, before);
    if (begin != end) parts.emplace_back(view, std::span<FaceRecord>(begin, end));
  }
  for (const auto& [view, records] : parts)
    for (const FaceRecord& record : records) ++first_[record.face - begin_face_ + 1];
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  records_.resize(first_.back());
  std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
  for (const auto& [view, records] : parts)
    for (FaceRecord& record : records) records_[next[record.face - begin_face_]++] = {view, &record};
}

}  // namespace gpvc::labeling
