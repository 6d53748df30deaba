#include "io/near_words.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace gpvc::io {
namespace {

// Levenshtein's distance, O(|a| |b|).
std::size_t edits(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t next = std::min({row[j] + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0 : 1)});
      diagonal = row[j];
      row[j] = next;
    }
  }
  return row.back();
}

}  // namespace

std::vector<std::string> near_words(const std::string& word, const std::vector<std::string>& words, std::size_t count,
                                    std::size_t most_edits) {
  std::vector<std::pair<std::size_t, std::string>> near;
  for (const std::string& known : words) near.emplace_back(edits(word, known), known);
  count = std::min(count, near.size());
  std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count), near.end());
  std::vector<std::string> nearest;
  for (std::size_t i = 0; i < count && near[i].first <= most_edits; ++i) nearest.push_back(near[i].second);
  return nearest;
}

}  // namespace gpvc::io
