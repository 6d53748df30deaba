// Tables of the benchmarks, as Markdown and as CSV.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace gpvc {

class Table {
 public:
  explicit Table(std::vector<std::string> columns) : rows_{std::move(columns)} {}
  /// As many cells as there are columns.
  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  bool empty() const { return rows_.size() == 1; }
  std::string markdown() const;
  /// Throws std::runtime_error if the file cannot be written.
  void write_csv(const std::filesystem::path& file) const;

 private:
  std::vector<std::vector<std::string>> rows_;  ///< the columns' names first
};

/// Throws std::runtime_error if the file cannot be written.
void write_text(const std::filesystem::path& file, const std::string& text);

}  // namespace gpvc
