// Suggestions for a mistyped word.
#pragma once

#include <string>
#include <vector>

namespace gpvc::io {

/// The `count` words nearest to `word` by Levenshtein's distance, nearest first, `most_edits` away at most. O(words x
/// length^2).
std::vector<std::string> near_words(const std::string& word, const std::vector<std::string>& words, std::size_t count,
                                    std::size_t most_edits = 1000000);

}  // namespace gpvc::io
