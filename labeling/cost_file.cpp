// Cost tables on disk: a folder of three arrays, and mvs-texturing's sparse table.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <string>
#include <utility>

#include "io/grouping.h"
#include "io/npy.h"
#include "io/paths.h"
#include "labeling/labeling.h"

namespace gpvc::labeling {
namespace {

namespace fs = std::filesystem;

void check_cost(const fs::path& file, std::size_t entry, float cost) {
  if (!(cost >= 0) || !std::isfinite(cost))
    throw InputError(file, "entry " + std::to_string(entry), "a cost is negative or not finite");
}

template <typename T>
std::vector<T> read_vector(const fs::path& file) {
  io::NpyArray<T> array = io::read_npy<T>(file);
  if (array.shape.size() != 1) throw InputError(file, "", "expected an array of one dimension");
  return std::move(array.values);
}

// View selection takes time and memory in proportion to the largest view number, which the file's size does not bound.
// The 16 bits that mvs-texturing's table has for it are enough for any flight; a larger number is an error in the file.
constexpr std::uint32_t kViewNumbers = 1u << 16;

void check_views(const fs::path& file, const CostTable& table) {
  for (std::size_t face = 0; face + 1 < table.first.size(); ++face)
    for (std::size_t i = table.first[face]; i < table.first[face + 1]; ++i) {
      if (i > table.first[face] && table.views[i] <= table.views[i - 1])
        throw InputError(file, "face " + std::to_string(face), "its views do not ascend");
      if (table.views[i] >= kViewNumbers)
        throw InputError(file, "face " + std::to_string(face),
                         "has the view " + std::to_string(table.views[i]) + "; expected numbers below " +
                             std::to_string(kViewNumbers));
    }
}

CostTable read_folder(const fs::path& folder) {
  const std::vector<std::uint32_t> counts = read_vector<std::uint32_t>(folder / "counts.npy");
  CostTable table;
  table.views = read_vector<std::uint32_t>(folder / "views.npy");
  table.costs = read_vector<float>(folder / "costs.npy");
  table.first.reserve(counts.size() + 1);
  table.first.push_back(0);
  for (const std::uint32_t count : counts) table.first.push_back(table.first.back() + count);
  if (table.first.back() != table.views.size())
    throw InputError(folder / "counts.npy", "",
                     "the counts add up to " + std::to_string(table.first.back()) + ", but views.npy has " +
                         std::to_string(table.views.size()) + " entries");
  if (table.views.size() != table.costs.size())
    throw InputError(folder / "costs.npy", "",
                     "has " + std::to_string(table.costs.size()) + " entries, but views.npy has " +
                         std::to_string(table.views.size()));
  const fs::path costs_file = folder / "costs.npy";
  for (std::size_t i = 0; i < table.costs.size(); ++i) check_cost(costs_file, i, table.costs[i]);
  check_views(folder / "views.npy", table);
  return table;
}

// --- mvs-texturing

struct SparseEntry {
  std::uint32_t face;
  std::uint16_t view;
  float cost;
};

struct SparseFile {
  std::uint64_t faces = 0, views = 0;
  std::vector<SparseEntry> entries;
};

SparseFile read_sparse_file(const fs::path& file) {
  io::refuse_special_file(file);
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(file, "", "cannot be opened");
  std::string magic, version;
  SparseFile table;
  std::uint64_t entries = 0;
  in >> magic >> version >> table.faces >> table.views >> entries;
  if (!in || magic != "SPT" || in.get() != '\n')
    throw InputError(file, "line 1", "expected 'SPT 0.2 FACES VIEWS ENTRIES'");
  constexpr std::size_t kEntryBytes = 10;
  const std::uint64_t size = fs::file_size(file), header = static_cast<std::uint64_t>(in.tellg());
  if ((size - header) / kEntryBytes < entries)
    throw InputError(file, "byte " + std::to_string(size),
                     "the file ends before its " + std::to_string(entries) + " entries");
  // Faces without an entry take no byte of the file, so the file's size does not bound their number. A table with
  // entries for less than one face in 1024 is an error in the header rather than a mesh.
  constexpr std::uint64_t kMaxFacesPerEntry = 1024, kAlwaysAllowed = 1u << 20;
  if (table.faces > 0xFFFFFFFEu || table.faces > kAlwaysAllowed + kMaxFacesPerEntry * entries)
    throw InputError(
        file, "line 1",
        "claims " + std::to_string(table.faces) + " faces, too many for its " + std::to_string(entries) + " entries");
  table.entries.resize(entries);
  for (SparseEntry& entry : table.entries) {
    std::array<char, kEntryBytes> bytes;
    if (!in.read(bytes.data(), kEntryBytes)) throw InputError(file, "", "cannot be read");
    std::memcpy(&entry.face, bytes.data(), 4);
    std::memcpy(&entry.view, bytes.data() + 4, 2);
    std::memcpy(&entry.cost, bytes.data() + 6, 4);
  }
  return table;
}

CostTable read_sparse_table(const fs::path& file) {
  const SparseFile sparse = read_sparse_file(file);
  for (std::size_t i = 0; i < sparse.entries.size(); ++i) {
    const SparseEntry& entry = sparse.entries[i];
    if (entry.face >= sparse.faces || entry.view >= sparse.views)
      throw InputError(file, "entry " + std::to_string(i), "its face or view is out of range");
    check_cost(file, i, entry.cost);
  }
  using Candidate = std::pair<std::uint32_t, float>;  // view, cost
  Grouped<Candidate> rows = group_items<Candidate>(sparse.faces, [&](const auto& add) {
    for (const SparseEntry& entry : sparse.entries) add(entry.face, {entry.view, entry.cost});
  });
  CostTable table;
  table.views.reserve(sparse.entries.size());
  table.costs.reserve(sparse.entries.size());
  for (std::size_t face = 0; face < sparse.faces; ++face) {
    const std::span<Candidate> row = rows[face];
    std::sort(row.begin(), row.end());
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (i > 0 && row[i].first == row[i - 1].first)
        throw InputError(file, "face " + std::to_string(face), "has a view twice");
      table.views.push_back(row[i].first);
      table.costs.push_back(row[i].second);
    }
  }
  table.first = std::move(rows.first);
  return table;
}

}  // namespace

CostTable read_costs(const fs::path& path) {
  return fs::is_directory(path) ? read_folder(path) : read_sparse_table(path);
}

void write_costs(const fs::path& folder, const CostTable& table) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw OutputError(folder, error.message());
  std::vector<std::uint32_t> counts(table.faces());
  for (std::size_t face = 0; face < counts.size(); ++face)
    counts[face] = static_cast<std::uint32_t>(table.first[face + 1] - table.first[face]);
  const std::size_t faces[] = {counts.size()}, entries[] = {table.views.size()};
  io::write_npy(folder / "counts.npy", counts, faces);
  io::write_npy(folder / "views.npy", table.views, entries);
  io::write_npy(folder / "costs.npy", table.costs, entries);
}

}  // namespace gpvc::labeling
