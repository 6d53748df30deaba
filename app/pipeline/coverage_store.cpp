#include "app/pipeline/coverage_store.h"

#include <algorithm>

namespace gpvc::pipeline {
namespace {

constexpr std::uint64_t kNone = 0, kAll = ~std::uint64_t{0};

/// A run: numbers of words that are all 0, of words that are all 1, and of other words, which follow the run as they are.
/// Packed into one word of 21, 21 and 22 bits.
struct Run {
  std::size_t none = 0, all = 0, others = 0;
  static constexpr std::size_t kMost = (std::size_t{1} << 21) - 1;

  std::uint64_t packed() const { return none | all << 21 | others << 42; }
  static Run unpacked(std::uint64_t word) { return {word & kMost, word >> 21 & kMost, word >> 42}; }
};

std::size_t word_count(const visibility::FaceCoverage& entry) {
  return (static_cast<std::size_t>(entry.width) * static_cast<std::size_t>(entry.height) + 63) / 64;
}

void pack_words(std::span<const std::uint64_t> words, std::vector<std::uint64_t>& runs) {
  const auto count = [&words](std::size_t from, auto wanted) {
    std::size_t end = from;
    while (end < words.size() && end - from < Run::kMost && wanted(words[end])) ++end;
    return end - from;
  };
  for (std::size_t i = 0; i < words.size();) {
    Run run;
    run.none = count(i, [](std::uint64_t w) { return w == kNone; });
    run.all = count(i + run.none, [](std::uint64_t w) { return w == kAll; });
    const std::size_t first = i + run.none + run.all;
    run.others = count(first, [](std::uint64_t w) { return w != kNone && w != kAll; });
    runs.push_back(run.packed());
    const auto others = words.subspan(first, run.others);
    runs.insert(runs.end(), others.begin(), others.end());
    i = first + run.others;
  }
}

void unpack(const std::uint64_t* runs, std::size_t count, std::vector<std::uint64_t>& words) {
  const std::size_t end = words.size() + count;
  while (words.size() < end) {
    const Run run = Run::unpacked(*runs++);
    words.insert(words.end(), run.none, kNone);
    words.insert(words.end(), run.all, kAll);
    words.insert(words.end(), runs, runs + run.others);
    runs += run.others;
  }
}

}  // namespace

PackedCoverage pack(const visibility::CoverageTable& coverage) {
  PackedCoverage packed;
  packed.entries.reserve(coverage.entries.size());
  for (visibility::FaceCoverage entry : coverage.entries) {
    const auto words = std::span(coverage.words).subspan(entry.first_word, word_count(entry));
    entry.first_word = packed.runs.size();
    pack_words(words, packed.runs);
    packed.entries.push_back(entry);
  }
  return packed;
}

void CoverageStore::add(const PackedCoverage& coverage) {
  for (visibility::FaceCoverage entry : coverage.entries) {
    entry.first_word += all_.runs.size();
    all_.entries.push_back(entry);
  }
  all_.runs.insert(all_.runs.end(), coverage.runs.begin(), coverage.runs.end());
}

visibility::CoverageTable CoverageStore::of_partial_faces(std::span<const labeling::FaceTag> tags) const {
  const auto is_partial = [&](const visibility::FaceCoverage& entry) {
    return tags[index(entry.face)] == labeling::FaceTag::partial;
  };
  visibility::CoverageTable kept;
  std::size_t entries = 0, words = 0;
  for (const visibility::FaceCoverage& entry : all_.entries) {
    if (!is_partial(entry)) continue;
    ++entries;
    words += word_count(entry);
  }
  kept.entries.reserve(entries);
  kept.words.reserve(words);
  for (visibility::FaceCoverage entry : all_.entries) {
    if (!is_partial(entry)) continue;
    const std::uint64_t* runs = all_.runs.data() + entry.first_word;
    entry.first_word = kept.words.size();
    unpack(runs, word_count(entry), kept.words);
    kept.entries.push_back(entry);
  }
  return kept;
}

}  // namespace gpvc::pipeline
